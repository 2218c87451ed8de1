//! Walks from record to record through an RSD file and skips damaged parts.

use super::record::{BEFORE_MAGIC, MAGIC, RecordHeader};
use crate::formats::report::{WarningKind, WarningReport};
use crate::formats::scalar::u32_le;
use crate::support::progress::{Cancelled, Progress};

/// First four bytes of the trailer of a record, as a number.
const TRAILER_MAGIC: u32 = 0xF98E_ACBC;
/// Bytes of the trailer: the magic number, the record's length, a checksum.
const TRAILER: usize = 12;

/// A walk over the records of a file.
pub(super) struct RecordWalk<'a> {
    /// The whole file.
    pub(super) bytes: &'a [u8],
    /// Report for warnings.
    pub(super) report: &'a WarningReport,
    /// True if the file is still being written: a truncated last record is then no damage.
    pub(super) is_growing: bool,
    /// Progress of the walk.
    pub(super) progress: &'a Progress,
}

impl RecordWalk<'_> {
    /// Calls `take` with the offset and the header of every whole record from `start` on; fails
    /// only if cancelled.
    pub(super) fn run(
        &self,
        start: usize,
        mut take: impl FnMut(usize, &RecordHeader),
    ) -> Result<(), Cancelled> {
        self.progress.walk(start, self.bytes.len(), |at| {
            Ok(match RecordHeader::read(self.bytes, at) {
                Some(header) => self.step(at, &header, &mut take),
                None => self.over_gap(at),
            })
        })
    }

    /// Passes a record to `take` if another record follows it; where none follows, the size in its
    /// header may be damaged. Returns the offset of the next record.
    fn step(
        &self,
        at: usize,
        header: &RecordHeader,
        take: &mut impl FnMut(usize, &RecordHeader),
    ) -> usize {
        let (len, end) = (self.bytes.len(), header.end());
        if let Some(next) = behind(self.bytes, end) {
            take(at, header);
            return next;
        }
        if let Some(found) = next_record(self.bytes, header.body, end) {
            let text = format!(
                "a record says that it is {} bytes long, but the next begins after {}; it was dropped",
                end - at,
                found - at
            );
            self.report.at(WarningKind::Frame, 0, at, text);
            return found;
        }
        if end <= len {
            take(at, header);
            return end;
        }
        if !self.is_growing {
            let text = format!(
                "the recording was cut inside its last record ({} bytes of it are there); it was dropped",
                len - at
            );
            self.report.at(WarningKind::Frame, 0, at, text);
        }
        len
    }

    fn over_gap(&self, at: usize) -> usize {
        let len = self.bytes.len();
        let found = next_record(self.bytes, at + 1, len);
        let to = found.unwrap_or(len);
        if found.is_none() && self.is_growing {
            return to;
        }
        let text = format!("{} bytes belong to no record and were skipped", to - at);
        self.report.at(WarningKind::Gap, 0, at, text);
        to
    }
}

/// Returns the offset of the record after one that ends at `end`, if the bytes there confirm this
/// end: a trailer, which may be truncated, another record without a trailer between, or the end of
/// the file.
fn behind(bytes: &[u8], end: usize) -> Option<usize> {
    let len = bytes.len();
    let next = end.saturating_add(TRAILER);
    let is_record = |at| RecordHeader::read(bytes, at).is_some();
    let has_trailer = u32_le(bytes, end) == Some(TRAILER_MAGIC);
    if has_trailer || next == len || is_record(next) {
        Some(next.min(len)).filter(|_| end <= len)
    } else {
        (end == len || is_record(end)).then_some(end)
    }
}

/// Returns the offset of the first record header that begins in `from..to`: the magic number and
/// readable fields identify it.
pub(super) fn next_record(bytes: &[u8], from: usize, to: usize) -> Option<usize> {
    let to = to.min(bytes.len());
    let mut at = from;
    while at < to {
        let magic = at.checked_add(BEFORE_MAGIC)?;
        let searched = bytes.get(magic..)?;
        let found = at + find_magic(searched, to - at)?;
        if RecordHeader::read(bytes, found).is_some() {
            return Some(found);
        }
        at = found + 1;
    }
    None
}

/// Returns the index of the first magic number that begins within the first `places` bytes.
fn find_magic(searched: &[u8], places: usize) -> Option<usize> {
    let windows = searched.windows(MAGIC.len()).take(places);
    windows.into_iter().position(|window| window == MAGIC.as_slice())
}
