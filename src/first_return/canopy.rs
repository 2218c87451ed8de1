//! Which picks lie above the bottom that the recorder saw.

use super::Pick;
use crate::survey::{Side, Survey};

/// Sets the flag of every pick: nearer than the depth by more than `margin_m`, by the recorder's own scale.
///
/// `depths_m` holds a depth a pick, NaN where there is none to believe: there, nothing is flagged. `first` is the ping of
/// the first pick.
pub(super) fn flag(
    survey: &Survey,
    side: Side,
    first: usize,
    depths_m: &[f32],
    picks: &mut [Pick],
    margin_m: f64,
) {
    let pings = survey.side_scan.iter().skip(first);
    for ((pick, &depth_m), ping) in picks.iter_mut().zip(depths_m).zip(pings) {
        // Comparisons with NaN are false: no depth or no pick is no canopy.
        pick.canopy = ping.side(side).is_some_and(|span| {
            span.range_m(f64::from(pick.sample)) < f64::from(depth_m) - margin_m
        });
    }
}
