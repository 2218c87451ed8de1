//! Writes what was decided about boxes: where the objects lie, for maps and plotters, and pictures with labels, for training.

use super::logs::{log_names, survey_name};
use super::objects::ObjectRows;
use super::training_tiles::TrainingTiles;
use crate::detection::Raster;
use crate::detection::review::{PIXEL_M, Review, ReviewedTile};
use crate::pipeline::ProcessedLog;
use crate::products::export::{self, ObjectLog, Part};
use crate::products::outputs::OutputError;
use crate::support::progress::Progress;
use std::fs;
use std::io::Write as _;
use std::path::Path;
use std::sync::Arc;

/// Folder of the pictures for training.
const DATASET: &str = "dataset";
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

/// The boxes of a log with what was decided about them.
struct LogBoxes<'a> {
    index: usize,
    log: &'a ProcessedLog,
    review: &'a Review,
    raster: Raster,
    tiles: Vec<ReviewedTile>,
}

/// Writes the boxes of the logs of a survey into `folder`, which is made when it is missing; `reviews` has what was decided about each log,
/// if anything. `objects.csv` and `objects.geojson` have every box with its state, `objects.gpkg` the accepted and added ones, `objects.kml` and `objects.gpx` a point for
/// each object that those show, `shapes.ply` the solids that those are like; sightings of one object in whatever log have its number. Beside them lie the review itself, and `dataset/` with a picture around
/// each decided box and its labels as YOLO, COCO and Pascal VOC, in the layout that detectors are trained on
/// ([`export::DatasetFolder`]); a whole log is one part of it, for its pictures overlap. A picture in which all was rejected has no
/// label: a hard negative. Undecided boxes are marked as to be neither found nor missed (COCO `iscrowd`, VOC `difficult`).
/// Of several logs each has its review, `NAME.review.json`, and its data set, `dataset/NAME`.
/// Pictures of an earlier export of the same log are replaced.
///
/// # Errors
/// A sentence that names the file, or says that no log has boxes. A cancelled run leaves whole files only.
pub fn write_boxes(
    logs: &[ProcessedLog],
    reviews: &[Option<Arc<Review>>],
    part: Part,
    folder: &Path,
    progress: &Progress,
) -> Result<BoxesWritten, OutputError> {
    let of_log = |(index, (log, review))| {
        let (log, review): (&ProcessedLog, &Option<Arc<Review>>) = (log, review);
        let review = review.as_deref()?;
        let raster = Raster::new(&log.survey, &log.products.navigation, PIXEL_M);
        let tiles = review.tiles(&raster);
        Some(LogBoxes {
            index,
            log,
            review,
            raster,
            tiles,
        })
    };
    let boxes: Vec<LogBoxes<'_>> = (logs.iter().zip(reviews).enumerate())
        .filter_map(of_log)
        .collect();
    if boxes.is_empty() {
        return Err("there are no boxes to write".into());
    }
    let work = |one: &LogBoxes<'_>| (one.review.boxes().len() + one.tiles.len()) as u64;
    progress.start(boxes.iter().map(work).sum());
    make(folder)?;
    let mut all = ObjectRows::default();
    for one in &boxes {
        all.add_reviewed(one.index, one.log, one.review, progress)?;
    }
    all.group();
    let shapes = all.find_shapes(logs, progress)?;
    all.set_shapes(&shapes);
    let names = log_names(logs);
    let boxes_written = all.rows.len();
    tables(logs, &names, all, folder)?;
    let mut written = BoxesWritten {
        boxes: boxes_written,
        pictures: 0,
        negatives: 0,
    };
    for one in &boxes {
        let (root, review) = match logs {
            [_] => (folder.join(DATASET), folder.join(REVIEW)),
            _ => {
                let name = file_name(&names[one.index]);
                let review = format!("{name}.review.json");
                (folder.join(DATASET).join(name), folder.join(review))
            }
        };
        let training_tiles = TrainingTiles {
            survey: &one.log.survey,
            review: one.review,
            classes: &one.log.products.settings.review.classes,
            raster: &one.raster,
            tiles: &one.tiles,
            part,
        };
        written.pictures += one.tiles.len();
        written.negatives += training_tiles.write(&root, progress)?;
        text(&review, &(one.review.to_json() + "\n"))?;
    }
    Ok(written)
}

fn tables(
    logs: &[ProcessedLog],
    names: &[String],
    mut all: ObjectRows<'_>,
    folder: &Path,
) -> Result<(), export::ExportError> {
    let named: Vec<ObjectLog<'_>> = (names.iter().zip(logs))
        .map(|(name, log)| ObjectLog {
            name,
            survey: &log.survey,
        })
        .collect();
    export::objects_csv(&folder.join("objects.csv"), &named, &all.rows)?;
    export::objects_geojson(&folder.join("objects.geojson"), &named, &all.rows)?;
    all.retain_decided();
    let points = all.points(logs);
    let title = survey_name(names);
    export::objects_kml(&folder.join("objects.kml"), &title, &points)?;
    export::objects_gpx(&folder.join("objects.gpx"), &points)?;
    export::objects_gpkg(&folder.join("objects.gpkg"), &named, &all.rows)?;
    export::shapes_ply(&folder.join("shapes.ply"), &all.rows).map(|_| ())
}

/// A log's name as that of a file: the name of a recording is that of its own file, but for a log out of memory.
fn file_name(name: &str) -> String {
    name.replace(['/', '\\'], "-")
}

fn make(folder: &Path) -> Result<(), OutputError> {
    fs::create_dir_all(folder)
        .map_err(|error| format!("cannot make the folder: {error}: {}", folder.display()).into())
}

fn text(path: &Path, text: &str) -> Result<(), OutputError> {
    export::write_aside(path, |mut file| file.write_all(text.as_bytes())).map_err(OutputError::from)
}
