//! Statistics of differences by a variable that may cause them, and histograms of differences.

use crate::cloud::Residuals;
use crate::presentation::ticks;
use serde::Serialize;

/// Differences whose variable lies in one stretch.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Bin {
    /// Begin of the stretch, itself included.
    pub from: f64,
    /// End of the stretch.
    pub to: f64,
    /// Their statistics.
    #[serde(flatten)]
    pub residuals: Residuals,
}

/// Statistics for each stretch of `width` of a variable that holds any difference, in rising order.
/// Pairs are the variable and the difference, metres; those that are not finite are left out.
pub fn binned(pairs: impl Iterator<Item = (f64, f64)>, width: f64) -> Vec<Bin> {
    let finite =
        pairs.filter(|(variable, difference)| variable.is_finite() && difference.is_finite());
    let mut keyed: Vec<(i64, f64)> = Vec::with_capacity(finite.size_hint().1.unwrap_or(0));
    keyed.extend(
        finite.map(|(variable, difference)| ((variable / width).floor() as i64, difference)),
    );
    keyed.sort_unstable_by_key(|(key, _)| *key);
    let bin = |same: &[(i64, f64)]| {
        let mut differences: Vec<f64> = same.iter().map(|(_, difference)| *difference).collect();
        Some(Bin {
            from: same[0].0 as f64 * width,
            to: same[0].0.saturating_add(1) as f64 * width,
            residuals: Residuals::of(&mut differences)?,
        })
    };
    keyed.chunk_by(|a, b| a.0 == b.0).filter_map(bin).collect()
}

/// A width of 1, 2 or 5 times a power of ten that makes 6 to 15 stretches, more or less, of what
/// lies between the 1st and the 99th percentile of `values`, which are sorted; `None` where they
/// are all the same.
pub fn suited_width(values: &mut [f64]) -> Option<f64> {
    values.sort_unstable_by(f64::total_cmp);
    let at = |share: f64| bathyscope_log::support::statistics::quantile(values, share);
    let width = (at(0.99) - at(0.01)) / 10.0;
    if !(width > 1e-9 && width.is_finite()) {
        return None;
    }
    // A width a little narrower than that, rather than one twice as wide.
    Some(ticks::round_up(0.999 * width))
}

/// Histogram of differences.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DifferenceHistogram {
    /// Begin of the first column, metres.
    pub from_m: f64,
    /// Width of a column, metres.
    pub width_m: f64,
    /// Differences in each column.
    pub counts: Vec<usize>,
    /// Differences smaller than all columns.
    pub below: usize,
    /// Differences larger than all columns.
    pub above: usize,
}

/// Columns of a histogram to either side of its middle, at most.
const COLUMNS: i64 = 100;

impl DifferenceHistogram {
    /// Creates the histogram of differences in metres; its columns hold 98 % of them or more.
    /// `None` without any.
    pub fn of(differences: &[f64]) -> Option<Self> {
        let mut sorted: Vec<f64> = differences.iter().copied().filter(|d| d.is_finite()).collect();
        let width_m = 0.2 * suited_width(&mut sorted).unwrap_or(0.05);
        let column = |difference: f64| (difference / width_m).floor() as i64;
        let middle = column(*sorted.get(sorted.len() / 2)?);
        let first = column(sorted[0]).max(middle.saturating_sub(COLUMNS));
        let last = column(sorted[sorted.len() - 1]).min(middle.saturating_add(COLUMNS));
        let mut made = Self {
            from_m: first as f64 * width_m,
            width_m,
            counts: vec![0; (last - first + 1) as usize],
            below: 0,
            above: 0,
        };
        for column in sorted.into_iter().map(column) {
            match usize::try_from(column.saturating_sub(first)).ok() {
                None => made.below += 1,
                Some(index) => match made.counts.get_mut(index) {
                    Some(count) => *count += 1,
                    None => made.above += 1,
                },
            }
        }
        Some(made)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bins_hold_what_falls_into_them() {
        let pairs = [(0.0, 1.0), (0.9, 3.0), (1.0, 5.0), (-0.1, 7.0), (f64::NAN, 9.0)];
        let bins = binned(pairs.into_iter(), 1.0);
        let found: Vec<(f64, usize, f64)> =
            bins.iter().map(|bin| (bin.from, bin.residuals.n, bin.residuals.mean_m)).collect();
        assert_eq!(found, [(-1.0, 1, 7.0), (0.0, 2, 2.0), (1.0, 1, 5.0)]);
    }

    #[test]
    fn widths_are_round() {
        let mut depths: Vec<f64> = (0..=1000).map(|index| 2.0 + 0.003 * f64::from(index)).collect();
        assert_eq!(suited_width(&mut depths), Some(0.5));
        assert_eq!(suited_width(&mut [1.0; 9]), None);
    }

    #[test]
    fn a_histogram_counts_everything_once() {
        let mut differences: Vec<f64> =
            (-200..=200).map(|index| 0.001 * f64::from(index)).collect();
        differences.extend([-50.0, 80.0, 90.0, f64::NAN]);
        let made = DifferenceHistogram::of(&differences).unwrap();
        assert_eq!((made.below, made.above), (1, 2));
        assert_eq!(made.counts.iter().sum::<usize>(), 401);
        for (index, count) in made.counts.iter().enumerate() {
            let from_m = made.from_m + index as f64 * made.width_m;
            let inside = differences
                .iter()
                .filter(|d| **d >= from_m - 1e-12 && **d < from_m + made.width_m - 1e-12);
            assert!(inside.count().abs_diff(*count) <= 1, "{from_m}");
        }
        assert_eq!(DifferenceHistogram::of(&[]), None);
    }
}
