//! Reads `MODEL.json` beside `MODEL.onnx`, which states what the ONNX file does not, and the
//! metadata inside the ONNX file, which states some of the same. Every entry may be missing; other
//! entries of the file (how a model was trained) are ignored.

use super::Unusable;
use crate::OverlapMeasure;
use crate::decode::HeadEntry;
use serde::Deserialize;
use std::collections::HashMap;

/// Entries of the sidecar file.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct Sidecar {
    /// Layout of the outputs.
    pub family: Option<FamilyName>,
    /// Class names, in the network's order.
    pub names: Option<Vec<String>>,
    /// Preparation of a picture for the input.
    pub input: InputEntry,
    /// Interpretation of the outputs.
    pub outputs: OutputEntry,
    /// Side of a pixel that the network was trained on, metres.
    pub pixel_m: Option<f64>,
    /// Adjustment of the grey levels of tiles before the search.
    pub level: Option<LevelEntry>,
    /// Second search of a picture that seems to show an object; `None` for a single search.
    pub test_time_augmentation: Option<Augmentation>,
    /// Anchors of raw heads, one entry a head.
    pub heads: Vec<HeadEntry>,
    /// Thresholds for boxes.
    pub thresholds: ThresholdEntry,
    /// Points of confidence and share of right boxes (see [`ConfidenceCalibration`]).
    pub calibration: Option<Vec<[f32; 2]>>,
}

/// Layout of the outputs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum FamilyName {
    /// Decoded boxes in one output, scores in another.
    Yolov4,
    /// Outputs of the last convolutions, not decoded.
    #[serde(alias = "raw")]
    RawHeads,
    /// Rows of 5 + classes numbers.
    #[serde(alias = "yolov7")]
    Yolov5,
    /// Columns of 4 + classes numbers.
    #[serde(alias = "yolov9", alias = "yolov11", alias = "yolo11", alias = "yolov12")]
    Yolov8,
    /// Rows of 6 numbers, with overlapping boxes already suppressed.
    #[serde(alias = "yolov10", alias = "yolo26")]
    EndToEnd,
    /// Rows of 5 + classes numbers, in units of grid cells.
    Yolox,
}

/// Preparation of a picture for the input.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct InputEntry {
    /// Width of the input, pixels; needed if the ONNX file leaves it open.
    pub width: Option<usize>,
    /// Height of the input, pixels; needed if the ONNX file leaves it open.
    pub height: Option<usize>,
    /// Order of the colours.
    pub colour: Option<Colour>,
    /// Factor from levels of 0 to 255.
    pub scale: Option<f32>,
    /// Number that is subtracted after scaling, for all channels or for each.
    pub mean: Option<Vec<f32>>,
    /// Number by which the result is then divided, for all channels or for each.
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
    /// The picture is stretched across and down separately.
    Stretch,
    /// The picture is scaled in proportion and centred between bars of grey 114.
    Letterbox,
    /// The picture is scaled in proportion and placed at the top left, with bars on the right and
    /// below.
    LetterboxTopLeft,
}

/// Interpretation of the outputs.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct OutputEntry {
    /// Text that contains `pixel` or `fraction`, the unit of YOLOv4's boxes. Without it, the unit
    /// is determined from a first run.
    pub coordinates: Option<String>,
}

/// Adjustment of the grey levels of tiles before the search.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum LevelEntry {
    /// Levels are adjusted by [`crate::picture`].
    Auto,
    /// Levels are left as recorded.
    Raw,
}

/// Kind of the second search of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Augmentation {
    /// The picture is mirrored along the track (see [`super::agree`]).
    Mirrored,
}

/// Thresholds for boxes.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct ThresholdEntry {
    /// Least confidence, 0 to 1.
    pub score: Option<f32>,
    /// Overlap above which the box of the lower score is dropped, 0 to 1.
    pub iou: Option<f32>,
    /// Least confidence of a box that keeps its class, 0 to 1; if `None`, every box keeps it.
    pub name: Option<f32>,
    /// Measure of overlap.
    pub nms: Option<OverlapMeasure>,
    /// True if boxes of different classes drop each other.
    pub class_agnostic: Option<bool>,
    /// Overlap above which the boxes of its class move a kept box to their mean, 0 to 1; if `None`,
    /// boxes are not moved.
    pub vote: Option<f32>,
}

impl Sidecar {
    /// Reads the text of the sidecar file.
    ///
    /// # Errors
    /// When the text is no JSON of these entries, or an entry has an impossible value.
    pub(super) fn parse(text: &str) -> Result<Self, Unusable> {
        let sidecar: Self =
            serde_json::from_str(text).map_err(|error| Unusable::Sidecar(error.to_string()))?;
        sidecar.check()?;
        Ok(sidecar)
    }

    /// Returns the calibration of the network's confidences; `None` if the file states none, or one
    /// that is no rising map.
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

/// A rising map of confidences, 0 to 1 on both sides. Without points, it leaves confidences
/// unchanged.
///
/// A network's confidence ranks its boxes, but the share of right boxes at a confidence of 0.8, for
/// example, depends on the training data. A sidecar file may hold points that map the confidence to
/// the share of right boxes on chips that were not used in the training; between two points the map
/// is linear.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct ConfidenceCalibration {
    /// Pairs of the network's confidence and the calibrated one, both rising, from `[0, 0]` on.
    points: Vec<[f32; 2]>,
}

impl ConfidenceCalibration {
    /// Creates the map from its points. `None` unless both numbers rise from point to point between
    /// 0 and 1, with a confidence of 1 at the end: only then does each confidence have one
    /// counterpart.
    pub(super) fn new(points: &[[f32; 2]]) -> Option<Self> {
        let mut all = vec![[0.0, 0.0]];
        all.extend(points.iter().filter(|&&point| point != [0.0, 0.0]));
        let rises = all.windows(2).all(|pair| pair[0][0] < pair[1][0] && pair[0][1] < pair[1][1]);
        let [last, highest] = all[all.len() - 1];
        (rises && last == 1.0 && highest <= 1.0).then_some(Self { points: all })
    }

    /// Converts a confidence of the network to the calibrated one.
    pub(super) fn calibrated(&self, confidence: f32) -> f32 {
        self.mapped(confidence, [0, 1])
    }

    /// Converts a calibrated confidence to that of the network; above 1 if no confidence of the
    /// network is mapped to it.
    pub(super) fn confidence(&self, calibrated: f32) -> f32 {
        match self.points.last() {
            Some(&[_, highest]) if calibrated > highest => 1.0 + calibrated - highest,
            _ => self.mapped(calibrated, [1, 0]),
        }
    }

    fn mapped(&self, value: f32, [from, to]: [usize; 2]) -> f32 {
        let above = self.points.partition_point(|point| point[from] < value);
        match (above.checked_sub(1), self.points.get(above)) {
            (Some(below), Some(high)) => {
                let low = self.points[below];
                let share = (value - low[from]) / (high[from] - low[from]);
                low[to] + share * (high[to] - low[to])
            }
            // The value is 0 or below, or above the last point.
            (None, Some(first)) => first[to].min(value),
            (Some(below), None) => self.points[below][to],
            (None, None) => value,
        }
    }
}

/// Metadata that Ultralytics' exporter writes into the ONNX file: key-value pairs, whose values are
/// Python literals and are read leniently.
#[derive(Clone, Debug, Default)]
pub(super) struct Metadata(pub HashMap<String, String>);

impl Metadata {
    /// Returns the class names from `{0: 'rock', 1: "it's"}` or `['rock', 'tyre']`; `None` if there
    /// are none.
    pub(super) fn names(&self) -> Option<Vec<String>> {
        let mut names = quoted(self.0.get("names")?);
        // JSON dictionaries have their keys in quotes as well.
        if names.len().is_multiple_of(2) && names.iter().step_by(2).all(|key| is_number(key)) {
            names = names.into_iter().skip(1).step_by(2).collect();
        }
        (!names.is_empty()).then_some(names)
    }

    /// Returns height and width from `[640, 640]`.
    pub(super) fn image_size(&self) -> Option<[usize; 2]> {
        let numbers: Vec<usize> = self
            .0
            .get("imgsz")?
            .split(|letter: char| !letter.is_ascii_digit())
            .filter_map(|digits| digits.parse().ok())
            .collect();
        match numbers[..] {
            [size] => Some([size, size]),
            [height, width] => Some([height, width]),
            _ => None,
        }
    }

    /// Returns true if the network suppresses overlapping boxes itself.
    pub(super) fn end_to_end(&self) -> bool {
        ["end2end", "nms"]
            .iter()
            .filter_map(|key| self.0.get(*key))
            .any(|value| value.eq_ignore_ascii_case("true"))
    }

    /// Returns the task that the network was trained for, if it is another than detection.
    pub(super) fn other_task(&self) -> Option<&str> {
        let task = self.0.get("task")?.as_str();
        (task != "detect").then_some(task)
    }
}

fn is_number(text: &str) -> bool {
    !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit())
}

/// Returns the strings of a Python literal, in either kind of quotes; a backslash escapes the next
/// letter.
fn quoted(text: &str) -> Vec<String> {
    let mut found = Vec::new();
    let mut open: Option<(char, String)> = None;
    let mut letters = text.chars();
    while let Some(letter) = letters.next() {
        match &mut open {
            None if letter == '\'' || letter == '"' => open = Some((letter, String::new())),
            None => {}
            Some((quote, name)) if letter == *quote => {
                found.push(std::mem::take(name));
                open = None;
            }
            Some((_, name)) if letter == '\\' => name.extend(letters.next()),
            Some((_, name)) => name.push(letter),
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bent() -> ConfidenceCalibration {
        ConfidenceCalibration::new(&[[0.2, 0.1], [0.6, 0.8], [1.0, 0.95]]).expect("a rising map")
    }

    fn names(text: &str) -> Option<Vec<String>> {
        Metadata(HashMap::from([("names".to_owned(), text.to_owned())])).names()
    }

    #[test]
    fn confidences_are_mapped_straight_between_points_and_back() {
        let map = bent();
        for (confidence, calibrated) in
            [(0.0, 0.0), (0.1, 0.05), (0.2, 0.1), (0.4, 0.45), (0.8, 0.875), (1.0, 0.95)]
        {
            assert!((map.calibrated(confidence) - calibrated).abs() < 1e-6);
            assert!((map.confidence(calibrated) - confidence).abs() < 1e-6);
        }
        // No box has a calibrated confidence of 0.97.
        assert!(map.confidence(0.97) > 1.0);
    }

    #[test]
    fn without_points_confidences_stay() {
        for value in [0.0, 0.3, 1.0] {
            let map = ConfidenceCalibration::default();
            assert_eq!([map.calibrated(value), map.confidence(value)], [value; 2]);
        }
    }

    #[test]
    fn what_does_not_rise_to_the_end_is_no_map() {
        let refused: [&[[f32; 2]]; 6] = [
            &[],
            &[[0.5, 0.5]],
            &[[0.5, 0.5], [0.4, 0.6], [1.0, 1.0]],
            &[[0.5, 0.5], [0.7, 0.5], [1.0, 1.0]],
            &[[0.5, 0.5], [1.0, 1.1]],
            &[[0.5, f32::NAN], [1.0, 1.0]],
        ];
        for points in refused {
            assert_eq!(ConfidenceCalibration::new(points), None, "{points:?}");
        }
        assert!(ConfidenceCalibration::new(&[[0.0, 0.0], [1.0, 1.0]]).is_some());
    }

    #[test]
    fn names_are_read_from_what_python_prints() {
        let two = |a: &str, b: &str| Some(vec![a.to_owned(), b.to_owned()]);
        assert_eq!(names("{0: 'rock', 1: 'tyre'}"), two("rock", "tyre"));
        assert_eq!(names(r#"{0: "diver's", 1: 'a\'b'}"#), two("diver's", "a'b"));
        assert_eq!(names("['rock', 'tyre']"), two("rock", "tyre"));
        assert_eq!(names(r#"{"0": "rock", "1": "tyre"}"#), two("rock", "tyre"));
        assert_eq!(names("{0: 'unclosed"), None);
        assert_eq!(names("{}"), None);
    }
}
