//! What each choice of geometry and calibration costs: the same picks, compared with the same soundings.

use super::residuals::kept_of;
use crate::bottom::bathymetry::compare::{Matching, ReferencePoints};
use crate::bottom::cloud::{Geometry, PointSource, Residuals};
use crate::pipeline::{Products, Settings, run};
use crate::sonar::calibration::{OffsetMode, PpdReach, ScaleMode};
use crate::support::progress::{Cancelled, Progress};
use crate::survey::Survey;
use serde::Serialize;

/// Side-scan against soundings with one geometry and one calibration.
#[derive(Serialize)]
pub(crate) struct GeometryChoice {
    geometry: Geometry,
    calibration: &'static str,
    /// Whether these are the settings of the products.
    in_force: bool,
    /// Points without a sounding near them.
    unmatched: usize,
    #[serde(flatten)]
    residuals: Residuals,
}

const GEOMETRIES: [Geometry; 4] = [
    Geometry::Published,
    Geometry::SelfConsistent,
    Geometry::Nadir,
    Geometry::Slope,
];

const CALIBRATIONS: [(&str, ScaleMode, PpdReach, OffsetMode); 4] = [
    (
        "flat_spot, constant",
        ScaleMode::FlatSpot,
        PpdReach::Constant,
        OffsetMode::None,
    ),
    (
        "flat_spot, factor",
        ScaleMode::FlatSpot,
        PpdReach::Factor,
        OffsetMode::None,
    ),
    (
        "header",
        ScaleMode::Header,
        PpdReach::Factor,
        OffsetMode::None,
    ),
    (
        "header less offset",
        ScaleMode::Header,
        PpdReach::Factor,
        OffsetMode::Fit,
    ),
];

/// One line for each combination that gives points over the soundings; a flat spot that gives no scale has none. The outlier filter
/// runs for each.
pub(crate) fn choices(
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
    let mut found = Vec::new();
    for (calibration, mode, ppd, offset) in CALIBRATIONS {
        for geometry in GEOMETRIES {
            let mut settings = Settings::clone(&products.settings);
            settings.calibration.mode = mode;
            settings.calibration.ppd = ppd;
            settings.calibration.offset = match (offset, products.settings.calibration.offset) {
                // Whichever way to it is in force.
                (OffsetMode::Fit, in_force @ (OffsetMode::Auto | OffsetMode::Fit)) => in_force,
                _ => offset,
            };
            settings.cloud.geometry = geometry;
            let made = run(survey, &settings, Some(products), progress, |_| ())?;
            if made.calibration.mode != mode {
                continue;
            }
            let points = kept_of(&made, &[PointSource::Port, PointSource::Starboard]);
            let matches = reference.matches(&points, |point| point.place(), progress)?;
            let mut differences: Vec<f64> = matches.iter().map(|one| one.difference_m).collect();
            found.extend(
                Residuals::of(&mut differences).map(|residuals| GeometryChoice {
                    geometry,
                    calibration,
                    in_force: settings == *products.settings,
                    unmatched: points.len() - matches.len(),
                    residuals,
                }),
            );
        }
    }
    Ok(found)
}
