//! Distances at the same times between two tracks of one boat that two receivers recorded: least
//! where their clocks agree.

use super::Track;
use crate::support::geo::{LonLat, distance_m};
use crate::support::statistics;

/// Most places of [`TracksApart::line`].
const PLACES: usize = 2000;

/// Two tracks at the same times.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TracksApart {
    /// Places of the boat on the first and on the second track at the same times, in time order.
    pub pairs: Vec<[LonLat; 2]>,
    /// Places of the first track, few enough to draw in a frame.
    pub line: Vec<LonLat>,
    /// Median of the distances, metres; NaN without a pair.
    pub median_m: f64,
}

impl TracksApart {
    /// Compares two tracks at some of `times_s`, evenly chosen, `most` of them; at times that only
    /// one covers there is no pair.
    pub fn new(one: &Track, other: &Track, times_s: &[f64], most: usize) -> Self {
        let step = times_s.len().div_ceil(most.max(1)).max(1);
        let (one, other) = (moves(one), moves(other));
        let pairs: Vec<[LonLat; 2]> = times_s
            .iter()
            .step_by(step)
            .filter_map(|&time_s| Some([at(&one, time_s)?, at(&other, time_s)?]))
            .collect();
        let mut apart_m: Vec<f64> = pairs.iter().map(|[a, b]| distance_m(*a, *b)).collect();
        let thinned = one.iter().step_by(one.len().div_ceil(PLACES).max(1));
        Self {
            pairs,
            line: thinned.map(|(_, place)| *place).collect(),
            median_m: statistics::median(&mut apart_m),
        }
    }
}

/// Times and places where the position changed: recorders repeat the last fix for many pings.
fn moves(track: &Track) -> Vec<(f64, LonLat)> {
    let mut moves: Vec<(f64, LonLat)> = Vec::new();
    for fix in track.fixes.iter() {
        if moves.last().is_none_or(|(_, last)| *last != fix.position) {
            moves.push((fix.time_s, fix.position));
        }
    }
    moves
}

/// The place at a time, straight between the fixes; `None` beyond them.
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
    use crate::survey::Fix;

    /// A boat that goes north at 1.5 m/s, fixed every second and reported `late_s` late.
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
