//! Collects the warnings about a log while it is read.

use crate::survey::Warning;
use std::cell::RefCell;
use std::rc::Rc;

/// Most warnings of a kind that are kept: for a log with ten thousand broken frames, one more
/// sentence with their number is enough.
const KEPT_OF_A_KIND: usize = 20;

/// Kind of a warning; warnings of a kind are counted together beyond `KEPT_OF_A_KIND`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum WarningKind {
    /// Bytes between frames that belong to no frame.
    Gap,
    /// A frame that contradicts itself.
    Frame,
    /// An implausible value in a frame.
    Value,
    /// A remark about the log as a whole.
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

/// Warnings about one log. Clones share the same report, so that both the walk over the bytes and
/// the decoding can add warnings.
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
    /// Adds a warning about a place: index of the file and offset in bytes.
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

    /// Adds a warning that the recorder's clock was set back by `seconds`, if this is above 0.
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

    /// Removes and returns all warnings: those about the whole log first, then the kept ones in the
    /// order of the bytes, then sentences with the number of those that were not kept.
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
