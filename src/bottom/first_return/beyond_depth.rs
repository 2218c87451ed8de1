//! First returns beyond the recorded depth: the bottom below the boat returns at that range, so
//! that nothing farther can be the first one, unless the depth is wrong.

use super::Pick;
use super::false_soundings::pick_range_m;
use bathyscope_log::survey::{Side, Survey};
use std::ops::Range;

/// A first return has to lie beyond the depth by so much to be doubted, metres: depths may be
/// rounded to 0.1 m.
const LEAST_BEYOND_M: f64 = 0.2;
/// With so much confidence it is believed all the same, and the depth may be wrong, unless the
/// other side bears the depth out: it lies within these shares of it, as on a bank.
const CERTAIN: f32 = 0.6;
const BEARS_OUT: Range<f64> = 0.75..1.0;
/// On a bank of 35 degrees the lower side is as many times as far as the upper one. Sides that are
/// farther apart do not bear each other out against the depth.
const MOST_APART: f64 = 1.25;

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
    for index in 0..sides[0].len() {
        let depth_m = f64::from(survey.locked_depth_m(first + index));
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
