//! Writes the tables of pings and points, and the cloud for other programs.

use super::content::{FileContent, FileResult};
use super::results::Results;
use crate::export::{self, LasPacking, LogPoints};
use bathyscope_bottom::cloud::CloudPoint;
use std::path::Path;

/// Writes `first_returns.csv`.
pub(super) fn first_returns(results: &Results<'_>, path: &Path) -> FileResult {
    let pings = export::first_returns_csv(path, &results.log_points())?;
    Ok(FileContent::in_degrees(pings))
}

/// Writes `cloud.csv`.
pub(super) fn table(results: &Results<'_>, path: &Path) -> FileResult {
    let points = export::cloud_csv(path, &results.log_points())?;
    Ok(FileContent::in_degrees(points))
}

/// Writes all points to `cloud.copc.laz`, in the coordinate system of the map.
pub(super) fn copc(results: &Results<'_>, path: &Path) -> FileResult {
    las_file(results, path, LasPacking::Copc)
}

/// Writes all points to `cloud.las`, in the coordinate system of the map.
pub(super) fn las(results: &Results<'_>, path: &Path) -> FileResult {
    las_file(results, path, LasPacking::Plain)
}

fn las_file(results: &Results<'_>, path: &Path, packing: LasPacking) -> FileResult {
    let crs = &results.map.crs;
    let place = |log: &LogPoints<'_>, point: &CloudPoint| place(results, log, point);
    let points = export::cloud_las(path, packing, crs, place, &results.log_points())?;
    Ok(FileContent {
        detail: if results.start_unix_s().is_some() {
            ", time adjusted standard GPS time"
        } else {
            ", time seconds after the log's beginning"
        },
        ..FileContent::in_system(crs, points)
    })
}

/// Writes all points to `cloud.ply`, in the local coordinate frame of the survey.
pub(super) fn ply(results: &Results<'_>, path: &Path) -> FileResult {
    let origin = results.survey.track.frame.origin();
    let points = export::cloud_ply(path, &results.log_points())?;
    Ok(FileContent::in_metres(origin, points))
}

/// Writes the points of the bottom to `cloud.xyz`, in the coordinate system of the map.
pub(super) fn xyz(results: &Results<'_>, path: &Path) -> FileResult {
    let crs = &results.map.crs;
    let decimals = if crs.is_degrees() { 9 } else { 3 };
    let place = |log: &LogPoints<'_>, point: &CloudPoint| place(results, log, point);
    let points = export::cloud_xyz(path, decimals, place, &results.log_points())?;
    Ok(FileContent::in_system(crs, points))
}

/// Returns the x and y of a point of a log in the coordinate system of the map.
fn place(results: &Results<'_>, log: &LogPoints<'_>, point: &CloudPoint) -> [f64; 2] {
    let track = &log.survey.track;
    let at = (log.navigation).to_lon_lat(track, point.east_m, point.north_m);
    results.map.crs.place(at)
}
