//! From frame to frame through a log, over whatever is damaged in it.

use super::frame::{Found, Frame, Layout};
use crate::formats::report::{Kind, Report};
use crate::formats::scalar;
use crate::progress::{Cancelled, Progress};

/// Frames between two looks at the progress.
const FRAMES_A_CHECK: usize = 1024;
/// Bytes searched between two looks at the progress.
const BYTES_A_CHECK: usize = 1 << 20;

/// A walk over the frames of a log.
pub(super) struct Walk<'a> {
    /// The whole file.
    pub(super) bytes: &'a [u8],
    /// Its frames' layout.
    pub(super) layout: Layout,
    /// Where to say what is wrong.
    pub(super) report: &'a mut Report,
    /// Where to say how far it is.
    pub(super) progress: &'a Progress,
}

impl Walk<'_> {
    /// Calls `take` for every whole frame from `start` on.
    pub(super) fn run(
        &mut self,
        start: usize,
        mut take: impl FnMut(Frame),
    ) -> Result<(), Cancelled> {
        let mut at = start;
        let mut told = start;
        let mut frames = 0_usize;
        while at < self.bytes.len() {
            if frames.is_multiple_of(FRAMES_A_CHECK) {
                self.progress.check()?;
                self.progress.advance((at - told) as u64);
                told = at;
            }
            frames += 1;
            at = match self.layout.look(self.bytes, at) {
                Found::Whole(frame) => self.step(frame, &mut take)?,
                Found::Cut => self.over_cut(at)?,
                Found::Nothing => self.over_gap(at)?,
            };
        }
        self.progress.advance((self.bytes.len() - told) as u64);
        Ok(())
    }

    /// Takes a frame if the chain goes on behind it; where it does not, the frame's size may be what is damaged.
    fn step(&mut self, frame: Frame, take: &mut impl FnMut(Frame)) -> Result<usize, Cancelled> {
        let next = frame.offset + frame.size;
        let goes_on =
            next == self.bytes.len() || scalar::u32_le(self.bytes, next) == Some(next as u32);
        if goes_on {
            take(frame);
            return Ok(next);
        }
        let inside = frame.offset + self.layout.shortest_header();
        match self.find(inside, next)? {
            Some(found) => {
                let text = format!(
                    "a frame says that it is {} bytes long, but the next begins after {}; it was dropped",
                    frame.size,
                    found - frame.offset
                );
                self.report.at(Kind::Frame, 0, frame.offset, text);
                Ok(found)
            }
            None => {
                take(frame);
                Ok(next)
            }
        }
    }

    fn over_cut(&mut self, at: usize) -> Result<usize, Cancelled> {
        let len = self.bytes.len();
        if let Some(found) = self.find(at + 4, len)? {
            let text = "a frame header is damaged; the frame was dropped".to_owned();
            self.report.at(Kind::Frame, 0, at, text);
            return Ok(found);
        }
        let text = format!(
            "the recording was cut inside its last frame ({} bytes of it are there); it was dropped",
            len - at
        );
        self.report.at(Kind::Frame, 0, at, text);
        Ok(len)
    }

    fn over_gap(&mut self, at: usize) -> Result<usize, Cancelled> {
        let len = self.bytes.len();
        let found = self.find(at + 1, len)?;
        let to = found.unwrap_or(len);
        let text = match found {
            Some(_) => format!("{} bytes belong to no frame and were skipped", to - at),
            None => format!(
                "the last {} bytes of the file belong to no frame and were skipped",
                to - at
            ),
        };
        self.report.at(Kind::Gap, 0, at, text);
        Ok(to)
    }

    /// The first whole frame that begins in `from..to`: a number that is its own offset, with a header behind it.
    fn find(&self, from: usize, to: usize) -> Result<Option<usize>, Cancelled> {
        let mut at = from;
        while at < to.min(self.bytes.len()) {
            self.progress.check()?;
            let until = to.min(at.saturating_add(BYTES_A_CHECK));
            if let Some(found) = first_frame(self.bytes, self.layout, at, until) {
                return Ok(Some(found));
            }
            at = until;
        }
        Ok(None)
    }
}

/// The first whole frame that begins in `from..to`.
pub(super) fn first_frame(bytes: &[u8], layout: Layout, from: usize, to: usize) -> Option<usize> {
    let searched = bytes.get(from..bytes.len().min(to.saturating_add(3)))?;
    searched
        .windows(4)
        .enumerate()
        .map(|(index, window)| (from + index, window))
        .filter(|(at, window)| {
            u32::from_le_bytes([window[0], window[1], window[2], window[3]]) == *at as u32
        })
        .map(|(at, _)| at)
        .find(|&at| matches!(layout.look(bytes, at), Found::Whole(_)))
}
