//! `targets.*`: the objects that an analyst accepted or added, in every run of a survey with a review.

use super::detections::{content, in_degrees, known_rows, placed_in};
use super::manifest::FileContent;
use super::objects::ObjectRows;
use super::results::Results;
use crate::products::export::{self, Summary};
use crate::products::outputs::OutputError;
use std::path::Path;

/// The decided boxes of all logs, and the objects that they show; none without a review.
fn decided<'a>(results: &'a Results<'_>) -> Result<ObjectRows<'a>, OutputError> {
    let mut all = known_rows(results)?.unwrap_or_default();
    all.retain_decided();
    Ok(all)
}

/// Writes `targets.csv`: a line for each box.
pub fn csv(results: &Results<'_>, path: &Path) -> Result<FileContent, OutputError> {
    let rows = decided(results)?.rows;
    let summary = Summary {
        count: rows.len(),
        ..placed_in(&rows)
    };
    let logs = results.object_logs();
    content(summary, export::objects_csv(path, &logs, &rows))
}

/// Writes `targets.geojson`: a point for each box.
pub fn geojson(results: &Results<'_>, path: &Path) -> Result<FileContent, OutputError> {
    let rows = decided(results)?.rows;
    let logs = results.object_logs();
    let written = export::objects_geojson(path, &logs, &rows);
    content(placed_in(&rows), written)
}

/// Writes `targets.gpx`: a waypoint for each object.
pub fn gpx(results: &Results<'_>, path: &Path) -> Result<FileContent, OutputError> {
    let points = decided(results)?.points(results.order.logs);
    in_degrees(export::objects_gpx(path, &points))
}

/// Writes `targets.kml`: a placemark for each object.
pub fn kml(results: &Results<'_>, path: &Path) -> Result<FileContent, OutputError> {
    let points = decided(results)?.points(results.order.logs);
    in_degrees(export::objects_kml(path, &results.name(), &points))
}
