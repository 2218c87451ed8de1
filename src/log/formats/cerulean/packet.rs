//! Reads packets of the Ping protocol: the profile, the ping of one transducer, in packet 2198
//! (`os_mono_profile`), and positions of NMEA and MAVLink packets, which get the times of the
//! profiles around them.

use crate::formats::nmea;
use crate::formats::scalar::{Fields, u16_le};
use crate::formats::walk::MessageFormat;
use crate::support::geo::LonLat;
use crate::support::statistics::upper_median;
use crate::survey::{Fix, Side, SideSpan};
use serde::Deserialize;

/// Bytes before the payload.
const HEADER: usize = 8;
/// Bytes of the checksum after the payload.
const SUM: usize = 2;
/// First two bytes of each packet.
const MARKER: [u8; 2] = *b"BR";
/// Packet id of a profile.
const PROFILE: u16 = 2198;
/// Bytes of a profile before the samples.
const PROFILE_HEADER: usize = 52;
/// Largest amount of a plausible power, decibels; larger ones are damage.
const MOST_DB: f32 = 400.0;

/// Marker and length of packets, with which a walk finds the next packet.
pub(super) const FORMAT: MessageFormat = MessageFormat {
    noun: "message",
    marker: MARKER,
    length: |bytes, at| {
        let header = Fields(bytes.get(at..at.checked_add(HEADER)?)?);
        let is_header = header.0.starts_with(&MARKER);
        is_header.then(|| HEADER + usize::from(header.u16(2)) + SUM)
    },
};

/// A complete packet.
#[derive(Clone, Copy, Debug)]
pub(super) struct Packet<'a> {
    /// Id of the packet's type.
    pub(super) id: u16,
    /// Number of the device that sent it.
    device: u8,
    /// Offset of the payload in the file.
    payload_at: usize,
    /// The payload.
    pub(super) payload: &'a [u8],
    header: &'a [u8],
    sum: u16,
}

impl<'a> Packet<'a> {
    /// Returns the packet at an offset; `None` where no packet begins there, or where it is
    /// truncated.
    pub(super) fn at(bytes: &'a [u8], at: usize) -> Option<Self> {
        let length = (FORMAT.length)(bytes, at)?;
        let packet = bytes.get(at..at.checked_add(length)?)?;
        let (header, rest) = packet.split_at_checked(HEADER)?;
        let (payload, sum) = rest.split_at_checked(rest.len().checked_sub(SUM)?)?;
        Some(Self {
            id: Fields(header).u16(4),
            device: Fields(header).u8(6),
            payload_at: at + HEADER,
            payload,
            header,
            sum: u16_le(sum, 0)?,
        })
    }

    /// Returns true if the checksum is right, or 0: some programs do not set it.
    pub(super) fn is_sound(&self) -> bool {
        let bytes = self.header.iter().chain(self.payload);
        let sum = bytes.fold(0_u16, |sum, byte| sum.wrapping_add(u16::from(*byte)));
        sum == self.sum || self.sum == 0
    }
}

/// Content of a profile.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Profile {
    /// Device that sent the profile.
    pub(super) device: u8,
    /// Number of the channel.
    pub(super) channel: u8,
    /// Heading of the transducer, degrees; negative is port.
    pub(super) transducer_deg: f32,
    /// Heading of the vehicle, degrees; 0 where unknown.
    pub(super) vehicle_deg: f32,
    /// Milliseconds since the sonar was switched on.
    pub(super) time_ms: u32,
    /// Slant range of the near edge of the first sample and of the far edge of the last, metres.
    pub(super) range_m: [f32; 2],
    /// Frequency, kHz; `None` where it is not plausible.
    pub(super) frequency_khz: Option<f32>,
    /// Decibels of the sample value 0 and of the sample value 65535.
    pub(super) power_db: [f32; 2],
    /// Number of samples.
    pub(super) samples: u16,
    /// Offset of the first sample in the file.
    pub(super) samples_at: usize,
    /// True if the packet contains all samples.
    pub(super) has_samples: bool,
    /// Offset of the end of the packet's payload.
    pub(super) end: usize,
}

impl Profile {
    /// Returns the profile in a packet; `None` if the packet is no profile.
    pub(super) fn of(packet: &Packet<'_>) -> Option<Self> {
        let (fields, samples) = packet.payload.split_at_checked(PROFILE_HEADER)?;
        if packet.id != PROFILE {
            return None;
        }
        let fields = Fields(fields);
        let metres = |mm: u64| (mm as f64 / 1000.0) as f32;
        let [start_mm, length_mm] = [4, 8].map(|at| u64::from(fields.u32(at)));
        let khz = fields.u32(16) as f32 / 1000.0;
        let count = fields.u16(22);
        Some(Self {
            device: packet.device,
            channel: fields.u8(26),
            transducer_deg: fields.f32(44),
            vehicle_deg: fields.f32(48),
            time_ms: fields.u32(12),
            range_m: [start_mm, start_mm + length_mm].map(metres),
            frequency_khz: (1.0..10_000.0).contains(&khz).then_some(khz),
            power_db: [fields.f32(40), fields.f32(36)],
            samples: count,
            samples_at: packet.payload_at + PROFILE_HEADER,
            has_samples: samples.len() >= 2 * usize::from(count),
            end: packet.payload_at + packet.payload.len(),
        })
    }

    /// Returns the profile that a span was made from; `None` where no profile is before the
    /// samples.
    pub(super) fn of_span(bytes: &[u8], span: &SideSpan) -> Option<Self> {
        let samples_at = usize::try_from(span.offset).ok()?;
        let start = samples_at.checked_sub(HEADER + PROFILE_HEADER)?;
        Self::of(&Packet::at(bytes, start)?)
    }

    /// Returns the side of the transducer by its heading; where the heading is 0, by the channel
    /// number, or port if that is unknown too.
    pub(super) fn side(&self) -> Side {
        match (self.transducer_deg, self.channel_side()) {
            (deg, _) if deg > 0.0 => Side::Starboard,
            (deg, _) if deg < 0.0 => Side::Port,
            (_, side) => side.unwrap_or(Side::Port),
        }
    }

    /// Returns the side of the channel number; `None` for numbers other than 0 and 1.
    pub(super) fn channel_side(&self) -> Option<Side> {
        match self.channel {
            0 => Some(Side::Port),
            1 => Some(Side::Starboard),
            _ => None,
        }
    }

    /// Returns true if the decibels are plausible.
    pub(super) fn has_power(&self) -> bool {
        let [least, most] = self.power_db;
        least >= -MOST_DB && most <= MOST_DB && least <= most
    }
}

/// Packet ids of NMEA sentences and MAVLink messages.
const NMEA: u16 = 109;
const MAVLINK: u16 = 150;
/// Largest difference between a position's own clock and the profile after it, seconds; where it is
/// larger, the time of the profile is used.
const MOST_APART_S: f64 = 5.0;
/// MAVLink message with a position, and its value for an unknown heading.
const POSITION_MESSAGE: &str = "GLOBAL_POSITION_INT";
const NO_HEADING: u16 = u16::MAX;

/// A position whose time on the sonar's clock is not known yet.
#[derive(Clone, Copy, Debug)]
pub(super) struct ReceivedPosition {
    /// Time on the position's own clock, seconds, and which clock that is; `None` without a time.
    own_s: Option<(Clock, f64)>,
    fix: Fix,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Clock {
    Receiver,
    Autopilot,
}

/// Wrapper of a MAVLink message, as mavlink2rest writes it.
#[derive(Deserialize)]
struct Wrapped {
    message: GlobalPosition,
}

/// MAVLink's `GLOBAL_POSITION_INT`.
#[derive(Deserialize)]
struct GlobalPosition {
    #[serde(rename = "type")]
    name: String,
    time_boot_ms: Option<f64>,
    /// Latitude and longitude, ten millionths of degrees.
    lat: f64,
    lon: f64,
    /// Speed to the north and to the east, centimetres a second.
    vx: Option<f32>,
    vy: Option<f32>,
    /// Heading, hundredths of degrees.
    hdg: Option<u16>,
}

/// Collects positions, with the last course, speed and heading of sentences without a position.
#[derive(Debug)]
pub(super) struct Navigation {
    cog_rad: f32,
    speed_mps: f32,
    heading_rad: f32,
    /// Positions, each with the time of the profile that follows, seconds after the log's time
    /// zero.
    placed: Vec<(f64, ReceivedPosition)>,
}

impl Default for Navigation {
    fn default() -> Self {
        Self { cog_rad: f32::NAN, speed_mps: f32::NAN, heading_rad: f32::NAN, placed: Vec::new() }
    }
}

impl Navigation {
    /// Reads a packet; returns its position, or `None` if it has none.
    pub(super) fn take(&mut self, id: u16, payload: &[u8]) -> Option<ReceivedPosition> {
        match id {
            NMEA => self.take_sentence(nmea::sentence(payload)?),
            MAVLINK => take_message(payload),
            _ => None,
        }
    }

    fn take_sentence(&mut self, sentence: nmea::Sentence) -> Option<ReceivedPosition> {
        let keep = |kept: &mut f32, value: f32| {
            if !value.is_nan() {
                *kept = value;
            }
        };
        keep(&mut self.cog_rad, sentence.cog_rad);
        keep(&mut self.speed_mps, sentence.speed_mps);
        keep(&mut self.heading_rad, sentence.heading_rad);
        Some(ReceivedPosition {
            own_s: sentence.utc_s.map(|utc_s| (Clock::Receiver, utc_s)),
            fix: Fix {
                time_s: f64::NAN,
                position: sentence.position?,
                cog_rad: self.cog_rad,
                compass_rad: self.heading_rad,
                speed_mps: self.speed_mps,
            },
        })
    }

    /// Stores a position with the time of the profile that follows, seconds; the vehicle's heading
    /// in that profile, degrees (0 is unknown), is used where the position has none.
    pub(super) fn place(&mut self, mut position: ReceivedPosition, time_s: f64, vehicle_deg: f32) {
        if position.fix.compass_rad.is_nan() && vehicle_deg != 0.0 && vehicle_deg.abs() <= 360.0 {
            position.fix.compass_rad = vehicle_deg.to_radians();
        }
        self.placed.push((time_s, position));
    }

    /// Returns the fixes. Packets are delayed by tenths of seconds, so that the clocks of receiver
    /// and autopilot give better times: their constant difference from the sonar's clock is
    /// estimated by the median.
    pub(super) fn fixes(self) -> Vec<Fix> {
        let later_s = |clock: Clock| {
            let own = self.placed.iter().filter_map(|(time_s, position)| {
                let (its, own_s) = position.own_s?;
                (its == clock).then_some(time_s - own_s)
            });
            upper_median(&mut own.collect::<Vec<f64>>(), f64::total_cmp)
        };
        let later_s = [Clock::Receiver, Clock::Autopilot].map(later_s);
        let each = self.placed.iter().map(|(beside_s, position)| {
            let own_s = position.own_s;
            let own_s = own_s.and_then(|(clock, own_s)| Some(own_s + later_s[clock as usize]?));
            let is_near = |own_s: &f64| (own_s - beside_s).abs() <= MOST_APART_S;
            Fix { time_s: own_s.filter(is_near).unwrap_or(*beside_s), ..position.fix }
        });
        each.collect()
    }
}

fn take_message(payload: &[u8]) -> Option<ReceivedPosition> {
    // Most messages are of other types and are not parsed.
    let name = POSITION_MESSAGE.as_bytes();
    payload.windows(name.len()).find(|part| *part == name)?;
    let Wrapped { message } = serde_json::from_slice(payload).ok()?;
    let [lat_deg, lon_deg] = [message.lat, message.lon].map(|value| value / 1e7);
    // An autopilot sends 0, 0 before it has a fix.
    let is_fix = message.name == POSITION_MESSAGE && lat_deg != 0.0 && lon_deg != 0.0;
    let [north, east] =
        [message.vx, message.vy].map(|speed| speed.map_or(f32::NAN, |cm| cm / 100.0));
    let heading = message.hdg.filter(|heading| *heading != NO_HEADING);
    let speed_mps = north.hypot(east);
    is_fix.then(|| ReceivedPosition {
        own_s: message.time_boot_ms.map(|boot_ms| (Clock::Autopilot, boot_ms / 1000.0)),
        fix: Fix {
            time_s: f64::NAN,
            position: LonLat { lon_deg, lat_deg },
            // A boat at rest has no course.
            cog_rad: if speed_mps > 0.0 { east.atan2(north) } else { f32::NAN },
            compass_rad: heading
                .map_or(f32::NAN, |heading| (f32::from(heading) / 100.0).to_radians()),
            speed_mps,
        },
    })
}
