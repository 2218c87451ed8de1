//! Loads a trained detector from an ONNX file, checks and compiles it once, and runs it on many
//! tiles.
//!
//! In: an ONNX file, and pictures. Out: boxes with classes and scores, or a reason why the file
//! cannot be used.
//!
//! Two modules check the network: `screen` refuses harmful files before anything is computed, and
//! `cost` refuses tensors that would become too large during compilation, and networks that would
//! take too much memory or time to run. `tract` compiles and runs the network; `fast_layers`
//! replaces layers that tract computes slowly: convolutions of 3 x 3 (by `winograd`), and maxima.
//! `load` limits the time of this work and catches its failures, and holds the model that comes
//! with the program. `family` infers the layout of the boxes from the outputs' shapes; `sidecar`
//! reads the JSON file next to the model and the metadata inside the model, and converts a
//! network's confidence to the share of right boxes at that confidence. `input` computes the input
//! numbers of the network.

mod cost;
mod family;
mod fast_layers;
mod input;
mod load;
mod screen;
mod sidecar;
mod tract;
mod winograd;

pub use load::{screened, shipped};

use super::{Nms, Picture, Rect, Scored, level, suppress, vote};
use bathyscope_log::support::progress::Cancelled;
use family::DetectorFamily;
use input::InputSpec;
use load::Limits;
use sidecar::ConfidenceCalibration;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use tract::Network;

/// Greatest number of boxes of one picture that are processed, those of highest confidence first:
/// this bounds the work for a network that proposes boxes everywhere.
const MOST_BOXES: usize = 1000;
/// Least confidence of a box that takes part in the vote, at any wanted score: a box must not move
/// with the confidence slider.
const LEAST_VOTER: f32 = 0.01;
/// Least confidence of a box for which its picture is searched a second time, mirrored. Most tiles
/// of a survey show bare ground.
const WORTH_AUGMENTING: f32 = 0.1;
/// Least confidence of any box. Without this limit, every cell of a network would make a box.
const LEAST_SCORE: f32 = 0.001;
/// Overlap (IoU) above which boxes of both passes show the same object.
const SAME: f32 = 0.6;

/// Error of a model that cannot be used, with the path.
#[derive(Debug, thiserror::Error)]
#[error("cannot use the model: {reason}: {path}")]
pub struct ModelError {
    /// The fault.
    pub reason: Unusable,
    /// File of the model.
    pub path: PathBuf,
}

/// Fault of a model, with the remedy in its message.
#[derive(Debug, thiserror::Error)]
pub enum Unusable {
    /// The file could not be read from the disk.
    #[error("it cannot be read: {0}")]
    Unreadable(#[from] std::io::Error),
    /// The file is larger than any detector for a tile, MiB.
    #[error("it is larger than {0} MiB; export a smaller network")]
    TooLarge(u64),
    /// The file is no protobuf of ONNX, or holds no graph.
    #[error("it is no ONNX file, or is cut short; export the network as ONNX, opset 13")]
    NotOnnx,
    /// The weights are in another file, which is missing.
    #[error(
        "its weights lie in `{0}`, which is not beside it; copy that file there, or export again with the weights inside"
    )]
    WeightsElsewhere(String),
    /// The network has a layer that is refused.
    #[error("it holds the layer {layer}, {why}")]
    Layer {
        /// The operator's name.
        layer: String,
        /// Reason why the layer is refused, and what the user can do.
        why: &'static str,
    },
    /// The network has more layers than any detector, or a tensor or computation is too large.
    #[error("{0}; export a smaller network")]
    TooBig(String),
    /// The input of the network is no picture.
    #[error(
        "its input {0}; a picture of 1 or 3 channels is expected, for example [1, 3, 416, 416]"
    )]
    Input(String),
    /// The outputs have shapes of no known family of detectors.
    #[error(
        "its outputs ({0}) are those of no known detector; name the family in the sidecar JSON file (yolov4, raw_heads, \
         yolov5, yolov8, end_to_end or yolox)"
    )]
    Layout(String),
    /// The outputs do not fit the family that the sidecar file names.
    #[error("its outputs do not fit the family {family}: {why}; correct the sidecar JSON file")]
    Misfit {
        /// Name of the family.
        family: String,
        /// Outputs or entries that do not fit.
        why: String,
    },
    /// The outputs are raw heads, and the sidecar file holds no anchors.
    #[error(
        "its outputs are raw heads, whose anchors no ONNX file holds; write them into the sidecar JSON file, as `heads`"
    )]
    NoAnchors,
    /// The network was trained for another task than detection.
    #[error("it was trained for the task `{0}`; export a detector")]
    Task(String),
    /// The sidecar JSON file is wrong.
    #[error("the sidecar JSON file is wrong: {0}")]
    Sidecar(String),
    /// tract refuses the network; the text is the whole chain of reasons.
    #[error("it cannot be compiled: {0}")]
    Compile(String),
    /// The network fails while it runs; the text is the whole chain of reasons.
    #[error("it fails on a picture: {0}")]
    Run(String),
    /// tract panicked during this work.
    #[error("it is damaged: {0} stopped half way")]
    Damaged(&'static str),
    /// The work takes too long.
    #[error("{what} takes longer than {seconds} s; export a smaller network")]
    Slow {
        /// Work that takes too long.
        what: &'static str,
        /// Limit of its time, seconds.
        seconds: u64,
    },
}

impl Unusable {
    /// Refuses a network that is too large, with `text` as the reason, unless it fits.
    fn unless(fits: bool, text: impl FnOnce() -> String) -> Result<(), Self> {
        if fits { Ok(()) } else { Err(Self::TooBig(text())) }
    }
}

/// Error of a search that did not end normally.
#[derive(Debug, thiserror::Error)]
pub enum DetectError {
    /// The search was cancelled.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    /// The model failed on a tile.
    #[error("cannot search for objects: {0}")]
    Model(#[from] Unusable),
}

/// A detector that is ready to run. It can be used from several threads at once.
pub struct Model {
    network: Arc<Network>,
    family: DetectorFamily,
    input: InputSpec,
    /// The network's class names, then the class of boxes without a known class, unless it is one
    /// of them.
    names: Vec<String>,
    /// Index of the class of boxes without a known class.
    pub(crate) nameless: usize,
    /// Side of a pixel that the network expects, metres.
    pub pixel_m: f64,
    levelled: bool,
    /// Least confidence of a box that the sidecar file states, or the usual one.
    pub score: f32,
    /// Overlap, stated by the sidecar file or the usual one, above which the box of the lower score
    /// is dropped.
    pub iou: f32,
    /// Confidence below which the class of a box is a guess, as the sidecar file states it; 0 if it
    /// states none.
    pub(crate) name_score: f32,
    /// Rule by which boxes are suppressed.
    pub nms: Nms,
    /// Overlap above which boxes vote; `None` for no vote.
    vote: Option<f32>,
    /// True if a picture that seems to show an object is searched once more, mirrored.
    augments: bool,
    /// Calibration of the network's confidences.
    calibration: ConfidenceCalibration,
    /// One line about the model: its family and how that was determined, its classes and its input.
    pub description: String,
}

impl std::fmt::Debug for Model {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter.debug_tuple("Model").field(&self.description).finish()
    }
}

impl Model {
    /// Loads `MODEL.onnx`, and `MODEL.json` beside it if it exists. The file may be of unknown
    /// origin: the result is always a model that has run once, or an error.
    ///
    /// # Errors
    /// When the model cannot be used; the error names the file and the reason.
    pub fn load(path: &Path) -> Result<Model, ModelError> {
        load::from_path(path).map_err(|reason| ModelError { reason, path: path.to_path_buf() })
    }

    /// Loads the model at a path, or the one that comes with the program.
    ///
    /// # Errors
    /// As for [`Model::load`].
    pub fn load_or_shipped(path: Option<&Path>) -> Result<Model, ModelError> {
        path.map_or_else(shipped, Self::load)
    }

    /// Loads a model from the bytes of an ONNX file and the text of its sidecar file.
    ///
    /// # Errors
    /// When the model cannot be used; the error is the reason.
    pub fn from_bytes(onnx: Vec<u8>, sidecar: Option<&str>) -> Result<Model, Unusable> {
        load::from_bytes(onnx.into(), sidecar, None, Limits::USUAL)
    }

    /// Returns the network's class names, in the network's order.
    pub fn classes(&self) -> &[String] {
        &self.names[..self.family.classes]
    }

    /// Returns the names that [`Scored::class`] and [`super::Detection::class`] are indices of: the
    /// network's classes, and the class of boxes without a known class ([`super::NAMELESS_CLASS`]).
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// Returns the size of the network's input, across and down, pixels.
    pub(crate) fn input_size(&self) -> [usize; 2] {
        [self.input.width, self.input.height]
    }

    /// Returns the objects in one picture, of at least the score `score` (calibrated if the sidecar
    /// file holds a calibration), by falling score, in the picture's pixels. For a network of one
    /// channel, the picture is converted to grey and, unless the sidecar file states `raw`, its
    /// levels are adjusted ([`level`]); a network of three channels receives the picture unchanged.
    ///
    /// # Errors
    /// When the network fails on the picture.
    pub fn detect(&self, picture: &Picture, score: f32, iou: f32) -> Result<Vec<Scored>, Unusable> {
        let grey = self.input.channels == 1;
        let mut copy;
        let picture = if grey && (self.levelled || picture.channels == 3) {
            copy = picture.to_grey();
            if self.levelled {
                level(&mut copy.levels);
            }
            &copy
        } else {
            picture
        };
        // Up to the end of this function, confidences are those of the network, not calibrated.
        let score = self.calibration.confidence(score).max(LEAST_SCORE);
        let least =
            if self.vote.is_some() || self.augments { score.min(LEAST_VOTER) } else { score };
        let mut boxes = self.look(picture, least)?;
        if self.augments && boxes.iter().any(|found| found.score >= WORTH_AUGMENTING) {
            let height = picture.height as f32;
            let mut again = self.look(&picture.mirrored(), least)?;
            for found in &mut again {
                *found = mirrored(*found, height);
            }
            boxes = agree(&boxes, &again);
        }
        Ok(self.settle(boxes, score, iou))
    }

    /// Returns the boxes that the network proposes in a picture, the [`MOST_BOXES`] of highest
    /// confidence, in the picture's pixels.
    fn look(&self, picture: &Picture, least: f32) -> Result<Vec<Scored>, Unusable> {
        let fit = self.input.fit(picture);
        let outputs = self.network.run(&self.input.numbers(picture, &fit))?;
        let mut boxes = self.family.decode(&outputs, self.input_size(), least);
        keep_surest(&mut boxes);
        for found in &mut boxes {
            found.rect = fit.to_picture(&found.rect);
        }
        boxes.retain(|found| found.rect.area() > 0.0);
        Ok(boxes)
    }

    /// Suppresses overlapping candidates, so that each object has one box of at least the score
    /// `score`, moves each box by the vote of the candidates around it, and calibrates the scores.
    fn settle(&self, candidates: Vec<Scored>, score: f32, iou: f32) -> Vec<Scored> {
        let settled = self.family.suppresses() && !self.augments;
        let iou = if settled { 1.0 } else { iou };
        let mut boxes = candidates.clone();
        boxes.retain(|found| found.score >= score);
        suppress(&mut boxes, self.nms, iou);
        if let Some(overlap) = self.vote {
            let voters = candidates.into_iter().filter(|candidate| candidate.score >= LEAST_VOTER);
            vote(&mut boxes, &voters.collect::<Vec<_>>(), overlap);
        }
        for found in &mut boxes {
            found.score = self.calibration.calibrated(found.score);
        }
        boxes
    }
}

fn keep_surest(boxes: &mut Vec<Scored>) {
    if boxes.len() > MOST_BOXES {
        boxes.select_nth_unstable_by(MOST_BOXES, |a, b| b.score.total_cmp(&a.score));
        boxes.truncate(MOST_BOXES);
    }
}

/// Returns the candidates of both passes, with new confidences: the mean of a candidate's own
/// confidence and the highest confidence of a box of its class at the same place in the other pass
/// (0 without such a box). `second` holds the boxes of the mirrored picture, mirrored back.
///
/// The two passes are test-time augmentation; the second is mirrored along the track. The boat may
/// come from either end, so a picture and its mirror image show the same objects. A false detection
/// in one of them is mostly absent in the other: the mean of both passes raises fewer false alarms
/// and places edges better (figures in the detector's model card). Columns are never mirrored:
/// shadows fall outward.
fn agree(first: &[Scored], second: &[Scored]) -> Vec<Scored> {
    let weighed = |own: &[Scored], other: &[Scored]| -> Vec<Scored> {
        own.iter()
            .map(|candidate| Scored {
                score: (candidate.score + surest_there(candidate, other)) / 2.0,
                ..*candidate
            })
            .collect()
    };
    let mut both = weighed(first, second);
    both.extend(weighed(second, first));
    both
}

/// Returns the highest confidence among boxes of the same class at the same place; 0 without such a
/// box.
fn surest_there(one: &Scored, others: &[Scored]) -> f32 {
    others
        .iter()
        .filter(|other| other.class == one.class && other.rect.iou(&one.rect) > SAME)
        .map(|other| other.score)
        .fold(0.0, f32::max)
}

/// Mirrors a box along the track in a picture of `height` pixels; the same function mirrors it
/// back.
fn mirrored(found: Scored, height: f32) -> Scored {
    let Rect { x0, y0, x1, y1 } = found.rect;
    Scored { rect: Rect::new([x0, height - y1], [x1, height - y0]), ..found }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scored(class: usize, score: f32, [y0, y1]: [f32; 2]) -> Scored {
        Scored::new(class, score, Rect::new([0.0, y0], [10.0, y1]))
    }

    fn scores(first: &[Scored], second: &[Scored]) -> Vec<f32> {
        agree(first, second).iter().map(|found_box| found_box.score).collect()
    }

    #[test]
    fn what_both_passes_see_is_as_sure_as_their_mean() {
        // The two boxes share 9 of 11.
        let first = [scored(0, 0.75, [0.0, 10.0])];
        let second = [scored(0, 0.25, [1.0, 11.0])];
        assert_eq!(scores(&first, &second), [0.5, 0.5]);
        let boxes = agree(&first, &second);
        assert_eq!([boxes[0].rect, boxes[1].rect], [first[0].rect, second[0].rect]);
    }

    #[test]
    fn what_one_look_sees_is_half_as_sure() {
        let first = [scored(0, 0.5, [0.0, 10.0])];
        // The first box is of another class; the second shares 7 of 13.
        let others = [scored(1, 0.75, [0.0, 10.0]), scored(0, 1.0, [3.0, 13.0])];
        assert_eq!(scores(&first, &others), [0.25, 0.375, 0.5]);
        assert_eq!(scores(&first, &[]), [0.25]);
        assert_eq!(scores(&[], &first), [0.25]);
    }

    #[test]
    fn the_surest_of_the_other_look_counts() {
        let first = [scored(0, 0.5, [0.0, 10.0])];
        let second = [scored(0, 0.25, [0.0, 10.0]), scored(0, 1.0, [1.0, 10.0])];
        assert_eq!(scores(&first, &second)[0], 0.75);
    }

    #[test]
    fn a_box_mirrored_twice_is_where_it_was() {
        let found = scored(2, 0.5, [30.0, 50.0]);
        let there = mirrored(found, 416.0);
        assert_eq!([there.rect.y0, there.rect.y1], [366.0, 386.0]);
        assert_eq!(mirrored(there, 416.0), found);
    }
}
