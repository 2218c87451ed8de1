//! Height of the transducer over the ground, by side: the first return, made steady.

use crate::calibration::Calibration;
use crate::first_return::FirstReturns;
use bathyscope_log::support::statistics::median;
use bathyscope_log::survey::{Side, Survey};
use rayon::prelude::*;

/// Pings before and behind whose middle value counts: a fish or a lost pick must not bend the
/// ground.
const HALF_PINGS: usize = 6;

/// Altitude of every ping on one side, metres: the median over nearby pings of the first returns,
/// where one is none or lies above the bottom by the recorded depth; between such stretches linear
/// in the ping. NaN throughout where there is neither.
pub fn altitudes_m(
    survey: &Survey,
    returns: &FirstReturns,
    calibration: &Calibration,
    side: Side,
) -> Vec<f32> {
    let measured: Vec<f64> = (0..survey.side_scan.len())
        .map(|ping| altitude_m(survey, returns, calibration, side, ping))
        .collect();
    let mut steady: Vec<f32> = (0..measured.len())
        .into_par_iter()
        .map(|ping| {
            let near = ping.saturating_sub(HALF_PINGS)..(ping + HALF_PINGS + 1).min(measured.len());
            let mut known: Vec<f64> =
                measured[near].iter().copied().filter(|m| m.is_finite()).collect();
            median(&mut known) as f32
        })
        .collect();
    bridge(&mut steady);
    steady
}

/// The first return's slant range, or the recorded depth; NaN without either.
fn altitude_m(
    survey: &Survey,
    returns: &FirstReturns,
    calibration: &Calibration,
    side: Side,
    ping: usize,
) -> f64 {
    let picked = returns.side(side).get(ping);
    let picked_m = match (picked, survey.span(ping, side)) {
        (Some(pick), Some(span)) if pick.is_some() && !pick.above_bottom => {
            calibration.range_m(span, f64::from(pick.sample))
        }
        _ => f64::NAN,
    };
    if picked_m > 0.0 { picked_m } else { f64::from(survey.good_depth_m(ping)) }
}

/// Fills NaN linearly between its neighbours, and with the nearest value at both ends.
fn bridge(values: &mut [f32]) {
    let known: Vec<usize> = (0..values.len()).filter(|&i| !values[i].is_nan()).collect();
    let (Some(&first), Some(&last)) = (known.first(), known.last()) else {
        return;
    };
    let (head, tail) = (values[first], values[last]);
    values[..first].fill(head);
    values[last..].fill(tail);
    for pair in known.windows(2) {
        let (from, to) = (values[pair[0]], values[pair[1]]);
        let steps = (pair[1] - pair[0]) as f32;
        for (step, value) in values[pair[0]..pair[1]].iter_mut().enumerate().skip(1) {
            *value = from + (to - from) * step as f32 / steps;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::bridge;

    #[test]
    fn gaps_are_bridged_and_ends_held() {
        let nan = f32::NAN;
        let mut values = [nan, 2.0, nan, nan, 5.0, nan];
        bridge(&mut values);
        assert_eq!(values, [2.0, 2.0, 3.0, 4.0, 5.0, 5.0]);
        let mut none = [nan, nan];
        bridge(&mut none);
        assert!(none.iter().all(|value| value.is_nan()));
    }
}
