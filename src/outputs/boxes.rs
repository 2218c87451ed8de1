//! Writes what was decided about boxes: where the objects lie, for maps and plotters, and pictures with labels, for training.

use super::detections::{is_left_out, number_objects};
use super::training_tiles::TrainingTiles;
use crate::detection::Raster;
use crate::detection::review::{Review, State};
use crate::export::{self, ObjectRow, Part};
use crate::pipeline::{Placing, Products};
use crate::progress::Progress;
use crate::survey::Survey;
use std::fs;
use std::io::Write as _;
use std::path::Path;

/// Name of the review's own file in the folder.
const REVIEW: &str = "boxes.review.json";

/// What was written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BoxesWritten {
    /// Boxes in the tables.
    pub boxes: usize,
    /// Pictures for training.
    pub pictures: usize,
    /// Of those, pictures in which there is nothing: hard negatives.
    pub negatives: usize,
}

impl BoxesWritten {
    /// What was written, in a sentence.
    pub fn summary(&self, folder: &Path) -> String {
        format!(
            "Wrote {} boxes and {} pictures for training, {} of them hard negatives, into {}",
            self.boxes,
            self.pictures,
            self.negatives,
            folder.display()
        )
    }
}

/// Writes into `folder`, which is made when it is missing: `objects.csv` and `objects.geojson` with every box and its state,
/// `objects.kml` and `objects.gpx` with the accepted and added ones, the review itself, and `dataset/` with a picture around
/// each decided box and its labels as YOLO, COCO and Pascal VOC, in the layout that detectors are trained on
/// ([`export::DatasetFolder`]); the whole log is one part of it, for its pictures overlap. A picture in which all was rejected has no
/// label: a hard negative. Undecided boxes are marked as to be neither found nor missed (COCO `iscrowd`, VOC `difficult`).
/// Pictures of an earlier export of the same log are replaced.
///
/// The error is one sentence that names the file. A cancelled run leaves whole files only.
pub fn write_boxes(
    survey: &Survey,
    products: &Products,
    review: &Review,
    raster: &Raster,
    part: Part,
    folder: &Path,
    progress: &Progress,
) -> Result<BoxesWritten, String> {
    let tiles = review.tiles(raster);
    progress.start((review.boxes().len() + tiles.len()) as u64);
    make(folder)?;
    let rows = reviewed_rows(survey, products, review, progress)?;
    tables(survey, &rows, folder).map_err(|error| error.to_string())?;
    let root = folder.join("dataset");
    let training_tiles = TrainingTiles {
        survey,
        review,
        raster,
        tiles: &tiles,
        part,
    };
    let negatives = training_tiles.write(&root, progress)?;
    text(&folder.join(REVIEW), &(review.to_json() + "\n"))?;
    Ok(BoxesWritten {
        boxes: rows.len(),
        pictures: tiles.len(),
        negatives,
    })
}

/// A line for each box but those in stretches that are left out; sightings of one object share its number. The error is one sentence.
pub fn reviewed_rows<'a>(
    survey: &Survey,
    products: &Products,
    review: &'a Review,
    progress: &Progress,
) -> Result<Vec<ObjectRow<'a>>, String> {
    let placing = Placing::new(
        survey,
        &products.navigation,
        &products.returns,
        &products.calibration,
        &products.correction,
    );
    let mut rows = Vec::with_capacity(review.boxes().len());
    let counted = || {
        let boxes = review.boxes();
        boxes.filter(|one| !is_left_out(products, &one.mark))
    };
    for one in counted() {
        progress.check().map_err(|error| error.to_string())?;
        rows.push(ObjectRow {
            id: one.id.0,
            class: review.class_name(one.class),
            score: one.score,
            state: one.state.name(),
            mark: &one.mark,
            target: placing.place(&one.mark),
            object: None,
            note: &one.note,
        });
        progress.advance(1);
    }
    let classes: Vec<Option<usize>> = counted()
        .map(|one| one.state.is_object().then_some(one.class))
        .collect();
    number_objects(&mut rows, |row| classes[row]);
    Ok(rows)
}

fn tables(
    survey: &Survey,
    rows: &[ObjectRow<'_>],
    folder: &Path,
) -> Result<(), export::ExportError> {
    let is_object =
        |row: &&ObjectRow<'_>| [State::Accepted.name(), State::Added.name()].contains(&row.state);
    let objects: Vec<ObjectRow<'_>> = rows.iter().filter(is_object).cloned().collect();
    export::objects_csv(&folder.join("objects.csv"), survey, rows)?;
    export::objects_geojson(&folder.join("objects.geojson"), rows)?;
    export::objects_kml(&folder.join("objects.kml"), &survey.name(), &objects)?;
    export::objects_gpx(&folder.join("objects.gpx"), &objects)
}

fn make(folder: &Path) -> Result<(), String> {
    fs::create_dir_all(folder)
        .map_err(|error| format!("cannot make the folder: {error}: {}", folder.display()))
}

fn text(path: &Path, text: &str) -> Result<(), String> {
    export::write_aside(path, |mut file| file.write_all(text.as_bytes()))
        .map_err(|error| error.to_string())
}
