//! Cuts a small picture of each object found, writes these chips into a folder, and finds the chips
//! of an earlier run.

use super::ExportError;
use crate::Error;
use bathyscope_log::support::progress::Progress;
use bathyscope_log::survey::Survey;
use bathyscope_objects::{Detection, Mark, Picture, Raster, Rect, Scored, TILE_PX, level};
use image::codecs::png::PngEncoder;
use image::{ExtendedColorType, ImageEncoder as _};
use std::collections::HashSet;
use std::fs::{self, File};
use std::io::{self, BufWriter, Write as _};
use std::path::{Path, PathBuf};

/// Name of the folder of chips, beside their table.
const FOLDER: &str = "chips";
/// Name of the folder of unfinished chips in an old version, which did not write the files of a run
/// together.
const PASSING: &str = "chips.part";
/// Name of the table beside the folder, which names the classes of the chips.
const TABLE: &str = "detections.csv";
/// Class of a box for which the model has no class name.
const UNNAMED: &str = "object";
/// Pixels around a box, so that the object is seen against its surroundings.
const AROUND_PX: f32 = 24.0;

/// The boxes of a log, and the recording and raster that their chips are cut from.
pub(crate) struct ChipLog<'a> {
    /// The recording.
    pub survey: &'a Survey,
    /// Raster of the log.
    pub raster: Raster,
    /// Boxes of the log.
    pub found: &'a [Detection],
}

/// Writes the [`chip`] of each box of the logs, one log after the other, into the folder of chips
/// in `folder`: `0001-rock.png` and so on.
///
/// # Errors
/// When a picture cannot be written, or the work was cancelled.
pub(crate) fn chips(
    folder: &Path,
    names: &[String],
    logs: &[ChipLog<'_>],
    progress: &Progress,
) -> Result<(), Error> {
    let count: usize = logs.iter().map(|log| log.found.len()).sum();
    progress.start(count as u64);
    let mut chips = ChipFolder::begin(folder, names)?;
    for log in logs {
        for found in log.found {
            progress.check()?;
            chips.add(found.class, &chip(log.survey, &log.raster, &found.mark))?;
            progress.advance(1);
        }
    }
    Ok(())
}

/// Returns the picture of a box of a survey with its surroundings: range to the right, levels as
/// the detector's input. Pixels are those of the raster, or larger where the box would not fit into
/// a tile, so that a hull is shown as a whole.
pub fn chip(survey: &Survey, raster: &Raster, mark: &Mark) -> Picture {
    let rect = raster.rect_of(mark);
    let room_px = TILE_PX as f32 - 2.0 * AROUND_PX - 1.0;
    let factor = (rect.x1 - rect.x0).max(rect.y1 - rect.y0) / room_px;
    let coarser;
    let raster = if factor > 1.0 {
        coarser = raster.coarser(f64::from(factor));
        &coarser
    } else {
        raster
    };
    let (x, y, width, height) = around(&raster.rect_of(mark));
    let (width, height) = (width.min(TILE_PX), height.min(TILE_PX));
    let mut tile = raster.tile(survey, mark.side, y, x);
    level(&mut tile.pixels);
    Picture::grey(TILE_PX, TILE_PX, tile.pixels).piece(0, 0, width, height)
}

/// Writes the chips of boxes in a picture of another program into the folder of chips in `folder`.
pub(crate) fn picture_chips(
    folder: &Path,
    picture: &Picture,
    names: &[String],
    boxes: &[Scored],
) -> Result<(), ExportError> {
    let mut chips = ChipFolder::begin(folder, names)?;
    for found in boxes {
        let (x, y, width, height) = around(&found.rect);
        let width = width.min(picture.width.saturating_sub(x));
        let height = height.min(picture.height.saturating_sub(y));
        let chip = picture.piece(x, y, width, height);
        chips.add(found.class, &chip)?;
    }
    Ok(())
}

/// Returns the first column and row, and the number of columns and rows, of a box and its
/// surroundings.
fn around(rect: &Rect) -> (usize, usize, usize, usize) {
    // `as` saturates, and a box's edges are finite.
    let first = |edge: f32| (edge - AROUND_PX).max(0.0) as usize;
    let (x, y) = (first(rect.x0), first(rect.y0));
    let size = |first: usize, edge: f32| ((edge + AROUND_PX) as usize).saturating_sub(first).max(1);
    (x, y, size(x, rect.x1), size(y, rect.y1))
}

/// A folder into which chips are being written.
struct ChipFolder {
    folder: PathBuf,
    /// Classes by index, as part of a file name.
    classes: Vec<String>,
    /// Number of chips written so far.
    count: usize,
}

impl ChipFolder {
    /// Makes a folder for the chips in `output`, the folder into which their table is written too.
    ///
    /// # Errors
    /// When the folder cannot be made.
    fn begin(output: &Path, classes: &[String]) -> Result<Self, ExportError> {
        let folder = output.join(FOLDER);
        fs::create_dir_all(&folder).map_err(ExportError::at(&folder))?;
        Ok(Self { folder, classes: classes.iter().map(|name| file_safe(name)).collect(), count: 0 })
    }

    /// Writes the next chip, `0001-rock.png` and so on.
    fn add(&mut self, class: usize, chip: &Picture) -> Result<(), ExportError> {
        let class = self.classes.get(class).map_or(UNNAMED, String::as_str);
        self.count += 1;
        let path = self.folder.join(format!("{:04}-{class}.png", self.count));
        let colour =
            if chip.channels == 3 { ExtendedColorType::Rgb8 } else { ExtendedColorType::L8 };
        let write = |file: File| {
            let mut out = BufWriter::new(file);
            PngEncoder::new(&mut out)
                .write_image(&chip.levels, chip.width as u32, chip.height as u32, colour)
                .map_err(io::Error::other)?;
            out.flush()
        };
        File::create(&path).and_then(write).map_err(ExportError::at(&path))
    }
}

/// Returns the chips in the subfolder `of` of a folder of products that belong to its table of
/// boxes, if this table is in `removed` or is replaced by one in `new`. A chip has a number and a
/// class of either table as its name; other files belong to the user.
pub(crate) fn earlier_chips(
    output: &Path,
    of: &str,
    new: Option<&Path>,
    removed: &[String],
) -> Vec<String> {
    let table = format!("{of}{TABLE}");
    let replaced = new.map(|new| new.join(TABLE)).filter(|new| new.exists());
    if replaced.is_none() && !removed.contains(&table) {
        return Vec::new();
    }
    let mut known = classes_in(&output.join(&table));
    known.extend(replaced.into_iter().flat_map(|new| classes_in(&new)));
    known.insert(UNNAMED.to_owned());
    let chips = chips_in(&output.join(of).join(FOLDER), |class| known.contains(class));
    let names = chips.iter().filter_map(|chip| chip.file_name()?.to_str());
    names.map(|name| format!("{of}{FOLDER}/{name}")).collect()
}

/// Removes the chips that an old version left unfinished; best effort.
pub(crate) fn remove_passing_chips(output: &Path) {
    let passing = output.join(PASSING);
    for chip in chips_in(&passing, |_| true) {
        fs::remove_file(chip).ok();
    }
    // A folder that holds anything else is not removed.
    fs::remove_dir(&passing).ok();
}

/// Returns the chips in a folder whose classes satisfy `such`.
fn chips_in(folder: &Path, such: impl Fn(&str) -> bool) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    let chips = entries.filter(|entry| {
        let is_file = entry.file_type().is_ok_and(|kind| kind.is_file());
        is_file && entry.file_name().to_str().and_then(class_in).is_some_and(&such)
    });
    chips.map(|entry| entry.path()).collect()
}

/// Returns the classes that an earlier table names; none where there is no such table.
fn classes_in(table: &Path) -> HashSet<String> {
    let Ok(mut table) = csv::Reader::from_path(table) else {
        return HashSet::new();
    };
    let column = table.headers().ok().and_then(|header| {
        let mut header = header.iter();
        header.position(|name| name == "class")
    });
    let rows = table.records().map_while(Result::ok);
    rows.filter_map(|row| row.get(column?).map(file_safe)).collect()
}

/// Returns the class in the name of a chip; `None` for a file that is no chip.
fn class_in(name: &str) -> Option<&str> {
    let (number, class) = name.strip_suffix(".png")?.split_once('-')?;
    let numbered = number.len() >= 4 && number.bytes().all(|digit| digit.is_ascii_digit());
    (numbered && class == file_safe(class)).then_some(class)
}

/// Converts a class name, which may come from a model's file, to a part of a file name: letters,
/// digits and hyphens.
fn file_safe(name: &str) -> String {
    let letters = name.chars().take(40);
    letters.map(|letter| if letter.is_alphanumeric() { letter } else { '-' }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let entries = fs::read_dir(folder).unwrap();
        let mut names: Vec<String> =
            entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    #[test]
    fn earlier_chips_are_distinguished_from_other_files() {
        let temporary = tempfile::tempdir().unwrap();
        let [output, new] = ["out", "new"].map(|name| temporary.path().join(name));
        let classes = ["rock", "sunken boat"].map(str::to_owned);
        let mut chips = ChipFolder::begin(&output, &classes).unwrap();
        for class in [0, 1, 2] {
            chips.add(class, &Picture::grey(2, 1, vec![0, 9])).unwrap();
        }
        let ours = ["0001-rock.png", "0002-sunken-boat.png", "0003-object.png"];
        assert_eq!(names(&output.join(FOLDER)), ours);
        let table = "id,class\n1,rock\n2,sunken boat\n";
        fs::write(output.join(TABLE), table).unwrap();
        for name in ["0003-best.png", "0003-rock copy.png", "3-rock.png", "rock.png"] {
            fs::write(output.join(FOLDER).join(name), "mine").unwrap();
        }
        fs::create_dir(output.join(FOLDER).join("0004-rock.png")).unwrap();
        fs::create_dir(&new).unwrap();
        let root = temporary.path();
        let earlier = |removed: &[String]| earlier_chips(root, "out/", Some(&new), removed);
        assert!(earlier(&[]).is_empty());
        let mut found = earlier(&["out/detections.csv".to_owned()]);
        found.sort();
        assert_eq!(found, ours.map(|name| format!("out/chips/{name}")));
        fs::write(new.join(TABLE), "id,class\n1,tyre\n").unwrap();
        assert_eq!(earlier(&[]).len(), 3);
        // Chips of a version without subfolders belong to the table in the folder itself only.
        assert!(earlier_chips(&output, "", None, &[]).is_empty());
        assert_eq!(earlier_chips(&output, "", None, &[TABLE.to_owned()]).len(), 3);
    }
}
