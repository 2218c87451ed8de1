//! Computes the residuals of each choice of geometry and calibration: the same picks, compared with
//! the same soundings.

use super::residuals::kept_of;
use crate::pipeline::Products;
use bathyscope_bottom::bathymetry::compare::{Matching, ReferencePoints};
use bathyscope_bottom::calibration::{OffsetMode, PpdReach, ScaleMode};
use bathyscope_bottom::cloud::{
    self, CloudPoint, CloudSettings, Geometry, PickTraits, PointSource, Residuals,
};
use bathyscope_log::support::progress::{Cancelled, Progress};
use bathyscope_log::survey::Survey;
use serde::Serialize;
use std::sync::Arc;

/// Residuals of side-scan points from soundings, with one geometry and one calibration.
#[derive(Serialize)]
pub struct GeometryChoice {
    geometry: Geometry,
    calibration: &'static str,
    /// True if these are the settings of the products.
    in_force: bool,
    /// Number of points without a sounding near them.
    unmatched: usize,
    #[serde(flatten)]
    residuals: Residuals,
}

const GEOMETRIES: [Geometry; 4] =
    [Geometry::Published, Geometry::SelfConsistent, Geometry::Nadir, Geometry::Slope];

const CALIBRATIONS: [(&str, ScaleMode, PpdReach, OffsetMode); 4] = [
    ("flat_spot, constant", ScaleMode::FlatSpot, PpdReach::Constant, OffsetMode::None),
    ("flat_spot, factor", ScaleMode::FlatSpot, PpdReach::Factor, OffsetMode::None),
    ("header", ScaleMode::Header, PpdReach::Factor, OffsetMode::None),
    ("header less offset", ScaleMode::Header, PpdReach::Factor, OffsetMode::Fit),
];

/// Returns the residuals of each combination that gives points over the soundings; a flat spot that
/// gives no scale has none. Only the calibration, the cloud and the outlier filter are run again,
/// each where its settings differ.
pub fn choices(
    survey: &Survey,
    products: &Products,
    progress: &Progress,
) -> Result<Vec<GeometryChoice>, Cancelled> {
    let soundings = kept_of(products, &[PointSource::DownScan]);
    let max_gap_m = products.settings.surface.max_gap_m;
    let reference = ReferencePoints::new(
        soundings.iter().map(|point| point.place()),
        Matching::Surface { max_gap_m },
    );
    let (judged, counted) = (products.judged_returns(survey), products.counted_returns());
    // A swath does not depend on these choices.
    let survey = &Survey { swath: Arc::default(), ..survey.clone() };
    let traits = PickTraits::new(survey, &products.navigation, &counted);
    let mut found = Vec::new();
    for (name, mode, ppd, offset) in CALIBRATIONS {
        let mut settings = products.settings.calibration.clone();
        settings.mode = mode;
        settings.ppd = ppd;
        settings.offset = match (offset, settings.offset) {
            // The offset mode in force, if it fits an offset.
            (OffsetMode::Fit, in_force @ (OffsetMode::Auto | OffsetMode::Fit)) => in_force,
            _ => offset,
        };
        let made = products.calibrated(survey, &judged, &settings, progress)?;
        if made.mode != mode {
            continue;
        }
        for geometry in GEOMETRIES {
            let in_force = settings == products.settings.calibration
                && geometry == products.settings.cloud.geometry;
            let cloud = if in_force {
                products.cloud.clone()
            } else {
                let how = CloudSettings { geometry, ..products.settings.cloud.clone() };
                let counted = (&*counted, &traits);
                Arc::new(products.placed(survey, counted, &made, &how, progress)?)
            };
            let points = cloud.points.iter().enumerate();
            let points: Vec<(usize, &CloudPoint)> =
                points.filter(|(_, point)| point.source.is_side_scan()).collect();
            let matches = reference.matches(&points, |(_, point)| point.place(), progress)?;
            // With a single track, some geometries have no point over the soundings; they are left
            // out before the points are classified.
            if matches.is_empty() {
                continue;
            }
            let classes = if in_force {
                products.classes.clone()
            } else {
                let rules = products.settings.class_rules();
                Arc::new(cloud::classify(&cloud, &rules, progress)?)
            };
            let is_kept = |(index, _): &(usize, &CloudPoint)| classes[*index].is_kept();
            let kept = points.iter().filter(|point| is_kept(point)).count();
            let matches = matches.iter().filter(|matched| is_kept(&points[matched.measured]));
            let mut differences: Vec<f64> = matches.map(|matched| matched.difference_m).collect();
            let unmatched = kept - differences.len();
            found.extend(Residuals::of(&mut differences).map(|residuals| GeometryChoice {
                geometry,
                calibration: name,
                in_force,
                unmatched,
                residuals,
            }));
        }
    }
    Ok(found)
}
