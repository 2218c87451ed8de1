//! Writes the folder of pictures and labels that a detector is trained on
//! (`assets/detector/training/data.py` reads it).

use super::{ExportError, write_bytes};
use bathyscope_objects::dataset::{Chip, Coco, PictureBoxes, voc_xml, yolo_lines};
use serde::Serialize;
use std::fs;
use std::path::{Path, PathBuf};

/// A part of a dataset. No recording, real or simulated, is in two parts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum DatasetPart {
    /// Pictures to train on.
    Train,
    /// Pictures to choose settings on.
    Val,
    /// Pictures to measure figures on.
    Test,
}

bathyscope_log::named! {
    /// All parts, in the order of a split.
    pub DatasetPart {
        Train: "train",
        Val: "val",
        Test: "test",
    }
}

/// Content of a part, for the manifest.
#[derive(Clone, Debug, Serialize)]
pub struct PartSummary {
    /// Name of the part: `train`, `val` or `test`.
    pub name: &'static str,
    /// Number of pictures.
    pub images: usize,
    /// Number of pictures without an object to find.
    pub images_without_boxes: usize,
    /// Number of boxes to find, by class.
    pub labels: std::collections::BTreeMap<String, usize>,
    /// Number of boxes that are ignored.
    pub ignored: usize,
}

/// A folder `images/PART/NNNNNN.png` with `labels/PART/NNNNNN.txt` (YOLO), `PART.json` (COCO),
/// `classes.txt` and `manifest.json`.
#[derive(Clone, Debug)]
pub struct DatasetFolder {
    root: PathBuf,
    classes: Vec<String>,
}

impl DatasetFolder {
    /// Makes the folders and writes the class names.
    pub fn new(root: &Path, classes: &[String]) -> Result<Self, ExportError> {
        let folder = Self { root: root.to_owned(), classes: classes.to_vec() };
        for kind in ["images", "labels"] {
            for part in DatasetPart::ALL {
                make(&root.join(kind).join(part.name()))?;
            }
        }
        folder.file("classes.txt", classes.join("\n") + "\n")?;
        Ok(folder)
    }

    /// Writes a picture and its YOLO labels.
    pub fn chip(&self, part: DatasetPart, number: usize, chip: &Chip) -> Result<(), ExportError> {
        let png = format!("images/{}/{}", part.name(), picture(number));
        self.file(&png, chip.png())?;
        let labels = format!("labels/{}/{number:06}.txt", part.name());
        self.file(&labels, yolo_lines(&chip.boxes.labels))
    }

    /// Writes a picture's labels as Pascal VOC, in `voc/PART`.
    pub fn voc(
        &self,
        part: DatasetPart,
        number: usize,
        boxes: &PictureBoxes,
    ) -> Result<(), ExportError> {
        make(&self.root.join("voc").join(part.name()))?;
        let text = voc_xml(&picture(number), &self.classes, boxes);
        self.file(&format!("voc/{}/{number:06}.xml", part.name()), text)
    }

    /// Writes the COCO file of a part, with pictures numbered from 0; returns the content of the
    /// part.
    pub fn finish(
        &self,
        part: DatasetPart,
        pictures: &[PictureBoxes],
    ) -> Result<PartSummary, ExportError> {
        let mut coco = Coco::new(self.classes.iter().map(String::as_str));
        for (number, boxes) in pictures.iter().enumerate() {
            coco.add(picture(number), boxes);
        }
        self.json(&format!("{}.json", part.name()), &coco)?;
        let mut labels: std::collections::BTreeMap<String, usize> =
            self.classes.iter().map(|name| (name.clone(), 0)).collect();
        for label in pictures.iter().flat_map(|boxes| &boxes.labels) {
            if let Some(name) = self.classes.get(label.class) {
                *labels.entry(name.clone()).or_default() += 1;
            }
        }
        let is_empty = |boxes: &&PictureBoxes| boxes.labels.is_empty();
        Ok(PartSummary {
            name: part.name(),
            images: pictures.len(),
            images_without_boxes: pictures.iter().filter(is_empty).count(),
            labels,
            ignored: pictures.iter().map(|boxes| boxes.ignored.len()).sum(),
        })
    }

    /// Writes the record of how the dataset was made.
    pub fn manifest(&self, manifest: &impl Serialize) -> Result<(), ExportError> {
        self.json("manifest.json", manifest)
    }

    fn json(&self, name: &str, value: &impl Serialize) -> Result<(), ExportError> {
        let text = serde_json::to_vec(value)
            .map_err(|error| ExportError::at(&self.root.join(name))(error.into()))?;
        self.file(name, text)
    }

    fn file(&self, name: &str, content: impl AsRef<[u8]>) -> Result<(), ExportError> {
        write_bytes(&self.root.join(name), content)
    }
}

fn picture(number: usize) -> String {
    format!("{number:06}.png")
}

fn make(folder: &Path) -> Result<(), ExportError> {
    fs::create_dir_all(folder).map_err(ExportError::at(folder))
}
