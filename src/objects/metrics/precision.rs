//! Computes counts, precision and recall, and their curves over the score.

use super::ranking::{MatchOutcome, Ranked, Ranking};

/// Method to compute one number from a precision-recall curve.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ApMethod {
    /// Area under the curve, where the precision at a recall is the best one at that recall or a
    /// higher one (VOC since 2010, Darknet's `-points 0`).
    AllPoint,
    /// Mean of the precision of `AllPoint` at recall 0, 0.1 .. 1 (VOC 2007, Darknet's `-points
    /// 11`).
    Voc11,
    /// Mean of the precision of `AllPoint` at recall 0, 0.01 .. 1 (COCO).
    Coco101,
}

/// Counts of true boxes, found ones and false alarms, at one score.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MatchCounts {
    /// Number of truths that count.
    pub truths: usize,
    /// Predictions that found a truth (TP).
    pub found: usize,
    /// Predictions that found no truth (FP).
    pub false_alarms: usize,
    /// Sum of the IoU of the predictions that found a truth.
    pub iou_sum: f64,
}

impl MatchCounts {
    /// Counts hits and false alarms among predictions, given the number of truths.
    pub fn of(shown: &[Ranked], truths: usize) -> Self {
        let mut counts = MatchCounts { truths, ..Self::default() };
        for ranked in shown {
            match ranked.outcome {
                MatchOutcome::Hit { iou, .. } => {
                    counts.found += 1;
                    counts.iou_sum += iou;
                }
                _ => counts.false_alarms += 1,
            }
        }
        counts
    }

    /// Counts the truths of a class, and hits and false alarms of at least a score.
    pub(super) fn shown(ranking: &Ranking, score: f32) -> Self {
        Self::of(ranking.shown(score), ranking.truths)
    }

    /// Adds two counts.
    pub fn plus(self, other: Self) -> Self {
        Self {
            truths: self.truths + other.truths,
            found: self.found + other.found,
            false_alarms: self.false_alarms + other.false_alarms,
            iou_sum: self.iou_sum + other.iou_sum,
        }
    }

    /// Returns the number of truths that no prediction found (FN).
    pub fn missed(&self) -> usize {
        self.truths.saturating_sub(self.found)
    }

    /// Returns TP / (TP + FP); NaN without predictions.
    pub fn precision(&self) -> f64 {
        share(self.found, self.found + self.false_alarms)
    }

    /// Returns TP / (TP + FN); NaN without truths.
    pub fn recall(&self) -> f64 {
        share(self.found, self.truths)
    }

    /// Returns 2 TP / (2 TP + FP + FN); NaN without any box.
    pub fn f1(&self) -> f64 {
        let boxes = self.found + self.false_alarms + self.truths;
        share(2 * self.found, boxes)
    }

    /// Returns the mean IoU of the predictions that found a truth; NaN without any.
    pub fn iou_of_matches(&self) -> f64 {
        self.iou_sum / self.found as f64
    }

    /// Returns Darknet's "average IoU", in which a false alarm counts as 0. It cannot exceed the
    /// precision. NaN without predictions.
    pub fn darknet_iou(&self) -> f64 {
        self.iou_sum / (self.found + self.false_alarms) as f64
    }
}

fn share(part: usize, whole: usize) -> f64 {
    part as f64 / whole as f64
}

/// Precision, recall and F1 of the boxes of at least a score.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CurvePoint {
    /// Least score of the boxes.
    pub score: f32,
    /// TP / (TP + FP) of these boxes.
    pub precision: f64,
    /// TP / (TP + FN) of these boxes; NaN without truths.
    pub recall: f64,
    /// 2 TP / (2 TP + FP + FN) of these boxes.
    pub f1: f64,
}

/// Returns precision, recall and F1 for every score that occurs, by falling score; `ranked` must be
/// sorted by falling score.
pub(super) fn curve(ranked: &[Ranked], truths: usize) -> Vec<CurvePoint> {
    let mut counts = MatchCounts { truths, ..MatchCounts::default() };
    let same_score = |a: &Ranked, b: &Ranked| a.score == b.score;
    ranked
        .chunk_by(same_score)
        .map(|equals| {
            counts = counts.plus(MatchCounts::of(equals, 0));
            CurvePoint {
                score: equals[0].score,
                precision: counts.precision(),
                recall: counts.recall(),
                f1: counts.f1(),
            }
        })
        .collect()
}

/// Returns the average precision of a class; NaN without truths.
pub(super) fn average_precision(ranking: &Ranking, method: ApMethod) -> f64 {
    if ranking.truths == 0 {
        return f64::NAN;
    }
    let (recall, precision) = envelope(&ranking.ranked, ranking.truths);
    let mean_at = |levels: Vec<f64>| {
        let reached = levels.iter().map(|level| {
            let first = recall.partition_point(|recall| recall < level);
            precision.get(first).copied().unwrap_or(0.0)
        });
        reached.sum::<f64>() / levels.len() as f64
    };
    match method {
        ApMethod::AllPoint => area_under(&recall, &precision),
        ApMethod::Voc11 => mean_at((0..=10).map(|tenth| f64::from(tenth) / 10.0).collect()),
        // Computed as in numpy: 57 * 0.01 is slightly above 0.57, and a recall of 57/100 does not
        // reach it.
        ApMethod::Coco101 => mean_at((0..=100).map(|point| f64::from(point) * 0.01).collect()),
    }
}

fn area_under(recall: &[f64], precision: &[f64]) -> f64 {
    let (mut area, mut before) = (0.0, 0.0);
    for (&recall, &precision) in recall.iter().zip(precision) {
        area += (recall - before) * precision;
        before = recall;
    }
    area
}

/// Returns the recall after each prediction, and the best precision after that prediction or a
/// later one.
fn envelope(ranked: &[Ranked], truths: usize) -> (Vec<f64>, Vec<f64>) {
    let mut counts = MatchCounts { truths, ..MatchCounts::default() };
    let (recall, mut precision): (Vec<f64>, Vec<f64>) = ranked
        .iter()
        .map(|detection| {
            counts = counts.plus(MatchCounts::of(std::slice::from_ref(detection), 0));
            (counts.recall(), counts.precision())
        })
        .unzip();
    let mut best = 0.0;
    for precision in precision.iter_mut().rev() {
        best = f64::max(best, *precision);
        *precision = best;
    }
    (recall, precision)
}
