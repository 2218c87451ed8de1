//! Computes the position and the heading of every side-scan ping, from one of four sources, and the
//! turn rate of the boat.

use super::fitted_track::{FittedTrack, Motion};
use super::{Fix, MountingSettings, PositionShift, Side, Survey, Track};
use crate::support::geo::{LonLat, metres_per_degree, web_mercator, web_mercator_inverse};
use crate::support::progress::{Cancelled, Progress};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Number of records that a worker places between two checks for cancellation.
const CHUNK: usize = 4096;
/// Time before and after a ping over which its turn rate is computed, seconds.
const LOOK_S: f64 = 2.0;
/// Shortest way whose direction is used for the turn rate, metres.
const LEAST_WAY_M: f64 = 0.3;

/// Source of the heading.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum HeadingSource {
    /// `h_i = p_(i+1) - p_i` of the paper: consecutive recorded positions; zero steps give no
    /// heading.
    Steps,
    /// A straight line fitted to the fixes in a time window around the ping.
    TrackFit,
    /// The recorded course over ground.
    Cog,
    /// The recorded compass heading.
    Compass,
}

/// The `heading.*` settings.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct HeadingSettings {
    /// Source of the heading.
    pub source: HeadingSource,
    /// Width of the window that the line is fitted over, seconds (plus and minus half of it).
    pub window_s: f64,
}

impl Default for HeadingSettings {
    fn default() -> Self {
        Self { source: HeadingSource::TrackFit, window_s: 6.0 }
    }
}

/// The plane that the point cloud is built in.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Projection {
    /// Metres on the ground in the survey's local coordinate frame, east and north.
    #[default]
    Enu,
    /// Spherical pseudo-Mercator metres relative to the first fix, as published: stretched by 1 /
    /// cos(latitude).
    Mercator,
}

/// Position and heading of one ping.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PingNav {
    /// Metres east of the survey's origin, in the chosen projection; NaN without any fix.
    pub east_m: f64,
    /// Metres north of the survey's origin, in the chosen projection; NaN without any fix.
    pub north_m: f64,
    /// Heading, radians clockwise from the north of the plane; NaN where there is none.
    pub heading_rad: f64,
    /// Speed over ground, metres a second; NaN when unknown.
    pub speed_mps: f64,
}

/// Position and heading of every side-scan ping ([`Survey::side_scan`]), every sounding
/// ([`Survey::soundings`]) and every ping of a swath ([`Survey::swath`]); the lists are shared by
/// all copies.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Navigation {
    /// One entry per side-scan ping.
    pub pings: Arc<Vec<PingNav>>,
    /// One entry per sounding.
    pub soundings: Arc<Vec<PingNav>>,
    /// One entry per ping of a swath.
    pub swath: Arc<Vec<PingNav>>,
    /// Places of the antenna at the side-scan pings, metres east and north; empty where the antenna
    /// is right above the transducer.
    pub antenna: Arc<Vec<[f64; 2]>>,
    /// The plane that the metres are in.
    pub projection: Projection,
    /// Standard deviation of the places along an axis that the rounding of fixes leaves in them,
    /// metres.
    pub rounding_m: f64,
    /// Number of side-scan pings without a heading.
    pub zero_heading: usize,
    /// Number of side-scan pings at which the boat moves: at 0.2 m/s or more by the fitted track,
    /// and farther than its rounded fixes can resolve (0.4 m/s over the default window of a
    /// recorder that rounds to a metre).
    pub moving: usize,
}

impl Navigation {
    /// Creates the navigation of side-scan pings in the survey's plane; the boat counts as moving
    /// at all of them.
    pub fn of_pings(pings: impl IntoIterator<Item = PingNav>) -> Self {
        let pings: Vec<PingNav> = pings.into_iter().collect();
        Self { moving: pings.len(), pings: Arc::new(pings), ..Self::default() }
    }

    /// Converts a WGS84 position to metres east and north in the plane of this navigation; inverse
    /// of [`Navigation::to_lon_lat`].
    pub fn to_plane(&self, track: &Track, position: LonLat) -> [f64; 2] {
        self.projection.place(track, position)
    }

    /// Converts a place in the plane of this navigation to a WGS84 position.
    pub fn to_lon_lat(&self, track: &Track, east_m: f64, north_m: f64) -> LonLat {
        match self.projection {
            Projection::Enu => track.frame.to_lon_lat(east_m, north_m),
            Projection::Mercator => {
                let [x0, y0] = web_mercator(track.frame.origin());
                web_mercator_inverse(x0 + east_m, y0 + north_m)
            }
        }
    }
}

impl PingNav {
    /// Creates the navigation of a ping at a place, metres east and north, heading north.
    pub fn northbound([east_m, north_m]: [f64; 2], speed_mps: f64) -> Self {
        Self { east_m, north_m, heading_rad: 0.0, speed_mps }
    }

    const UNKNOWN: Self =
        Self { east_m: f64::NAN, north_m: f64::NAN, heading_rad: f64::NAN, speed_mps: f64::NAN };

    /// Returns the place, metres east and north; NaN where unknown.
    pub fn place(&self) -> [f64; 2] {
        [self.east_m, self.north_m]
    }

    /// Returns the unit vector to starboard in the plane, `(h_y, -h_x) / |h|`; `None` without a
    /// heading.
    ///
    /// The paper prints `h x (-z)`, which is port in a coordinate frame with z up.
    pub fn starboard(&self) -> Option<[f64; 2]> {
        let (sin, cos) = self.heading_rad.sin_cos();
        self.heading_rad.is_finite().then_some([cos, -sin])
    }

    /// Returns the place `out_m` outward on a side of the boat; `None` without a heading.
    pub fn abeam(&self, side: Side, out_m: f64) -> Option<[f64; 2]> {
        let [x, y] = self.starboard()?;
        let right_m = side.to_starboard(out_m);
        Some([self.east_m + x * right_m, self.north_m + y * right_m])
    }
}

impl Projection {
    /// Returns the place of a position in this plane, metres east and north of the track's origin.
    fn place(self, track: &Track, position: LonLat) -> [f64; 2] {
        match self {
            Projection::Enu => track.frame.to_enu(position),
            Projection::Mercator => {
                let [x, y] = web_mercator(position);
                let [x0, y0] = web_mercator(track.frame.origin());
                [x - x0, y - y0]
            }
        }
    }
}

/// Places every ping and sounding of a survey whose antenna is right above its transducer:
/// [`navigate_with`] with no mounting and no shift.
///
/// # Errors
/// When the work was cancelled.
pub fn navigate(
    survey: &Survey,
    settings: &HeadingSettings,
    projection: Projection,
    progress: &Progress,
) -> Result<Navigation, Cancelled> {
    let positions = PositionSettings {
        heading: settings,
        mounting: &MountingSettings::default(),
        shift: &PositionShift::default(),
        projection,
    };
    navigate_with(survey, positions, progress)
}

/// Settings that determine the positions of the pings and soundings of a log.
#[derive(Clone, Copy, Debug)]
pub struct PositionSettings<'a> {
    /// Source of the headings.
    pub heading: &'a HeadingSettings,
    /// Mounting of the recorder on the boat.
    pub mounting: &'a MountingSettings,
    /// Correction of the error of the positions.
    pub shift: &'a PositionShift,
    /// The plane of the positions.
    pub projection: Projection,
}

/// Places every ping and sounding of the survey on the ground, and every ping of a swath.
///
/// [`HeadingSource::Steps`] keeps the positions as recorded, repeats and rounding included; the
/// other sources take the position from the fitted track. A boat at rest has neither course nor
/// fitted heading.
///
/// Fixes are those of the antenna. The transducer is `forward_m` along the heading `h` and
/// `right_m` to starboard of the antenna: `east += forward sin h + right cos h`, `north += forward
/// cos h - right sin h`. `h` is the heading of the source, except for [`HeadingSource::Steps`],
/// whose headings are multiples of 45 degrees: there `h` is the heading of the fitted track. Where
/// the boat is at rest and has no heading, the last heading before is used, so that the track does
/// not jump by the length of the arm at every stop. Places, courses and fitted headings are read
/// `latency_s` later than the echo, the compass heading is not. `heading_offset_deg` is added to
/// the compass heading alone: a course is the direction of the boat's motion and does not depend on
/// how an instrument is turned. The shift is added to all places.
///
/// # Errors
/// When the work was cancelled.
pub fn navigate_with(
    survey: &Survey,
    positions: PositionSettings<'_>,
    progress: &Progress,
) -> Result<Navigation, Cancelled> {
    let navigator = Navigator {
        positions,
        track: &survey.track,
        fitted: FittedTrack::new(&survey.track, positions.heading.window_s),
    };
    let records = survey.side_scan.len() + survey.soundings.len() + survey.swath.len();
    progress.start(records as u64);
    let (mut pings, moving) =
        navigator.place_all(&survey.side_scan, |ping| ping.time_s, progress)?;
    let (mut soundings, _) =
        navigator.place_all(&survey.soundings, |sounding| sounding.time_s, progress)?;
    let (mut swath, _) = navigator.place_all(&survey.swath, |ping| ping.time_s, progress)?;
    let mut antenna = Vec::new();
    if let Some(arm_m) = positions.mounting.lever_arm_m() {
        antenna = pings.iter().map(PingNav::place).collect();
        navigator.move_by(arm_m, &mut pings, &survey.side_scan, |ping| ping.time_s);
        navigator.move_by(arm_m, &mut soundings, &survey.soundings, |sounding| sounding.time_s);
        navigator.move_by(arm_m, &mut swath, &survey.swath, |ping| ping.time_s);
    }
    Ok(Navigation {
        rounding_m: navigator.fitted.rounding_m(!navigator.is_by_steps()),
        antenna: Arc::new(antenna),
        zero_heading: pings.iter().filter(|ping| ping.heading_rad.is_nan()).count(),
        moving,
        pings: Arc::new(pings),
        soundings: Arc::new(soundings),
        swath: Arc::new(swath),
        projection: positions.projection,
    })
}

/// Sets headings along the steps, `h_i = p_(i+1) - p_i`. The last ping, and those whose next
/// position is the same, keep theirs.
fn head_along_steps(places: &mut [PingNav]) {
    for index in 0..places.len().saturating_sub(1) {
        let east = places[index + 1].east_m - places[index].east_m;
        let north = places[index + 1].north_m - places[index].north_m;
        if east != 0.0 || north != 0.0 {
            places[index].heading_rad = east.atan2(north);
        }
    }
}

struct Navigator<'a> {
    track: &'a Track,
    fitted: FittedTrack,
    positions: PositionSettings<'a>,
}

impl Navigator<'_> {
    fn is_by_steps(&self) -> bool {
        self.positions.heading.source == HeadingSource::Steps
    }

    /// Moves places from the antenna to the transducer, by metres forward and to starboard. Places
    /// stay where no record has a heading.
    fn move_by<T: Sync>(
        &self,
        [forward_m, right_m]: [f64; 2],
        places: &mut [PingNav],
        records: &[T],
        time_s: impl Fn(&T) -> f64 + Sync,
    ) {
        let headings = places.par_iter().zip(records).map(|(place, record)| {
            if !self.is_by_steps() {
                return place.heading_rad;
            }
            let motion = self.fitted.at(time_s(record) + self.positions.mounting.latency_s);
            if motion.moving { motion.velocity[0].atan2(motion.velocity[1]) } else { f64::NAN }
        });
        let headings: Vec<f64> = headings.collect();
        // Before the first known heading, that heading is used.
        let mut heading_rad = headings.iter().copied().find(|rad| rad.is_finite());
        for (place, own_rad) in places.iter_mut().zip(headings) {
            if own_rad.is_finite() {
                heading_rad = Some(own_rad);
            }
            let Some((sin, cos)) = heading_rad.map(f64::sin_cos) else {
                return;
            };
            let by_m = [forward_m * sin + right_m * cos, forward_m * cos - right_m * sin];
            [place.east_m, place.north_m] = self.moved(place.place(), by_m);
        }
    }

    /// Returns a place of the plane, moved by metres on the ground.
    fn moved(&self, [east_m, north_m]: [f64; 2], by_m: [f64; 2]) -> [f64; 2] {
        let projection = self.positions.projection;
        match projection {
            Projection::Enu => [east_m + by_m[0], north_m + by_m[1]],
            Projection::Mercator => {
                let [x0, y0] = web_mercator(self.track.frame.origin());
                let at = web_mercator_inverse(x0 + east_m, y0 + north_m);
                let [lon_m, lat_m] = metres_per_degree(at);
                let moved = LonLat::new(at.lon_deg + by_m[0] / lon_m, at.lat_deg + by_m[1] / lat_m);
                projection.place(self.track, moved)
            }
        }
    }

    /// Returns one place per record, and the number of records at which the boat moves. Headings
    /// along the steps are set if these are the source.
    fn place_all<T: Sync>(
        &self,
        records: &[T],
        time_s: impl Fn(&T) -> f64 + Sync,
        progress: &Progress,
    ) -> Result<(Vec<PingNav>, usize), Cancelled> {
        let mut places = vec![PingNav::UNKNOWN; records.len()];
        let place_chunk = |(places, records): (&mut [PingNav], &[T])| {
            progress.check()?;
            let mut moving = 0;
            for (place, record) in places.iter_mut().zip(records) {
                if let Some((placed, moves)) = self.place(time_s(record)) {
                    *place = placed;
                    moving += usize::from(moves);
                }
            }
            progress.advance(records.len() as u64);
            Ok(moving)
        };
        let moving = places
            .par_chunks_mut(CHUNK)
            .zip(records.par_chunks(CHUNK))
            .map(place_chunk)
            .try_reduce(|| 0, |a, b| Ok(a + b))?;
        if self.is_by_steps() {
            head_along_steps(&mut places);
        }
        Ok((places, moving))
    }

    /// Returns the place at a time, and true if the boat moves there; `None` where the place is not
    /// known.
    fn place(&self, time_s: f64) -> Option<(PingNav, bool)> {
        let compass = self.recorded_at(time_s)?;
        let time_s = time_s + self.positions.mounting.latency_s;
        let external = self.track.external.as_ref();
        if external.is_some_and(|track| time_s < track.span_s[0] || time_s > track.span_s[1]) {
            return None;
        }
        let motion = self.fitted.at(time_s);
        if motion.place_m[0].is_nan() {
            return None;
        }
        let recorded = self.recorded_at(time_s)?;
        let projection = self.positions.projection;
        let place = match (self.positions.heading.source, projection) {
            (HeadingSource::Steps, _) => projection.place(self.track, recorded.position),
            (_, Projection::Enu) => motion.place_m,
            (_, Projection::Mercator) => {
                let [east_m, north_m] = motion.place_m;
                projection.place(self.track, self.track.frame.to_lon_lat(east_m, north_m))
            }
        };
        let shift_m = self.positions.shift.by_m();
        let [east_m, north_m] = shift_m.map_or(place, |by_m| self.moved(place, by_m));
        let heading_rad = self.heading_rad(&motion, recorded, compass);
        let place = PingNav { east_m, north_m, heading_rad, speed_mps: motion.speed_mps() };
        Some((place, motion.moving))
    }

    /// Returns the last fix recorded at or before a time (the first fix where the time is before
    /// it); `None` without fixes.
    fn recorded_at(&self, time_s: f64) -> Option<&Fix> {
        let after = self.track.fixes.partition_point(|fix| fix.time_s <= time_s);
        self.track.fixes.get(after.saturating_sub(1))
    }

    /// Returns the heading in the plane, radians; NaN where there is none. A compass heading is
    /// taken from the fix `compass`, which was recorded with the echo: the compass is a separate
    /// instrument without the latency of the receiver.
    fn heading_rad(&self, motion: &Motion, recorded: &Fix, compass: &Fix) -> f64 {
        let in_plane = |recorded_rad: f32, fix: &Fix| {
            f64::from(recorded_rad) + self.true_north_rad(fix.position)
        };
        match self.positions.heading.source {
            HeadingSource::TrackFit if motion.moving => {
                motion.velocity[0].atan2(motion.velocity[1])
            }
            HeadingSource::Cog if motion.moving => in_plane(recorded.cog_rad, recorded),
            HeadingSource::Compass => {
                let offset_rad = self.positions.mounting.heading_offset_deg.to_radians();
                in_plane(compass.compass_rad, compass) + offset_rad
            }
            _ => f64::NAN,
        }
    }

    /// Returns the direction of true north in the plane, radians: recorded headings count from true
    /// north, which is not the north of a plane whose origin is kilometres east or west.
    fn true_north_rad(&self, position: LonLat) -> f64 {
        match self.positions.projection {
            Projection::Enu => self.track.frame.true_north_rad(position),
            Projection::Mercator => 0.0,
        }
    }
}

/// Returns the turn rate at every place, degrees a second, from the places two seconds before and
/// after; 0 where the boat hardly moves. `times_s` are in ascending order, one for each place.
pub fn turn_rates_deg_s(times_s: &[f64], places: &[PingNav]) -> Vec<f32> {
    let (mut before, mut after) = (0, 0);
    (0..times_s.len().min(places.len()))
        .map(|ping| {
            while times_s[before] < times_s[ping] - LOOK_S {
                before += 1;
            }
            while after + 1 < times_s.len() && times_s[after] < times_s[ping] + LOOK_S {
                after += 1;
            }
            let turn_rad = turn_rad(&places[before], &places[ping], &places[after]);
            // The mean directions of the ways before and after are half of the whole time apart.
            let apart_s = 0.5 * (times_s[after] - times_s[before]);
            (turn_rad.to_degrees() / apart_s.max(0.1)) as f32
        })
        .collect()
}

/// Returns the angle between the way to a place and the way on from there, radians, 0 to pi; 0
/// where one of the ways is too short.
fn turn_rad(before: &PingNav, here: &PingNav, after: &PingNav) -> f64 {
    let way = |from: &PingNav, to: &PingNav| [to.east_m - from.east_m, to.north_m - from.north_m];
    let (come, go) = (way(before, here), way(here, after));
    let long = |way: [f64; 2]| way[0].hypot(way[1]) > LEAST_WAY_M;
    if !(long(come) && long(go)) {
        return 0.0;
    }
    let dot = come[0] * go[0] + come[1] * go[1];
    let cross = come[0] * go[1] - come[1] * go[0];
    cross.atan2(dot).abs()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_circle_turns_at_its_rate_and_a_line_does_not() {
        let times: Vec<f64> = (0..200).map(|ping| 0.1 * f64::from(ping)).collect();
        // Ten seconds straight at 1.5 m/s, then a circle at 9 degrees a second.
        let rate = 9_f64.to_radians();
        let place = |time_s: f64| {
            let turned = rate * (time_s - 10.0).max(0.0);
            let along = 1.5 * time_s.min(10.0) + 1.5 / rate * turned.sin();
            [1.5 / rate * (1.0 - turned.cos()), along]
        };
        let places = times.iter();
        let places = places.map(|&time_s| PingNav::northbound(place(time_s), 1.5));
        let places: Vec<PingNav> = places.collect();
        let rates = turn_rates_deg_s(&times, &places);
        assert!(rates[40] < 0.01, "{}", rates[40]);
        assert!((rates[150] - 9.0).abs() < 0.3, "{}", rates[150]);
    }
}
