//! Part of a log that is read: all of it, or the records added to a log that is known.

use crate::survey::{Seam, Survey};

/// Way in which a log is read. The default one is all of a log that is whole.
#[derive(Clone, Copy, Default)]
pub(super) struct Reading<'a> {
    /// More of it is being written: a record that is cut at its end comes later and is no damage.
    pub(super) is_growing: bool,
    /// The log as it was read before, and from where on it is read now.
    pub(super) tail: Option<(&'a Survey, &'a Seam)>,
}

impl<'a> Reading<'a> {
    /// The log as it was read before; `None` where all of it is read.
    pub(super) fn known(&self) -> Option<&'a Survey> {
        self.tail.map(|(known, _)| known)
    }

    /// Bytes of a file before which nothing is read; `None` where all of it is.
    pub(super) fn from(&self, file: usize) -> Option<usize> {
        let (_, seam) = self.tail?;
        let from = seam.from.get(file).copied().unwrap_or(0);
        usize::try_from(from).ok().filter(|from| *from > 0)
    }

    /// Returns for each file the number of bytes whose records were counted before.
    pub(super) fn counted_to(&self) -> Vec<u64> {
        let bytes = self.tail.map(|(known, _)| known.bytes.iter());
        let lengths = bytes.into_iter().flatten().map(|file| file.len() as u64);
        lengths.collect()
    }
}
