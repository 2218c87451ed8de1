//! Writes the reviewed boxes of a survey: the places of objects for maps and plotters, and pictures
//! with labels for training.

use super::order::{check_logs, log_names, survey_name};
use super::results::{find_shapes, listed};
use super::training_tiles::TrainingTiles;
use crate::Error;
use crate::export::{self, DatasetPart, ObjectLog, make_folder};
use crate::file_name::file_name;
use crate::pipeline::ProcessedLog;
use crate::pipeline::list_objects;
use bathyscope_log::support::progress::Progress;
use bathyscope_objects::Raster;
use bathyscope_objects::objects::{LogReview, ObjectBox, ObjectList, SurveyReview};
use bathyscope_objects::review::{PIXEL_M, Review, ReviewedTile};
use std::path::Path;

/// Folder of the pictures for training.
const DATASET: &str = "dataset";
/// Name of the file of the review in the folder.
const REVIEW: &str = "boxes.review.json";

/// Numbers of the boxes and pictures that were written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BoxesWritten {
    /// Number of boxes in the tables.
    pub boxes: usize,
    /// Number of pictures for training.
    pub pictures: usize,
    /// Number of pictures in which all boxes were rejected: hard negatives.
    pub negatives: usize,
}

impl BoxesWritten {
    /// Describes the written files in a sentence.
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

/// The boxes of a log with its review.
struct LogBoxes<'a> {
    index: usize,
    log: &'a ProcessedLog,
    review: &'a Review,
    raster: Raster,
    tiles: Vec<ReviewedTile>,
}

/// Writes the boxes of the logs of a survey into `folder`, which is made if it is missing; `review`
/// has the review of each log, if any. `detections.csv` has every box with its state and the number
/// of its object, `objects.csv` and `objects.geojson` every object, `objects.gpkg`, `objects.kml`
/// and `objects.gpx` the targets ([`ObjectList::targets`]), `shapes.ply` the solids fitted to the
/// targets. The folder also holds the review itself, and `dataset/` with a picture around each
/// decided box and its labels as YOLO, COCO and Pascal VOC, in the layout that detectors are
/// trained on ([`export::DatasetFolder`]); a whole log belongs to one part of the dataset, because
/// its pictures overlap. A picture in which all boxes were rejected has no label: it is a hard
/// negative. Undecided boxes have a mark by which training neither rewards nor penalizes them (COCO
/// `iscrowd`, VOC `difficult`). With several logs each log has its own review, `NAME.review.json`,
/// and its own dataset, `dataset/NAME`. Pictures of an earlier export of the same log are replaced.
///
/// # Errors
/// When no log has boxes, or a file cannot be written; the sentence names the file. A cancelled run
/// leaves complete files only. A log that was cut or changed meanwhile is reported after the files
/// are written; its pictures may then show its present content.
pub fn write_boxes(
    logs: &[ProcessedLog],
    review: &SurveyReview,
    part: DatasetPart,
    folder: &Path,
    progress: &Progress,
) -> Result<BoxesWritten, Error> {
    let of_log = |(index, (log, review))| {
        let (log, review): (&ProcessedLog, &Option<LogReview>) = (log, review);
        let review = &*review.as_ref()?.review;
        let raster = Raster::new(&log.survey, &log.products.navigation, PIXEL_M);
        let tiles = review.tiles(&raster);
        Some(LogBoxes { index, log, review, raster, tiles })
    };
    let boxes: Vec<LogBoxes<'_>> =
        (logs.iter().zip(&review.logs).enumerate()).filter_map(of_log).collect();
    if boxes.is_empty() {
        return Err("there are no boxes to write".into());
    }
    let work =
        |log_boxes: &LogBoxes<'_>| (log_boxes.review.boxes().len() + log_boxes.tiles.len()) as u64;
    progress.start(boxes.iter().map(work).sum());
    make_folder(folder)?;
    let list = list_objects(logs, review, progress)?;
    let names = log_names(logs);
    tables(logs, &names, &list, folder, progress)?;
    let mut written = BoxesWritten { boxes: list.boxes().len(), pictures: 0, negatives: 0 };
    for log_boxes in &boxes {
        let (root, review) = match logs {
            [_] => (folder.join(DATASET), folder.join(REVIEW)),
            _ => {
                let name = file_name(&names[log_boxes.index]);
                let review = format!("{name}.review.json");
                (folder.join(DATASET).join(name), folder.join(review))
            }
        };
        let training_tiles = TrainingTiles {
            survey: &log_boxes.log.survey,
            review: log_boxes.review,
            classes: &log_boxes.log.products.settings.review.classes,
            raster: &log_boxes.raster,
            tiles: &log_boxes.tiles,
            part,
        };
        written.pictures += log_boxes.tiles.len();
        written.negatives += training_tiles.write(&root, progress)?;
        export::write_bytes(&review, log_boxes.review.to_json() + "\n")?;
    }
    check_logs(logs)?;
    Ok(written)
}

fn tables(
    logs: &[ProcessedLog],
    names: &[String],
    list: &ObjectList,
    folder: &Path,
    progress: &Progress,
) -> Result<(), Error> {
    let named: Vec<ObjectLog<'_>> = (names.iter().zip(logs))
        .map(|(name, log)| ObjectLog { name, survey: &log.survey })
        .collect();
    let shapes = find_shapes(list, logs, progress)?;
    let boxes: Vec<&ObjectBox> = list.boxes().iter().collect();
    export::box_table(&folder.join("detections.csv"), &named, &boxes, &shapes)?;
    let objects = listed(list.objects().iter(), (list, &shapes), logs, names);
    export::object_table(&folder.join("objects.csv"), &objects)?;
    export::objects_geojson(&folder.join("objects.geojson"), &objects)?;
    let targets = listed(list.targets(), (list, &shapes), logs, names);
    export::objects_kml(&folder.join("objects.kml"), &survey_name(names), &targets)?;
    export::objects_gpx(&folder.join("objects.gpx"), &targets)?;
    let first = logs.first().and_then(|log| log.survey.start_unix_s);
    export::objects_gpkg(&folder.join("objects.gpkg"), &targets, first.unwrap_or(0.0))?;
    export::shapes_ply(&folder.join("shapes.ply"), &targets)?;
    Ok(())
}
