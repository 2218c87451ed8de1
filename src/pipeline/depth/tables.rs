//! What the differences of side-scan from soundings hang on, and how they spread.

use super::residuals::{kept_of, place};
use crate::bathymetry::compare::{Bin, Histogram, Matching, Reference, binned, suited_width};
use crate::cloud::{CloudPoint, PointSource};
use crate::pipeline::Products;
use crate::progress::{Cancelled, Progress};
use serde::Serialize;

/// Differences of all side-scan points from the triangulated soundings at their place, measured minus reference elevation, sorted.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ResidualTables {
    /// By the depth of the soundings there, metres.
    pub by_depth_m: Vec<Bin>,
    /// By the distance beside the track, metres: port below 0, starboard above.
    pub by_across_m: Vec<Bin>,
    /// By the heading, degrees clockwise from north.
    pub by_heading_deg: Vec<Bin>,
    /// How often each size occurs.
    pub histogram: Option<Histogram>,
}

/// Headings that are taken together, degrees.
const SECTOR_DEG: f64 = 45.0;
/// Where all points lie at one distance from the track.
const ANY_WIDTH_M: f64 = 0.5;

/// Sorts the differences; `None` where no side-scan point lies over the soundings.
pub fn residual_tables(
    products: &Products,
    progress: &Progress,
) -> Result<Option<ResidualTables>, Cancelled> {
    let max_gap_m = products.settings.surface.max_gap_m;
    let soundings = kept_of(products, &[PointSource::DownScan]);
    let soundings: Vec<[f64; 3]> = soundings.into_iter().map(place).collect();
    let points = kept_of(products, &[PointSource::Port, PointSource::Starboard]);
    let places: Vec<[f64; 3]> = points.iter().map(|point| place(point)).collect();
    let reference = Reference::new(&soundings, Matching::Surface { max_gap_m });
    let matches = reference.matches(&places, progress)?;
    if matches.is_empty() {
        return Ok(None);
    }
    let by = |variable: &dyn Fn(usize, f64) -> f64, width: Option<f64>| {
        let pair = |one: &crate::bathymetry::compare::Match| {
            let variable = variable(one.measured, one.reference_z_m);
            (variable, one.difference_m)
        };
        let mut values: Vec<f64> = matches.iter().map(|one| pair(one).0).collect();
        values.retain(|value| value.is_finite());
        let width = width.or_else(|| suited_width(&mut values));
        binned(matches.iter().map(pair), width.unwrap_or(ANY_WIDTH_M))
    };
    let differences: Vec<f64> = matches.iter().map(|one| one.difference_m).collect();
    Ok(Some(ResidualTables {
        by_depth_m: by(&|_, reference_z_m| -reference_z_m, None),
        by_across_m: by(&|index, _| across_m(products, points[index]), None),
        by_heading_deg: by(
            &|index, _| heading_deg(products, points[index]),
            Some(SECTOR_DEG),
        ),
        histogram: Histogram::of(&differences),
    }))
}

/// Distance of a point from where the boat was, to starboard.
fn across_m(products: &Products, point: &CloudPoint) -> f64 {
    let boat = products.navigation.pings.get(point.ping as usize);
    let across = boat.and_then(|boat| {
        let [east, north] = boat.starboard()?;
        Some((point.east_m - boat.east_m) * east + (point.north_m - boat.north_m) * north)
    });
    across.unwrap_or(f64::NAN)
}

fn heading_deg(products: &Products, point: &CloudPoint) -> f64 {
    let boat = products.navigation.pings.get(point.ping as usize);
    boat.map_or(f64::NAN, |boat| {
        boat.heading_rad.to_degrees().rem_euclid(360.0)
    })
}
