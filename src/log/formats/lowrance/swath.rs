//! Reads the frames of StructureScan 3D (channel 9 of SL3): depths across the track.
//!
//! After the frame header comes another header of i32: its own length (76), bytes of the pairs to
//! port and to starboard, bytes of the unreliable pairs, and how many of the unreliable pairs are
//! on each side. Then come the pairs in that order: distance outward and depth, f32, feet. The
//! packet length in the frame header is wrong for these frames: their length is given by the frame
//! size.
//!
//! The layout is taken from the public reader SL3Reader (`3D.cs`, `InterferometricMeasurement.cs`
//! and `SL3Reader.cs` of github.com/halmaia/SL3Reader). It was not tried on a real recording.

use super::frame::LowranceFrame;
use crate::formats::collected::Collected;
use crate::formats::report::WarningKind;
use crate::formats::scalar;
use crate::survey::{SWATH_PAIR, SwathPing, swath_pair_m};

/// Shortest header before the pairs, bytes.
const HEADER: usize = 76;
/// Longest plausible header before the pairs, bytes.
const LONGEST_HEADER: usize = 256;

/// Totals of all frames that were read, for a warning.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct SwathTotals {
    frames: usize,
    pairs: usize,
    unreliable: usize,
}

impl SwathTotals {
    /// Adds the depths of a frame to the log; warns where they are damaged.
    pub(super) fn keep(&mut self, log: &mut Collected, frame: &LowranceFrame, time_s: f64) {
        let read = {
            let bytes = &log.bytes[0];
            read(bytes, frame, time_s).map(|ping| (ping, damaged(bytes, &ping)))
        };
        let Some((ping, damaged)) = read else {
            let text = "a frame of StructureScan 3D does not hold as many depths as it says; it was dropped";
            return log.report.at(WarningKind::Frame, 0, frame.offset, text);
        };
        if damaged > 0 {
            let text = format!(
                "{damaged} of {} depths in a frame of StructureScan 3D cannot be; they were dropped",
                ping.len()
            );
            log.report.at(WarningKind::Value, 0, frame.offset, text);
        }
        self.frames += 1;
        self.pairs += ping.len() - damaged;
        self.unreliable += usize::from(ping.unreliable);
        log.swath.push(ping);
    }

    /// Adds a warning with the totals, if there were frames.
    pub(super) fn report(&self, log: &Collected) {
        let Self { frames, pairs, unreliable } = self;
        if *frames > 0 {
            log.report.log(format!(
                "the log holds {frames} frames of StructureScan 3D with {pairs} depths across the track; {unreliable} more that the unit marks as unreliable are not used. The format was not tried on a real recording: compare these depths with the soundings"
            ));
        }
    }
}

/// Returns the most pairs that a frame can contain.
pub(super) fn most_pairs(frame: &LowranceFrame) -> usize {
    frame.data_len.saturating_sub(HEADER) / SWATH_PAIR
}

/// Finds the pairs of a frame; `None` where the frame is too short for the pairs that its header
/// states.
fn read(bytes: &[u8], frame: &LowranceFrame, time_s: f64) -> Option<SwathPing> {
    let data = bytes.get(frame.data_offset..frame.data_offset + frame.data_len)?;
    let length = |at: usize| usize::try_from(scalar::u32_le(data, at)?).ok();
    let header = length(0).filter(|header| (HEADER..=LONGEST_HEADER).contains(header))?;
    let [port, starboard, unreliable] = [length(4)?, length(8)?, length(12)?];
    let end = [port, starboard, unreliable].into_iter().try_fold(header, usize::checked_add)?;
    let are_pairs = (port | starboard | unreliable).is_multiple_of(SWATH_PAIR);
    if end > data.len() || !are_pairs {
        return None;
    }
    // The conversion does not fail, because a frame is shorter than 64 KiB.
    let pairs = |bytes: usize| u16::try_from(bytes / SWATH_PAIR).ok();
    Some(SwathPing {
        time_s,
        offset: (frame.data_offset + header) as u64,
        file: 0,
        port: pairs(port)?,
        starboard: pairs(starboard)?,
        unreliable: pairs(unreliable)?,
    })
}

/// Returns the number of pairs of a ping that are no plausible depths.
fn damaged(bytes: &[u8], ping: &SwathPing) -> usize {
    let start = ping.offset as usize;
    let pairs = bytes.get(start..start + SWATH_PAIR * ping.len()).unwrap_or_default();
    let (pairs, _) = pairs.as_chunks::<SWATH_PAIR>();
    let can_be = |pair: &&[u8; SWATH_PAIR]| swath_pair_m(**pair).is_some();
    ping.len() - pairs.iter().filter(can_be).count()
}
