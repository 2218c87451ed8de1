//! A ping of one channel, as messages 80 and 82 hold it.

use super::message::{HEADER, MessageHeader};
use super::place::Coordinates;
use super::sensors::SOUNDS_MPS;
use super::time::unix_ms;
use crate::formats::scalar::Fields;
use crate::support::geo::MPS_PER_KNOT;
use crate::survey::{ChannelKind, Encoding, SideSpan};
use std::ops::Range;

/// A trace with a header of 240 bytes.
const TRACE: u16 = 80;
const TRACE_HEADER: usize = 240;
/// An older trace with a header of 80 bytes.
const OLD_TRACE: u16 = 82;
const OLD_TRACE_HEADER: usize = 80;
/// First version of the protocol with a field for the high bits of the number of samples.
const WITH_HIGH_BITS: u8 = 0xA;
/// Bits of the validity flags, bytes 30 and 31 of a trace.
const POSITION_VALID: u16 = 1 << 0;
const COURSE_VALID: u16 = 1 << 1;
const SPEED_VALID: u16 = 1 << 2;
const HEADING_VALID: u16 = 1 << 3;
const ALTITUDE_VALID: u16 = 1 << 6;
const SOUND_VALID: u16 = 1 << 14;

/// Content of a trace, in SI units. Missing values are NaN or `None`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Trace {
    /// Subsystem of the sonar.
    pub(super) subsystem: u8,
    /// Channel of the subsystem.
    pub(super) channel: u8,
    /// Number of the part of a ping that it holds, from 1 on; 0 where parts are not counted.
    pub(super) packet: u16,
    /// Unix milliseconds.
    pub(super) unix_ms: i64,
    /// Format of its samples, by EdgeTech's number.
    pub(super) data_format: u16,
    /// Offset of the first sample in the file.
    pub(super) samples_at: usize,
    /// Bytes from there to the end of the message.
    pub(super) room: usize,
    /// Samples.
    pub(super) samples: u32,
    /// Samples that were left out before the first.
    pub(super) first_sample: u32,
    /// Seconds from sample to sample, there and back.
    pub(super) interval_s: f64,
    /// A sample counts 2^-weight volts.
    pub(super) weight: i16,
    /// Frequency of the pulse, kHz.
    pub(super) frequency_khz: Option<f32>,
    /// Speed of sound, metres a second.
    pub(super) sound_mps: Option<f64>,
    /// Height of the sonar above the bottom, metres; 0 where it is not known.
    pub(super) altitude_m: f32,
    /// Recorded position.
    pub(super) place: Option<Coordinates>,
    /// Heading of the compass, radians.
    pub(super) heading_rad: f32,
    /// Course over ground, radians.
    pub(super) cog_rad: f32,
    /// Speed over ground, metres a second.
    pub(super) speed_mps: f32,
}

impl Trace {
    /// The trace that a whole message holds; `None` where it holds none.
    pub(super) fn of(bytes: &[u8], message: Range<usize>) -> Option<Self> {
        let header = MessageHeader::at(bytes, message.start)?;
        let body = bytes.get(message.start + HEADER..message.end)?;
        let (trace_header, parse): (_, fn(MessageHeader, Fields<'_>) -> Self) = match header.kind {
            TRACE => (TRACE_HEADER, trace),
            OLD_TRACE => (OLD_TRACE_HEADER, old_trace),
            _ => return None,
        };
        let (fields, samples) = body.split_at_checked(trace_header)?;
        Some(Self {
            samples_at: message.start + HEADER + trace_header,
            room: samples.len(),
            ..parse(header, Fields(fields))
        })
    }

    /// The trace that a span was made of; `None` where there is none before it.
    pub(super) fn of_span(bytes: &[u8], span: &SideSpan) -> Option<Self> {
        let samples_at = usize::try_from(span.offset).ok()?;
        [TRACE_HEADER, OLD_TRACE_HEADER].into_iter().find_map(|trace_header| {
            let start = samples_at.checked_sub(HEADER + trace_header)?;
            let size = MessageHeader::at(bytes, start)?.size;
            let trace = Self::of(bytes, start..start + HEADER + size)?;
            (trace.samples_at == samples_at).then_some(trace)
        })
    }

    /// Returns the kind of its channel.
    pub(super) fn kind(&self) -> ChannelKind {
        match (self.subsystem, self.channel) {
            (20..=22 | 70..=72, 0) => ChannelKind::Port,
            (20..=22 | 70..=72, 1) => ChannelKind::Starboard,
            _ => ChannelKind::Other(self.number()),
        }
    }

    /// A number for its channel.
    pub(super) fn number(&self) -> u16 {
        u16::from_be_bytes([self.subsystem, self.channel])
    }

    /// Returns the encoding of its samples, on a scale that is not set yet; `None` for formats that
    /// are not read.
    pub(super) fn encoding(&self) -> Option<Encoding> {
        match self.data_format {
            0 => Some(Encoding::ScaledU16 { base: 0, step: 0 }),
            1 => Some(Encoding::ScaledComplex { step: 0 }),
            _ => None,
        }
    }

    /// Slant range of the near edge of its first sample and of the far edge of its last, metres.
    pub(super) fn range_m(&self, sound_mps: f64) -> [f32; 2] {
        let first = f64::from(self.first_sample);
        let metres = self.interval_s * sound_mps / 2.0;
        [first, first + f64::from(self.samples)].map(|samples| (samples * metres) as f32)
    }
}

/// Returns true if a field is filled: by its flag, or by not being 0 where a recorder sets no flag
/// at all.
fn is_valid(fields: Fields<'_>, flag: u16) -> bool {
    let flags = fields.u16(30);
    flags == 0 || flags & flag != 0
}

fn trace(header: MessageHeader, fields: Fields<'_>) -> Trace {
    let high_bits = if header.version >= WITH_HIGH_BITS { fields.u16(16) } else { 0 };
    let high = |shift: u16| u32::from(high_bits >> shift & 0xF) << 16;
    let valid = |flag, value: i32| (value != 0 && is_valid(fields, flag)).then_some(value);
    let from_north = |flag, value: i32, per_degree: f32| {
        valid(flag, value).map_or(f32::NAN, |value| (value as f32 / per_degree).to_radians())
    };
    // Older recorders count from -180 degrees on.
    let heading = match fields.u16(172) {
        centidegrees @ 0..=36_000 => i32::from(centidegrees),
        _ => i32::from(fields.i16(172)),
    };
    let sound_mps = f64::from(fields.f32(148));
    let is_sound = SOUNDS_MPS.contains(&sound_mps) && is_valid(fields, SOUND_VALID);
    let [from, to] =
        [(126, 0), (128, 4)].map(|(at, shift)| u32::from(fields.u16(at)) + high(shift));
    let place = Coordinates { x: fields.i32(80), y: fields.i32(84), units: fields.u16(88) };
    let calendar = [156, 158, 160, 162, 164].map(|at| fields.i16(at));
    Trace {
        packet: fields.u16(220),
        unix_ms: unix_ms(fields.i32(0).into(), calendar, fields.u32(200)),
        data_format: fields.u16(34),
        samples: u32::from(fields.u16(114)) + high(8),
        first_sample: fields.u32(4),
        interval_s: f64::from(fields.u32(116)) * 1e-9,
        weight: fields.i16(168),
        frequency_khz: frequency_khz([from, to], fields.f32(152)),
        sound_mps: is_sound.then_some(sound_mps),
        altitude_m: valid(ALTITUDE_VALID, fields.i32(144)).unwrap_or(0) as f32 / 1000.0,
        place: Some(place).filter(|_| is_valid(fields, POSITION_VALID)),
        heading_rad: from_north(HEADING_VALID, heading, 100.0),
        cog_rad: from_north(COURSE_VALID, fields.i16(192).into(), 10.0),
        speed_mps: valid(SPEED_VALID, fields.i16(194).into())
            .map_or(f32::NAN, |tenths| (f64::from(tenths) / 10.0 * MPS_PER_KNOT) as f32),
        ..empty(header)
    }
}

fn old_trace(header: MessageHeader, fields: Fields<'_>) -> Trace {
    let heading_min = f32::from(fields.i16(54));
    let calendar = [44, 46, 48, 50, 52].map(|at| fields.i16(at));
    Trace {
        packet: fields.u16(8),
        unix_ms: unix_ms(0, calendar, fields.u32(40)),
        data_format: fields.u16(36),
        samples: fields.u32(12),
        first_sample: fields.u32(20),
        interval_s: f64::from(fields.u32(16)) * 1e-9,
        weight: fields.i16(24),
        heading_rad: if heading_min == 0.0 { f32::NAN } else { (heading_min / 60.0).to_radians() },
        ..empty(header)
    }
}

/// A trace that says nothing but what its message is of.
fn empty(header: MessageHeader) -> Trace {
    Trace {
        subsystem: header.subsystem,
        channel: header.channel,
        packet: 0,
        unix_ms: 0,
        data_format: 0,
        samples_at: 0,
        room: 0,
        samples: 0,
        first_sample: 0,
        interval_s: 0.0,
        weight: 0,
        frequency_khz: None,
        sound_mps: None,
        altitude_m: 0.0,
        place: None,
        heading_rad: f32::NAN,
        cog_rad: f32::NAN,
        speed_mps: f32::NAN,
    }
}

/// The middle of a pulse from its ends in tens of hertz, or the frequency that it is mixed with,
/// Hz.
fn frequency_khz(ends: [u32; 2], mixer_hz: f32) -> Option<f32> {
    let ends_khz = ends.map(|ten_hz| ten_hz as f32 / 100.0);
    let khz = match ends_khz {
        [0.0, 0.0] => mixer_hz / 1000.0,
        [0.0, one] | [one, 0.0] => one,
        [from, to] => (from + to) / 2.0,
    };
    (1.0..10_000.0).contains(&khz).then_some(khz)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frequencies_are_the_middle_of_the_pulse() {
        assert_eq!(frequency_khz([11_000, 13_000], 0.0), Some(120.0));
        assert_eq!(frequency_khz([0, 0], 410_000.0), Some(410.0));
        assert_eq!(frequency_khz([0, 41_000], 1.0), Some(410.0));
        for mixer_hz in [0.0, f32::NAN, f32::INFINITY, -1e9] {
            assert_eq!(frequency_khz([0, 0], mixer_hz), None);
        }
    }
}
