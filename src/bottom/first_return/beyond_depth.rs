//! Lowers the confidence of first returns beyond the recorded depth: the bottom below the boat
//! returns an echo at the recorded depth, so nothing farther away can be the first return, unless
//! the depth is wrong.

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
/// Least confidence at which a first return beyond the depth is believed all the same (the depth
/// may be wrong), unless the range of the other side confirms the depth: that range is then between
/// these shares of the depth, as on a bank.
const CERTAIN: f32 = 0.6;
const BEARS_OUT: Range<f64> = 0.75..1.0;
/// Largest ratio of the ranges of the two sides at which they confirm each other against the depth:
/// that of the lower side to the upper side on a bank of 35 degrees.
const MOST_APART: f64 = 1.25;
/// Largest difference of the two sides over a level bottom, as a share; fewest pings over a level
/// bottom that determine at which share of the depth the first returns of a log are; and distance
/// of the limit above the median of these shares, in standard deviations of their scatter.
const LEVEL: f64 = 0.03;
const FEWEST_LEVEL: usize = 200;
const OWN_SIGMAS: f64 = 4.0;

/// Returns the largest range of the echo of the bottom below the boat where the recorder's depth is
/// right, metres: differences of scale, rounding and noise between ranges and depths are no larger.
pub(super) fn farthest_m(depth_m: f64) -> f64 {
    const SHALLOW: f64 = 1.08;
    const DEEP: (f64, f64) = (1.03, 0.25);
    (SHALLOW * depth_m).min(DEEP.0 * depth_m + DEEP.1)
}

/// Sets the confidence of first returns beyond the bottom below the boat to 0. A first return keeps
/// its confidence in two cases: the first return of the other side is beyond the depth too, at
/// about the same range, since the depth may be wrong or the beams may not reach the nadir; or it
/// is certain and the other side does not confirm the depth. `sides` are the picks of port and
/// starboard from the ping `first` on.
pub(super) fn doubt(survey: &Survey, first: usize, sides: &mut [Vec<Pick>; 2]) {
    let [port, starboard] = sides;
    doubt_beyond(survey, first, [port, starboard], &|depth_m| farthest_m(depth_m));
}

/// Doubts first returns as [`doubt`] does, with a limit measured on this log: the ratio of ranges
/// to depths where both sides detect a level bottom.
pub(super) fn doubt_by_own_scale(survey: &Survey, returns: &mut FirstReturns) {
    let Some(farthest) = farthest_share(survey, returns) else {
        return;
    };
    let FirstReturns { port, starboard, .. } = returns;
    let sides = [Arc::make_mut(port).as_mut_slice(), Arc::make_mut(starboard).as_mut_slice()];
    doubt_beyond(survey, 0, sides, &|depth_m| farthest_m(depth_m).min(farthest * depth_m));
}

/// Returns the largest ratio of first return to depth over a level bottom in this log; `None` where
/// too few pings determine it.
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

/// Doubts first returns beyond the range that `farthest_m` returns for the depth.
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
