//! First returns beyond the recorded depth: the bottom below the boat returns at that range, so
//! that nothing farther can be the first one, unless the depth is wrong.

use super::false_soundings::pick_range_m;
use super::{FirstReturns, Pick};
use bathyscope_log::support::statistics::{median, spread_about};
use bathyscope_log::survey::{Side, Survey};
use rayon::prelude::*;
use std::ops::Range;
use std::sync::Arc;

/// Least distance beyond the depth at which a first return is doubted, metres: depths may be
/// rounded to 0.1 m.
const LEAST_BEYOND_M: f64 = 0.2;
/// Confidence from which such a first return is believed all the same (the depth may be wrong),
/// unless the range of the other side confirms the depth: it lies within these shares of the depth,
/// as on a bank.
const CERTAIN: f32 = 0.6;
const BEARS_OUT: Range<f64> = 0.75..1.0;
/// Largest ratio of the ranges of the two sides that confirm each other against the depth: that of
/// the lower side to the upper one on a bank of 35 degrees.
const MOST_APART: f64 = 1.25;
/// Largest difference of the two sides over a level bottom, as a share; fewest such pings that
/// determine the share of the depth at which a log's first returns lie; and distance of the limit
/// beyond the median of these shares, in standard deviations of their scatter.
const LEVEL: f64 = 0.03;
const FEWEST_LEVEL: usize = 200;
const OWN_SIGMAS: f64 = 4.0;

/// Farthest that the bottom below the boat returns where the recorder's depth is true, metres: the
/// scales of ranges and depths, their rounding and their noise make no more of a difference.
pub(super) fn farthest_m(depth_m: f64) -> f64 {
    const SHALLOW: f64 = 1.08;
    const DEEP: (f64, f64) = (1.03, 0.25);
    (SHALLOW * depth_m).min(DEEP.0 * depth_m + DEEP.1)
}

/// Takes the confidence from first returns farther away than the bottom below the boat. They keep
/// it where the other side is beyond the depth too, and about as far, for the depth may be wrong or
/// the beams end beside the nadir, and where they are certain and the other side does not bear the
/// depth out. `sides` are port and starboard from the ping `first` on.
pub(super) fn doubt(survey: &Survey, first: usize, sides: &mut [Vec<Pick>; 2]) {
    let [port, starboard] = sides;
    doubt_beyond(survey, first, [port, starboard], &|depth_m| farthest_m(depth_m));
}

/// Doubts first returns as [`doubt`] does by the scale of this log: where both sides see a level
/// bottom, they show how ranges and depths differ.
pub(super) fn doubt_by_own_scale(survey: &Survey, returns: &mut FirstReturns) {
    let Some(farthest) = farthest_share(survey, returns) else {
        return;
    };
    let FirstReturns { port, starboard, .. } = returns;
    let sides = [Arc::make_mut(port).as_mut_slice(), Arc::make_mut(starboard).as_mut_slice()];
    doubt_beyond(survey, 0, sides, &|depth_m| farthest_m(depth_m).min(farthest * depth_m));
}

/// Largest share of the depth at which the first returns of a level bottom lie in this log; `None`
/// where too few of them show it.
fn farthest_share(survey: &Survey, returns: &FirstReturns) -> Option<f64> {
    let share = |ping: usize| {
        let picks = Side::BOTH.map(|side| &returns.side(side)[ping]);
        let [port_m, starboard_m] =
            Side::BOTH.map(|side| pick_range_m(survey, ping, side, picks[side as usize]));
        let is_certain = picks.iter().all(|pick| pick.confidence >= CERTAIN);
        let is_level = (port_m - starboard_m).abs() < LEVEL * port_m.max(starboard_m);
        let share = port_m.max(starboard_m) / f64::from(survey.good_depth_m(ping));
        (is_certain && is_level && share.is_finite()).then_some(share)
    };
    let mut shares: Vec<f64> =
        (0..survey.side_scan.len()).into_par_iter().filter_map(share).collect();
    if shares.len() < FEWEST_LEVEL {
        return None;
    }
    let middle = median(&mut shares);
    Some(middle + OWN_SIGMAS * spread_about(&mut shares, middle))
}

/// Doubts first returns that lie beyond the range that a function of the depth returns.
fn doubt_beyond(
    survey: &Survey,
    first: usize,
    sides: [&mut [Pick]; 2],
    farthest_m: &dyn Fn(f64) -> f64,
) {
    for index in 0..sides[0].len() {
        let depth_m = f64::from(survey.good_depth_m(first + index));
        let ranges_m = Side::BOTH
            .map(|side| pick_range_m(survey, first + index, side, &sides[side as usize][index]));
        for side in Side::BOTH {
            let (own_m, other_m) = (ranges_m[side as usize], ranges_m[side.other() as usize]);
            let pick = &mut sides[side as usize][index];
            let is_beyond = own_m > farthest_m(depth_m).max(depth_m + LEAST_BEYOND_M);
            let is_certain =
                pick.confidence >= CERTAIN && !BEARS_OUT.contains(&(other_m / depth_m));
            let is_other_beyond = other_m > depth_m;
            let is_apart = is_other_beyond && own_m.max(other_m) > MOST_APART * own_m.min(other_m);
            if is_beyond && (is_apart || !is_other_beyond && !is_certain) {
                pick.confidence = 0.0;
            }
        }
    }
}
