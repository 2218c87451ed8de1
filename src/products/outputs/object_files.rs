//! Writes files of objects. Those of a search, `detections.*`, `objects.csv` and `chips`, are
//! written with a run or into a folder that may hold the files of a run; `targets.*`, the objects
//! that an analyst accepted or drew, are written in every run of a survey with a review.

use super::content::{FileContent, FileResult};
use super::order::{When, object_logs};
use super::results::{NOT_SEARCHED, Results, ShapedObjects};
use crate::Error;
use crate::export::{self, ChipLog};
use crate::pipeline::ProcessedLog;
use bathyscope_log::support::geo::LonLat;
use bathyscope_objects::objects::{ListedObject, Object, ObjectBox, ObjectList};
use bathyscope_objects::targets::Target;
use bathyscope_objects::{Detection, Raster};
use std::path::Path;

/// Boxes that a search proposes, and the number of their objects.
#[derive(Clone, Debug, PartialEq)]
pub struct Proposed {
    /// The boxes, log by log, in the order of the pings.
    pub boxes: Vec<Detection>,
    /// Number of objects that the boxes show: an object that several lines or logs saw has several
    /// boxes.
    pub objects: usize,
    /// Number of boxes whose position, and therefore whose object, is not known.
    pub unplaced: usize,
}

impl Proposed {
    /// Returns the result of the search of a run.
    pub(super) fn of(results: &Results<'_>) -> Result<Self, Error> {
        let (list, _) = results.shaped_found()?;
        Ok(Self {
            boxes: results.found()?.concat(),
            objects: list.objects.len(),
            unplaced: list.boxes.iter().filter(|object_box| object_box.object.is_none()).count(),
        })
    }
}

/// Returns the objects that a search found.
fn objects<'a>(results: &'a Results<'_>) -> Result<Vec<ListedObject<'a>>, Error> {
    let found = results.shaped_found()?;
    Ok(listed(found.0.objects.iter(), found, results.order.logs, &results.names))
}

/// Writes `detections.csv`: a row for each box.
pub(super) fn detections_csv(results: &Results<'_>, path: &Path) -> FileResult {
    let (list, shapes) = results.shaped_found()?;
    let boxes: Vec<&ObjectBox> = list.boxes.iter().collect();
    let logs = object_logs(results.order.logs, &results.names);
    let boxes = export::box_table(path, &logs, &boxes, shapes)?;
    Ok(FileContent::in_degrees(boxes))
}

/// Writes `detections.geojson`: a point for each object.
pub(super) fn detections_geojson(results: &Results<'_>, path: &Path) -> FileResult {
    Ok(FileContent::in_degrees(export::objects_geojson(path, &objects(results)?)?))
}

/// Writes `detections.gpx`: a waypoint for each object.
pub(super) fn detections_gpx(results: &Results<'_>, path: &Path) -> FileResult {
    Ok(FileContent::in_degrees(export::objects_gpx(path, &objects(results)?)?))
}

/// Writes `objects.csv`: a row for each object of the review, or of the search where there is no
/// review.
pub(super) fn all_objects(results: &Results<'_>, path: &Path) -> FileResult {
    let all = results.shaped_objects()?;
    let objects = listed(all.0.objects.iter(), all, results.order.logs, &results.names);
    Ok(FileContent::in_degrees(export::object_table(path, &objects)?))
}

/// Writes `shapes.ply`.
pub(super) fn shapes(results: &Results<'_>, path: &Path) -> FileResult {
    let summary = export::shapes_ply(path, &objects(results)?)?;
    let origin = results.survey.track.frame.origin();
    Ok(FileContent::in_metres(origin, summary))
}

/// Writes `chips`, a folder with a picture of each box.
pub(super) fn chips(results: &Results<'_>, path: &Path) -> FileResult {
    let found = results.found()?;
    let model = results.order.search.ok_or(NOT_SEARCHED)?;
    let logs = results.order.logs.iter().zip(found);
    let logs = logs.map(|(log, found)| ChipLog {
        survey: &log.survey,
        raster: Raster::new(&log.survey, &log.products.navigation, model.pixel_m),
        found,
    });
    let logs: Vec<ChipLog<'_>> = logs.collect();
    let folder = path.parent().unwrap_or(path);
    export::chips(folder, model.names(), &logs, results.progress)?;
    Ok(FileContent::count(0))
}

/// Writes `targets.csv`: a row for each box.
pub(super) fn targets_csv(results: &Results<'_>, path: &Path) -> FileResult {
    let (list, shapes) = results.shaped_objects()?;
    let logs = object_logs(results.order.logs, &results.names);
    let boxes = export::box_table(path, &logs, &target_boxes(list), shapes)?;
    Ok(FileContent::in_degrees(boxes))
}

/// Writes `targets.geojson`: a point for each object.
pub(super) fn targets_geojson(results: &Results<'_>, path: &Path) -> FileResult {
    Ok(FileContent::in_degrees(export::objects_geojson(path, &targets(results)?)?))
}

/// Writes `targets.gpx`: a waypoint for each object.
pub(super) fn targets_gpx(results: &Results<'_>, path: &Path) -> FileResult {
    Ok(FileContent::in_degrees(export::objects_gpx(path, &targets(results)?)?))
}

/// Writes `targets.kml`: a placemark for each object.
pub(super) fn targets_kml(results: &Results<'_>, path: &Path) -> FileResult {
    let places = export::objects_kml(path, &results.name(), &targets(results)?)?;
    Ok(FileContent::in_degrees(places))
}

/// Returns the targets; none without a search or a review.
pub(super) fn targets<'a>(results: &'a Results<'_>) -> Result<Vec<ListedObject<'a>>, Error> {
    if !results.order.asks_for(When::Listed) {
        return Ok(Vec::new());
    }
    let all = results.shaped_objects()?;
    Ok(listed(all.0.targets(), all, results.order.logs, &results.names))
}

/// Returns objects as rows of tables, with their shapes and outlines.
pub(super) fn listed<'a>(
    objects: impl Iterator<Item = &'a Object>,
    (list, shapes): &'a ShapedObjects,
    logs: &[ProcessedLog],
    names: &'a [String],
) -> Vec<ListedObject<'a>> {
    let outline = |object: &Object| {
        let best = list.members(object).nth(object.best)?;
        outline(logs.get(best.log)?, best.target.as_ref()?)
    };
    let listed = objects.map(|object| ListedObject {
        object,
        shape: shapes.get(&object.number),
        outline: outline(object),
        log_names: if names.len() > 1 { names } else { &[] },
    });
    listed.collect()
}

/// Returns the boxes of targets.
pub(super) fn target_boxes(list: &ObjectList) -> Vec<&ObjectBox> {
    list.boxes.iter().filter(|object_box| list.is_target(object_box)).collect()
}

/// Returns the outline of a target in WGS84; `None` where its size is not known.
fn outline(of: &ProcessedLog, target: &Target) -> Option<[LonLat; 4]> {
    let is_known = target.length_m.is_finite() && target.width_m.is_finite();
    let (navigation, track) = (&of.products.navigation, &of.survey.track);
    let place = |[east_m, north_m]: [f64; 2]| navigation.to_lon_lat(track, east_m, north_m);
    is_known.then(|| target.corners().map(place))
}
