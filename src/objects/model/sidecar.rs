//! `MODEL.json` beside `MODEL.onnx`: what the ONNX file does not state. Every entry may be missing;
//! entries that are not named here (how a model was trained) are left alone.

use super::Unusable;
use super::calibration::ConfidenceCalibration;
use crate::OverlapMeasure;
use serde::Deserialize;

/// Entries of the file.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct Sidecar {
    /// Layout of the outputs.
    pub family: Option<FamilyName>,
    /// Class names, in the network's order.
    pub names: Option<Vec<String>>,
    /// Preparation of a picture as input.
    pub input: InputEntry,
    /// Interpretation of the outputs.
    pub outputs: OutputEntry,
    /// Side of a pixel that the network was trained on, metres.
    pub pixel_m: Option<f64>,
    /// Levelling of tiles before the search.
    pub level: Option<LevelEntry>,
    /// Second evaluation of a picture that seems to show something.
    pub test_time_augmentation: Option<Augmentation>,
    /// Anchors of raw heads, one entry a head.
    pub heads: Vec<HeadEntry>,
    /// Thresholds for boxes.
    pub thresholds: ThresholdEntry,
    /// Points of confidence and share of right boxes (see the module `calibration`).
    pub calibration: Option<Vec<[f32; 2]>>,
}

/// Layout of the outputs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum FamilyName {
    /// Decoded boxes beside scores.
    Yolov4,
    /// Heads as the last convolution leaves them.
    #[serde(alias = "raw")]
    RawHeads,
    /// Rows of 5 + classes.
    #[serde(alias = "yolov7")]
    Yolov5,
    /// Columns of 4 + classes.
    #[serde(alias = "yolov9", alias = "yolov11", alias = "yolo11", alias = "yolov12")]
    Yolov8,
    /// Rows of 6, already suppressed.
    #[serde(alias = "yolov10", alias = "yolo26")]
    EndToEnd,
    /// Rows of 5 + classes in units of grid cells.
    Yolox,
}

/// Preparation of a picture as input.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct InputEntry {
    /// Needed where the file leaves it open.
    pub width: Option<usize>,
    /// Needed where the file leaves it open.
    pub height: Option<usize>,
    /// Order of the colours.
    pub colour: Option<Colour>,
    /// Factor from levels of 0 to 255.
    pub scale: Option<f32>,
    /// Taken off after scaling, a number a channel.
    pub mean: Option<Vec<f32>>,
    /// Divided by after that, a number a channel.
    pub std: Option<Vec<f32>>,
    /// Method to bring a picture to the input's size.
    pub resize: Option<Resize>,
}

/// Order of the colours in an input of three channels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Colour {
    /// Red first.
    Rgb,
    /// Blue first.
    Bgr,
    /// The same grey in all channels.
    #[serde(alias = "gray")]
    Grey,
}

/// Method to bring a picture to the input's size.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Resize {
    /// Stretched across and down separately.
    Stretch,
    /// Scaled in proportion, centred between bars of grey 114.
    Letterbox,
    /// Scaled in proportion, at the top left, with bars right and below.
    LetterboxTopLeft,
}

/// Interpretation of the outputs.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct OutputEntry {
    /// Words that hold `pixel` or `fraction`: the unit of YOLOv4's boxes. Without them a first run
    /// shows it.
    pub coordinates: Option<String>,
}

/// Levelling of tiles before the search.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum LevelEntry {
    /// Levelled by [`crate::level`].
    Auto,
    /// Left as recorded.
    Raw,
}

/// Kind of second evaluation of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Augmentation {
    /// Mirrored along the track (see the module `test_time_augmentation`).
    Mirrored,
}

/// The anchors of one raw head.
#[derive(Clone, Debug, Deserialize)]
pub(super) struct HeadEntry {
    /// Pixels of the input to a grid cell, which distinguishes the heads.
    pub stride: usize,
    /// Width and height, pixels of the input.
    pub anchors: Vec<[f32; 2]>,
    /// Darknet's `scale_x_y`.
    #[serde(default = "one")]
    pub scale_x_y: f32,
    /// Darknet's `new_coords`.
    #[serde(default)]
    pub new_coords: bool,
    /// True if the logistic function has been applied already.
    #[serde(default)]
    pub activated: bool,
}

fn one() -> f32 {
    1.0
}

/// Thresholds for boxes.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct ThresholdEntry {
    /// Least confidence, 0 to 1.
    pub score: Option<f32>,
    /// Overlap above which the box of the lower score is dropped, 0 to 1.
    pub iou: Option<f32>,
    /// Confidence from which a box is named, 0 to 1; without it every box is.
    pub name: Option<f32>,
    /// Measure of overlap.
    pub nms: Option<NmsEntry>,
    /// True if boxes of different classes drop each other.
    pub class_agnostic: Option<bool>,
    /// Overlap above which the boxes of its class move a kept box to their mean, 0 to 1; without it
    /// a box stays as it is.
    pub vote: Option<f32>,
}

/// Measure of overlap.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum NmsEntry {
    /// Intersection over union.
    Plain,
    /// Less the distance of the centres.
    Darknet,
}

impl From<NmsEntry> for OverlapMeasure {
    fn from(entry: NmsEntry) -> Self {
        match entry {
            NmsEntry::Plain => OverlapMeasure::Plain,
            NmsEntry::Darknet => OverlapMeasure::Darknet,
        }
    }
}

impl Sidecar {
    /// Reads the file's text.
    ///
    /// # Errors
    /// Why the model cannot be used.
    pub(super) fn parse(text: &str) -> Result<Self, Unusable> {
        let sidecar: Self =
            serde_json::from_str(text).map_err(|error| Unusable::Sidecar(error.to_string()))?;
        sidecar.check()?;
        Ok(sidecar)
    }

    /// Returns the calibration of the network's confidences; `None` where the file states none, or
    /// one that is no rising map.
    pub(super) fn calibration(&self) -> Option<ConfidenceCalibration> {
        ConfidenceCalibration::new(self.calibration.as_deref()?)
    }

    fn check(&self) -> Result<(), Unusable> {
        let wrong = |text: &str| Err(Unusable::Sidecar(text.to_owned()));
        let share = |value: Option<f32>| value.is_none_or(|share| (0.0..=1.0).contains(&share));
        let ThresholdEntry { score, iou, name, vote, .. } = self.thresholds;
        if ![score, iou, name, vote].into_iter().all(share) {
            return wrong(
                "thresholds.score, thresholds.iou, thresholds.name and thresholds.vote lie between 0 and 1",
            );
        }
        if self.pixel_m.is_some_and(|pixel_m| !(0.005..=1.0).contains(&pixel_m)) {
            return wrong("pixel_m lies between 0.005 and 1 m");
        }
        let anchors = self.heads.iter().flat_map(|head| &head.anchors).flatten();
        if self.heads.iter().any(|head| head.stride == 0)
            || anchors.copied().any(|size| size <= 0.0)
        {
            return wrong("a head's stride and its anchors are above 0");
        }
        if self.calibration.is_some() && self.calibration().is_none() {
            return wrong("calibration holds points that rise from 0 to a confidence of 1");
        }
        if self.names.as_ref().is_some_and(Vec::is_empty) {
            return wrong("names holds no name");
        }
        Ok(())
    }
}
