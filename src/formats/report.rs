//! Collects what is wrong with a log while the rest is read.

use crate::survey::Warning;

/// So many warnings of a kind are kept; a log with ten thousand broken frames needs one sentence more, not as many.
const KEPT_OF_A_KIND: usize = 20;

/// Kinds of warnings: what is counted together once there are many.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// Bytes between frames that belong to none.
    Gap,
    /// A frame that lies about itself.
    Frame,
    /// A value in a frame that cannot be.
    Value,
    /// A companion file is missing or unusable.
    Companion,
    /// Something about the log as a whole.
    Log,
}

/// The warnings of one log.
#[derive(Debug, Default)]
pub(super) struct Report {
    warnings: Vec<Warning>,
    counts: Vec<(Kind, usize)>,
}

impl Report {
    /// Adds a warning about a place: index of the file and byte offset.
    pub(super) fn at(&mut self, kind: Kind, file: usize, offset: usize, text: String) {
        self.add(kind, Some((file, offset as u64)), text);
    }

    /// Adds a warning about the whole log.
    pub(super) fn log(&mut self, text: impl Into<String>) {
        self.add(Kind::Log, None, text.into());
    }

    /// Adds a warning about a file beside the log.
    pub(super) fn companion(&mut self, text: impl Into<String>) {
        self.add(Kind::Companion, None, text.into());
    }

    fn add(&mut self, kind: Kind, place: Option<(usize, u64)>, text: String) {
        let known = self.counts.iter().position(|(known, _)| *known == kind);
        let index = known.unwrap_or_else(|| {
            self.counts.push((kind, 0));
            self.counts.len() - 1
        });
        self.counts[index].1 += 1;
        if self.counts[index].1 <= KEPT_OF_A_KIND {
            self.warnings.push(Warning { place, text });
        }
    }

    /// Takes over the warnings of another report.
    pub(super) fn absorb(&mut self, other: Report) {
        self.warnings.extend(other.warnings);
        for (kind, count) in other.counts {
            match self.counts.iter_mut().find(|(known, _)| *known == kind) {
                Some((_, known)) => *known += count,
                None => self.counts.push((kind, count)),
            }
        }
    }

    /// All warnings kept, and one sentence for each kind of which more were seen.
    pub(super) fn finish(mut self) -> Vec<Warning> {
        for (kind, count) in self.counts {
            if count > KEPT_OF_A_KIND {
                let what = match kind {
                    Kind::Gap => "gaps between frames",
                    Kind::Frame => "damaged frames",
                    Kind::Value => "values that cannot be",
                    Kind::Companion => "problems with files beside the log",
                    Kind::Log => "remarks",
                };
                self.warnings.push(Warning {
                    place: None,
                    text: format!("{} more {what} are not listed", count - KEPT_OF_A_KIND),
                });
            }
        }
        self.warnings
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn many_of_a_kind_are_counted() {
        let mut report = Report::default();
        for offset in 0..1000 {
            report.at(Kind::Gap, 0, offset, "gap".into());
        }
        report.log("once");
        let warnings = report.finish();
        assert_eq!(warnings.len(), KEPT_OF_A_KIND + 2);
        assert!(
            warnings
                .last()
                .is_some_and(|last| last.text.starts_with("980 more gaps"))
        );
    }
}
