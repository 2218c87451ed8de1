//! Pairs the predicted and the true boxes of one class, picture by picture, and sorts all
//! predictions of the class by falling score, with the outcome of the pairing of each.

use super::{BoxMatching, Image, MetricSettings, area, iou};
use crate::Rect;
use std::ops::RangeInclusive;

/// A prediction and the outcome of its pairing.
#[derive(Clone, Copy, Debug)]
pub struct Ranked {
    pub image: usize,
    /// Index into the picture's predictions.
    pub predicted: usize,
    pub score: f32,
    pub outcome: MatchOutcome,
}

/// The predictions of one class in all pictures.
#[derive(Clone, Debug)]
pub(super) struct Ranking {
    /// Predictions by falling score; equal scores in the order of the pictures. Predictions that
    /// lie on an ignored truth are excluded.
    pub ranked: Vec<Ranked>,
    /// Number of truths that count.
    pub truths: usize,
}

/// Range of the areas of boxes that count, square pixels.
pub(super) type Sizes = RangeInclusive<f64>;

/// Range of all areas.
pub(super) const ANY_SIZE: Sizes = 0.0..=f64::INFINITY;

impl Ranking {
    /// Pairs the boxes of the class in every picture at an IoU threshold, and sorts the
    /// predictions. Truths of other sizes count neither as found nor as missed; predictions of
    /// other sizes that find no truth do not count either.
    pub(super) fn new(
        images: &[Image],
        class: usize,
        settings: &MetricSettings,
        threshold: f64,
        sizes: &Sizes,
    ) -> Self {
        let mut ranking = Ranking { ranked: Vec::new(), truths: 0 };
        for (image, boxes) in images.iter().enumerate() {
            let candidates = candidates(boxes, class, sizes);
            ranking.truths += candidates.iter().filter(|candidate| !candidate.ignored).count();
            let order = by_score(boxes, class, settings.max_detections);
            let rects: Vec<Rect> = order.iter().map(|&index| boxes.predicted[index].rect).collect();
            let outcomes = pair(&rects, &candidates, settings.matching, threshold);
            for (predicted, outcome) in order.into_iter().zip(outcomes) {
                let predicted_box = &boxes.predicted[predicted];
                let counts = match outcome {
                    MatchOutcome::Hit { .. } => true,
                    MatchOutcome::FalseAlarm => sizes.contains(&area(&predicted_box.rect)),
                    MatchOutcome::Ignored => false,
                };
                if counts {
                    ranking.ranked.push(Ranked {
                        image,
                        predicted,
                        score: predicted_box.score,
                        outcome,
                    });
                }
            }
        }
        ranking.ranked.sort_by(|a, b| b.score.total_cmp(&a.score));
        ranking
    }

    /// Returns the predictions of at least a score.
    pub(super) fn shown(&self, score: f32) -> &[Ranked] {
        let end = self.ranked.partition_point(|ranked| ranked.score >= score);
        &self.ranked[..end]
    }
}

fn candidates(boxes: &Image, class: usize, sizes: &Sizes) -> Vec<TruthCandidate> {
    let of_class = boxes.truth.iter().enumerate();
    of_class
        .filter(|(_, truth)| truth.class == class)
        .map(|(index, truth)| TruthCandidate {
            truth: index,
            rect: truth.rect,
            crowd: truth.ignored,
            ignored: truth.ignored || !sizes.contains(&area(&truth.rect)),
        })
        .collect()
}

/// Returns the indices of the predictions of a class in a picture, by falling score, at most `most`
/// of them.
fn by_score(boxes: &Image, class: usize, most: Option<usize>) -> Vec<usize> {
    let score = |index: usize| boxes.predicted[index].score;
    let mut order: Vec<usize> = (0..boxes.predicted.len())
        .filter(|&index| boxes.predicted[index].class == class && !score(index).is_nan())
        .collect();
    order.sort_by(|&a, &b| score(b).total_cmp(&score(a)));
    order.truncate(most.unwrap_or(usize::MAX));
    order
}

/// A true box as a candidate for the predictions of its class.
#[derive(Clone, Copy, Debug)]
struct TruthCandidate {
    /// Index into the picture's truths.
    truth: usize,
    rect: Rect,
    /// True if any number of predictions may lie in the box.
    crowd: bool,
    /// True if the box does not count: it is a crowd, or not of the wanted size.
    ignored: bool,
}

/// Result of pairing a prediction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MatchOutcome {
    /// The prediction found this truth (index into the picture's truths).
    Hit { truth: usize, iou: f64 },
    /// The prediction found no truth.
    FalseAlarm,
    /// The prediction lies on a truth that does not count.
    Ignored,
}

/// Pairs predictions, sorted by falling score, with the candidates of their class. Returns one
/// outcome for each prediction.
fn pair(
    predicted: &[Rect],
    candidates: &[TruthCandidate],
    rule: BoxMatching,
    threshold: f64,
) -> Vec<MatchOutcome> {
    let mut is_taken = vec![false; candidates.len()];
    // COCO tries the ignored candidates last.
    let mut order: Vec<usize> = (0..candidates.len()).collect();
    order.sort_by_key(|&index| candidates[index].ignored);
    let outcome = |predicted: &Rect| {
        let found = match rule {
            BoxMatching::DarknetVoc => most_overlapped(predicted, candidates, threshold),
            BoxMatching::Coco => best_free(predicted, candidates, &order, &is_taken, threshold),
        };
        let Some((index, iou)) = found else {
            return MatchOutcome::FalseAlarm;
        };
        let candidate = &candidates[index];
        if candidate.ignored {
            is_taken[index] = true;
            MatchOutcome::Ignored
        } else if is_taken[index] {
            MatchOutcome::FalseAlarm
        } else {
            is_taken[index] = true;
            MatchOutcome::Hit { truth: candidate.truth, iou }
        }
    };
    predicted.iter().map(outcome).collect()
}

/// Returns the candidate that a box overlaps most, by more than the threshold, whether it is taken
/// or not.
fn most_overlapped(
    predicted: &Rect,
    candidates: &[TruthCandidate],
    threshold: f64,
) -> Option<(usize, f64)> {
    let overlaps = candidates.iter().map(|candidate| iou(predicted, &candidate.rect, false));
    overlaps
        .enumerate()
        .filter(|&(_, overlap)| BoxMatching::DarknetVoc.passes(overlap, threshold))
        .max_by(|(_, a), (_, b)| a.total_cmp(b))
}

/// Returns the free candidate with the greatest overlap; an ignored candidate is returned only if
/// no other one passes. Among equal overlaps the last is returned, as in `pycocotools`.
fn best_free(
    predicted: &Rect,
    candidates: &[TruthCandidate],
    order: &[usize],
    is_taken: &[bool],
    threshold: f64,
) -> Option<(usize, f64)> {
    let mut best: Option<(usize, f64)> = None;
    for &index in order {
        let candidate = &candidates[index];
        if is_taken[index] && !candidate.crowd {
            continue;
        }
        if candidate.ignored && best.is_some_and(|(index, _)| !candidates[index].ignored) {
            break;
        }
        let overlap = iou(predicted, &candidate.rect, candidate.crowd);
        let least = best.map_or(0.0, |(_, overlap)| overlap);
        if overlap >= least && BoxMatching::Coco.passes(overlap, threshold) {
            best = Some((index, overlap));
        }
    }
    best
}
