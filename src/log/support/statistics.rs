//! Computes medians, quantiles and spreads that a few bad values hardly change. This module depends
//! on no other module of the crate.

use std::cmp::Ordering;

/// Ratio of the standard deviation of normal noise to its median absolute deviation.
pub const SIGMA_PER_MAD: f64 = 1.4826;
/// Standard error of a median as a multiple of that of a mean, for normal noise.
pub const MEDIAN_ERROR: f64 = 1.2533;

/// Returns the 2nd and the 98th percentile of some values, as the ends of a colour scale, which a
/// few odd values do not change. `None` without a finite value.
pub fn colour_ends(values: impl IntoIterator<Item = f32>) -> Option<[f32; 2]> {
    let finite = values.into_iter().filter(|value| value.is_finite());
    let mut values: Vec<f32> = finite.collect();
    let last = values.len().checked_sub(1)?;
    let mut at = |share: f64| {
        let rank = (share * last as f64).round() as usize;
        *values.select_nth_unstable_by(rank, f32::total_cmp).1
    };
    Some([at(0.02), at(0.98)])
}

/// Returns the least and the greatest of some values; without values, the first is above the
/// second.
pub fn ends(values: impl IntoIterator<Item = f64>) -> [f64; 2] {
    let values = values.into_iter();
    values.fold([f64::MAX, f64::MIN], |[least, most], value| [least.min(value), most.max(value)])
}

/// Returns the smallest range around two ranges; where only one is given, that range.
pub fn wider(one: Option<[f32; 2]>, other: Option<[f32; 2]>) -> Option<[f32; 2]> {
    match (one, other) {
        (Some([a, b]), Some([c, d])) => Some([a.min(c), b.max(d)]),
        (one, other) => one.or(other),
    }
}

/// Returns the median, for an even count the mean of the middle two values; NaN for an empty slice.
/// Reorders `values`.
pub fn median(values: &mut [f64]) -> f64 {
    if values.is_empty() {
        return f64::NAN;
    }
    let (middle, even) = (values.len() / 2, values.len().is_multiple_of(2));
    let (below, &mut upper, _) = values.select_nth_unstable_by(middle, f64::total_cmp);
    if !even {
        return upper;
    }
    let lower = below.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    (lower + upper) / 2.0
}

/// Returns the [`median`] of some values; NaN without any.
pub fn median_of(values: impl IntoIterator<Item = f64>) -> f64 {
    median(&mut values.into_iter().collect::<Vec<_>>())
}

/// Returns the median step from each value to the next; NaN for fewer than two values.
pub fn usual_step(values: impl Iterator<Item = f64>) -> f64 {
    let mut before = None;
    let steps = values.filter_map(|value| before.replace(value).map(|before: f64| value - before));
    median_of(steps)
}

/// Returns the value with half of the weight on either side; where half of the weight is reached
/// exactly between two neighbours, their mean, so that equal weights give the [`median`]; NaN for
/// an empty slice. Each entry is a value and its weight, above 0. Sorts `values`.
pub fn weighted_median(values: &mut [(f64, f64)]) -> f64 {
    values.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
    let half = 0.5 * values.iter().map(|(_, weight)| weight).sum::<f64>();
    let mut below = 0.0;
    for (index, &(value, weight)) in values.iter().enumerate() {
        below += weight;
        // The tolerance allows for the rounding of the sums.
        if (below - half).abs() <= 1e-9 * half {
            let next = values.get(index + 1).map_or(value, |(next, _)| *next);
            return 0.5 * (value + next);
        }
        if below > half {
            return value;
        }
    }
    f64::NAN
}

/// Returns the middle value in the order of `compare`, for an even count the upper of the middle
/// two. `None` for an empty slice. Reorders `values`.
pub fn upper_median<T: Copy>(
    values: &mut [T],
    compare: impl FnMut(&T, &T) -> Ordering,
) -> Option<T> {
    let middle = values.len() / 2;
    (!values.is_empty()).then(|| *values.select_nth_unstable_by(middle, compare).1)
}

/// Returns the robust standard deviation about `centre`: 1.4826 times the median absolute
/// deviation. Overwrites `values`.
pub fn spread_about(values: &mut [f64], centre: f64) -> f64 {
    for value in values.iter_mut() {
        *value = (*value - centre).abs();
    }
    SIGMA_PER_MAD * median(values)
}

/// Returns some values in ascending order.
pub fn sorted(values: impl IntoIterator<Item = f64>) -> Vec<f64> {
    let mut values: Vec<f64> = values.into_iter().collect();
    values.sort_unstable_by(f64::total_cmp);
    values
}

/// Estimates the standard deviation of errors from their sizes, in ascending order: the mean of the
/// 68 % quantile and of half the 95 % quantile. NaN for an empty slice.
pub fn sigma_of_sizes(sorted: &[f64]) -> f64 {
    0.5 * (quantile(sorted, 0.683) + 0.5 * quantile(sorted, 0.954))
}

/// Returns the value below which a share (0 to 1) of the values is, interpolated linearly as numpy
/// does by default; NaN for an empty slice. `sorted` is in ascending order.
pub fn quantile(sorted: &[f64], share: f64) -> f64 {
    let Some(last) = sorted.len().checked_sub(1) else {
        return f64::NAN;
    };
    let place = share.clamp(0.0, 1.0) * last as f64;
    let below = place as usize;
    let (low, high) = (sorted[below], sorted[(below + 1).min(last)]);
    low + (place - below as f64) * (high - low)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn medians_of_odd_and_even_counts() {
        assert_eq!(median(&mut [3.0, 1.0, 2.0]), 2.0);
        assert_eq!(median(&mut [4.0, 1.0, 3.0, 2.0]), 2.5);
        assert!(median(&mut []).is_nan());
        assert_eq!(upper_median(&mut [4.0, 1.0, 3.0, 2.0], f64::total_cmp), Some(3.0));
        assert_eq!(upper_median(&mut [], f64::total_cmp), None);
    }

    #[test]
    fn a_gap_does_not_change_the_usual_step() {
        assert_eq!(usual_step([0.0, 1.0, 2.0, 9.0, 10.0].into_iter()), 1.0);
        assert!(usual_step([3.0].into_iter()).is_nan());
    }

    #[test]
    fn the_colour_scale_leaves_out_the_outer_two_percent() {
        let depths = (0..=100).map(|i| i as f32).chain([f32::NAN]);
        assert_eq!(colour_ends(depths), Some([2.0, 98.0]));
        assert_eq!(colour_ends([f32::NAN]), None);
    }

    #[test]
    fn weights_move_the_median() {
        let mut even = [4.0, 1.0, 3.0, 2.0].map(|value| (value, 0.3));
        assert_eq!(weighted_median(&mut even), 2.5);
        assert_eq!(weighted_median(&mut [(1.0, 1.0), (2.0, 1.0), (9.0, 5.0)]), 9.0);
        assert_eq!(weighted_median(&mut [(7.0, 0.1)]), 7.0);
        assert!(weighted_median(&mut []).is_nan());
    }

    #[test]
    fn quantiles_are_those_of_numpy() {
        // numpy.quantile([1, 2, 4, 8], [0.0, 0.4, 0.95, 1.0])
        let sorted = [1.0, 2.0, 4.0, 8.0];
        for (share, expected) in [(0.0, 1.0), (0.4, 2.4), (0.95, 7.4), (1.0, 8.0)] {
            assert!((quantile(&sorted, share) - expected).abs() < 1e-12, "{share}");
        }
        assert!(quantile(&[], 0.5).is_nan());
    }
}
