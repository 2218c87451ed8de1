//! Walks from record to record through a log and skips damaged parts; finds the records of logs
//! that consist of messages only, each of which begins with a marker and states its length.

use super::collected::{Collected, WarningKind, WarningReport};
use super::log_format::Reading;
use crate::support::progress::{Cancelled, Progress};
use std::ops::Range;

/// A walk over the records of a file: the file, and the report of damaged records.
pub(super) struct Walk<'a> {
    /// The whole file.
    pub(super) bytes: &'a [u8],
    /// Index of the file in the log.
    pub(super) file: usize,
    /// Word for a record of the format, used in warnings.
    pub(super) noun: &'static str,
    /// Report for warnings.
    pub(super) report: WarningReport,
    /// True if the file is still being written: a truncated last record is then no damage.
    pub(super) is_growing: bool,
    /// Progress of the walk.
    pub(super) progress: &'a Progress,
}

impl<'a> Walk<'a> {
    /// Creates a walk over the first file of a log; `noun` is the word for a record.
    pub(super) fn new(
        bytes: &'a [u8],
        noun: &'static str,
        report: &WarningReport,
        reading: &Reading<'_>,
        progress: &'a Progress,
    ) -> Self {
        let (report, is_growing) = (report.clone(), reading.is_growing);
        Self { bytes, file: 0, noun, report, is_growing, progress }
    }

    /// Skips the record at an offset, whose stated end is beyond the record at `found`, which
    /// begins inside it; returns `found`.
    pub(super) fn over_long(&self, at: usize, end: usize, found: usize) -> usize {
        let text = format!(
            "a {} says that it is {} bytes long, but the next begins after {}; it was dropped",
            self.noun,
            end - at,
            found - at
        );
        self.report.at(WarningKind::Frame, self.file, at, text);
        found
    }

    /// Skips the record at an offset, which exceeds the bytes; returns their number. `whole` is a
    /// word for the file.
    pub(super) fn over_cut(&self, at: usize, whole: &str) -> usize {
        let len = self.bytes.len();
        if !self.is_growing {
            let text = format!(
                "the {whole} was cut inside its last {} ({} bytes of it are there); it was dropped",
                self.noun,
                len - at
            );
            self.report.at(WarningKind::Frame, self.file, at, text);
        }
        len
    }

    /// Skips the bytes from an offset up to the next record, `found`, or up to the end of the file;
    /// returns the offset at which they end.
    pub(super) fn over_gap(&self, at: usize, found: Option<usize>) -> usize {
        let to = found.unwrap_or(self.bytes.len());
        if found.is_some() || !self.is_growing {
            let text = format!("{} bytes belong to no {} and were skipped", to - at, self.noun);
            self.report.at(WarningKind::Gap, self.file, at, text);
        }
        to
    }
}

/// Marker and length of the messages of a format.
#[derive(Clone, Copy, Debug)]
pub(super) struct MessageFormat {
    /// Word for a message of the format, used in warnings.
    pub(super) noun: &'static str,
    /// First two bytes of each message.
    pub(super) marker: [u8; 2],
    /// Returns the bytes of the whole message at an offset, at least 2; `None` where no message can
    /// begin. The message may exceed the bytes.
    pub(super) length: fn(&[u8], usize) -> Option<usize>,
}

impl MessageFormat {
    /// Returns the range of the message at an offset, which may exceed the bytes; `None` where none
    /// can begin.
    fn message(self, bytes: &[u8], at: usize) -> Option<Range<usize>> {
        let length = (self.length)(bytes, at)?;
        Some(at..at.checked_add(length)?)
    }

    /// Returns true if a message begins at an offset, or the bytes end there.
    fn is_border(self, bytes: &[u8], at: usize) -> bool {
        at == bytes.len() || self.message(bytes, at).is_some()
    }

    /// Returns the offset of the first message that begins in `from..to` and is followed by another
    /// message or by the end of the bytes: a marker alone may occur by chance.
    pub(super) fn next(self, bytes: &[u8], from: usize, to: usize) -> Option<usize> {
        let searched = bytes.get(from..to.min(bytes.len()))?;
        let marked = searched.windows(2).enumerate();
        let marked = marked.filter(|(_, window)| **window == self.marker);
        let mut starts = marked.map(|(index, _)| from + index);
        starts.find(|&at| {
            let message = self.message(bytes, at);
            message.is_some_and(|message| self.is_border(bytes, message.end))
        })
    }

    /// Calls `take` with the log and the range of every whole message of its file from the offset
    /// `first` on, or of the tail from the offset `tail` on; fails only if cancelled.
    pub(super) fn read(
        self,
        bytes: &[u8],
        (first, tail): (usize, Option<usize>),
        log: &mut Collected,
        (reading, progress): (&Reading<'_>, &Progress),
        mut take: impl FnMut(&mut Collected, Range<usize>),
    ) -> Result<(), Cancelled> {
        let len = bytes.len();
        let start = tail.map_or(first, |from| self.next(bytes, from, len).unwrap_or(len));
        progress.start(len.saturating_sub(start) as u64);
        let walk = Walk::new(bytes, self.noun, &log.report, reading, progress);
        self.walk(walk, start, |message| take(log, message))
    }

    /// Calls `take` with the range of every whole message from `start` on; fails only if cancelled.
    pub(super) fn walk(
        self,
        walk: Walk<'_>,
        start: usize,
        mut take: impl FnMut(Range<usize>),
    ) -> Result<(), Cancelled> {
        let bytes = walk.bytes;
        let mut longest = 0;
        walk.progress.walk(start, bytes.len(), |at| {
            let Some(message) = self.message(bytes, at) else {
                return Ok(walk.over_gap(at, self.next(bytes, at + 1, bytes.len())));
            };
            let end = message.end;
            // A damaged length may end at the start of another message by chance. Only a message
            // that is longer than all before is searched for messages inside it.
            let is_usual = message.len() <= longest || self.inside(bytes, &message).is_none();
            if is_usual && self.is_border(bytes, end) {
                longest = longest.max(message.len());
                take(message);
                return Ok(end);
            }
            // Something is damaged: the length of this message if another message begins inside it,
            // otherwise the bytes after it.
            if let Some(found) = self.next(bytes, at + 2, end) {
                return Ok(walk.over_long(at, end, found));
            }
            if end > bytes.len() {
                return Ok(walk.over_cut(at, "file"));
            }
            take(message);
            Ok(end)
        })
    }

    /// Returns the offset inside a message from which other messages follow each other up to its
    /// end; `None` where there are none, as in a whole message.
    fn inside(self, bytes: &[u8], message: &Range<usize>) -> Option<usize> {
        let first = self.next(bytes, message.start + 2, message.end)?;
        let mut at = first;
        while at < message.end {
            at = self.message(bytes, at)?.end;
        }
        (at == message.end).then_some(first)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Format of messages with a marker, a byte for the length, and zeros.
    const SMALL: MessageFormat = MessageFormat {
        noun: "message",
        marker: [0xAB, 0xCD],
        length: |bytes, at| match bytes.get(at..at + 3)? {
            [0xAB, 0xCD, length] if *length > 2 => Some(usize::from(*length)),
            _ => None,
        },
    };

    /// Returns the lengths of the messages that a walk finds, and the number of warnings.
    fn walked(bytes: &[u8]) -> (Vec<usize>, usize) {
        let (report, progress) = (WarningReport::default(), Progress::new());
        let walk = Walk::new(bytes, SMALL.noun, &report, &Reading::default(), &progress);
        let mut lengths = Vec::new();
        SMALL.walk(walk, 0, |message| lengths.push(message.len())).expect("no cancel");
        (lengths, report.finish().len())
    }

    #[test]
    fn a_length_that_ends_where_another_message_does_costs_one_message() {
        let message =
            |length: u8| [&[0xAB, 0xCD, length][..], &[0; 250][..usize::from(length) - 3]].concat();
        let whole = [message(20), message(10), message(20), message(30)].concat();
        assert_eq!(walked(&whole), (vec![20, 10, 20, 30], 0));
        let mut harmed = whole.clone();
        harmed[32] = 50;
        assert_eq!(walked(&harmed), (vec![20, 10, 30], 1));
        // The first message of the file is damaged too.
        harmed[2] = 30;
        assert_eq!(walked(&harmed), (vec![10, 30], 2));
    }
}
