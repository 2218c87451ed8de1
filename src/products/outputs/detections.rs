//! What a search for objects proposes: `detections.*` and `chips`, with a run or into a folder that may hold the files of one.

use super::content::{Coordinates, FileContent};
use super::objects::all_rows;
use super::results::Results;
use crate::detection::objects::SurveyObject;
use crate::detection::{Detection, Raster};
use crate::products::export::{self, ChipLog, ExportError, ObjectRow, Summary};
use crate::products::outputs::OutputError;
use std::path::Path;

/// What a search proposes.
#[derive(Clone, Debug, PartialEq)]
pub struct Proposed {
    /// The boxes, log by log, in order of the pings.
    pub boxes: Vec<Detection>,
    /// Objects that they are sightings of: one that several lines or logs saw has as many boxes.
    pub objects: usize,
    /// Boxes whose place in the world cannot be known, and so neither whose object they show.
    pub unplaced: usize,
}

impl Proposed {
    /// What the search of a run found; `None` where none searched.
    pub(super) fn of(results: &Results<'_>) -> Result<Option<Self>, OutputError> {
        let Some((list, found)) = results.found_objects()?.zip(results.found()?) else {
            return Ok(None);
        };
        Ok(Some(Self {
            boxes: found.concat(),
            objects: list.objects().len(),
            unplaced: list
                .boxes()
                .iter()
                .filter(|one| one.object.is_none())
                .count(),
        }))
    }
}

/// Writes `detections.csv`.
pub(super) fn csv(results: &Results<'_>, path: &Path) -> Result<FileContent, OutputError> {
    let (list, shapes) = results.shaped_found()?;
    objects_csv(results, path, &all_rows(list, shapes, results.order.logs))
}

/// Writes `detections.geojson`.
pub(super) fn geojson(results: &Results<'_>, path: &Path) -> Result<FileContent, OutputError> {
    let (list, shapes) = results.shaped_found()?;
    objects_geojson(results, path, &all_rows(list, shapes, results.order.logs))
}

/// Writes `detections.gpx`.
pub(super) fn gpx(results: &Results<'_>, path: &Path) -> Result<FileContent, OutputError> {
    let (list, _) = results.shaped_found()?;
    let objects: Vec<&SurveyObject> = list.objects().iter().collect();
    in_degrees(export::objects_gpx(path, &objects))
}

/// Writes `shapes.ply`.
pub(super) fn shapes(results: &Results<'_>, path: &Path) -> Result<FileContent, OutputError> {
    let (list, shapes) = results.shaped_found()?;
    let summary = export::shapes_ply(path, &all_rows(list, shapes, results.order.logs))?;
    let origin = Coordinates::Local(results.survey.track.frame.origin());
    Ok(FileContent::new(origin, summary))
}

/// Writes `chips`, a folder with a picture of each box.
pub(super) fn chips(results: &Results<'_>, path: &Path) -> Result<FileContent, OutputError> {
    let (Some(model), Some(found)) = (results.order.search, results.found()?) else {
        return Err("nothing searched for objects".into());
    };
    let logs = results.order.logs.iter().zip(found);
    let logs = logs.map(|(log, found)| ChipLog {
        survey: &log.survey,
        raster: Raster::new(&log.survey, &log.products.navigation, model.pixel_m()),
        found,
    });
    let logs: Vec<ChipLog<'_>> = logs.collect();
    let folder = path.parent().unwrap_or(path);
    export::chips(folder, model.names(), &logs, results.progress)?;
    Ok(FileContent::new(Coordinates::None, Summary::default()))
}

pub(super) fn in_degrees(
    written: Result<Summary, ExportError>,
) -> Result<FileContent, OutputError> {
    let summary = written.map_err(OutputError::from)?;
    Ok(FileContent::new(Coordinates::Degrees, summary))
}

/// Writes boxes as a table.
pub(super) fn objects_csv(
    results: &Results<'_>,
    path: &Path,
    rows: &[ObjectRow<'_>],
) -> Result<FileContent, OutputError> {
    let summary = Summary {
        count: rows.len(),
        ..placed_in(rows)
    };
    export::objects_csv(path, &results.object_logs(), rows)?;
    Ok(FileContent::new(Coordinates::Degrees, summary))
}

/// Writes boxes as points.
pub(super) fn objects_geojson(
    results: &Results<'_>,
    path: &Path,
    rows: &[ObjectRow<'_>],
) -> Result<FileContent, OutputError> {
    export::objects_geojson(path, &results.object_logs(), rows)?;
    Ok(FileContent::new(Coordinates::Degrees, placed_in(rows)))
}

/// The places of the boxes, counted.
fn placed_in(rows: &[ObjectRow<'_>]) -> Summary {
    let mut summary = Summary::default();
    for target in rows.iter().filter_map(|row| row.of.target.as_ref()) {
        let at = target.position;
        summary.add([at.lon_deg, at.lat_deg], f64::NAN);
    }
    summary
}
