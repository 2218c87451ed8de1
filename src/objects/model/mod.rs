//! A detector somebody trained: an ONNX file, looked through, understood, compiled once and run on
//! many tiles.
//!
//! In: an ONNX file, and pictures. Out: boxes with classes and scores, or a reason why the file
//! cannot be used.
//!
//! `screen` refuses what could harm before anything is computed, `constants` what would grow while
//! it is compiled, `cost` what would take too much to run. `tract` compiles and runs, `fast_layers`
//! replaces what it computes slowly: convolutions of 3 x 3 by `winograd`, and maxima. `load` keeps
//! failures and endless work to themselves, and has the model that comes with the program. `family`
//! infers from the outputs' shapes how boxes are written; `sidecar` reads what the JSON file next
//! to the model and the metadata inside it state, and turns a network's confidence into the share
//! of such boxes that are right. `input` makes the numbers that the network takes.

mod constants;
mod cost;
mod error;
mod family;
mod fast_layers;
mod input;
mod load;
mod screen;
mod sidecar;
mod tract;
mod winograd;

pub use error::{DetectError, ModelError, Unusable};
pub use load::shipped;

use super::{Nms, Picture, Rect, Scored, level, suppress, vote};
use family::DetectorFamily;
use input::InputSpec;
use load::Limits;
use sidecar::ConfidenceCalibration;
use std::path::Path;
use std::sync::Arc;
use tract::Network;

/// Looks through a model as [`Model::from_bytes`] does before it compiles it, for the fuzzer.
///
/// # Errors
/// Why the model cannot be used.
pub fn screened(onnx: &[u8], sidecar: Option<&str>) -> Result<(), Unusable> {
    load::screen_only(onnx, sidecar)
}

/// Boxes of one picture that are looked at, the surest: a network that fires everywhere stays
/// bearable.
const MOST_BOXES: usize = 1000;
/// Confidence from which a box takes part in the vote, whatever is asked for: a box must not move
/// with the slider.
const LEAST_VOTER: f32 = 0.01;
/// Confidence from which a box is worth a second, mirrored pass over its picture. Most tiles of a
/// survey show bare ground.
const WORTH_AUGMENTING: f32 = 0.1;
/// Least confidence of any box. Without a floor a network's every cell would be one.
const LEAST_SCORE: f32 = 0.001;
/// Overlap (IoU) above which boxes of both passes are the same object.
const SAME: f32 = 0.6;

/// A detector that is ready to run, from several threads at once.
pub struct Model {
    network: Arc<Network>,
    family: DetectorFamily,
    input: InputSpec,
    /// The network's class names, then that of a box without one unless the network has it.
    names: Vec<String>,
    /// Classes of the network.
    classes: usize,
    /// Index of the name of a box whose class is a guess.
    nameless: usize,
    pixel_m: f64,
    levelled: bool,
    score: f32,
    iou: f32,
    name_score: f32,
    nms: Nms,
    /// Overlap above which boxes vote.
    vote: Option<f32>,
    /// True if a picture that seems to show something is evaluated once more, mirrored.
    augments: bool,
    /// Calibration of the network's confidences.
    calibration: ConfidenceCalibration,
    description: String,
}

impl std::fmt::Debug for Model {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter.debug_tuple("Model").field(&self.description).finish()
    }
}

impl Model {
    /// Loads `MODEL.onnx`, with `MODEL.json` beside it where there is one. The file may come from
    /// anywhere: whatever it holds, this ends in a model that has run once, or in a sentence.
    ///
    /// # Errors
    /// When the model cannot be used; the error names its file and says why.
    pub fn load(path: &Path) -> Result<Model, ModelError> {
        load::from_path(path).map_err(|reason| ModelError { reason, path: path.to_path_buf() })
    }

    /// Loads a model from the bytes of an ONNX file and the text of its sidecar.
    ///
    /// # Errors
    /// Why the model cannot be used.
    pub fn from_bytes(onnx: Vec<u8>, sidecar: Option<&str>) -> Result<Model, Unusable> {
        load::from_bytes(onnx.into(), sidecar, None, Limits::USUAL)
    }

    /// The network's class names, in their order there.
    pub fn classes(&self) -> &[String] {
        &self.names[..self.classes]
    }

    /// Returns the names that [`Scored::class`] and [`super::Detection::class`] are indices of: the
    /// network's classes, and the name of a box whose class is a guess ([`super::NAMELESS_CLASS`]).
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// Index of the name of a box whose class is a guess.
    pub(crate) fn nameless(&self) -> usize {
        self.nameless
    }

    /// Confidence from which a box is named, as its makers suggest: below it the class is a guess.
    pub fn name_score(&self) -> f32 {
        self.name_score
    }

    /// Side of a pixel that the network expects, metres.
    pub fn pixel_m(&self) -> f64 {
        self.pixel_m
    }

    /// The network's own size of picture, across and down.
    pub(crate) fn input_size(&self) -> [usize; 2] {
        [self.input.width, self.input.height]
    }

    /// The least confidence that its makers suggest.
    pub fn score(&self) -> f32 {
        self.score
    }

    /// The overlap above which the box of the lower score is dropped, as its makers suggest.
    pub fn iou(&self) -> f32 {
        self.iou
    }

    /// Returns the rule by which boxes are suppressed.
    pub fn nms(&self) -> Nms {
        self.nms
    }

    /// The same model with another rule of which boxes hide which.
    pub fn with_nms(self, nms: Nms) -> Self {
        Self { nms, ..self }
    }

    /// One line: what the file was taken for, and by what.
    pub fn description(&self) -> &str {
        &self.description
    }

    /// The objects in one picture, of at least that score (calibrated where the sidecar says how),
    /// by falling score, in the picture's pixels. For a network of one channel the picture is made
    /// grey and, unless the sidecar says `raw`, brought to one level; one of three channels gets
    /// its colours as they are.
    ///
    /// # Errors
    /// Why the model cannot be used.
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
        // Up to the end, confidences are the network's own.
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

    /// Returns the surest boxes that the network proposes in a picture, in the picture's pixels.
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

    /// One box an object, of at least that score, where the boxes around it put it.
    fn settle(&self, candidates: Vec<Scored>, score: f32, iou: f32) -> Vec<Scored> {
        let settled = self.family.suppresses() && !self.augments;
        let iou = if settled { 1.0 } else { iou };
        let mut boxes = candidates.clone();
        boxes.retain(|found| found.score >= score);
        suppress(&mut boxes, self.nms, iou);
        if let Some(overlap) = self.vote {
            let voters = candidates.into_iter().filter(|one| one.score >= LEAST_VOTER);
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

/// The candidates of both passes, each as sure as the mean of its own confidence and that of the
/// surest of its class that the other pass has there; 0 where it has none. `second` holds the boxes
/// of the mirrored picture, mirrored back.
///
/// The two passes are test-time augmentation, the second mirrored along the track. The boat may
/// come from either end, so a picture and its mirror image show the same objects, and what a
/// network sees in one of them by chance it mostly does not see in the other: the mean of both
/// passes raises fewer false alarms and places edges better (figures in the detector's model card).
/// Columns are never mirrored: shadows fall outward.
fn agree(first: &[Scored], second: &[Scored]) -> Vec<Scored> {
    let weighed = |own: &[Scored], other: &[Scored]| -> Vec<Scored> {
        own.iter()
            .map(|one| Scored { score: (one.score + surest_there(one, other)) / 2.0, ..*one })
            .collect()
    };
    let mut both = weighed(first, second);
    both.extend(weighed(second, first));
    both
}

/// Confidence of the surest box of the same class at the same place; 0 without one.
fn surest_there(one: &Scored, others: &[Scored]) -> f32 {
    others
        .iter()
        .filter(|other| other.class == one.class && other.rect.iou(&one.rect) > SAME)
        .map(|other| other.score)
        .fold(0.0, f32::max)
}

/// A box of a picture of `height` pixels as it lies in the mirrored one, and back.
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
        agree(first, second).iter().map(|one| one.score).collect()
    }

    #[test]
    fn what_both_passes_see_is_as_sure_as_their_mean() {
        // They share 9 of 11.
        let first = [scored(0, 0.75, [0.0, 10.0])];
        let second = [scored(0, 0.25, [1.0, 11.0])];
        assert_eq!(scores(&first, &second), [0.5, 0.5]);
        let boxes = agree(&first, &second);
        assert_eq!([boxes[0].rect, boxes[1].rect], [first[0].rect, second[0].rect]);
    }

    #[test]
    fn what_one_look_sees_is_half_as_sure() {
        let first = [scored(0, 0.5, [0.0, 10.0])];
        // Of another class; sharing 7 of 13.
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
