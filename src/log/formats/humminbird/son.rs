//! Walks from ping to ping through a SON file. The IDX file beside it is not needed: magic numbers
//! and lengths are sufficient.

use super::ping::{MAGIC, PingHeader};
use crate::formats::ByteOrder;
use crate::formats::report::{WarningKind, WarningReport};
use crate::support::progress::{Cancelled, Progress};

/// Bytes in which the first pings of a file are searched.
const SEARCHED_FOR_PINGS: usize = 1 << 20;

/// Returns the byte order of a file's numbers: the order in which the length of a ping leads to the
/// next ping. `None` where there is no ping in the first megabyte.
pub(super) fn byte_order(bytes: &[u8]) -> Option<ByteOrder> {
    let until = bytes.len().min(SEARCHED_FOR_PINGS);
    let mut fallback = None;
    let mut at = 0;
    while let Some(offset) = next_magic(bytes, at).filter(|&offset| offset < until) {
        for order in [ByteOrder::Big, ByteOrder::Little] {
            if let Some(ping) = PingHeader::parse(bytes, offset, order) {
                let next = offset + ping.size();
                if bytes.get(next..next + MAGIC.len()) == Some(&MAGIC) || next == bytes.len() {
                    return Some(order);
                }
                fallback = fallback.or(Some(order));
            }
        }
        at = offset + 1;
    }
    fallback
}

/// A walk over one SON file.
pub(super) struct SonWalk<'a> {
    /// The whole file.
    pub(super) bytes: &'a [u8],
    /// Index of the file in the survey.
    pub(super) file: usize,
    /// Byte order of the file's numbers.
    pub(super) order: ByteOrder,
    /// Report for warnings.
    pub(super) report: &'a WarningReport,
    /// True if the file is still being written: a truncated last ping is then no damage.
    pub(super) is_growing: bool,
    /// Progress of the walk.
    pub(super) progress: &'a Progress,
}

impl SonWalk<'_> {
    /// Calls `take` with the offset and the header of every whole ping, beginning at or after
    /// `from` if it is given; fails only if cancelled.
    pub(super) fn run(
        &self,
        from: Option<usize>,
        mut take: impl FnMut(usize, PingHeader),
    ) -> Result<(), Cancelled> {
        let len = self.bytes.len();
        let start = from.map_or(0, |from| next_magic(self.bytes, from).unwrap_or(len));
        self.progress.advance(start as u64);
        self.progress.walk(start, len, |at| {
            Ok(match PingHeader::parse(self.bytes, at, self.order) {
                Some(ping) => self.step(at, ping, &mut take),
                None => self.over_gap(at),
            })
        })
    }

    /// Passes a ping to `take` if another ping follows it; where none follows, the sample count may
    /// be damaged. Returns the offset of the next ping.
    fn step(&self, at: usize, ping: PingHeader, take: &mut impl FnMut(usize, PingHeader)) -> usize {
        let len = self.bytes.len();
        let next = at.saturating_add(ping.size());
        let goes_on = next == len || self.bytes.get(next..next + MAGIC.len()) == Some(&MAGIC);
        if goes_on {
            take(at, ping);
            return next;
        }
        let inside = next_magic(self.bytes, at + ping.header_len).filter(|&found| found < next);
        if let Some(found) = inside {
            let text = format!(
                "a ping says that it has {} samples, but the next begins after {}; it was dropped",
                ping.sample_count,
                found - at - ping.header_len
            );
            self.report.at(WarningKind::Frame, self.file, at, text);
            return found;
        }
        if next > len && self.is_growing {
            return len;
        }
        if next > len {
            let text = format!(
                "the recording was cut inside its last ping ({} bytes of it are there); it was dropped",
                len - at
            );
            self.report.at(WarningKind::Frame, self.file, at, text);
            return len;
        }
        take(at, ping);
        next
    }

    fn over_gap(&self, at: usize) -> usize {
        let found = next_magic(self.bytes, at + 1);
        let to = found.unwrap_or(self.bytes.len());
        if found.is_none() && self.is_growing {
            return to;
        }
        let text = format!("{} bytes belong to no ping and were skipped", to - at);
        self.report.at(WarningKind::Gap, self.file, at, text);
        to
    }
}

/// Returns the offset of the first magic number at or after `from`.
fn next_magic(bytes: &[u8], from: usize) -> Option<usize> {
    let searched = bytes.get(from..)?;
    searched.windows(4).position(|window| window == MAGIC).map(|at| from + at)
}
