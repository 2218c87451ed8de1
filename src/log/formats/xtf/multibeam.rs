//! Reads the depths of a multibeam sonar in an XTF file, with which its side-scan can be compared.
//!
//! Packets of type 2 are a header like that of a ping and a datagram of Reson's SeaBat 8101 and
//! related sonars, big-endian: ff ff 00 00, type, and ranges in quarters of a sample, one for each
//! beam. The datagrams 0x13, 0x14, 0x17 and 0x18 are read, as MB-System (`mbf_xtfr8101.h`,
//! `mbr_xtfr8101.c`) describes them. Beams of other sonars are not read.

use super::navigation::recorded;
use super::positions::first_set;
use super::raw::{self, AttitudePacket, PACKETS, PingHeader, record};
use super::sniff;
use crate::formats::OpenError;
use crate::formats::collected::WarningReport;
use crate::formats::log_format::{FileSource, Reading};
use crate::formats::points::{Elevations, PointPlane};
use crate::formats::scalar::take;
use crate::formats::walk::Walk;
use crate::support::geo::{LocalFrame, LonLat};
use crate::support::progress::Progress;
use crate::survey::nearest_within;
use std::path::Path;

/// Types of packets that are read.
const BATHYMETRY: u8 = 2;
const ATTITUDE: u8 = 3;
/// First bytes of each datagram.
const SYNCHRONISATION: [u8; 4] = [0xFF, 0xFF, 0, 0];
/// Units of range in one sample of one-way range: quarters of a sample, for the two-way travel
/// time.
const RANGES_A_SAMPLE: f64 = 8.0;
/// Most beams of a sonar of this kind.
const MOST_BEAMS: usize = 240;
/// Bits that a good beam has set in its quality: bright enough, and consistent with its neighbours.
const IS_GOOD: u8 = 3;
/// Largest angle of a beam from the vertical, degrees; larger angles do not occur in a fan that
/// looks down.
const STEEPEST_DEG: f64 = 85.0;
/// Longest time between a ping and the attitude that is used for it, seconds.
const ATTITUDE_WITHIN_S: f64 = 0.5;

/// Offsets of the fields in a datagram, bytes.
struct Layout {
    velocity: usize,
    beam_count: usize,
    ranges: usize,
    /// True if the quality of a beam has one byte, false if it has half a byte.
    has_whole_qualities: bool,
}

/// Beams of one ping.
struct Swath {
    time_s: f64,
    header: PingHeader,
    /// Angle to starboard from the sonar's vertical, radians, and range, metres, of each beam.
    beams: Vec<[f64; 2]>,
}

impl Swath {
    /// Returns the recorded position of the sonar, or else of the ship; `None` without either.
    fn recorded(&self) -> Option<[f64; 2]> {
        let header = &self.header;
        let sensor = recorded([header.sensor_x, header.sensor_y]);
        sensor.or_else(|| recorded([header.ship_x, header.ship_y]))
    }

    /// Returns true if the position may be in degrees, or is missing.
    fn fits_degrees(&self) -> bool {
        let recorded = self.recorded();
        recorded.is_none_or(|[x, y]| x.abs() <= 180.0 && y.abs() <= 90.0)
    }

    /// Returns the points of the beams; `None` without a position or a heading. `rolls` are times,
    /// seconds, and rolls to starboard, radians.
    fn points(&self, rolls: &[(f64, f64)], is_degrees: bool) -> Option<Vec<[f64; 3]>> {
        let [x, y] = self.recorded()?;
        let header = &self.header;
        let heading_deg = first_set([header.sensor_heading_deg, header.ship_gyro_deg])?;
        let (sin, cos) = f64::from(heading_deg).to_radians().sin_cos();
        let near = nearest_within(rolls, self.time_s, ATTITUDE_WITHIN_S, |(time_s, _)| *time_s);
        let stated_rad = f64::from(header.sensor_roll_deg).to_radians();
        let roll_rad = near.map_or(stated_rad, |(_, roll_rad)| *roll_rad);
        let frame = LocalFrame::new(LonLat::new(x, y));
        let point = |&[angle_rad, range_m]: &[f64; 2]| {
            let angle_rad = angle_rad - roll_rad;
            let is_down = angle_rad.abs() <= STEEPEST_DEG.to_radians();
            let (right_m, depth_m) = (range_m * angle_rad.sin(), range_m * angle_rad.cos());
            let [east_m, north_m] = [right_m * cos, -right_m * sin];
            let [x, y] = if is_degrees {
                let at = frame.to_lon_lat(east_m, north_m);
                [at.lon_deg, at.lat_deg]
            } else {
                [x + east_m, y + north_m]
            };
            is_down.then_some([x, y, -depth_m])
        };
        Some(self.beams.iter().filter_map(point).collect())
    }
}

/// Reads the depths of a multibeam sonar as elevations relative to the sonar.
///
/// # Errors
/// When the file cannot be read, is no XTF, or contains no beams that can be read and placed; or
/// when the user cancelled the reading.
pub(in crate::formats) fn read_multibeam(
    path: &Path,
    progress: &Progress,
) -> Result<Elevations, OpenError> {
    let bytes = FileSource::Disk
        .read(path)
        .map_err(|source| OpenError::Io { path: path.to_owned(), source })?;
    let none = |what: &str| OpenError::Unsupported { path: path.to_owned(), what: what.to_owned() };
    let found = sniff(&bytes).ok_or_else(|| none("this is no XTF file"))?;
    let mut swaths: Vec<Swath> = Vec::new();
    let mut rolls: Vec<(f64, f64)> = Vec::new();
    let reading = Reading { is_growing: true, tail: None };
    let walk = Walk::new(&bytes, PACKETS.noun, &WarningReport::default(), &reading, progress);
    progress.start(bytes.len() as u64);
    PACKETS.walk(walk, found.first_packet, |packet| {
        let packet = &bytes[packet];
        match packet.get(2) {
            Some(&BATHYMETRY) => swaths.extend(swath(packet)),
            Some(&ATTITUDE) => rolls.extend(roll(packet)),
            _ => (),
        }
    })?;
    if swaths.is_empty() {
        return Err(none(
            "there are no beams of a Reson SeaBat (packets of type 2) in this XTF file, and others are not read",
        ));
    }
    rolls.sort_by(|a, b| a.0.total_cmp(&b.0));
    let says_degrees = found.header.is_none_or(|header| header.nav_units == 3);
    let is_degrees = says_degrees || swaths.iter().all(Swath::fits_degrees);
    let mut unplaced = 0;
    let mut points = Vec::new();
    for swath in &swaths {
        match swath.points(&rolls, is_degrees) {
            Some(placed) => points.extend(placed),
            None => unplaced += swath.beams.len(),
        }
    }
    if points.is_empty() {
        return Err(none("the multibeam pings in this XTF file have no positions with a heading"));
    }
    Ok(Elevations {
        path: path.to_owned(),
        points,
        plane: if is_degrees { PointPlane::Degrees } else { PointPlane::Metres },
        blank: unplaced,
        note: Some("the multibeam depths count from the sonar; heave, draft, tide and a sound speed profile are not applied to them".to_owned()),
    })
}

/// Returns the good beams of a packet of bathymetry; `None` where it has no datagram that is read.
fn swath(packet: &[u8]) -> Option<Swath> {
    let header: PingHeader = record(packet, 0)?;
    let datagram = packet.get(size_of::<PingHeader>()..)?;
    if take(datagram, 0) != Some(SYNCHRONISATION) {
        return None;
    }
    let u16_at = |at: usize| take(datagram, at).map(u16::from_be_bytes);
    let is_old = match datagram.get(4)? {
        0x13 | 0x14 => true,
        0x17 | 0x18 => false,
        _ => return None,
    };
    let layout = if is_old {
        Layout {
            velocity: 16,
            beam_count: 34,
            ranges: 36,
            has_whole_qualities: datagram.get(4) == Some(&0x14),
        }
    } else {
        Layout { velocity: 28, beam_count: 66, ranges: 68, has_whole_qualities: false }
    };
    let beam_deg = if is_old {
        f64::from(*datagram.get(33)?) / 10.0
    } else {
        f64::from(u16_at(46)?) / f64::from(u16_at(48)?)
    };
    let [velocity_mps, rate_hz] = [u16_at(layout.velocity)?, u16_at(layout.velocity + 2)?];
    let unit_m = f64::from(velocity_mps) / (RANGES_A_SAMPLE * f64::from(rate_hz));
    let count = usize::from(u16_at(layout.beam_count)?);
    if !(beam_deg > 0.0 && beam_deg < 10.0 && unit_m > 0.0 && unit_m.is_finite())
        || count > MOST_BEAMS
    {
        return None;
    }
    let qualities = layout.ranges + 2 * count;
    let beam = |index: usize| {
        let quality = if layout.has_whole_qualities {
            *datagram.get(qualities + index)?
        } else {
            datagram.get(qualities + index / 2)? >> (4 * (index % 2))
        };
        let range_m = f64::from(u16_at(layout.ranges + 2 * index)?) * unit_m;
        let from_middle = index as f64 - (count / 2) as f64;
        let is_good = quality & IS_GOOD == IS_GOOD && range_m > 0.0;
        is_good.then_some([(from_middle * beam_deg).to_radians(), range_m])
    };
    Some(Swath {
        time_s: raw::unix_ms(&header) as f64 / 1000.0,
        header,
        beams: (0..count).filter_map(beam).collect(),
    })
}

/// Returns the time, seconds, and the roll to starboard, radians, of a packet of attitude.
fn roll(packet: &[u8]) -> Option<(f64, f64)> {
    let sent: AttitudePacket = record(packet, 0)?;
    let time_s = raw::seconds(sent.time) as f64 + f64::from(sent.milliseconds) / 1e3;
    let roll_deg = f64::from(sent.roll_deg);
    (roll_deg.abs() < 90.0).then_some((time_s, roll_deg.to_radians()))
}
