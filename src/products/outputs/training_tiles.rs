//! Writes reviewed boxes as pictures with labels, for training.

use crate::Error;
use crate::export::{DatasetFolder, DatasetPart, PartSummary};
use bathyscope_log::support::progress::Progress;
use bathyscope_log::survey::{Identity, Survey};
use bathyscope_objects::dataset::{Chip, PictureBoxes};
use bathyscope_objects::review::{Review, ReviewedTile};
use bathyscope_objects::{Labelled, Raster, TILE_PX, level};
use serde::{Deserialize, Serialize};
use std::fs;
use std::path::Path;

/// Name of the program in the manifest of the pictures.
const PROGRAM: &str = "bathyscope review";

/// The decided boxes of a log with the data that their pictures are drawn from.
pub(super) struct TrainingTiles<'a> {
    pub survey: &'a Survey,
    pub review: &'a Review,
    /// The analyst's classes, in the order of their numbers in labels.
    pub classes: &'a [String],
    pub raster: &'a Raster,
    pub tiles: &'a [ReviewedTile],
    /// Part of the dataset that the whole log belongs to.
    pub part: DatasetPart,
}

/// Origin and numbers of the pictures.
#[derive(Serialize)]
struct Manifest<'a> {
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
struct Earlier {
    program: String,
    survey: Identity,
}

impl TrainingTiles<'_> {
    /// Writes the pictures with their labels; returns the number of hard negatives.
    pub(super) fn write(&self, root: &Path, progress: &Progress) -> Result<usize, Error> {
        self.clear(root)?;
        let (classes, places) = self.review.training_classes(self.classes);
        let folder = DatasetFolder::new(root, &classes)?;
        let (mut all, mut hard_negatives) = (Vec::with_capacity(self.tiles.len()), 0);
        for (number, tile) in self.tiles.iter().enumerate() {
            progress.check()?;
            let chip = self.chip(tile, &places);
            hard_negatives += usize::from(chip.boxes.labels.is_empty() && tile.rejected > 0);
            folder.chip(self.part, number, &chip)?;
            folder.voc(self.part, number, &chip.boxes)?;
            all.push(chip.boxes);
            progress.advance(1);
        }
        let of_part = |part: DatasetPart| {
            if part == self.part { folder.finish(part, &all) } else { folder.finish(part, &[]) }
        };
        let [train, val, test] = DatasetPart::ALL.map(of_part);
        let manifest = Manifest {
            program: PROGRAM,
            version: env!("CARGO_PKG_VERSION"),
            survey: self.review.identity(),
            pixel_m: self.raster.pixel_m(),
            tile_px: TILE_PX,
            classes: &classes,
            hard_negatives,
            parts: [train?, val?, test?],
        };
        folder.manifest(&manifest)?;
        Ok(hard_negatives)
    }

    fn chip(&self, tile: &ReviewedTile, places: &[Option<usize>]) -> Chip {
        let drawn = self.raster.tile(self.survey, tile.side, tile.row, tile.column);
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
        let is_ours = serde_json::from_slice(&manifest).is_ok_and(|earlier: Earlier| {
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
