//! `targets.*`: the objects that an analyst accepted or drew, in every run of a survey with a review.

use super::content::FileContent;
use super::detections::{in_degrees, objects_csv, objects_geojson};
use super::objects::target_rows;
use super::results::Results;
use crate::detection::objects::SurveyObject;
use crate::products::export;
use crate::products::outputs::OutputError;
use std::path::Path;

/// Writes `targets.csv`: a line for each box.
pub(super) fn csv(results: &Results<'_>, path: &Path) -> Result<FileContent, OutputError> {
    let (list, shapes) = results.shaped_objects()?;
    objects_csv(
        results,
        path,
        &target_rows(list, shapes, results.order.logs),
    )
}

/// Writes `targets.geojson`: a point for each box.
pub(super) fn geojson(results: &Results<'_>, path: &Path) -> Result<FileContent, OutputError> {
    let (list, shapes) = results.shaped_objects()?;
    objects_geojson(
        results,
        path,
        &target_rows(list, shapes, results.order.logs),
    )
}

/// Writes `targets.gpx`: a waypoint for each object.
pub(super) fn gpx(results: &Results<'_>, path: &Path) -> Result<FileContent, OutputError> {
    in_degrees(export::objects_gpx(path, &targets(results)?))
}

/// Writes `targets.kml`: a placemark for each object.
pub(super) fn kml(results: &Results<'_>, path: &Path) -> Result<FileContent, OutputError> {
    in_degrees(export::objects_kml(
        path,
        &results.name(),
        &targets(results)?,
    ))
}

fn targets<'a>(results: &'a Results<'_>) -> Result<Vec<&'a SurveyObject>, OutputError> {
    let objects = results.objects()?;
    Ok(objects.map_or_else(Vec::new, |list| list.targets().collect()))
}
