//! Reads the messages of a JSF file: their header, and the ping of one channel, with its time and
//! position, in messages 80 and 82.

use crate::formats::scalar::Fields;
use crate::formats::walk::MessageFormat;
use crate::support::geo::{LonLat, MPS_PER_KNOT};
use crate::survey::{ChannelKind, Encoding, ProjectedTrack, SideSpan};
use chrono::NaiveDate;
use std::ops::Range;

/// Bytes of a message's header.
pub(super) const HEADER: usize = 16;
/// First two bytes of each message: 0x1601.
const MARKER: [u8; 2] = [0x01, 0x16];
/// Limit of a message's bytes; longer messages are damage.
const LONGEST: usize = 1 << 24;
/// Type of a trace with a header of 240 bytes.
const TRACE: u16 = 80;
const TRACE_HEADER: usize = 240;
/// Type of an older trace with a header of 80 bytes.
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
/// Plausible speeds of sound in water, metres a second.
pub(super) const SOUNDS_MPS: std::ops::RangeInclusive<f64> = 1300.0..=1700.0;
/// Milliseconds of a day.
const DAY_MS: i64 = 86_400_000;

/// Marker and length of messages, with which a walk finds the next message.
pub(super) const FORMAT: MessageFormat = MessageFormat {
    noun: "message",
    marker: MARKER,
    length: |bytes, at| Some(HEADER + MessageHeader::at(bytes, at)?.size),
};

/// A message's header.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct MessageHeader {
    /// Version of the protocol.
    pub(super) version: u8,
    /// Type of the message.
    pub(super) kind: u16,
    /// Subsystem that sent the message.
    pub(super) subsystem: u8,
    /// Channel of the subsystem.
    pub(super) channel: u8,
    /// Bytes of the message after the header.
    size: usize,
}

impl MessageHeader {
    /// Returns the header at an offset; `None` where there is no valid header.
    pub(super) fn at(bytes: &[u8], at: usize) -> Option<Self> {
        let header = Fields(bytes.get(at..at.checked_add(HEADER)?)?);
        let size = usize::try_from(header.i32(12)).ok()?;
        let is_header = header.0.starts_with(&MARKER) && size < LONGEST;
        is_header.then(|| Self {
            version: header.u8(2),
            kind: header.u16(4),
            subsystem: header.u8(7),
            channel: header.u8(8),
            size,
        })
    }
}

/// A position as stored in a trace.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Coordinates {
    /// Longitude, or easting.
    x: i32,
    /// Latitude, or northing.
    y: i32,
    /// Unit of x and y: 1: millimetres, 2: ten thousandths of minutes of arc, 3: decimetres, 4:
    /// centimetres.
    units: u16,
}

impl Coordinates {
    /// Returns the position in degrees; metres of a projection that the file does not name are
    /// placed around longitude 0, latitude 0, where `origin_m`, the first of them, is. `None` where
    /// the position is not set or its unit is not known.
    pub(super) fn position(self, origin_m: &mut Option<[f64; 2]>) -> Option<LonLat> {
        if self.x == 0 || self.y == 0 {
            return None;
        }
        let [x, y] = [self.x, self.y].map(f64::from);
        let per_metre = match self.units {
            1 => 1000.0,
            2 => return Some(LonLat::new(x / 600_000.0, y / 600_000.0)),
            3 => 10.0,
            4 => 100.0,
            _ => return None,
        };
        let [x_m, y_m] = [x, y].map(|value| value / per_metre);
        let [x0_m, y0_m] = *origin_m.get_or_insert([x_m, y_m]);
        Some(ProjectedTrack::frame().to_lon_lat(x_m - x0_m, y_m - y0_m))
    }
}

/// Content of a trace, in SI units. Missing values are NaN or `None`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Trace {
    /// Subsystem of the sonar.
    pub(super) subsystem: u8,
    /// Channel of the subsystem.
    pub(super) channel: u8,
    /// Number of the part of a ping in this trace, from 1 on; 0 where parts are not counted.
    pub(super) packet: u16,
    /// Time of the ping, Unix milliseconds.
    pub(super) unix_ms: i64,
    /// EdgeTech's number for the format of the samples.
    pub(super) data_format: u16,
    /// Offset of the first sample in the file.
    pub(super) samples_at: usize,
    /// Bytes from the first sample to the end of the message.
    pub(super) room: usize,
    /// Number of samples.
    pub(super) samples: u32,
    /// Number of samples that were left out before the first.
    pub(super) first_sample: u32,
    /// Two-way travel time from sample to sample, seconds.
    pub(super) interval_s: f64,
    /// Weighting factor: a sample counts 2^-weight volts.
    pub(super) weight: i16,
    /// Frequency of the pulse, kHz.
    pub(super) frequency_khz: Option<f32>,
    /// Speed of sound, metres a second.
    pub(super) sound_mps: Option<f64>,
    /// Height of the sonar above the bottom, metres; 0 where unknown.
    pub(super) altitude_m: f32,
    /// Recorded position; `None` where it is flagged as invalid.
    pub(super) place: Option<Coordinates>,
    /// Heading of the compass, radians.
    pub(super) heading_rad: f32,
    /// Course over ground, radians.
    pub(super) cog_rad: f32,
    /// Speed over ground, metres a second.
    pub(super) speed_mps: f32,
}

impl Trace {
    /// Returns the trace in a complete message; `None` if the message is no trace.
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

    /// Returns the trace that a span was made from; `None` where no trace is before the samples.
    pub(super) fn of_span(bytes: &[u8], span: &SideSpan) -> Option<Self> {
        let samples_at = usize::try_from(span.offset).ok()?;
        [TRACE_HEADER, OLD_TRACE_HEADER].into_iter().find_map(|trace_header| {
            let start = samples_at.checked_sub(HEADER + trace_header)?;
            let size = MessageHeader::at(bytes, start)?.size;
            let trace = Self::of(bytes, start..start + HEADER + size)?;
            (trace.samples_at == samples_at).then_some(trace)
        })
    }

    /// Returns the kind of channel of this trace.
    pub(super) fn kind(&self) -> ChannelKind {
        match (self.subsystem, self.channel) {
            (20..=22 | 70..=72, 0) => ChannelKind::Port,
            (20..=22 | 70..=72, 1) => ChannelKind::Starboard,
            _ => ChannelKind::Other(self.number()),
        }
    }

    /// Returns a number for the channel, made of subsystem and channel.
    pub(super) fn number(&self) -> u16 {
        u16::from_be_bytes([self.subsystem, self.channel])
    }

    /// Returns the encoding of the samples, on a scale that is not set yet; `None` for formats that
    /// are not read.
    pub(super) fn encoding(&self) -> Option<Encoding> {
        match self.data_format {
            0 => Some(Encoding::ScaledU16 { base: 0, step: 0 }),
            1 => Some(Encoding::ScaledComplex { step: 0 }),
            _ => None,
        }
    }

    /// Returns the slant range of the near edge of the first sample and of the far edge of the
    /// last, metres.
    pub(super) fn range_m(&self, sound_mps: f64) -> [f32; 2] {
        let first = f64::from(self.first_sample);
        let metres = self.interval_s * sound_mps / 2.0;
        [first, first + f64::from(self.samples)].map(|samples| (samples * metres) as f32)
    }
}

/// Returns true if a field is valid: its flag is set, or the recorder sets no flag at all.
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
    // Older recorders count headings from -180 degrees on.
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

/// Creates a trace with no values but the subsystem and the channel of its header.
fn empty(header: MessageHeader) -> Trace {
    Trace {
        subsystem: header.subsystem,
        channel: header.channel,
        heading_rad: f32::NAN,
        cog_rad: f32::NAN,
        speed_mps: f32::NAN,
        ..Trace::default()
    }
}

/// Returns the Unix milliseconds of a trace: of its Unix seconds, or where those are not set, of
/// its year, day of the year, hour, minute and second. The milliseconds since midnight are used
/// where they are within 2 s of those seconds; otherwise (another clock) only their fraction of a
/// second is added.
fn unix_ms(unix_s: i64, calendar: [i16; 5], today_ms: u32) -> i64 {
    let [year, day, hour, minute, second] = calendar.map(i64::from);
    let date = i32::try_from(year).ok().zip(u32::try_from(day).ok());
    let date = date.and_then(|(year, day)| NaiveDate::from_yo_opt(year, day));
    let from_calendar_s = || {
        let days = i64::from(date?.to_epoch_days());
        Some(((days * 24 + hour) * 60 + minute) * 60 + second)
    };
    let seconds_ms = 1000 * if unix_s > 0 { unix_s } else { from_calendar_s().unwrap_or(0) };
    let today_ms = i64::from(today_ms);
    let after_ms =
        (today_ms - seconds_ms.rem_euclid(DAY_MS) + DAY_MS / 2).rem_euclid(DAY_MS) - DAY_MS / 2;
    if today_ms <= DAY_MS && after_ms.abs() <= 2000 {
        seconds_ms + after_ms
    } else {
        seconds_ms + today_ms % 1000
    }
}

/// Returns the middle of a pulse's frequencies, kHz, from its two ends in tens of hertz, or from
/// the frequency of the mixer, Hz, where both ends are 0; `None` where it is implausible.
fn frequency_khz(ends: [u32; 2], mixer_hz: f32) -> Option<f32> {
    let ends_khz = ends.map(|ten_hz| ten_hz as f32 / 100.0);
    let khz = match ends_khz {
        [0.0, 0.0] => mixer_hz / 1000.0,
        [0.0, end] | [end, 0.0] => end,
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

    #[test]
    fn times_have_milliseconds() {
        // `date -u -d "2021-06-05 23:59:59" +%s`; day 156 of the year.
        const S: i64 = 1_622_937_599;
        let calendar = [2021, 156, 23, 59, 59];
        assert_eq!(unix_ms(S, calendar, 86_399_250), S * 1000 + 250);
        assert_eq!(unix_ms(0, calendar, 86_399_250), S * 1000 + 250);
        // The milliseconds are those of the next day, of another time zone, or not set.
        assert_eq!(unix_ms(S, calendar, 40), S * 1000 + 1040);
        assert_eq!(unix_ms(S, calendar, 7_199_250), S * 1000 + 250);
        assert_eq!(unix_ms(S, calendar, 0), S * 1000 + 1000);
        assert_eq!(unix_ms(0, [0; 5], 7_250), 250);
        assert_eq!(unix_ms(0, [i16::MAX; 5], u32::MAX), 295);
    }
}
