//! Decodes frames of Lowrance logs to pings, depths and fixes in SI units.
//!
//! A side-scan frame has both sides (channel 5) or one (channels 3 and 4).
//!
//! A frame of StructureScan 3D (channel 9 of SL3) has depths across the track. After the frame
//! header comes another header of i32: its own length (76), bytes of the pairs to port and to
//! starboard, bytes of the unreliable pairs, and how many of the unreliable pairs are on each side.
//! Then come the pairs in that order: distance outward and depth, f32, feet. The packet length in
//! the frame header is wrong for these frames: their length is given by the frame size.
//!
//! This layout is taken from the public reader SL3Reader (`3D.cs`, `InterferometricMeasurement.cs`
//! and `SL3Reader.cs` of github.com/halmaia/SL3Reader). It was not tried on a real recording.

use super::frame::{LowranceFrame, STRUCTURE_SCAN_3D, metres};
use crate::formats::clock::{Clock, ClockVerdict, UNIX_S};
use crate::formats::collected::{Collected, Counted, HalfPing, WarningKind, is_range, is_sound};
use crate::formats::scalar;
use crate::support::geo::{self, LonLat, MPS_PER_KNOT};
use crate::survey::{
    ChannelKind, Fix, SWATH_PAIR, SampleOrder, SidePing, SideSpan, SwathPing, swath_pair_m,
};
use std::ops::Range;

/// Shortest header before the pairs of a frame of StructureScan 3D, bytes.
const SWATH_HEADER: usize = 76;
/// Longest plausible header before the pairs, bytes.
const LONGEST_SWATH_HEADER: usize = 256;

/// Decodes frames, two frames behind the walk so that damaged times are recognised.
#[derive(Default)]
pub(super) struct Reader {
    clock: Clock<LowranceFrame>,
    keel_ft: f32,
    swath: SwathTotals,
    /// The last position, as recorded and in degrees, for reuse: units repeat a fix for tens of
    /// frames.
    place: Option<([i32; 2], LonLat)>,
}

impl Reader {
    /// Decodes the next frame of the file.
    pub(super) fn take(&mut self, log: &mut Collected, frame: LowranceFrame) {
        if let Some(verdict) = self.clock.push(time_s(&frame), frame) {
            self.settle(log, verdict);
        }
    }

    /// Processes the frames that still wait for a verdict of the clock, and warns about a keel
    /// offset.
    pub(super) fn finish(&mut self, log: &mut Collected) {
        while let Some(verdict) = self.clock.next() {
            self.settle(log, verdict);
        }
        log.report.set_back(self.clock.set_back_s);
        self.swath.report(log);
        if self.keel_ft != 0.0 {
            let keel_m = metres(self.keel_ft);
            log.report.log(format!(
                "the unit added a keel offset of {keel_m:.2} m to the depths it shows; it was taken off again, so that depths count from the transducer; set draft_m to what the transducer hangs below the water's surface",
            ));
        }
    }

    fn settle(&mut self, log: &mut Collected, verdict: ClockVerdict<LowranceFrame>) {
        match verdict {
            ClockVerdict::Sound { record, time_s } => self.keep(log, &record, time_s),
            ClockVerdict::Damaged(frame) => {
                let time = format!("a frame's time ({:.1} s)", time_s(&frame));
                log.report.odd_time(0, frame.offset, &time);
            }
        }
    }

    fn keep(&mut self, log: &mut Collected, frame: &LowranceFrame, time_s: f64) {
        let kind = channel_kind(frame.channel);
        if log.start_unix_s.is_none() && UNIX_S.contains(&frame.clock) {
            log.start_unix_s = Some(f64::from(frame.clock));
        }
        let counted = Counted {
            record: (0, frame.offset + frame.size),
            time_s,
            samples: samples_a_side(kind, frame),
            range_m: range_m(kind, frame),
        };
        log.count(frame.channel, counted, || {
            (kind, frame.channel.to_string(), frequency_khz(frame.frequency))
        });
        let is_sonar = !matches!(kind, ChannelKind::Swath | ChannelKind::Other(_));
        if is_sonar && frame.depth_ft > 0.0 {
            // Keel offsets above a metre are rare; ten metres are damage.
            let keel_ft = Some(frame.keel_ft).filter(|ft| ft.abs() < 33.0).unwrap_or(0.0);
            self.keel_ft = keel_ft;
            log.add_depth(kind, time_s, metres(frame.depth_ft) - metres(keel_ft));
        }
        if frame.x_m != 0 && frame.y_m != 0 {
            log.add_fix(fix(frame, time_s, self.position(frame)));
        }
        match kind {
            ChannelKind::Swath => self.swath.keep(log, frame, time_s),
            _ => keep_echoes(log, kind, frame, time_s),
        }
    }

    fn position(&mut self, frame: &LowranceFrame) -> LonLat {
        let recorded = [frame.x_m, frame.y_m];
        if let Some((_, degrees)) = self.place.filter(|(place, _)| *place == recorded) {
            return degrees;
        }
        let degrees = geo::lowrance_mercator_inverse(f64::from(frame.x_m), f64::from(frame.y_m));
        self.place = Some((recorded, degrees));
        degrees
    }
}

fn fix(frame: &LowranceFrame, time_s: f64, position: LonLat) -> Fix {
    let known = |value: f32| if value.is_finite() { value } else { f32::NAN };
    Fix {
        time_s,
        position,
        cog_rad: known(frame.course_rad),
        // Without a compass this field is 0 on every unit seen.
        compass_rad: if frame.heading_rad == 0.0 { f32::NAN } else { known(frame.heading_rad) },
        speed_mps: if frame.speed_kn >= 0.0 {
            (f64::from(frame.speed_kn) * MPS_PER_KNOT) as f32
        } else {
            f32::NAN
        },
    }
}

fn channel_kind(channel: u16) -> ChannelKind {
    match channel {
        0 => ChannelKind::Primary,
        1 => ChannelKind::Secondary,
        2 => ChannelKind::DownScan,
        3 => ChannelKind::Port,
        4 => ChannelKind::Starboard,
        5 => ChannelKind::Composite,
        STRUCTURE_SCAN_3D => ChannelKind::Swath,
        other => ChannelKind::Other(other),
    }
}

/// Nominal frequencies by code, kHz; for the chirp codes the middle of the band.
pub(super) const FREQUENCIES_KHZ: [f32; 11] =
    [200.0, 50.0, 83.0, 455.0, 800.0, 38.0, 28.0, 170.0, 120.0, 50.0, 35.0];

fn frequency_khz(code: u16) -> Option<f32> {
    FREQUENCIES_KHZ.get(usize::from(code)).copied()
}

fn time_s(frame: &LowranceFrame) -> f64 {
    f64::from(frame.time_ms) / 1000.0
}

/// Adds the sides of a frame, or its ping of a channel that looks down, to the log; warns where it
/// cannot be shown as a picture.
fn keep_echoes(log: &mut Collected, kind: ChannelKind, frame: &LowranceFrame, time_s: f64) {
    if kind.looks_down() {
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
fn samples_a_side(kind: ChannelKind, frame: &LowranceFrame) -> usize {
    match kind {
        ChannelKind::Composite => frame.data_len / 2,
        ChannelKind::Swath => most_pairs(frame),
        _ => frame.data_len,
    }
}

/// Returns the near and far limit of the range, metres; `None` where the frame states no plausible
/// one.
fn range_m(kind: ChannelKind, frame: &LowranceFrame) -> Option<(f32, f32)> {
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

/// Totals of all frames that were read, for a warning.
#[derive(Clone, Copy, Debug, Default)]
struct SwathTotals {
    frames: usize,
    pairs: usize,
    unreliable: usize,
}

impl SwathTotals {
    /// Adds the depths of a frame to the log; warns where they are damaged.
    fn keep(&mut self, log: &mut Collected, frame: &LowranceFrame, time_s: f64) {
        let read = {
            let bytes = &log.bytes[0];
            swath_ping(bytes, frame, time_s).map(|ping| (ping, damaged_pairs(bytes, &ping)))
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
    fn report(&self, log: &Collected) {
        let Self { frames, pairs, unreliable } = self;
        if *frames > 0 {
            log.report.log(format!(
                "the log holds {frames} frames of StructureScan 3D with {pairs} depths across the track; {unreliable} more that the unit marks as unreliable are not used. The format was not tried on a real recording: compare these depths with the soundings"
            ));
        }
    }
}

/// Returns the most pairs that a frame can contain.
fn most_pairs(frame: &LowranceFrame) -> usize {
    frame.data_len.saturating_sub(SWATH_HEADER) / SWATH_PAIR
}

/// Finds the pairs of a frame; `None` where the frame is too short for the pairs that its header
/// states.
fn swath_ping(bytes: &[u8], frame: &LowranceFrame, time_s: f64) -> Option<SwathPing> {
    let data = bytes.get(frame.data_offset..frame.data_offset + frame.data_len)?;
    let length = |at: usize| usize::try_from(scalar::u32_le(data, at)?).ok();
    let header =
        length(0).filter(|header| (SWATH_HEADER..=LONGEST_SWATH_HEADER).contains(header))?;
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
fn damaged_pairs(bytes: &[u8], ping: &SwathPing) -> usize {
    let start = ping.offset as usize;
    let pairs = bytes.get(start..start + SWATH_PAIR * ping.len()).unwrap_or_default();
    let (pairs, _) = pairs.as_chunks::<SWATH_PAIR>();
    let can_be = |pair: &&[u8; SWATH_PAIR]| swath_pair_m(**pair).is_some();
    ping.len() - pairs.iter().filter(can_be).count()
}
