//! `targets.*`: the objects that an analyst accepted or drew, in every run of a survey with a
//! review.

use super::content::{FileContent, FileResult};
use super::detections::{objects_csv, objects_geojson};
use super::objects::target_rows;
use super::results::Results;
use crate::export::{self, ObjectRow};
use crate::outputs::OutputError;
use bathyscope_objects::objects::SurveyObject;
use std::path::Path;

/// The sightings of targets.
pub(super) fn rows<'a>(results: &'a Results<'_>) -> Result<Vec<ObjectRow<'a>>, OutputError> {
    let (list, shapes) = results.shaped_objects()?;
    Ok(target_rows(list, shapes, results.order.logs))
}

/// Writes `targets.csv`: a line for each box.
pub(super) fn csv(results: &Results<'_>, path: &Path) -> FileResult {
    objects_csv(results, path, &rows(results)?)
}

/// Writes `targets.geojson`: a point for each box.
pub(super) fn geojson(results: &Results<'_>, path: &Path) -> FileResult {
    objects_geojson(results, path, &rows(results)?)
}

/// Writes `targets.gpx`: a waypoint for each object.
pub(super) fn gpx(results: &Results<'_>, path: &Path) -> FileResult {
    let waypoints = export::objects_gpx(path, &targets(results)?)?;
    Ok(FileContent::in_degrees(waypoints))
}

/// Writes `targets.kml`: a placemark for each object.
pub(super) fn kml(results: &Results<'_>, path: &Path) -> FileResult {
    let places = export::objects_kml(path, &results.name(), &targets(results)?)?;
    Ok(FileContent::in_degrees(places))
}

fn targets<'a>(results: &'a Results<'_>) -> Result<Vec<&'a SurveyObject>, OutputError> {
    let objects = results.objects()?;
    Ok(objects.map_or_else(Vec::new, |list| list.targets().collect()))
}
