//! Reads packets of the Ping protocol and the profile, the ping of one transducer, in packet 2198
//! (`os_mono_profile`).

use crate::formats::scalar::{Fields, u16_le};
use crate::formats::walk::MessageFormat;
use crate::survey::{Side, SideSpan};

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
