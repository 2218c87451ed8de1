//! Height of the transducer above the bottom over a few pings.

use bathyscope_bottom::calibration::Calibration;
use bathyscope_bottom::first_return::FirstReturns;
use bathyscope_log::support::statistics::median;
use bathyscope_log::survey::{Side, Survey};
use std::ops::Range;

/// Median over some pings of the bottom edits on a side, else of the recorded depths where the
/// recorder had the bottom, else of the first returns on that side: who draws the bottom sees what
/// the recorder took for it. Metres, times `range_factor`; `None` where nothing is known of the
/// bottom.
pub(super) fn altitude_m(
    survey: &Survey,
    returns: &FirstReturns,
    calibration: &Calibration,
    range_factor: f64,
    side: Side,
    pings: Range<usize>,
) -> Option<f64> {
    let pings = pings.start..pings.end.min(survey.side_scan.len());
    let first_return_m = |ping: usize| {
        let pick = returns.side(side).get(ping)?;
        let span = survey.span(ping, side)?;
        let range_m = calibration.range_m(span, f64::from(pick.sample));
        (pick.is_some() && !pick.above_bottom && range_m > 0.0).then_some(range_m)
    };
    let is_drawn = |&ping: &usize| returns.is_drawn(side, ping);
    let drawn = pings.clone().filter(is_drawn).filter_map(first_return_m);
    let mut depths_m: Vec<f64> = drawn.collect();
    if depths_m.is_empty() {
        let recorded = pings.clone();
        let recorded = recorded.map(|ping| f64::from(survey.good_depth_m(ping)));
        depths_m = recorded.filter(|depth_m| *depth_m > 0.0).collect();
    }
    if depths_m.is_empty() {
        depths_m = pings.filter_map(first_return_m).collect();
    }
    let altitude_m = median(&mut depths_m) * range_factor;
    (altitude_m > 0.0).then_some(altitude_m)
}
