//! Converts positions of a file, which are in degrees or in metres of an unknown projection, and
//! collects positions and headings of separate packets, which replace missing or repeated ones of
//! pings.

use super::raw::{
    AttitudePacket, GyroPacket, NavigationPacket, PacketHeader, PacketTime, RawNavigationPacket,
    record, seconds,
};
use crate::support::geo::{LonLat, distance_m};
use crate::survey::{Fix, ProjectedTrack, nearest_within};
use bytemuck::Pod;

/// Types of packets that are read.
const ATTITUDE: u8 = 3;
const GYRO: u8 = 23;
const NAVIGATION: u8 = 42;
const SOURCE_GYRO: u8 = 84;
const RAW_NAVIGATION: u8 = 107;
/// Longest time of a packet before the first or after the last ping, seconds; packets beyond have
/// another clock.
const BESIDE_S: f64 = 60.0;
/// Time after which a repeated position counts as old, seconds; a packet's position replaces those
/// of pings if no new one is within this time.
const STALE_S: f64 = 5.0;
/// Longest time between a position and the heading that is used for it, seconds.
pub(super) const HEADING_WITHIN_S: f64 = 1.0;
/// Value of the navigation units in the file header that means degrees.
pub(super) const DEGREES: u16 = 3;

/// Converts the positions of a file to degrees, also from metres of an unknown projection.
#[derive(Debug, Default)]
pub(super) struct PositionConverter {
    /// Units of positions in the file header; `None` where it is damaged.
    pub(super) units: Option<u16>,
    /// First projected position, metres, or that of the log whose tail is read: the easting and
    /// northing that are placed at longitude 0, latitude 0. `None` until a position in metres is
    /// converted.
    pub(super) origin_m: Option<[f64; 2]>,
}

impl PositionConverter {
    /// Returns true if a position is in degrees: some programs write degrees but state metres.
    fn is_degrees(&self, [x, y]: [f64; 2]) -> bool {
        let fits_degrees = x.abs() <= 180.0 && y.abs() <= 90.0;
        self.units == Some(DEGREES) || (self.origin_m.is_none() && fits_degrees)
    }

    /// Returns the distance between two recorded positions, metres.
    pub(super) fn apart_m(&self, one: [f64; 2], other: [f64; 2]) -> f64 {
        let [[x, y], [other_x, other_y]] = [one, other];
        if self.is_degrees(one) && self.is_degrees(other) {
            distance_m(LonLat::new(x, y), LonLat::new(other_x, other_y))
        } else {
            (x - other_x).hypot(y - other_y)
        }
    }

    /// Returns the position in degrees of a recorded position.
    pub(super) fn place(&mut self, [x, y]: [f64; 2]) -> LonLat {
        if self.is_degrees([x, y]) {
            return LonLat::new(x, y);
        }
        let [x0, y0] = *self.origin_m.get_or_insert([x, y]);
        ProjectedTrack::frame().to_lon_lat(x - x0, y - y0)
    }
}

/// A position from a separate packet.
#[derive(Clone, Copy, Debug)]
pub(super) struct SentPosition {
    /// Seconds after the log's time zero.
    pub(super) time_s: f64,
    /// Longitude and latitude, or easting and northing.
    pub(super) recorded: [f64; 2],
    /// Heading of the ship's compass, radians; NaN where none was recorded near it in time.
    pub(super) compass_rad: f32,
}

/// Collects positions and headings of separate packets; times count from 1970 until
/// [`SentNavigation::settle`].
#[derive(Debug, Default)]
pub(super) struct SentNavigation {
    positions: Vec<SentPosition>,
    /// Times, seconds, and headings, radians.
    headings: Vec<(f64, f32)>,
    /// Number of attitude packets.
    pub(super) attitudes: usize,
}

impl SentNavigation {
    /// Reads a packet; returns true if its type is read. `set_back_s` is by how much the recorder's
    /// clock was set back before it.
    pub(super) fn take(
        &mut self,
        bytes: &[u8],
        offset: usize,
        packet: &PacketHeader,
        set_back_s: f64,
    ) -> bool {
        let at = |time: PacketTime, part_s: f64| seconds(time) as f64 + part_s + set_back_s;
        match packet.kind {
            NAVIGATION => {
                if let Some(sent) = body::<NavigationPacket>(bytes, offset, packet) {
                    let time_s = at(sent.time, f64::from(sent.microseconds) / 1e6);
                    self.add_position(time_s, [sent.x, sent.y], f32::NAN);
                }
            }
            RAW_NAVIGATION => {
                if let Some(sent) = body::<RawNavigationPacket>(bytes, offset, packet) {
                    let time_s = at(sent.time, f64::from(sent.tenths_ms) / 1e4);
                    let compass_rad = self.add_heading(time_s, sent.heading_deg);
                    self.add_position(time_s, [sent.x, sent.y], compass_rad);
                }
            }
            GYRO | SOURCE_GYRO => {
                if let Some(sent) = body::<GyroPacket>(bytes, offset, packet) {
                    let time_s = at(sent.time, f64::from(sent.microseconds) / 1e6);
                    self.add_heading(time_s, sent.heading_deg);
                }
            }
            ATTITUDE => {
                self.attitudes += 1;
                if let Some(sent) = body::<AttitudePacket>(bytes, offset, packet) {
                    let time_s = at(sent.time, f64::from(sent.milliseconds) / 1e3);
                    self.add_heading(time_s, sent.heading_deg);
                }
            }
            _ => return false,
        }
        true
    }

    fn add_position(&mut self, time_s: f64, sent: [f64; 2], compass_rad: f32) {
        if let Some(recorded) = recorded(sent) {
            self.positions.push(SentPosition { time_s, recorded, compass_rad });
        }
    }

    /// Adds a heading and returns it in radians; NaN where it is not plausible.
    fn add_heading(&mut self, time_s: f64, heading_deg: f32) -> f32 {
        // 0 means "no heading", as in pings.
        if !(heading_deg.abs() > 0.0 && heading_deg.abs() <= 360.0) {
            return f32::NAN;
        }
        let heading_rad = heading_deg.to_radians();
        self.headings.push((time_s, heading_rad));
        heading_rad
    }

    /// Converts all times to the log's time zero, sorts by time, removes packets that are far from
    /// the pings' times `span_s` and therefore have another clock, and adds headings to positions
    /// without one.
    pub(super) fn settle(&mut self, zero_s: f64, span_s: [f64; 2]) {
        let [from_s, to_s] = span_s;
        let during = from_s - BESIDE_S..=to_s + BESIDE_S;
        let place_time = |time_s: &mut f64| {
            *time_s -= zero_s;
            during.contains(time_s)
        };
        self.positions.retain_mut(|sent| place_time(&mut sent.time_s));
        self.headings.retain_mut(|(time_s, _)| place_time(time_s));
        self.positions.sort_by(|a, b| a.time_s.total_cmp(&b.time_s));
        self.headings.sort_by(|a, b| a.0.total_cmp(&b.0));
        for index in 0..self.positions.len() {
            let SentPosition { time_s, compass_rad, .. } = self.positions[index];
            if compass_rad.is_nan() {
                self.positions[index].compass_rad = self.heading_rad(time_s);
            }
        }
    }

    /// Returns the heading at a time, radians; NaN where none is near in time.
    fn heading_rad(&self, time_s: f64) -> f32 {
        let near = nearest_within(&self.headings, time_s, HEADING_WITHIN_S, |(at_s, _)| *at_s);
        near.map_or(f32::NAN, |(_, heading_rad)| *heading_rad)
    }

    /// Sets the compass heading of fixes without one from packets; returns the number of changed
    /// fixes.
    pub(super) fn fill_headings(&self, fixes: &mut [Fix]) -> usize {
        if self.headings.is_empty() {
            return 0;
        }
        let mut filled = 0;
        for fix in fixes.iter_mut().filter(|fix| fix.compass_rad.is_nan()) {
            fix.compass_rad = self.heading_rad(fix.time_s);
            filled += usize::from(!fix.compass_rad.is_nan());
        }
        filled
    }

    /// Returns the positions of packets that replace missing or old positions of pings. Old
    /// positions are removed from `fixes`, the fixes of the pings.
    pub(super) fn stand_ins(&self, fixes: &mut Vec<Fix>) -> Vec<SentPosition> {
        if self.positions.is_empty() {
            return Vec::new();
        }
        let runs = fixes.chunk_by(|fix, next| fix.position == next.position);
        let mut fresh_s: Vec<f64> = runs.map(|run| run[0].time_s).collect();
        fresh_s.sort_by(f64::total_cmp);
        let is_near = |times_s: &[f64], time_s: f64| {
            nearest_within(times_s, time_s, STALE_S, |at_s| *at_s).is_some()
        };
        let sent = self.positions.iter().copied();
        let stand_ins: Vec<SentPosition> =
            sent.filter(|sent| !is_near(&fresh_s, sent.time_s)).collect();
        let sent_s: Vec<f64> = stand_ins.iter().map(|sent| sent.time_s).collect();
        fixes.retain(|fix| is_near(&fresh_s, fix.time_s) || !is_near(&sent_s, fix.time_s));
        stand_ins
    }
}

/// Returns the record of a packet; `None` where the packet is too short.
fn body<T: Pod>(bytes: &[u8], offset: usize, packet: &PacketHeader) -> Option<T> {
    let is_whole = packet.size as usize >= size_of::<T>();
    is_whole.then(|| record(bytes, offset)).flatten()
}

/// Returns a position; `None` where it was not recorded, which is stored as 0.
pub(super) fn recorded([x, y]: [f64; 2]) -> Option<[f64; 2]> {
    (x.is_finite() && y.is_finite() && x != 0.0 && y != 0.0).then_some([x, y])
}
