//! Properties that a point has from its first return, whatever the geometry and the calibration.

use super::above_bottom::{AboveDepth, height_m, way_m};
use super::clutter::{Clutter, clutter};
use super::level::echo_level;
use crate::first_return::{FirstReturns, Pick, ground_confidence};
use bathyscope_log::survey::{Navigation, Side, Survey};
use rayon::prelude::*;

/// Properties of a first return, wherever it is placed.
#[derive(Clone, Copy, Debug)]
pub(super) struct PickTrait {
    /// True if it is something above the bottom.
    pub(super) above_bottom: bool,
    /// The length of the stretch of such returns, metres; 0 of the bottom and of clutter.
    pub(super) above_bottom_m: f32,
    /// True if it is clutter, which does not show the slope of the bottom.
    pub(super) is_clutter: bool,
    /// Confidence that it is what `above_bottom` states.
    pub(super) confidence: f32,
    /// Level of its echo, 0 to 255.
    pub(super) level: u8,
}

/// Properties of all first returns. Several clouds of the same returns share them: they cost as
/// much as all else of a cloud.
pub struct PickTraits {
    /// Properties by side, port first, one a ping.
    sides: [Vec<PickTrait>; 2],
    clutter: Option<Clutter>,
}

impl PickTraits {
    /// Finds the properties of a survey's first returns.
    pub fn new(survey: &Survey, navigation: &Navigation, returns: &FirstReturns) -> Self {
        let (is_clutter, clutter) = clutter(survey, returns, &way_m(&navigation.pings));
        let above = AboveDepth::new(survey, navigation, returns, &is_clutter);
        let lengths_m = Side::BOTH.map(|side| above.stretches_m(side));
        let usual_m = above.usual_departures_m();
        let of_pick = |side: Side, ping: usize, pick: &Pick| {
            let is_clutter = is_clutter[side as usize].get(ping) == Some(&true);
            let high_m = height_m(survey, returns, ping, side);
            // Where the recorded depth was found to be false, so may be what lies above it.
            let is_usual = high_m <= usual_m[ping];
            let above_bottom = is_clutter || pick.above_bottom && !is_usual;
            PickTrait {
                above_bottom,
                is_clutter,
                // Without a depth to believe it is not known how high it is.
                above_bottom_m: if above_bottom && !is_clutter && high_m.is_finite() {
                    lengths_m[side as usize][ping]
                } else {
                    0.0
                },
                // What does not stand out is ground.
                confidence: if above_bottom {
                    pick.confidence
                } else {
                    ground_confidence(pick.confidence, pick.above_bottom)
                },
                level: if pick.is_some() { echo_level(survey, ping, side, pick.sample) } else { 0 },
            }
        };
        let of_side = |side: Side| {
            let picks = returns.side(side).par_iter().enumerate();
            picks.map(|(ping, pick)| of_pick(side, ping, pick)).collect()
        };
        Self { sides: Side::BOTH.map(of_side), clutter }
    }

    /// The clutter among the first returns; `None` without any.
    pub fn clutter(&self) -> Option<Clutter> {
        self.clutter
    }

    /// Returns the properties of a side, one a ping.
    pub(super) fn side(&self, side: Side) -> &[PickTrait] {
        &self.sides[side as usize]
    }
}
