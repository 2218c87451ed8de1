//! Which picks lie above the bottom that the recorder saw.

use super::Pick;
use crate::survey::{Side, Survey};

/// Whether a return at `sample` is nearer than the recorded depth by more than `margin_m`, by the recorder's own scale.
/// Never where no depth was recorded.
pub(super) fn is_canopy(
    survey: &Survey,
    ping: usize,
    side: Side,
    sample: f32,
    margin_m: f64,
) -> bool {
    let Some(recorded) = survey.side_scan.get(ping) else {
        return false;
    };
    let Some(span) = recorded.side(side) else {
        return false;
    };
    // Comparisons with NaN are false: no depth or no pick is no canopy.
    span.range_m(f64::from(sample)) < f64::from(recorded.depth_m) - margin_m
}

/// Sets the flag of every pick; `first` is the ping of the first one.
pub(super) fn flag(survey: &Survey, side: Side, first: usize, picks: &mut [Pick], margin_m: f64) {
    for (ping, pick) in (first..).zip(picks) {
        pick.canopy = is_canopy(survey, ping, side, pick.sample, margin_m);
    }
}
