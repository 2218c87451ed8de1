//! Tables of differences by depth, across-track distance and heading, and their histogram.

use crate::pipeline::Products;
use bathyscope_bottom::bathymetry::compare::{
    Bin, DifferenceHistogram, Match, binned, suited_width,
};
use bathyscope_bottom::cloud::CloudPoint;
use bathyscope_log::survey::PingNav;
use serde::Serialize;

/// Differences of points from a reference, measured minus reference elevation, sorted.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ResidualTables {
    /// Bins by the depth of the reference at the point, metres.
    pub by_depth_m: Vec<Bin>,
    /// Bins by the across-track distance, metres: port below 0, starboard above.
    pub by_across_m: Vec<Bin>,
    /// Bins by the heading, degrees clockwise from north.
    pub by_heading_deg: Vec<Bin>,
    /// Count of the differences by size.
    pub histogram: Option<DifferenceHistogram>,
}

/// Headings that are taken together, degrees.
const SECTOR_DEG: f64 = 45.0;
/// Width of a bin where the values give none, as where all points lie at one distance from the
/// track, metres.
const ANY_WIDTH_M: f64 = 0.5;

/// Sorts differences; `measured` tells the point of each, and the results that it is of.
pub(super) fn tables<'a>(
    differences: &[Match],
    measured: impl Fn(&Match) -> (&'a Products, &'a CloudPoint),
) -> ResidualTables {
    let by = |variable: &dyn Fn(&Match) -> f64, width: Option<f64>| {
        let mut values: Vec<f64> = differences.iter().map(variable).collect();
        values.retain(|value| value.is_finite());
        let width = width.or_else(|| suited_width(&mut values));
        let pairs = differences.iter().map(|one| (variable(one), one.difference_m));
        binned(pairs, width.unwrap_or(ANY_WIDTH_M))
    };
    let all: Vec<f64> = differences.iter().map(|one| one.difference_m).collect();
    let of_point = |of: fn(&Products, &CloudPoint) -> f64| {
        let measured = &measured;
        move |one: &Match| {
            let (products, point) = measured(one);
            of(products, point)
        }
    };
    ResidualTables {
        by_depth_m: by(&|one| -one.reference_z_m, None),
        by_across_m: by(&of_point(across_m), None),
        by_heading_deg: by(&of_point(heading_deg), Some(SECTOR_DEG)),
        histogram: DifferenceHistogram::of(&all),
    }
}

/// Returns the place and heading of the boat when a point was measured.
fn boat<'a>(products: &'a Products, point: &CloudPoint) -> Option<&'a PingNav> {
    point.record().place(&products.navigation)
}

/// Distance of a point from where the boat was, to starboard; NaN where that is not known.
fn across_m(products: &Products, point: &CloudPoint) -> f64 {
    let across = boat(products, point).and_then(|boat| {
        let [east, north] = boat.starboard()?;
        Some((point.east_m - boat.east_m) * east + (point.north_m - boat.north_m) * north)
    });
    across.unwrap_or(f64::NAN)
}

fn heading_deg(products: &Products, point: &CloudPoint) -> f64 {
    boat(products, point).map_or(f64::NAN, |boat| boat.heading_rad.to_degrees().rem_euclid(360.0))
}
