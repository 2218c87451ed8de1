//! Pairs predicted and true boxes of one class in one picture.

use super::{BoxMatching, iou};
use crate::Rect;

/// A true box as a candidate for the predictions of its class.
#[derive(Clone, Copy, Debug)]
pub(super) struct TruthCandidate {
    /// Index into the picture's truths.
    pub truth: usize,
    pub rect: Rect,
    /// True if any number of predictions may lie in the box.
    pub crowd: bool,
    /// True if the box does not count: it is a crowd, or not of the wanted size.
    pub ignored: bool,
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
pub(super) fn pair(
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
