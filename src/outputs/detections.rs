//! What a search for objects proposes: `detections.*` and `chips`, with a run or into a folder that may hold the files of one.

use super::record::{Coordinates, FileContent};
use super::registry::{When, row_of};
use super::results::Results;
use super::run_folder::RunFolder;
use super::write::{Order, write_rows};
use crate::detection::targets::{GroupSettings, Sighting, group};
use crate::detection::{
    Detection, DetectorSettings, Mark, Model, Picture, Raster, Scored, find_in_picture,
    review::State,
};
use crate::export::{self, ExportError, ObjectRow, Summary};
use crate::pipeline::{Derived, Placing, ProcessedLog, Products};
use crate::progress::Progress;
use crate::survey::Survey;
use std::path::Path;

/// What a search proposes.
#[derive(Clone, Debug, PartialEq)]
pub struct Proposed {
    /// The boxes, in order of the pings.
    pub boxes: Vec<Detection>,
    /// Objects that they are sightings of: one that several lines saw has as many boxes.
    pub objects: usize,
    /// Boxes whose place in the world cannot be known, and so neither whose object they show.
    pub unplaced: usize,
}

impl Proposed {
    /// What the search of a run found; `None` where none searched.
    pub(super) fn of(results: &Results<'_>) -> Result<Option<Self>, String> {
        let Some((rows, boxes)) = rows(results)?.zip(results.found()?) else {
            return Ok(None);
        };
        Ok(Some(Self {
            boxes: boxes.to_vec(),
            // Objects are numbered from 1 on.
            objects: rows.iter().filter_map(|row| row.object).max().unwrap_or(0),
            unplaced: rows.iter().filter(|row| row.object.is_none()).count(),
        }))
    }
}

/// Searches a survey and writes what is found, without records.
///
/// # Errors
/// A sentence that names the file, or says that the work was cancelled; the folder is then as it was.
pub fn write_detected(
    log: &ProcessedLog,
    model: &Model,
    run: RunFolder,
    progress: &Progress,
) -> Result<Proposed, String> {
    let order = Order {
        logs: std::slice::from_ref(log),
        derived: &Derived::default(),
        requested: &[],
        reference: None,
        search: Some(model),
        review: None,
    };
    let mut results = Results::new(&order, progress)?;
    let searched = |when| when == When::Searched;
    write_rows(&mut results, &run.path(), searched, &mut |_| ())?;
    let found = Proposed::of(&results)?;
    run.commit_group(is_of_search)?;
    found.ok_or_else(|| "nothing searched for objects".to_owned())
}

/// The same for a picture of another program, by its name in the table.
///
/// # Errors
/// As [`write_detected`].
pub fn write_detected_in_picture(
    name: &str,
    picture: &Picture,
    model: &Model,
    settings: &DetectorSettings,
    run: RunFolder,
    progress: &Progress,
) -> Result<Vec<Scored>, String> {
    let found =
        find_in_picture(picture, model, settings, progress).map_err(|error| error.to_string())?;
    let folder = run.path();
    export::picture_chips(&folder, picture, model.names(), &found)
        .and_then(|_| {
            let table = folder.join("detections.csv");
            export::picture_boxes_csv(&table, name, model.names(), &found)
        })
        .map_err(|error| error.to_string())?;
    run.commit_group(is_of_search)?;
    Ok(found)
}

fn is_of_search(name: &str) -> bool {
    row_of(name).is_some_and(|row| row.when == When::Searched)
}

/// Whether the middle of a box lies in a stretch that is left out.
pub(super) fn is_left_out(products: &Products, mark: &Mark) -> bool {
    let middle = usize::midpoint(mark.pings.start, mark.pings.end);
    products.left_out.ping(middle).is_some()
}

/// Writes `detections.csv`.
pub fn csv(results: &Results<'_>, path: &Path) -> Result<FileContent, String> {
    let rows = rows(results)?.unwrap_or_default();
    let placed = placed_in(&rows);
    let summary = Summary {
        count: rows.len(),
        ..placed
    };
    content(summary, export::objects_csv(path, results.survey, &rows))
}

/// Writes `detections.geojson`.
pub fn geojson(results: &Results<'_>, path: &Path) -> Result<FileContent, String> {
    let rows = rows(results)?.unwrap_or_default();
    content(placed_in(&rows), export::objects_geojson(path, &rows))
}

/// Writes `detections.gpx`.
pub fn gpx(results: &Results<'_>, path: &Path) -> Result<FileContent, String> {
    let rows = rows(results)?.unwrap_or_default();
    content(placed_in(&rows), export::objects_gpx(path, &rows))
}

/// Writes `chips`, a folder with a picture of each box.
pub fn chips(results: &Results<'_>, path: &Path) -> Result<FileContent, String> {
    let (survey, products, progress) = (results.survey, results.products, results.progress);
    let (Some(model), Some(found)) = (results.order.search, results.found()?) else {
        return Err("nothing searched for objects".to_owned());
    };
    let raster = Raster::new(survey, &products.navigation, model.pixel_m());
    let folder = path.parent().unwrap_or(path);
    export::chips(folder, survey, &raster, model.names(), found, progress)
        .map_err(|error| error.to_string())?;
    Ok(FileContent::new(Coordinates::None, Summary::default()))
}

fn content(summary: Summary, written: Result<(), ExportError>) -> Result<FileContent, String> {
    written
        .map(|()| FileContent::new(Coordinates::Degrees, summary))
        .map_err(|error| error.to_string())
}

/// The places of the boxes, counted.
fn placed_in(rows: &[ObjectRow<'_>]) -> Summary {
    let mut summary = Summary::default();
    for target in rows.iter().filter_map(|row| row.target.as_ref()) {
        let at = target.position;
        summary.add([at.lon_deg, at.lat_deg], f64::NAN);
    }
    summary
}

/// The rows of what a model found; `None` where none searched.
fn rows<'a>(results: &'a Results<'_>) -> Result<Option<Vec<ObjectRow<'a>>>, String> {
    let found = results.order.search.zip(results.found()?);
    Ok(found.map(|(model, found)| {
        proposed_rows(results.survey, results.products, model.names(), found)
    }))
}

/// The rows of the tables of what was found; boxes of the same object share its number.
pub fn proposed_rows<'a>(
    survey: &Survey,
    products: &Products,
    names: &'a [String],
    found: &'a [Detection],
) -> Vec<ObjectRow<'a>> {
    let Products {
        navigation,
        returns,
        calibration,
        correction,
        ..
    } = products;
    let placing = Placing::new(survey, navigation, returns, calibration, correction);
    let mut rows: Vec<ObjectRow<'a>> = (1..)
        .zip(found)
        .map(|(id, one)| ObjectRow {
            id,
            class: names.get(one.class).map_or("", String::as_str),
            score: Some(one.score),
            state: State::Proposed.name(),
            mark: &one.mark,
            target: placing.place(&one.mark),
            object: None,
            note: "",
        })
        .collect();
    number_objects(&mut rows, |row| Some(found[row].class));
    rows
}

/// Gives sightings of one object the same number. `class_of` tells a row's class; rows without one are no objects.
pub(super) fn number_objects(
    rows: &mut [ObjectRow<'_>],
    class_of: impl Fn(usize) -> Option<usize>,
) {
    let mut objects: Vec<Option<usize>> = vec![None; rows.len()];
    let (members, sightings): (Vec<usize>, Vec<Sighting<'_>>) = rows
        .iter()
        .enumerate()
        .filter_map(|(row, one)| {
            let sighting = Sighting {
                log: 0,
                target: one.target.as_ref()?,
                class: class_of(row)?,
                // Who drew a box was sure of it.
                score: one.score.map_or(1.0, f64::from),
            };
            Some((row, sighting))
        })
        .unzip();
    let groups = group(&sightings, &GroupSettings::default());
    for (object, group) in (1..).zip(&groups) {
        for &member in &group.members {
            objects[members[member]] = Some(object);
        }
    }
    for (row, object) in rows.iter_mut().zip(objects) {
        row.object = object;
    }
}
