//! Decodes the sides of a side-scan frame, which has both sides (channel 5) or one (channels 3 and
//! 4), and pings of channels that look down.

use super::frame::{LowranceFrame, metres};
use super::swath;
use crate::formats::collected::{Collected, HalfPing, is_range, is_sound};
use crate::formats::report::WarningKind;
use crate::survey::{ChannelKind, SampleOrder, SidePing, SideSpan};
use std::ops::Range;

/// Adds the sides of a frame, or its ping of a channel that looks down, to the log; warns where it
/// cannot be shown as a picture.
pub(super) fn keep(log: &mut Collected, kind: ChannelKind, frame: &LowranceFrame, time_s: f64) {
    if let ChannelKind::Primary | ChannelKind::Secondary | ChannelKind::DownScan = kind {
        return log.add_echogram(kind, time_s, alone(frame));
    }
    let spans = match kind {
        ChannelKind::Composite => composite(frame),
        ChannelKind::Port => [Some(alone(frame)), None],
        ChannelKind::Starboard => [None, Some(alone(frame))],
        _ => return,
    };
    let half = |span| HalfPing { time_s, span };
    match (kind, spans.map(|span| span.filter(is_sound))) {
        (_, [None, None]) => {
            let text = format!(
                "a side-scan frame has {} samples over {} to {} ft, which is no picture; it was dropped",
                frame.data_len, frame.min_range_ft, frame.max_range_ft
            );
            log.report.at(WarningKind::Value, 0, frame.offset, text);
        }
        (ChannelKind::Composite, [port, starboard]) => {
            let ping = SidePing::with_depth(time_s, f32::NAN);
            log.composite.push(SidePing { port, starboard, ..ping });
        }
        (_, [port, starboard]) => {
            log.port.extend(port.map(half));
            log.starboard.extend(starboard.map(half));
        }
    }
}

/// Returns the number of samples of one side; for a swath the most depths of both sides that the
/// frame can contain, with unused ones.
pub(super) fn samples_a_side(kind: ChannelKind, frame: &LowranceFrame) -> usize {
    match kind {
        ChannelKind::Composite => frame.data_len / 2,
        ChannelKind::Swath => swath::most_pairs(frame),
        _ => frame.data_len,
    }
}

/// Returns the near and far limit of the range, metres; `None` where the frame states no plausible
/// one.
pub(super) fn range_m(kind: ChannelKind, frame: &LowranceFrame) -> Option<(f32, f32)> {
    let (near_m, far_m) = match kind {
        ChannelKind::Composite => (0.0, metres(frame.max_range_ft)),
        ChannelKind::Port | ChannelKind::Starboard => {
            let span = alone(frame);
            (span.near_m, span.far_m)
        }
        // In raw products these fields have another meaning.
        ChannelKind::Swath | ChannelKind::Other(_) => return None,
        _ => (metres(frame.min_range_ft), metres(frame.max_range_ft)),
    };
    is_range(near_m, far_m).then_some((near_m, far_m))
}

/// Returns both halves of a composite frame: from far port through the nadir, where the range is 0,
/// to far starboard.
fn composite(frame: &LowranceFrame) -> [Option<SideSpan>; 2] {
    let (min_m, starboard_m) = (metres(frame.min_range_ft), metres(frame.max_range_ft));
    let port_m = if min_m < 0.0 { -min_m } else { starboard_m };
    let share = (port_m / (port_m + starboard_m)).clamp(0.0, 1.0);
    let middle = (frame.data_len as f32 * share) as usize;
    let port = span(frame, 0..middle, SampleOrder::FarToNear, [0.0, port_m]);
    let rest = middle..frame.data_len;
    let starboard = span(frame, rest, SampleOrder::NearToFar, [0.0, starboard_m]);
    [Some(port), Some(starboard)]
}

/// Returns the samples of a frame of one side, or of a channel that looks down; the first sample is
/// the nearest.
fn alone(frame: &LowranceFrame) -> SideSpan {
    let a_m = metres(frame.min_range_ft).abs();
    let b_m = metres(frame.max_range_ft).abs();
    let all = 0..frame.data_len;
    span(frame, all, SampleOrder::NearToFar, [a_m.min(b_m), a_m.max(b_m)])
}

/// Returns a part of a frame's samples, with their near and far limit in metres.
fn span(
    frame: &LowranceFrame,
    samples: Range<usize>,
    order: SampleOrder,
    range_m: [f32; 2],
) -> SideSpan {
    SideSpan {
        order,
        offset: (frame.data_offset + samples.start) as u64,
        ..SideSpan::of_bytes(samples.len() as u32, range_m)
    }
}
