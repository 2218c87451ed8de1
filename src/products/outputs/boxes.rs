//! Writes the reviewed boxes of a survey: the places of objects for maps and plotters, and pictures
//! with labels for training.

use super::object_files::listed;
use super::order::{check_logs, log_names, object_logs, survey_name};
use super::results::{ShapedObjects, list_with_shapes};
use crate::Error;
use crate::export::{self, DatasetFolder, DatasetPart, PartSummary, make_folder};
use crate::file_name::file_name;
use crate::pipeline::ProcessedLog;
use bathyscope_log::support::progress::Progress;
use bathyscope_log::survey::Identity;
use bathyscope_objects::dataset::{Chip, PictureBoxes};
use bathyscope_objects::objects::{LogReview, ObjectBox, SurveyReview};
use bathyscope_objects::review::{PIXEL_M, Review, ReviewedTile};
use bathyscope_objects::{Labelled, Raster, TILE_PX, level};
use serde::{Deserialize, Serialize};
use std::fs;
use std::path::Path;

/// Folder of the pictures for training.
const DATASET: &str = "dataset";
/// Name of the file of the review in the folder.
const REVIEW: &str = "boxes.review.json";
/// Name of the program in the manifest of the pictures.
const PROGRAM: &str = "bathyscope review";

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

/// The boxes of a log with its review, and the data that their pictures are drawn from.
struct LogBoxes<'a> {
    /// Name of the log in its survey.
    name: &'a str,
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
///
/// [`ObjectList::targets`]: bathyscope_objects::objects::ObjectList::targets
pub fn write_boxes(
    logs: &[ProcessedLog],
    review: &SurveyReview,
    part: DatasetPart,
    folder: &Path,
    progress: &Progress,
) -> Result<BoxesWritten, Error> {
    let names = log_names(logs);
    let of_log = |((name, log), review)| {
        let (name, log, review): (&String, &ProcessedLog, &Option<LogReview>) = (name, log, review);
        let review = &*review.as_ref()?.review;
        let raster = Raster::new(&log.survey, &log.products.navigation, PIXEL_M);
        let tiles = review.tiles(&raster);
        Some(LogBoxes { name, log, review, raster, tiles })
    };
    let boxes: Vec<LogBoxes<'_>> =
        (names.iter().zip(logs).zip(&review.logs)).filter_map(of_log).collect();
    if boxes.is_empty() {
        return Err("there are no boxes to write".into());
    }
    let work =
        |log_boxes: &LogBoxes<'_>| (log_boxes.review.boxes().len() + log_boxes.tiles.len()) as u64;
    progress.start(boxes.iter().map(work).sum());
    make_folder(folder)?;
    let objects = list_with_shapes(logs, review, progress)?;
    tables(logs, &names, &objects, folder)?;
    let mut written = BoxesWritten { boxes: objects.0.boxes.len(), pictures: 0, negatives: 0 };
    for log_boxes in &boxes {
        let (root, review) = match logs {
            [_] => (folder.join(DATASET), folder.join(REVIEW)),
            _ => {
                let name = file_name(log_boxes.name);
                let review = format!("{name}.review.json");
                (folder.join(DATASET).join(name), folder.join(review))
            }
        };
        written.pictures += log_boxes.tiles.len();
        written.negatives += log_boxes.write_dataset(&root, part, progress)?;
        export::write_bytes(&review, log_boxes.review.to_json() + "\n")?;
    }
    check_logs(logs)?;
    Ok(written)
}

/// Origin and numbers of the pictures.
#[derive(Serialize)]
struct DatasetManifest<'a> {
    program: &'static str,
    version: &'static str,
    survey: &'a Identity,
    pixel_m: f64,
    tile_px: usize,
    classes: &'a [String],
    /// Number of pictures in which all boxes were rejected.
    hard_negatives: usize,
    parts: [PartSummary; 3],
}

/// The parts of a manifest that identify an earlier export of the same log.
#[derive(Deserialize)]
struct EarlierDataset {
    program: String,
    survey: Identity,
}

impl LogBoxes<'_> {
    /// Writes a picture around each decided box with its labels, all in one part of the dataset;
    /// returns the number of hard negatives.
    fn write_dataset(
        &self,
        root: &Path,
        part: DatasetPart,
        progress: &Progress,
    ) -> Result<usize, Error> {
        self.clear(root)?;
        let settings = &self.log.products.settings;
        let (classes, places) = self.review.training_classes(&settings.review.classes);
        let folder = DatasetFolder::new(root, &classes)?;
        let (mut all, mut hard_negatives) = (Vec::with_capacity(self.tiles.len()), 0);
        for (number, tile) in self.tiles.iter().enumerate() {
            progress.check()?;
            let chip = self.chip(tile, &places);
            hard_negatives += usize::from(chip.boxes.labels.is_empty() && tile.rejected > 0);
            folder.chip(part, number, &chip)?;
            folder.voc(part, number, &chip.boxes)?;
            all.push(chip.boxes);
            progress.advance(1);
        }
        let of_part = |other: DatasetPart| {
            if other == part { folder.finish(part, &all) } else { folder.finish(other, &[]) }
        };
        let [train, val, test] = DatasetPart::ALL.map(of_part);
        let manifest = DatasetManifest {
            program: PROGRAM,
            version: env!("CARGO_PKG_VERSION"),
            survey: self.review.identity(),
            pixel_m: self.raster.pixel_m,
            tile_px: TILE_PX,
            classes: &classes,
            hard_negatives,
            parts: [train?, val?, test?],
        };
        folder.manifest(&manifest)?;
        Ok(hard_negatives)
    }

    fn chip(&self, tile: &ReviewedTile, places: &[Option<usize>]) -> Chip {
        let drawn = self.raster.tile(&self.log.survey, tile.side, tile.row, tile.column);
        let mut pixels = drawn.pixels;
        level(&mut pixels);
        let renumbered = |list: &[Labelled]| {
            let label = |label: &Labelled| {
                let class = places.get(label.class).copied().flatten()?;
                Some(Labelled { class, ..*label })
            };
            list.iter().filter_map(label).collect()
        };
        Chip {
            pixels,
            boxes: PictureBoxes {
                labels: renumbered(&tile.boxes.labels),
                ignored: renumbered(&tile.boxes.ignored),
                outlines: Vec::new(),
            },
        }
    }

    /// Removes the pictures of an earlier export of this log, which may have had more pictures;
    /// refuses a folder of other pictures.
    fn clear(&self, root: &Path) -> Result<(), Error> {
        if !fs::read_dir(root).is_ok_and(|mut entries| entries.next().is_some()) {
            return Ok(());
        }
        let manifest = fs::read(root.join("manifest.json")).unwrap_or_default();
        let is_ours = serde_json::from_slice(&manifest).is_ok_and(|earlier: EarlierDataset| {
            earlier.program == PROGRAM && earlier.survey.is_same_log(self.review.identity())
        });
        if !is_ours {
            return Err(format!(
                "the folder holds pictures of something else; name another one to write into: {}",
                root.display()
            )
            .into());
        }
        for (kind, ending) in [("images", "png"), ("labels", "txt"), ("voc", "xml")] {
            for part in DatasetPart::ALL {
                let entries = fs::read_dir(root.join(kind).join(part.name()));
                for entry in entries.into_iter().flatten().flatten() {
                    let path = entry.path();
                    if is_numbered(&path, ending) {
                        fs::remove_file(&path).map_err(|error| {
                            format!("cannot replace the picture: {error}: {}", path.display())
                        })?;
                    }
                }
            }
        }
        Ok(())
    }
}

/// Returns true if a file name has the form of those that are written: six digits.
fn is_numbered(path: &Path, ending: &str) -> bool {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let is_number = stem.len() == 6 && stem.bytes().all(|byte| byte.is_ascii_digit());
    is_number && path.extension().is_some_and(|is| is == ending)
}

fn tables(
    logs: &[ProcessedLog],
    names: &[String],
    shaped: &ShapedObjects,
    folder: &Path,
) -> Result<(), Error> {
    let (list, shapes) = shaped;
    let named = object_logs(logs, names);
    let boxes: Vec<&ObjectBox> = list.boxes.iter().collect();
    export::box_table(&folder.join("detections.csv"), &named, &boxes, shapes)?;
    let objects = listed(list.objects.iter(), shaped, logs, names);
    export::object_table(&folder.join("objects.csv"), &objects)?;
    export::objects_geojson(&folder.join("objects.geojson"), &objects)?;
    let targets = listed(list.targets(), shaped, logs, names);
    export::objects_kml(&folder.join("objects.kml"), &survey_name(names), &targets)?;
    export::objects_gpx(&folder.join("objects.gpx"), &targets)?;
    let first = logs.first().and_then(|log| log.survey.start_unix_s);
    export::objects_gpkg(&folder.join("objects.gpkg"), &targets, first.unwrap_or(0.0))?;
    export::shapes_ply(&folder.join("shapes.ply"), &targets)?;
    Ok(())
}
