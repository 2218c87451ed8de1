//! Computes the height of the transducer over the ground on each side: the first returns, smoothed
//! over neighbouring pings.

use crate::calibration::Calibration;
use crate::first_return::FirstReturns;
use bathyscope_log::support::statistics::median;
use bathyscope_log::survey::{Side, Survey};
use rayon::prelude::*;

/// Number of pings before and after a ping that the median is taken over, so that a fish or a lost
/// pick does not change the ground.
const HALF_PINGS: usize = 6;

/// Returns the altitude of every ping on one side, metres: the median over nearby pings of the
/// first returns, or of the recorded depth where there is no first return or it is an above-bottom
/// return. Gaps are filled by linear interpolation over the pings. NaN for all pings where none has
/// a first return or a depth.
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

/// Returns the slant range of the first return, or the recorded depth; NaN without either.
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
