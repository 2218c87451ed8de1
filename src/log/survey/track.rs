//! Holds the recorded fixes of the boat, and compares two tracks of one boat that two receivers
//! recorded: the distances at equal times are smallest where the clocks agree.

use crate::support::geo::{Crs, CrsError, LocalFrame, LonLat, distance_m};
use crate::support::statistics::median_of;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;
use std::sync::Arc;

/// Largest number of places of [`TracksApart::line`], approximately.
const PLACES: usize = 2000;

/// A recorded position with course, heading and speed. Recorders repeat the last fix for many
/// pings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fix {
    /// Seconds after the log's time zero.
    pub time_s: f64,
    /// WGS84 position.
    pub position: LonLat,
    /// Course over ground, radians clockwise from north; NaN when not recorded.
    pub cog_rad: f32,
    /// Compass heading, radians clockwise from north; NaN when not recorded (no compass).
    pub compass_rad: f32,
    /// Speed over ground, metres a second; NaN when not recorded.
    pub speed_mps: f32,
}

impl Fix {
    /// Creates a fix with a position only.
    pub fn at(time_s: f64, position: LonLat) -> Self {
        Self { time_s, position, cog_rad: f32::NAN, compass_rad: f32::NAN, speed_mps: f32::NAN }
    }
}

/// The boat's track. Position between fixes, and heading, come from [`super::navigate`].
#[derive(Clone, Debug, Default)]
pub struct Track {
    /// One entry per record that carries a position, repeats included, in time order; shared by all
    /// copies.
    pub fixes: Arc<Vec<Fix>>,
    /// Local coordinate frame of all `east_m`, `north_m` of the log: its origin is the first fix,
    /// unless the log shares the frame of another log ([`Track::in_frame`]).
    pub frame: LocalFrame,
    /// File and times of a track of another receiver; `None` for the recorder's own track.
    pub external: Option<ExternalTrack>,
    /// System of positions that the recorder wrote in metres of a system that the log does not
    /// name; `None` for positions in degrees or of a named system.
    pub projected: Option<ProjectedTrack>,
    /// True if the log has no times and its records are assumed to be one second apart: speeds and
    /// the durations of gaps are then unknown.
    pub has_assumed_times: bool,
}

/// Positions that the recorder wrote in metres of a system that the log does not name. Until the
/// user names the system they are placed around longitude 0, latitude 0, so that their distances
/// are right.
#[derive(Clone, Debug, PartialEq)]
pub struct ProjectedTrack {
    /// Easting and northing of the place at longitude 0, latitude 0, metres.
    pub origin_m: [f64; 2],
    /// The system of the metres; `None` until it is known.
    pub system: Option<Crs>,
}

impl ProjectedTrack {
    /// Creates a track whose system is not known.
    pub fn new(origin_m: [f64; 2]) -> Self {
        Self { origin_m, system: None }
    }

    /// Returns the local coordinate frame around longitude 0, latitude 0 in which the metres are
    /// kept.
    pub(crate) fn frame() -> LocalFrame {
        LocalFrame::new(LonLat::new(0.0, 0.0))
    }
}

/// A track that another receiver recorded.
#[derive(Clone, Debug, PartialEq)]
pub struct ExternalTrack {
    /// The file that it was read from.
    pub path: PathBuf,
    /// Seconds added to the times of the track.
    pub offset_s: f64,
    /// Times of its first and last fix, seconds of the log: beyond them the boat's place is not
    /// known.
    pub span_s: [f64; 2],
}

/// The `track.*` settings.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct TrackSettings {
    /// File of the track, CSV or GPX, that replaces the recorder's; `None` for the recorder's own
    /// track.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub file: Option<PathBuf>,
    /// Added to the times of an external track, seconds: the time by which its clock is behind that
    /// of the recorder.
    pub offset_s: f64,
}

impl Track {
    /// Returns the track with other fixes, in the same local coordinate frame.
    pub(crate) fn with_fixes(&self, fixes: impl Into<Arc<Vec<Fix>>>) -> Self {
        Self { fixes: fixes.into(), ..self.clone() }
    }

    /// Creates the recorder's track of `fixes`, which are in time order.
    pub fn new(fixes: Vec<Fix>) -> Self {
        let origin = fixes.first().map_or(LonLat::new(0.0, 0.0), |fix| fix.position);
        Self {
            fixes: Arc::new(fixes),
            frame: LocalFrame::new(origin),
            external: None,
            projected: None,
            has_assumed_times: false,
        }
    }

    /// Returns the track with its metres converted from `system` to positions on the Earth;
    /// unchanged where its positions are not in metres.
    ///
    /// # Errors
    /// A sentence after `source.crs: ` when the metres are outside of the area of the system.
    pub fn in_system(self, system: &Crs) -> Result<Self, CrsError> {
        let Some(projected) = self.projected.clone() else {
            return Ok(self);
        };
        let local = ProjectedTrack::frame();
        let [x0, y0] = projected.origin_m;
        let mut fixes = Arc::unwrap_or_clone(self.fixes);
        for (index, fix) in fixes.iter_mut().enumerate() {
            let [x, y] = local.to_enu(fix.position);
            let metres = [x0 + x, y0 + y];
            fix.position = system.to_lon_lat(metres);
            // Checking one position suffices, because a survey is small compared with a zone, and
            // damaged positions far away were left out before.
            if index == 0 || !fix.position.is_on_earth() {
                system.check_source(metres)?;
            }
        }
        Ok(Self {
            projected: Some(ProjectedTrack { system: Some(system.clone()), ..projected }),
            external: self.external,
            ..Self::new(fixes)
        })
    }

    /// Returns the track in a local coordinate frame that it shares with other logs, so that all of
    /// them are in one plane. Fixes are stored as longitude and latitude, so nothing is lost.
    ///
    /// The plane touches the ellipsoid at its origin: lengths at a distance `d` from there are
    /// short by `d^2 / 2 R^2` radially, which is 5 mm a kilometre at 20 km.
    #[must_use]
    pub fn in_frame(self, frame: &LocalFrame) -> Self {
        Self { frame: frame.clone(), ..self }
    }
}

/// Comparison of two tracks at the same times.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TracksApart {
    /// Places of the boat on the first and on the second track at the same times, in time order.
    pub pairs: Vec<[LonLat; 2]>,
    /// Places of the first track, few enough to be drawn in each picture.
    pub line: Vec<LonLat>,
    /// Median of the distances of the pairs, metres; NaN without a pair.
    pub median_m: f64,
}

impl TracksApart {
    /// Compares two tracks at `most` of `times_s` at most, evenly chosen; at times that only one
    /// track covers there is no pair.
    pub fn new(one: &Track, other: &Track, times_s: &[f64], most: usize) -> Self {
        let step = times_s.len().div_ceil(most.max(1)).max(1);
        let (one, other) = (moves(one), moves(other));
        let pairs: Vec<[LonLat; 2]> = times_s
            .iter()
            .step_by(step)
            .filter_map(|&time_s| Some([at(&one, time_s)?, at(&other, time_s)?]))
            .collect();
        let thinned = one.iter().step_by(one.len().div_ceil(PLACES).max(1));
        Self {
            line: thinned.map(|(_, place)| *place).collect(),
            median_m: median_of(pairs.iter().map(|[a, b]| distance_m(*a, *b))),
            pairs,
        }
    }
}

/// Returns the times and places at which the position changed: recorders repeat the last fix for
/// many pings.
fn moves(track: &Track) -> Vec<(f64, LonLat)> {
    let runs = track.fixes.chunk_by(|fix, next| fix.position == next.position);
    runs.map(|run| (run[0].time_s, run[0].position)).collect()
}

/// Returns the place at a time, interpolated linearly between the fixes; `None` beyond them.
fn at(moves: &[(f64, LonLat)], time_s: f64) -> Option<LonLat> {
    let after = moves.partition_point(|(move_s, _)| *move_s <= time_s);
    let (from_s, from) = *moves.get(after.checked_sub(1)?)?;
    let (to_s, to) = *moves.get(after)?;
    let share = (time_s - from_s) / (to_s - from_s);
    let between = |a: f64, b: f64| a + share * (b - a);
    Some(LonLat::new(between(from.lon_deg, to.lon_deg), between(from.lat_deg, to.lat_deg)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_log_twenty_kilometres_off_keeps_its_lengths_to_a_few_millimetres_a_kilometre() {
        let at = |lon_deg, lat_deg| LonLat { lon_deg, lat_deg };
        let fix = |position| Fix::at(0.0, position);
        for lat_deg in [0.0, 29.41, 61.0] {
            let frame = LocalFrame::new(at(-82.11, lat_deg));
            // About 20 km away in eight directions, a line of 1 km in each of two.
            for [east_km, north_km] in
                [[20.0, 0.0], [-20.0, 0.0], [0.0, 20.0], [0.0, -20.0], [14.0, 14.0]]
            {
                let there = frame.to_lon_lat(1e3 * east_km, 1e3 * north_km);
                let own = Track::new(vec![fix(there)]);
                assert_eq!(own.frame.to_enu(there), [0.0, 0.0]);
                for [east_m, north_m] in [[1e3, 0.0], [0.0, 1e3]] {
                    let end = own.frame.to_lon_lat(east_m, north_m);
                    let shared = own.clone().in_frame(&frame).frame;
                    let [a, b] = [there, end].map(|place| shared.to_enu(place));
                    let length_m = (b[0] - a[0]).hypot(b[1] - a[1]);
                    let off_m = length_m - distance_m(there, end);
                    assert!(off_m.abs() < 0.006, "{lat_deg} {east_km} {north_km}: {off_m}");
                }
            }
        }
    }

    /// Creates the track of a boat that goes north at 1.5 m/s, with a fix every second that is
    /// recorded `late_s` late.
    fn track(late_s: f64, east_deg: f64) -> Track {
        let fix = |second: i32| {
            Fix::at(
                f64::from(second) + late_s,
                LonLat::new(-82.0 + east_deg, 29.0 + 1.5 * f64::from(second) / 110_855.0),
            )
        };
        Track::new((0..200).flat_map(|second| [fix(second), fix(second)]).collect())
    }

    #[test]
    fn a_clock_that_is_late_sets_the_boat_back_by_its_way() {
        let times_s: Vec<f64> = (20..1800).map(|tenth| f64::from(tenth) / 10.0).collect();
        for late_s in [0.0, 0.5, -2.0] {
            let apart = TracksApart::new(&track(0.0, 0.0), &track(late_s, 0.0), &times_s, 400);
            assert!(apart.pairs.len() > 300 && apart.pairs.len() <= 400);
            let way_m = 1.5 * f64::abs(late_s);
            assert!((apart.median_m - way_m).abs() < 0.01, "{late_s}: {}", apart.median_m);
        }
        let aside = TracksApart::new(&track(0.0, 0.0), &track(0.0, 1e-5), &times_s, 50);
        let aside_m = 1e-5 * 111_320.0 * f64::to_radians(29.0).cos();
        assert!((aside.median_m - aside_m).abs() < 0.01, "{}", aside.median_m);
    }

    #[test]
    fn there_is_no_pair_where_one_track_is_silent() {
        let apart = TracksApart::new(&track(0.0, 0.0), &track(500.0, 0.0), &[1.0, 100.0], 10);
        assert!(apart.pairs.is_empty() && apart.median_m.is_nan());
    }
}
