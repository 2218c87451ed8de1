//! Measures the agreement of predicted boxes with true ones.
//!
//! In: true and predicted boxes by picture. Out: precision, recall, average precision, confusion
//! and mistakes.
//!
//! `ranking` pairs the boxes of each picture and sorts the pairs of a class by score, `precision`
//! computes curves and average precision from them, `mistakes` lists the mistakes to examine and
//! counts boxes by true and proposed class, [`Matched`] keeps the pairs to be counted at any score,
//! and [`evaluate`] collects all results.
//!
//! Two rules are in use and give different numbers from the same boxes: Darknet's (used for the
//! published figures) and COCO's. [`MetricSettings::darknet`] gives the same numbers as
//! `mean_average_precision`, and [`MetricSettings::coco`] the same as `pycocotools` (tests).

mod evaluate;
mod mistakes;
mod precision;
mod ranking;

pub(crate) use evaluate::Matched;
pub use evaluate::{AtScore, Evaluation, SizeReport, evaluate};
pub use mistakes::{Cause, Confusion};
pub use precision::{ApMethod, CurvePoint, MatchCounts};

use super::{Rect, Scored};

/// A true box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrueBox {
    /// Index into the class names.
    pub class: usize,
    /// Box, pixels.
    pub rect: Rect,
    /// True if the box counts neither as found nor as missed: a crowd, or an object that nobody
    /// could name. Any number of predictions may lie in it (COCO's `iscrowd`, VOC's `difficult`).
    pub ignored: bool,
}

/// The boxes of one picture.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Image {
    /// True boxes.
    pub truth: Vec<TrueBox>,
    /// Predicted boxes, in any order; of equal scores the first counts first.
    pub predicted: Vec<Scored>,
}

impl Image {
    /// Changes each prediction of the class `nameless` to the class of the true box that it
    /// overlaps most: a prediction that names no class cannot name a wrong one. A prediction that
    /// overlaps no true box is not changed.
    pub(crate) fn name_by_truth(&mut self, nameless: usize) {
        let without = |predicted: &&mut Scored| predicted.class == nameless;
        for predicted in self.predicted.iter_mut().filter(without) {
            let overlap = |truth: &TrueBox| predicted.rect.iou(&truth.rect);
            let met = self.truth.iter().filter(|truth| overlap(truth) > 0.0);
            if let Some(truth) = met.max_by(|a, b| overlap(a).total_cmp(&overlap(b))) {
                predicted.class = truth.class;
            }
        }
    }
}

/// Rule that pairs predictions with true boxes of their class. Predictions are paired by falling
/// score.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BoxMatching {
    /// Darknet and VOC: a prediction is paired with the truth that it overlaps most, by more than
    /// the threshold; if that truth is taken, the prediction is a false alarm, even if it overlaps
    /// a free truth. A class without truths counts as 0 in the mean.
    DarknetVoc,
    /// COCO: a prediction is paired with the free truth that it overlaps most, by the threshold or
    /// more. A class without truths does not count in the mean.
    Coco,
}

impl BoxMatching {
    /// Returns true if an overlap makes a match.
    fn passes(self, iou: f64, threshold: f64) -> bool {
        match self {
            BoxMatching::DarknetVoc => iou > threshold,
            // An IoU of 1 passes a threshold of 1 despite rounding.
            BoxMatching::Coco => iou >= threshold.min(1.0 - 1e-10),
        }
    }
}

/// Settings of an evaluation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MetricSettings {
    /// Rule that pairs predictions with truths.
    pub matching: BoxMatching,
    /// Method that computes average precision from a precision-recall curve.
    pub ap: ApMethod,
    /// Intersection over union from which a prediction matches a truth, 0 to 1.
    pub iou: f64,
    /// Least score of a box that is shown: counts, confusion and mistakes are of the shown boxes;
    /// curves and AP are of all boxes.
    pub score: f32,
    /// Number of the boxes of highest score that count in each class and picture; all if `None`.
    pub max_detections: Option<usize>,
}

impl MetricSettings {
    /// Returns the settings of Darknet's `detector map -points 0`: all points, more than IoU 0.5,
    /// score 0.25.
    pub fn darknet() -> Self {
        Self {
            matching: BoxMatching::DarknetVoc,
            ap: ApMethod::AllPoint,
            iou: 0.5,
            score: 0.25,
            max_detections: None,
        }
    }

    /// Returns the settings of COCO: 101 points, IoU 0.5 and above, 100 boxes of a class in a
    /// picture.
    pub fn coco() -> Self {
        Self {
            matching: BoxMatching::Coco,
            ap: ApMethod::Coco101,
            max_detections: Some(100),
            ..Self::darknet()
        }
    }
}

/// Returns the area of a box in double precision, square pixels.
fn area(rect: &Rect) -> f64 {
    let side = |from: f32, to: f32| (f64::from(to) - f64::from(from)).max(0.0);
    side(rect.x0, rect.x1) * side(rect.y0, rect.y1)
}

/// Returns the intersection over union in double precision, so that 0.5 is exactly 0.5; for a
/// crowd, the intersection over the predicted box alone.
fn iou(predicted: &Rect, truth: &Rect, crowd: bool) -> f64 {
    let shared = area(&predicted.intersection(truth));
    let joint = if crowd { area(predicted) } else { area(predicted) + area(truth) - shared };
    if joint > 0.0 { shared / joint } else { 0.0 }
}
