//! Walks from message to message through a log that consists of messages only: each begins with a
//! marker and states its length.

use super::collected::Collected;
use super::log_format::Reading;
use super::report::{WarningKind, WarningReport};
use crate::support::progress::{Cancelled, Progress};
use std::ops::Range;

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

    /// Calls `take` with the log and the range of every whole message of its file, or of the tail
    /// from the offset `tail` on; fails only if cancelled.
    pub(super) fn read(
        self,
        bytes: &[u8],
        tail: Option<usize>,
        log: &mut Collected,
        (reading, progress): (&Reading<'_>, &Progress),
        mut take: impl FnMut(&mut Collected, Range<usize>),
    ) -> Result<(), Cancelled> {
        let len = bytes.len();
        let start = tail.map_or(0, |from| self.next(bytes, from, len).unwrap_or(len));
        progress.start((len - start) as u64);
        let report = &log.report.clone();
        let is_growing = reading.is_growing;
        let walk = MessageWalk { format: self, bytes, report, is_growing, progress };
        walk.run(start, |message| take(log, message))
    }
}

/// A walk over the messages of a file.
pub(super) struct MessageWalk<'a> {
    /// Format of the messages.
    pub(super) format: MessageFormat,
    /// The whole file.
    pub(super) bytes: &'a [u8],
    /// Report for warnings.
    pub(super) report: &'a WarningReport,
    /// True if the file is still being written: a truncated last message is then no damage.
    pub(super) is_growing: bool,
    /// Progress of the walk.
    pub(super) progress: &'a Progress,
}

impl MessageWalk<'_> {
    /// Calls `take` with the range of every whole message from `start` on; fails only if cancelled.
    pub(super) fn run(
        &self,
        start: usize,
        mut take: impl FnMut(Range<usize>),
    ) -> Result<(), Cancelled> {
        let mut longest = 0;
        self.progress.walk(start, self.bytes.len(), |at| {
            Ok(match self.format.message(self.bytes, at) {
                Some(message) => self.step(message, &mut longest, &mut take),
                None => self.over_gap(at),
            })
        })
    }

    /// Passes a message to `take`, unless it is damaged or truncated; returns the offset at which
    /// to continue. `longest` is the length of the longest message before.
    fn step(
        &self,
        message: Range<usize>,
        longest: &mut usize,
        take: &mut impl FnMut(Range<usize>),
    ) -> usize {
        let (len, noun) = (self.bytes.len(), self.format.noun);
        let Range { start, end } = message;
        // A damaged length may end at the start of another message by chance. Only a message that
        // is longer than all before is searched for messages inside it.
        let is_usual = end - start <= *longest || self.inside(&message).is_none();
        if is_usual && self.format.is_border(self.bytes, end) {
            *longest = (*longest).max(end - start);
            take(start..end);
            return end;
        }
        // Something is damaged: the length of this message if another message begins inside it,
        // otherwise the bytes after it.
        if let Some(found) = self.format.next(self.bytes, start + 2, end) {
            let text = format!(
                "a {noun} says that it is {} bytes long, but the next begins after {}; it was dropped",
                end - start,
                found - start
            );
            self.report.at(WarningKind::Frame, 0, start, text);
            return found;
        }
        if end > len && self.is_growing {
            return len;
        }
        if end > len {
            let text = format!(
                "the file was cut inside its last {noun} ({} bytes of it are there); it was dropped",
                len - start
            );
            self.report.at(WarningKind::Frame, 0, start, text);
            return len;
        }
        take(start..end);
        end
    }

    /// Returns the offset inside a message from which other messages follow each other up to its
    /// end; `None` where there are none, as in a whole message.
    fn inside(&self, message: &Range<usize>) -> Option<usize> {
        let first = self.format.next(self.bytes, message.start + 2, message.end)?;
        let mut at = first;
        while at < message.end {
            at = self.format.message(self.bytes, at)?.end;
        }
        (at == message.end).then_some(first)
    }

    fn over_gap(&self, at: usize) -> usize {
        let len = self.bytes.len();
        let found = self.format.next(self.bytes, at + 1, len);
        let to = found.unwrap_or(len);
        if found.is_none() && self.is_growing {
            return to;
        }
        let (skipped, noun) = (to - at, self.format.noun);
        let text = format!("{skipped} bytes belong to no {noun} and were skipped");
        self.report.at(WarningKind::Gap, 0, at, text);
        to
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
        let walk = MessageWalk {
            format: SMALL,
            bytes,
            report: &report,
            is_growing: false,
            progress: &progress,
        };
        let mut lengths = Vec::new();
        walk.run(0, |message| lengths.push(message.len())).expect("no cancel");
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
