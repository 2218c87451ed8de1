//! Reads label files in the usual formats: folders of YOLO labels, and COCO's JSON.
//!
//! In: files of labels. Out: boxes by picture.
//!
//! `yolo` and `coco` each read one format, [`pair`] brings true and predicted boxes of the same
//! picture together.

mod coco;
mod yolo;

use super::metrics::{Image, TrueBox};
use super::{Rect, Scored, TILE_PX};
use bathyscope_log::support::file_error::FileError;
use bathyscope_log::support::regular_file;
use std::collections::{BTreeMap, HashMap};
use std::fs;
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};

/// Error of label files that cannot be used, with the path.
pub type LabelError = FileError<LabelFault>;

/// Fault of label files, as a sentence without the path.
#[derive(Debug, thiserror::Error)]
pub enum LabelFault {
    /// The file could not be read from the disk.
    #[error("cannot read the labels: {0}")]
    NotRead(io::Error),
    /// The folder could not be listed.
    #[error("cannot list the folder of labels: {0}")]
    NotListed(io::Error),
    /// A file is longer than this limit, bytes.
    #[error("labels longer than {} MiB are not read", .0 >> 20)]
    TooLong(u64),
    /// The folder holds no labels.
    #[error(
        "no labels in the folder; name one that holds YOLO label files (*.txt) or a COCO file (*.json)"
    )]
    NoLabels,
    /// The folder holds several JSON files, and any of them may be the COCO file.
    #[error("several JSON files in the folder; name the one that holds the labels")]
    SeveralFiles,
    /// The labels have too many classes.
    #[error("{count} {named} are more than {MOST_CLASSES}")]
    TooManyClasses {
        /// Number of classes.
        count: usize,
        /// Word for classes in this format.
        named: &'static str,
    },
    /// The file is not JSON in COCO's format.
    #[error("cannot use the COCO file: {0}")]
    NotCoco(serde_json::Error),
    /// The file holds no true boxes, only predictions.
    #[error(
        "a list of results holds predictions; true boxes are in a COCO file with images, annotations and categories"
    )]
    OnlyResults,
    /// A line of a YOLO file is no valid box.
    #[error("cannot use line {line}: {what}")]
    Line {
        /// Number of the line, from 1.
        line: usize,
        /// The fault.
        what: String,
    },
    /// An annotation or a result of a COCO file is no valid box.
    #[error("cannot use the box {number} of the file: {what}")]
    Annotation {
        /// Number of the box in the file, from 1.
        number: usize,
        /// The fault.
        what: String,
    },
    /// The predictions are of other pictures than the true boxes.
    #[error(
        "no predictions have the name of a labelled picture; name the folders of the same pictures"
    )]
    OtherPictures,
}

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

/// Pictures with their true and predicted boxes, ready for [`crate::metrics`].
#[derive(Clone, Debug, PartialEq)]
pub struct Paired {
    /// Names of the pictures, one for each of `images`.
    pub names: Vec<String>,
    /// Boxes of each picture, in pixels.
    pub images: Vec<Image>,
    /// Name of each class; its number where no name is known.
    pub classes: Vec<String>,
    /// Notes for the analyst, in sentences.
    pub notes: Vec<String>,
}

/// Brings the true and the predicted boxes of each picture together. A picture that only one of the
/// two sets has gets no boxes from the other.
///
/// # Errors
/// When there are predicted boxes, but no picture is in both sets.
pub fn pair(truth: &LabelSet, predicted: &LabelSet) -> Result<Paired, LabelError> {
    let shared = |name: &&String| truth.pictures.contains_key(*name);
    if predicted.boxes() > 0 && !predicted.pictures.keys().any(|name| shared(&name)) {
        return Err(LabelError::new(LabelFault::OtherPictures, &predicted.path));
    }
    let mut notes = Vec::new();
    let alone: Vec<&String> = predicted.pictures.keys().filter(|name| !shared(name)).collect();
    if let [first, ..] = &alone[..] {
        notes.push(format!(
            "{} predicted pictures have no truth and count as empty, the first of them {first}",
            alone.len()
        ));
    }
    let mut names: Vec<String> = truth.pictures.keys().chain(alone).cloned().collect();
    names.sort();
    let (mut images, mut unsized_pictures) = (Vec::with_capacity(names.len()), 0);
    for name in &names {
        let pictures = [truth.pictures.get(name), predicted.pictures.get(name)];
        let size_px = pictures.iter().flatten().find_map(|picture| picture.size_px);
        unsized_pictures += usize::from(size_px.is_none());
        images.push(image(truth, predicted, pictures, size_px));
    }
    if unsized_pictures > 0 && truth.format == LabelFormat::Yolo {
        notes.push(format!(
            "{unsized_pictures} pictures lie beside no labels; sizes count in pictures of {TILE_PX} x {TILE_PX} pixels"
        ));
    }
    Ok(Paired { classes: classes(truth, predicted), names, images, notes })
}

fn image(
    truth: &LabelSet,
    predicted: &LabelSet,
    pictures: [Option<&PictureLabels>; 2],
    size_px: Option<[u32; 2]>,
) -> Image {
    let size_px = size_px.unwrap_or([TILE_PX as u32; 2]);
    let [true_ones, proposed] =
        pictures.map(|picture| picture.into_iter().flat_map(|picture| &picture.labels));
    Image {
        truth: true_ones
            .map(|label| TrueBox {
                class: label.class,
                rect: pixels(label.rect, truth.format, size_px),
                ignored: label.ignored,
            })
            .collect(),
        predicted: proposed
            .map(|label| {
                let rect = pixels(label.rect, predicted.format, size_px);
                Scored::new(label.class, label.score.unwrap_or(0.0), rect)
            })
            .collect(),
    }
}

fn pixels(rect: Rect, format: LabelFormat, [width, height]: [u32; 2]) -> Rect {
    let (width, height) = match format {
        LabelFormat::Yolo => (width as f32, height as f32),
        LabelFormat::Coco => (1.0, 1.0),
    };
    Rect::new([rect.x0 * width, rect.y0 * height], [rect.x1 * width, rect.y1 * height])
}

/// Returns a name for every class that has a name or a box.
fn classes(truth: &LabelSet, predicted: &LabelSet) -> Vec<String> {
    let names = if truth.names.is_empty() { &predicted.names } else { &truth.names };
    let used = [truth, predicted]
        .into_iter()
        .flat_map(|set| set.pictures.values())
        .flat_map(|picture| &picture.labels)
        .map(|label| label.class + 1)
        .max();
    let count = names.len().max(used.unwrap_or(0));
    (0..count).map(|class| names.get(class).cloned().unwrap_or_else(|| class.to_string())).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Creates a folder with files of these names and texts.
    fn folder(files: &[(&str, &str)]) -> tempfile::TempDir {
        let folder = tempfile::tempdir().expect("a temporary folder");
        for (name, text) in files {
            let path = folder.path().join(name);
            fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
            fs::write(path, text).expect("a file");
        }
        folder
    }

    const COCO: &str = r#"{
  "info": {"year": 2026},
  "images": [{"id": 7, "file_name": "a.png", "width": 200, "height": 100}, {"id": 9, "file_name": "b.png", "width": 200, "height": 100}],
  "annotations": [{"id": 1, "image_id": 7, "category_id": 5, "bbox": [20, 10, 40, 20], "area": 800, "iscrowd": 0},
                  {"id": 2, "image_id": 9, "category_id": 2, "bbox": [0, 0, 100, 100], "area": 10000, "iscrowd": 1}],
  "categories": [{"id": 5, "name": "tyre"}, {"id": 2, "name": "rock"}]
}"#;

    const RESULTS: &str =
        r#"[{"image_id": 7, "category_id": 5, "bbox": [20, 10, 40, 20], "score": 0.75}]"#;

    fn refusal(files: &[(&str, &str)]) -> String {
        let folder = folder(files);
        let truth = read_truth(&folder.path().join("truth"));
        let error = truth
            .and_then(|truth| {
                let predicted = read_predicted(&folder.path().join("predicted"), &truth)?;
                pair(&truth, &predicted)
            })
            .expect_err("unusable labels");
        let path = error.path.strip_prefix(folder.path());
        let path = path.expect("a path in the folder").display().to_string();
        format!("{}: {path}", error.what)
    }

    #[test]
    fn both_formats_give_the_same_boxes() {
        let folder = folder(&[
            ("yolo/labels/a.txt", "1 0.2 0.2 0.2 0.2\n\n"),
            ("yolo/labels/b.txt", ""),
            ("yolo/classes.txt", "rock\ntyre\n"),
            ("predicted/a.txt", "1 0.2 0.2 0.2 0.2 0.75\n"),
            ("coco/truth.json", COCO),
            ("results.json", RESULTS),
        ]);
        let at = |name: &str| folder.path().join(name);
        let coco = read_truth(&at("coco")).expect("the data set");
        assert_eq!(coco.names, ["rock", "tyre"]);
        let yolo = read_truth(&at("yolo")).expect("the labels");
        assert_eq!(yolo.names, coco.names);
        let results = read_predicted(&at("results.json"), &coco).expect("the results");
        let texts = read_predicted(&at("predicted"), &coco).expect("the labels");
        let expected = Rect::new([20.0, 10.0], [60.0, 30.0]);
        for predicted in [&results, &texts] {
            let paired = pair(&coco, predicted).expect("the same pictures");
            assert_eq!(paired.names, ["a", "b"]);
            assert_eq!(paired.classes, ["rock", "tyre"]);
            assert_eq!(paired.notes, [""; 0]);
            let [a, b] = &paired.images[..] else { panic!("{paired:?}") };
            assert_eq!((a.truth[0].class, a.truth[0].rect), (1, expected));
            assert!(b.truth[0].ignored && b.predicted.is_empty());
            let [x0, x1] = [a.predicted[0].rect.x0, a.predicted[0].rect.x1];
            assert!((x0 - 20.0).abs() < 1e-4 && (x1 - 60.0).abs() < 1e-4);
            assert_eq!((a.predicted[0].class, a.predicted[0].score), (1, 0.75));
        }
        // There are no pictures beside the labels: one note is about their unknown size.
        let paired = pair(&yolo, &texts).expect("the same pictures");
        assert!((paired.images[0].truth[0].rect.x0 - 0.1 * 416.0).abs() < 1e-3);
        assert_eq!(paired.notes.len(), 1);
    }

    #[test]
    fn a_picture_next_to_its_labels_gives_its_size() {
        let folder = folder(&[("set/labels/a.txt", "0 0.5 0.5 0.5 0.5\n")]);
        let images = folder.path().join("set/images");
        fs::create_dir(&images).expect("a folder");
        let picture = image::GrayImage::new(64, 32);
        picture.save(images.join("a.png")).expect("a picture");
        let truth = read_truth(&folder.path().join("set/labels")).expect("the labels");
        assert_eq!(truth.pictures["a"].size_px, Some([64, 32]));
    }

    #[test]
    fn unusable_labels_are_refused_with_their_place() {
        let good = ("truth/a.txt", "0 0.5 0.5 0.1 0.1");
        let cases: [(&[(&str, &str)], &str); 10] = [
            (
                &[("truth/a.png", "")],
                "no labels in the folder; name one that holds YOLO label files (*.txt) or a COCO file (*.json): truth",
            ),
            (
                &[("truth/a.txt", "\n0 0.5 x 0.1 0.1")],
                "cannot use line 2: `x` is no number: truth/a.txt",
            ),
            (
                &[("truth/a.txt", "0 0.5 0.5 0.1 0.1 0.9")],
                "cannot use line 1: a true box has no sixth number (these may be predictions): class cx cy w h: truth/a.txt",
            ),
            (
                &[("truth/a.txt", "0 12 40 8 8")],
                "cannot use line 1: centre and size are shares of the picture, from 0 to 1: truth/a.txt",
            ),
            (
                &[("truth/a.txt", "99999999999 0.5 0.5 0.1 0.1")],
                "cannot use line 1: `99999999999` is no class (a whole number from 0, below 1000): truth/a.txt",
            ),
            (
                &[good, ("predicted/a.txt", "0 0.5 0.5 0.1 0.1")],
                "cannot use line 1: a predicted box needs a score: class cx cy w h score: predicted/a.txt",
            ),
            (
                &[good, ("predicted/a.txt", "0 0.5 0.5 0.1 0.1 7")],
                "cannot use line 1: the score `7` is not within 0 to 1: predicted/a.txt",
            ),
            (
                &[good, ("predicted/z.txt", "0 0.5 0.5 0.1 0.1 0.7")],
                "no predictions have the name of a labelled picture; name the folders of the same pictures: predicted",
            ),
            (
                &[
                    ("truth/t.json", COCO),
                    (
                        "predicted/p.json",
                        r#"[{"image_id": 8, "category_id": 5, "bbox": [0, 0, 1, 1], "score": 1}]"#,
                    ),
                ],
                "cannot use the box 1 of the file: there is no picture 8: predicted/p.json",
            ),
            (
                &[("truth/t.json", "{\"images\": [],\n \"annotations\": 3}")],
                "cannot use the COCO file: invalid type: integer `3`, expected a sequence at line 2 column 17: truth/t.json",
            ),
        ];
        for (files, sentence) in cases {
            assert_eq!(refusal(files), sentence);
        }
    }
}
