//! Reads label files in the usual formats: folders of YOLO labels, and COCO's JSON.
//!
//! In: files of labels. Out: boxes by picture.
//!
//! `yolo` and `coco` each read one format, `pairing` brings true and predicted boxes of the same
//! picture together.

mod coco;
mod error;
mod pairing;
#[cfg(test)]
mod tests;
mod yolo;

pub use error::{LabelError, LabelFault};
pub use pairing::{Paired, pair};

use super::Rect;
use bathyscope_log::support::regular_file;
use std::collections::{BTreeMap, HashMap};
use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

/// Format of labels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LabelFormat {
    /// One text file a picture, one line a box: `class cx cy w h`, followed by `score` in
    /// predictions; coordinates are shares of the picture's width and height.
    Yolo,
    /// One JSON file: `images`, `annotations`, `categories`, or a list of results; coordinates in
    /// pixels.
    Coco,
}

impl LabelFormat {
    /// Returns the usual name of the format.
    pub fn name(self) -> &'static str {
        match self {
            LabelFormat::Yolo => "YOLO labels",
            LabelFormat::Coco => "COCO JSON",
        }
    }
}

/// One labelled box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Label {
    /// Index into the class names.
    pub class: usize,
    /// Score, 0 to 1; `None` for a true box.
    pub score: Option<f32>,
    /// True if the box counts neither as found nor as missed (COCO's `iscrowd`).
    pub ignored: bool,
    /// Box, in shares of the picture in [`LabelFormat::Yolo`] and in pixels in
    /// [`LabelFormat::Coco`].
    pub rect: Rect,
}

/// The labels of one picture.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PictureLabels {
    /// Width and height of the picture, pixels; `None` where unknown.
    pub size_px: Option<[u32; 2]>,
    /// Boxes of the picture.
    pub labels: Vec<Label>,
}

/// Labels of many pictures.
#[derive(Clone, Debug, PartialEq)]
pub struct LabelSet {
    /// Format of the labels.
    pub format: LabelFormat,
    /// File or folder that the labels were read from.
    pub path: PathBuf,
    /// Names of the classes; empty, or shorter than the number of classes, where unknown.
    pub names: Vec<String>,
    /// Labels of each picture, by the picture's name without its ending.
    pub pictures: BTreeMap<String, PictureLabels>,
    /// Index of the class of each COCO category number.
    categories: HashMap<u64, usize>,
    /// Name of the picture of each COCO image number, and of each name.
    numbers: HashMap<String, String>,
}

impl LabelSet {
    fn empty(format: LabelFormat, path: &Path) -> Self {
        Self {
            format,
            path: path.to_owned(),
            names: Vec::new(),
            pictures: BTreeMap::new(),
            categories: HashMap::new(),
            numbers: HashMap::new(),
        }
    }

    /// Returns the number of boxes in all pictures.
    pub fn boxes(&self) -> usize {
        self.pictures.values().map(|picture| picture.labels.len()).sum()
    }
}

/// Greatest number of classes: more than any detector of this kind has; a greater class number
/// means a damaged line.
pub(crate) const MOST_CLASSES: usize = 1000;

/// Reads true boxes from a folder of YOLO labels, a COCO file, or a folder that holds one.
///
/// # Errors
/// When there are no labels at `path`, or one of the files cannot be read or is faulty.
pub fn read_truth(path: &Path) -> Result<LabelSet, LabelError> {
    match find(path)? {
        Found::Texts(folder, texts) => yolo::read(&folder, &texts, false),
        Found::Json(file) => coco::read_truth(&file),
    }
}

/// Reads predicted boxes. COCO's list of results needs the picture numbers and categories of
/// `truth`.
///
/// # Errors
/// When there are no labels at `path`, or one of the files cannot be read or is faulty.
pub fn read_predicted(path: &Path, truth: &LabelSet) -> Result<LabelSet, LabelError> {
    match find(path)? {
        Found::Texts(folder, texts) => yolo::read(&folder, &texts, true),
        Found::Json(file) => coco::read_predicted(&file, truth),
    }
}

enum Found {
    Texts(PathBuf, Vec<PathBuf>),
    Json(PathBuf),
}

/// Finds the labels at a path: the file itself; or, in a folder, its label texts, its only JSON
/// file, or the texts in its `labels` folder.
fn find(path: &Path) -> Result<Found, LabelError> {
    if !path.is_dir() {
        return Ok(Found::Json(path.to_owned()));
    }
    let listed = |folder: &Path, ending: &str| -> Result<Vec<PathBuf>, LabelError> {
        let entries = fs::read_dir(folder)
            .map_err(|error| LabelError::new(LabelFault::NotListed(error), folder))?;
        let mut files: Vec<PathBuf> = entries
            .flatten()
            .map(|entry| entry.path())
            .filter(|file| file.extension().is_some_and(|is| is == ending))
            .collect();
        files.sort();
        Ok(files)
    };
    let texts = listed(path, "txt")?;
    if texts.iter().any(|file| !yolo::is_names(file)) {
        return Ok(Found::Texts(path.to_owned(), texts));
    }
    let jsons = listed(path, "json")?;
    if let [file] = &jsons[..] {
        return Ok(Found::Json(file.clone()));
    }
    let below = path.join("labels");
    if below.is_dir() {
        let texts = listed(&below, "txt")?;
        return Ok(Found::Texts(below, texts));
    }
    let what = match jsons.len() {
        0 => LabelFault::NoLabels,
        _ => LabelFault::SeveralFiles,
    };
    Err(LabelError::new(what, path))
}

/// Reads the text of a file of at most `longest` bytes.
fn text(path: &Path, longest: u64) -> Result<String, LabelError> {
    regular_file::read_text(path, longest).map_err(|error| {
        let what = match error.kind() {
            ErrorKind::FileTooLarge => LabelFault::TooLong(longest),
            _ => LabelFault::NotRead(error),
        };
        LabelError::new(what, path)
    })
}
