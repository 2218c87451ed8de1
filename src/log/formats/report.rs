//! Collects what is wrong with a log while the rest is read.

use crate::survey::Warning;
use std::cell::RefCell;
use std::rc::Rc;

/// Most warnings of a kind that are kept; a log with ten thousand broken frames needs one sentence
/// more, not as many.
const KEPT_OF_A_KIND: usize = 20;

/// Kinds of warnings: what is counted together once there are many.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum WarningKind {
    /// Bytes between frames that belong to none.
    Gap,
    /// A frame that lies about itself.
    Frame,
    /// A value in a frame that cannot be.
    Value,
    /// Something about the log as a whole.
    Log,
}

impl WarningKind {
    fn plural(self) -> &'static str {
        match self {
            WarningKind::Gap => "gaps between frames",
            WarningKind::Frame => "damaged frames",
            WarningKind::Value => "impossible values",
            WarningKind::Log => "remarks",
        }
    }
}

/// The warnings of one log. Clones write into the same report, so that the walk over the bytes and
/// the decoding of what it finds can both complain.
#[derive(Clone, Debug, Default)]
pub(super) struct WarningReport {
    shared: Rc<RefCell<Collection>>,
}

#[derive(Debug, Default)]
struct Collection {
    warnings: Vec<Warning>,
    counts: Vec<(WarningKind, usize)>,
}

impl WarningReport {
    /// Adds a warning about a place: index of the file and byte offset.
    pub(super) fn at(
        &self,
        kind: WarningKind,
        file: usize,
        offset: usize,
        text: impl Into<String>,
    ) {
        self.add(kind, Some((file, offset as u64)), text.into());
    }

    /// Adds a warning about the whole log.
    pub(super) fn log(&self, text: impl Into<String>) {
        self.add(WarningKind::Log, None, text.into());
    }

    /// Says that the recorder's clock was set back by so many seconds, if it was.
    pub(super) fn set_back(&self, seconds: f64) {
        if seconds > 0.0 {
            self.log(format!(
                "the recorder's clock was set back by {seconds:.1} s in the middle; times go on from where they were"
            ));
        }
    }

    fn add(&self, kind: WarningKind, place: Option<(usize, u64)>, text: String) {
        let Collection { warnings, counts } = &mut *self.shared.borrow_mut();
        let seen = match counts.iter_mut().find(|(known, _)| *known == kind) {
            Some((_, seen)) => {
                *seen += 1;
                *seen
            }
            None => {
                counts.push((kind, 1));
                1
            }
        };
        if seen <= KEPT_OF_A_KIND {
            warnings.push(Warning { place, text });
        }
    }

    /// Returns the warnings about the whole log, then those that were kept in the order of the
    /// bytes, then sentences about how many more there were.
    pub(super) fn finish(&self) -> Vec<Warning> {
        let Collection { warnings, counts } = self.shared.take();
        let mut sorted = warnings;
        sorted.sort_by_key(|warning| warning.place);
        let more =
            counts.into_iter().filter(|(_, seen)| *seen > KEPT_OF_A_KIND).map(|(kind, seen)| {
                Warning {
                    place: None,
                    text: format!(
                        "{} more {} are not listed",
                        seen - KEPT_OF_A_KIND,
                        kind.plural()
                    ),
                }
            });
        sorted.extend(more);
        sorted
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn many_of_a_kind_are_counted() {
        let report = WarningReport::default();
        for offset in 0..1000 {
            report.at(WarningKind::Gap, 0, offset, "gap");
        }
        report.log("once");
        let warnings = report.finish();
        assert_eq!(warnings.len(), KEPT_OF_A_KIND + 2);
        assert!(warnings.last().is_some_and(|last| last.text.starts_with("980 more gaps")));
    }
}
