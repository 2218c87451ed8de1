//! The tables of pings and points, and the cloud for other programs.

use super::record::{Coordinates, FileContent};
use super::results::Results;
use crate::cloud::CloudPoint;
use crate::export::{self, ExportError};
use std::path::Path;

fn in_words(error: ExportError) -> String {
    error.to_string()
}

/// Writes `first_returns.csv`.
pub fn first_returns(results: &Results<'_>, path: &Path) -> Result<FileContent, String> {
    let (survey, products) = (results.survey, results.products);
    export::first_returns_csv(
        path,
        survey,
        &products.navigation,
        &products.returns,
        &products.calibration,
        &products.left_out,
    )
    .map(|pings| FileContent::new(Coordinates::Degrees, pings))
    .map_err(in_words)
}

/// Writes `cloud.csv`.
pub fn table(results: &Results<'_>, path: &Path) -> Result<FileContent, String> {
    let (survey, products) = (results.survey, results.products);
    let (navigation, cloud) = (&products.navigation, &products.cloud);
    export::cloud_csv(path, survey, navigation, cloud, &products.kept)
        .map(|points| FileContent::new(Coordinates::Degrees, points))
        .map_err(in_words)
}

/// Writes the kept points to `cloud.laz`, in the system of the map.
pub fn laz(results: &Results<'_>, path: &Path) -> Result<FileContent, String> {
    let (survey, products) = (results.survey, results.products);
    let crs = &results.plane.map.crs;
    let points = export::cloud_laz(
        path,
        survey,
        &products.returns,
        crs,
        |point| place(results, point),
        &products.cloud,
        &products.kept,
    );
    Ok(FileContent {
        detail: match survey.start_unix_s {
            Some(_) => ", time adjusted standard GPS time",
            None => ", time seconds after the log's beginning",
        },
        ..FileContent::new(Coordinates::System(crs.clone()), points.map_err(in_words)?)
    })
}

/// Writes the kept points to `cloud.ply`, in the survey's own plane.
pub fn ply(results: &Results<'_>, path: &Path) -> Result<FileContent, String> {
    let products = results.products;
    let origin = Coordinates::Local(results.survey.track.frame.origin());
    export::cloud_ply(path, &products.cloud, &products.kept)
        .map(|points| FileContent::new(origin, points))
        .map_err(in_words)
}

/// Writes the kept points to `cloud.xyz`, in the system of the map.
pub fn xyz(results: &Results<'_>, path: &Path) -> Result<FileContent, String> {
    let products = results.products;
    let crs = &results.plane.map.crs;
    let decimals = if crs.is_degrees() { 9 } else { 3 };
    let place = |point: &CloudPoint| place(results, point);
    export::cloud_xyz(path, decimals, place, &products.cloud, &products.kept)
        .map(|points| FileContent::new(Coordinates::System(crs.clone()), points))
        .map_err(in_words)
}

/// The place of a point in the system of the map.
fn place(results: &Results<'_>, point: &CloudPoint) -> [f64; 2] {
    let navigation = &results.products.navigation;
    let at = navigation.to_lon_lat(&results.survey.track, point.east_m, point.north_m);
    results.plane.map.crs.place(at)
}
