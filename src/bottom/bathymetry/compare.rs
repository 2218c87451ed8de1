//! Computes the residuals of measured points against a reference, and compares them with the limits
//! of an international standard.
//!
//! In: points with elevations, and a reference. Out: their differences with statistics, and the
//! share within each order of IHO S-44.
//!
//! Differences are sorted by the variables
//! that they may depend on, and into histograms. A difference is always measured minus reference
//! elevation, so that up is positive: a bottom measured too shallow gives more than 0.

use super::{Between, Node, Tin};
use crate::cloud::Residuals;
use crate::nearest::Nearest;
use crate::presentation::ticks;
use bathyscope_log::support::progress::{Cancelled, Progress};
use rayon::prelude::*;
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
    SurveyOrder { order: "exclusive", a_m: 0.15, b: 0.0075 },
    SurveyOrder { order: "special", a_m: 0.25, b: 0.0075 },
    SurveyOrder { order: "1a/1b", a_m: 0.5, b: 0.013 },
    SurveyOrder { order: "2", a_m: 1.0, b: 0.023 },
];
/// Largest number of columns of a histogram on either side of its middle.
const COLUMNS: i64 = 100;

/// Method that finds the reference of a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Matching {
    /// The nearest reference point, seen from above, within a radius in metres.
    Nearest {
        /// The radius, inclusive, metres.
        radius_m: f64,
    },
    /// The triangulated surface of the reference points at the place of the point.
    Surface {
        /// The surface has no triangles between points farther apart than twice this
        /// ([`Tin::with_max_gap`]), metres.
        max_gap_m: f64,
    },
}

impl Matching {
    /// Returns the method in words.
    pub fn in_words(self) -> String {
        match self {
            Self::Nearest { radius_m } => format!("nearest point within {radius_m} m"),
            Self::Surface { max_gap_m } => format!("triangulated surface, gap {max_gap_m} m"),
        }
    }
}

/// A measured point and its reference.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Match {
    /// Index of the measured point.
    pub measured: usize,
    /// Elevation of the reference there, metres.
    pub reference_z_m: f64,
    /// Measured minus reference elevation, metres: up is positive.
    pub difference_m: f64,
}

/// Number of points that a worker processes between two checks for cancellation.
const CHUNK: usize = 1024;

/// Finds the reference of each measured point, in the order of the points; points without a
/// reference and points that are not finite are left out. Points are east, north and elevation in
/// metres, all in one plane.
pub fn match_points(
    measured: &[[f64; 3]],
    reference: &[[f64; 3]],
    matching: Matching,
    progress: &Progress,
) -> Result<Vec<Match>, Cancelled> {
    ReferencePoints::new(reference.iter().copied(), matching).matches(
        measured,
        |point| *point,
        progress,
    )
}

/// Reference points, prepared for comparison with several measurements.
pub struct ReferencePoints(Prepared);

enum Prepared {
    Nearest {
        points: Vec<[f64; 3]>,
        nearest: Nearest,
        radius_m: f64,
    },
    Surface(Tin),
    /// No points, or points that span no surface.
    Nothing,
}

impl ReferencePoints {
    /// Prepares reference points as east, north, elevation, metres; points that are not finite are
    /// ignored.
    pub fn new(points: impl Iterator<Item = [f64; 3]> + Clone, matching: Matching) -> Self {
        let points = points.filter(|point| point.iter().all(|value| value.is_finite()));
        let prepared = match matching {
            Matching::Nearest { radius_m } => {
                let points: Vec<[f64; 3]> = points.collect();
                let places: Vec<[f64; 2]> = points.iter().map(|[x, y, _]| [*x, *y]).collect();
                let nearest = Nearest::of(&places);
                nearest.map(|nearest| Prepared::Nearest { points, nearest, radius_m })
            }
            Matching::Surface { max_gap_m } => {
                triangulated(points, max_gap_m).map(Prepared::Surface)
            }
        };
        Self(prepared.unwrap_or(Prepared::Nothing))
    }

    /// Finds the reference of each measured item as [`match_points`] does; `place` returns its
    /// east, north and elevation.
    pub fn matches<T: Sync>(
        &self,
        measured: &[T],
        place: impl Fn(&T) -> [f64; 3] + Sync,
        progress: &Progress,
    ) -> Result<Vec<Match>, Cancelled> {
        match &self.0 {
            Prepared::Nearest { points, nearest, radius_m } => {
                let reference = |place: [f64; 2]| {
                    let (found, _) = nearest.at(place);
                    let [x, y, z_m] = points[found];
                    // Computed from coordinates, not from the index's squared distance: only then
                    // is a radius exact to its last bit.
                    let distance_m = (x - place[0]).hypot(y - place[1]);
                    (distance_m <= *radius_m).then_some(z_m)
                };
                each(measured, place, || reference, progress)
            }
            Prepared::Surface(tin) => {
                let sampler = || {
                    let mut sampler = tin.sampler(Between::Linear);
                    move |place| Some(-sampler.depth_at(place)?)
                };
                each(measured, place, sampler, progress)
            }
            Prepared::Nothing => Ok(Vec::new()),
        }
    }
}

/// Finds the reference elevation at every measured place; each chunk of places has its own sampler.
fn each<T: Sync, R: FnMut([f64; 2]) -> Option<f64>>(
    measured: &[T],
    place: impl Fn(&T) -> [f64; 3] + Sync,
    reference: impl Fn() -> R + Sync,
    progress: &Progress,
) -> Result<Vec<Match>, Cancelled> {
    progress.start(measured.len() as u64);
    // One number per point, not a list per chunk: a log has more than a million points.
    let mut references_z_m = vec![f64::NAN; measured.len()];
    references_z_m.par_chunks_mut(CHUNK).zip(measured.par_chunks(CHUNK)).try_for_each(
        |(found, points)| {
            progress.check()?;
            let mut reference = reference();
            for (found, point) in found.iter_mut().zip(points) {
                let [east_m, north_m, z_m] = place(point);
                if [east_m, north_m, z_m].iter().all(|value| value.is_finite()) {
                    *found = reference([east_m, north_m]).unwrap_or(f64::NAN);
                }
            }
            progress.advance(points.len() as u64);
            Ok(())
        },
    )?;
    let known = || {
        let found = references_z_m.iter().enumerate();
        found.filter(|(_, z_m)| !z_m.is_nan())
    };
    let mut matches = Vec::with_capacity(known().count());
    matches.extend(known().map(|(measured_index, &reference_z_m)| Match {
        measured: measured_index,
        reference_z_m,
        difference_m: place(&measured[measured_index])[2] - reference_z_m,
    }));
    Ok(matches)
}

fn triangulated(points: impl Iterator<Item = [f64; 3]> + Clone, max_gap_m: f64) -> Option<Tin> {
    let node = |[east_m, north_m, z_m]: [f64; 3]| Node {
        east_m,
        north_m,
        depth_m: -z_m,
        spread_m: 0.0,
        has_side_scan: false,
        slope_end: f32::NAN,
    };
    let mut nodes = Vec::with_capacity(points.clone().count());
    nodes.extend(points.map(node));
    Some(Tin::new(nodes)?.with_max_gap(max_gap_m))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bathymetry::testing::{GOLDEN, golden_points};

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

    fn reference() -> Vec<[f64; 3]> {
        let points = golden_points();
        points.iter().map(|p| [p.east_m, p.north_m, -p.depth_m]).collect()
    }

    #[test]
    fn the_nearest_is_that_of_a_search_through_all() {
        let reference = reference();
        let measured: Vec<[f64; 3]> = (0..3000)
            .map(|i| [0.37 * f64::from(i % 32) - 1.0, 0.11 * f64::from(i / 32), -3.0])
            .collect();
        let radius_m = 0.6;
        let found =
            match_points(&measured, &reference, Matching::Nearest { radius_m }, &Progress::new());
        let brute = measured.iter().enumerate().filter_map(|(index, [x, y, _])| {
            let off = |point: &&[f64; 3]| (point[0] - x).hypot(point[1] - y);
            let nearest = reference.iter().min_by(|a, b| off(a).total_cmp(&off(b)))?;
            (off(&nearest) <= radius_m).then_some((index, nearest[2]))
        });
        let brute: Vec<(usize, f64)> = brute.collect();
        let found: Vec<(usize, f64)> =
            found.unwrap().iter().map(|m| (m.measured, m.reference_z_m)).collect();
        assert!(brute.len() > 500 && brute.len() < 2500, "{}", brute.len());
        assert_eq!(found, brute);
    }

    #[test]
    fn the_surface_is_that_of_scipy_and_up_is_positive() {
        let measured = GOLDEN.map(|golden| [golden.place[0], golden.place[1], -3.0]);
        let matching = Matching::Surface { max_gap_m: 20.0 };
        let found = match_points(&measured, &reference(), matching, &Progress::new()).unwrap();
        for (matched, golden) in found.iter().zip(&GOLDEN) {
            assert!((matched.difference_m - (golden.linear - 3.0)).abs() < 1e-9, "{matched:?}");
        }
        assert_eq!(found.len(), GOLDEN.len());
    }

    #[test]
    fn what_is_no_number_has_no_reference() {
        let nearest = Matching::Nearest { radius_m: 5.0 };
        let find = |measured: &[[f64; 3]], reference: &[[f64; 3]], matching| {
            match_points(measured, reference, matching, &Progress::new()).unwrap().len()
        };
        assert_eq!(
            find(
                &[[f64::NAN, 0.0, 1.0], [0.0, 0.0, 1.0]],
                &[[f64::NAN; 3], [1.0, 1.0, 1.0]],
                nearest
            ),
            1
        );
        assert_eq!(find(&[[0.0; 3]], &[], nearest), 0);
        assert_eq!(find(&[[0.0; 3]], &[], Matching::Surface { max_gap_m: 1.0 }), 0);
    }
}
