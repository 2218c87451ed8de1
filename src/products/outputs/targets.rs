//! `targets.*`: the objects that an analyst accepted or drew, in every run of a survey with a
//! review.

use super::content::{FileContent, FileResult};
use super::detections::box_table;
use super::objects::{listed, target_boxes};
use super::results::Results;
use crate::export;
use crate::outputs::OutputError;
use bathyscope_objects::objects::ListedObject;
use std::path::Path;

/// Writes `targets.csv`: a row for each box.
pub(super) fn csv(results: &Results<'_>, path: &Path) -> FileResult {
    let (list, shapes) = results.shaped_objects()?;
    box_table(results, path, &target_boxes(list), shapes)
}

/// Writes `targets.geojson`: a point for each object.
pub(super) fn geojson(results: &Results<'_>, path: &Path) -> FileResult {
    Ok(FileContent::in_degrees(export::objects_geojson(path, &targets(results)?)?))
}

/// Writes `targets.gpx`: a waypoint for each object.
pub(super) fn gpx(results: &Results<'_>, path: &Path) -> FileResult {
    Ok(FileContent::in_degrees(export::objects_gpx(path, &targets(results)?)?))
}

/// Writes `targets.kml`: a placemark for each object.
pub(super) fn kml(results: &Results<'_>, path: &Path) -> FileResult {
    let places = export::objects_kml(path, &results.name(), &targets(results)?)?;
    Ok(FileContent::in_degrees(places))
}

/// The targets; none where nobody looked.
pub(super) fn targets<'a>(results: &'a Results<'_>) -> Result<Vec<ListedObject<'a>>, OutputError> {
    if results.objects()?.is_none() {
        return Ok(Vec::new());
    }
    let all = results.shaped_objects()?;
    Ok(listed(all.0.targets(), all, results.order.logs, &results.names))
}
