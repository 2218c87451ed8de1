//! Sorts all predictions of one class by falling score, with the outcome of the pairing of each.

use super::matching::{MatchOutcome, TruthCandidate, pair};
use super::{Image, MetricSettings, area};
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
