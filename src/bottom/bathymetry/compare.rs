//! Computes the residuals of measured points against a reference, and compares them with the limits
//! of an international standard.
//!
//! In: points with elevations, and a reference. Out: their differences with statistics, and the
//! share within each order of IHO S-44.
//!
//! `matching` finds the reference of each measured point. Differences are sorted by the variables
//! that they may depend on, and into histograms. A difference is always measured minus reference
//! elevation, so that up is positive: a bottom measured too shallow gives more than 0.

mod matching;

pub use matching::{Match, Matching, ReferencePoints, match_points};

use crate::cloud::Residuals;
use crate::presentation::ticks;
use serde::Serialize;

/// Agreement of a measurement with a reference.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Comparison {
    /// Number of measured points.
    pub measured: usize,
    /// Number of measured points without a reference near enough.
    pub unmatched: usize,
    /// Statistics of the differences, measured minus reference elevation; `None` where nothing was
    /// matched.
    #[serde(flatten)]
    pub residuals: Option<Residuals>,
    /// Share of the matched points within each order's limit; empty where nothing was matched.
    pub orders: Vec<OrderShare>,
}

/// Share of the points within an order's limit.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct OrderShare {
    /// The order.
    #[serde(flatten)]
    pub order: SurveyOrder,
    /// Share of the points within its limit at their own depth, 0 to 1. An order requires 0.95.
    pub share: f64,
}

impl Comparison {
    /// Creates the comparison of `measured` points, of which those in `matches` have a reference;
    /// the water's surface is at `water_level_m` in their elevations.
    pub fn new(measured: usize, matches: &[Match], water_level_m: f64) -> Self {
        let mut differences: Vec<f64> =
            matches.iter().map(|matched| matched.difference_m).collect();
        let order_share = |order: SurveyOrder| {
            let holds = |matched: &&Match| {
                let depth_m = (water_level_m - matched.reference_z_m).max(0.0);
                matched.difference_m.abs() <= order.limit_m(depth_m)
            };
            OrderShare {
                order,
                share: matches.iter().filter(holds).count() as f64 / matches.len() as f64,
            }
        };
        Self {
            measured,
            unmatched: measured - matches.len(),
            orders: match matches {
                [] => Vec::new(),
                _ => ORDERS.into_iter().map(order_share).collect(),
            },
            residuals: Residuals::of(&mut differences),
        }
    }
}

/// An order of survey, by the vertical uncertainty that it allows at 95 %.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct SurveyOrder {
    /// Name: `exclusive`, `special`, `1a/1b` or `2`.
    pub order: &'static str,
    /// Part of the uncertainty that does not depend on the depth, metres.
    pub a_m: f64,
    /// Part of the uncertainty that grows with the depth, as a share of the depth.
    pub b: f64,
}

const fn order(order: &'static str, a_m: f64, b: f64) -> SurveyOrder {
    SurveyOrder { order, a_m, b }
}

impl SurveyOrder {
    /// Returns the total vertical uncertainty allowed at a depth, `sqrt(a^2 + (b d)^2)`, metres.
    pub(crate) fn limit_m(self, depth_m: f64) -> f64 {
        self.a_m.hypot(self.b * depth_m)
    }
}

/// Statistics of the differences whose variable lies in one stretch.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Bin {
    /// Start of the stretch, inclusive.
    pub from: f64,
    /// End of the stretch, exclusive.
    pub to: f64,
    /// Statistics of the differences.
    #[serde(flatten)]
    pub residuals: Residuals,
}

/// Returns the statistics for each stretch of `width` of a variable that holds any difference, in
/// rising order. Pairs are the variable and the difference, metres; those that are not finite are
/// left out.
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

/// Sorts `values`, and returns a width of 1, 2 or 5 times a power of ten that divides the range
/// from their 1st to their 99th percentile into some 6 to 15 stretches; `None` where this range is
/// empty.
pub fn suited_width(values: &mut [f64]) -> Option<f64> {
    values.sort_unstable_by(f64::total_cmp);
    let at = |share: f64| bathyscope_log::support::statistics::quantile(values, share);
    let width = (at(0.99) - at(0.01)) / 10.0;
    if !(width > 1e-9 && width.is_finite()) {
        return None;
    }
    // Slightly smaller, so that a width just above a round one is not rounded up to twice that.
    Some(ticks::round_up(0.999 * width))
}

/// Histogram of differences.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DifferenceHistogram {
    /// Start of the first column, metres.
    pub from_m: f64,
    /// Width of a column, metres.
    pub width_m: f64,
    /// Number of differences in each column.
    pub counts: Vec<usize>,
    /// Number of differences smaller than all columns.
    pub below: usize,
    /// Number of differences larger than all columns.
    pub above: usize,
}

impl DifferenceHistogram {
    /// Creates the histogram of differences in metres; its columns hold 98 % of them or more.
    /// `None` without finite differences.
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

/// The orders of IHO Standards for Hydrographic Surveys, S-44, edition 6, table 1; the strictest
/// first.
const ORDERS: [SurveyOrder; 4] = [
    order("exclusive", 0.15, 0.0075),
    order("special", 0.25, 0.0075),
    order("1a/1b", 0.5, 0.013),
    order("2", 1.0, 0.023),
];
/// Largest number of columns of a histogram on either side of its middle.
const COLUMNS: i64 = 100;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_are_those_of_the_printed_table() {
        let depths_m = [1.0, 2.3, 5.0, 10.0, 20.0, 40.0, 100.0];
        let printed = [
            [0.1502, 0.1510, 0.1546, 0.1677, 0.2121, 0.3354, 0.7649],
            [0.2501, 0.2506, 0.2528, 0.2610, 0.2915, 0.3905, 0.7906],
            [0.5002, 0.5009, 0.5042, 0.5166, 0.5636, 0.7214, 1.3928],
            [1.0003, 1.0014, 1.0066, 1.0261, 1.1007, 1.3588, 2.5080],
        ];
        for (order, row) in ORDERS.into_iter().zip(printed) {
            for (depth_m, limit_m) in depths_m.into_iter().zip(row) {
                assert!((order.limit_m(depth_m) - limit_m).abs() < 5.1e-5, "{order:?} {depth_m}");
            }
        }
    }

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
