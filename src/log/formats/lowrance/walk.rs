//! Walks from frame to frame through a log and skips damaged parts.

use super::frame::{self, FrameCheck, FrameLayout, LowranceFrame};
use crate::formats::collected::WarningKind;
use crate::formats::walk::Walk;
use crate::support::progress::Cancelled;
use std::ops::Range;

/// Number of bytes searched between two checks for cancellation.
const BYTES_A_CHECK: usize = 1 << 20;
/// Most bytes that may be missing (or inserted) in one place while the frames after it are still
/// found.
const MOST_LOST: u64 = 1 << 20;

/// A walk over the frames of a log.
pub(super) struct FrameWalk<'a> {
    /// The file, and the report of damaged frames.
    pub(super) walk: Walk<'a>,
    /// Layout of the file's frames.
    pub(super) layout: FrameLayout,
}

impl FrameWalk<'_> {
    /// Calls `take` for every whole frame from `start` on; fails only if cancelled.
    pub(super) fn run(
        &self,
        start: FrameStart,
        mut take: impl FnMut(LowranceFrame),
    ) -> Result<(), Cancelled> {
        let (mut lost, mut longest) = (start.lost, 0);
        self.walk.progress.walk(start.at, self.walk.bytes.len(), |at| {
            let here = FrameStart { at, lost };
            let next = match self.layout.look(self.walk.bytes, at, lost) {
                FrameCheck::Whole(frame) => self.step(here, frame, &mut longest, &mut take)?,
                FrameCheck::Cut => self.over_cut(here)?,
                FrameCheck::Nothing => self.over_gap(here)?,
            };
            lost = next.lost;
            Ok(next.at)
        })
    }

    /// Passes a frame to `take` if another frame follows it; where none follows, the frame's size
    /// may be damaged. A damaged size may also end at the start of another frame by chance: a frame
    /// that is longer than the `longest` before it is therefore searched for frames inside it.
    /// Returns where to continue.
    fn step(
        &self,
        here: FrameStart,
        frame: LowranceFrame,
        longest: &mut usize,
        take: &mut impl FnMut(LowranceFrame),
    ) -> Result<FrameStart, Cancelled> {
        let next = here.at + frame.size;
        let goes_on = next == self.walk.bytes.len()
            || frame::lost_before(self.walk.bytes, next) == Some(here.lost);
        if !goes_on || frame.size > *longest {
            let inside = here.at + self.layout.shortest_header();
            let found = self.find(inside, next, here.lost)?;
            if let Some(found) = found.filter(|found| !goes_on || self.reaches(*found, next)) {
                self.walk.over_long(here.at, next, found.at);
                return Ok(found);
            }
        }
        *longest = frame.size.max(*longest);
        take(frame);
        Ok(FrameStart { at: next, ..here })
    }

    /// Returns true if whole frames from `start` on end exactly at `end`.
    fn reaches(&self, start: FrameStart, end: usize) -> bool {
        let mut at = start.at;
        while at < end {
            match self.layout.look(self.walk.bytes, at, start.lost) {
                FrameCheck::Whole(frame) => at += frame.size,
                _ => return false,
            }
        }
        at == end
    }

    fn over_cut(&self, here: FrameStart) -> Result<FrameStart, Cancelled> {
        let Some(found) = self.find(here.at + 4, self.walk.bytes.len(), here.lost)? else {
            return Ok(FrameStart { at: self.walk.over_cut(here.at, "recording"), ..here });
        };
        let text = "a frame header is damaged; the frame was dropped";
        self.walk.report.at(WarningKind::Frame, 0, here.at, text);
        Ok(found)
    }

    fn over_gap(&self, here: FrameStart) -> Result<FrameStart, Cancelled> {
        let len = self.walk.bytes.len();
        let found = self.find(here.at + 1, len, here.lost)?;
        let to = found.unwrap_or(FrameStart { at: len, ..here });
        if found.is_none() && self.walk.is_growing {
            return Ok(to);
        }
        let bytes = to.at - here.at;
        let text = match found {
            Some(found) if found.lost != here.lost => format!(
                "{bytes} bytes belong to no frame and were skipped; {} bytes were lost around here",
                found.lost - here.lost
            ),
            Some(_) => format!("{bytes} bytes belong to no frame and were skipped"),
            // Some recorders add such an end to a file. A truncated frame has at least its own
            // offset.
            None if bytes < size_of::<u32>() => return Ok(to),
            None => {
                format!("the last {bytes} bytes of the file belong to no frame and were skipped")
            }
        };
        self.walk.report.at(WarningKind::Gap, 0, here.at, text);
        Ok(to)
    }

    /// Returns the first whole frame that begins in `from..to`.
    fn find(&self, from: usize, to: usize, lost: i64) -> Result<Option<FrameStart>, Cancelled> {
        let mut at = from;
        while at < to.min(self.walk.bytes.len()) {
            self.walk.progress.check()?;
            let until = to.min(at.saturating_add(BYTES_A_CHECK));
            if let Some(found) = first_frame(self.walk.bytes, self.layout, at..until, lost) {
                return Ok(Some(found));
            }
            at = until;
        }
        Ok(None)
    }
}

/// Beginning of a frame, and the number of bytes that the file lost before it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct FrameStart {
    /// Offset in the file.
    pub(super) at: usize,
    /// Number of lost bytes; negative where bytes were inserted.
    pub(super) lost: i64,
}

/// Returns the first whole frame that begins in `range`. `lost` bytes are known to be missing
/// before the range: a frame that agrees with this number is accepted; otherwise the frame after it
/// must agree with it.
pub(super) fn first_frame(
    bytes: &[u8],
    layout: FrameLayout,
    range: Range<usize>,
    lost: i64,
) -> Option<FrameStart> {
    (range.start..range.end.min(bytes.len()))
        .filter_map(|at| Some(FrameStart { at, lost: frame::lost_before(bytes, at)? }))
        .filter(|place| place.lost.abs_diff(lost) <= MOST_LOST)
        .find(|place| {
            let FrameCheck::Whole(frame) = layout.look(bytes, place.at, place.lost) else {
                return false;
            };
            let next = layout.look(bytes, place.at + frame.size, place.lost);
            place.lost == lost || matches!(next, FrameCheck::Whole(_))
        })
}
