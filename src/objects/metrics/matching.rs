//! The boxes of one class in one picture, paired.

use super::{BoxMatching, iou};
use crate::Rect;

/// A true box as one run sees it.
#[derive(Clone, Copy, Debug)]
pub(super) struct TruthCandidate {
    /// Index into the picture's truths.
    pub truth: usize,
    pub rect: Rect,
    /// Any number of boxes may lie in it.
    pub crowd: bool,
    /// Not counted: a crowd, or not of the size looked at.
    pub ignored: bool,
}

/// Result of pairing a prediction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MatchOutcome {
    /// It found this truth (index into the picture's).
    Hit { truth: usize, iou: f64 },
    /// It found nothing.
    FalseAlarm,
    /// It lies on something that does not count.
    Ignored,
}

/// Pairs predictions, which come by falling score, with the candidates of their class; one outcome
/// a prediction.
pub(super) fn pair(
    predicted: &[Rect],
    candidates: &[TruthCandidate],
    rule: BoxMatching,
    threshold: f64,
) -> Vec<MatchOutcome> {
    let mut taken = vec![false; candidates.len()];
    // COCO looks at the ignored ones last.
    let mut order: Vec<usize> = (0..candidates.len()).collect();
    order.sort_by_key(|&index| candidates[index].ignored);
    let outcome = |predicted: &Rect| {
        let found = match rule {
            BoxMatching::DarknetVoc => most_overlapped(predicted, candidates, threshold),
            BoxMatching::Coco => best_free(predicted, candidates, &order, &taken, threshold),
        };
        let Some((index, iou)) = found else {
            return MatchOutcome::FalseAlarm;
        };
        let candidate = &candidates[index];
        if candidate.ignored {
            taken[index] = true;
            MatchOutcome::Ignored
        } else if taken[index] {
            MatchOutcome::FalseAlarm
        } else {
            taken[index] = true;
            MatchOutcome::Hit { truth: candidate.truth, iou }
        }
    };
    predicted.iter().map(outcome).collect()
}

/// The candidate that a box overlaps most, by more than the threshold, taken or not.
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

/// The best candidate that is free; one that does not count only where none that counts passes. Of
/// equals the last, as in `pycocotools`.
fn best_free(
    predicted: &Rect,
    candidates: &[TruthCandidate],
    order: &[usize],
    taken: &[bool],
    threshold: f64,
) -> Option<(usize, f64)> {
    let mut best: Option<(usize, f64)> = None;
    for &index in order {
        let candidate = &candidates[index];
        if taken[index] && !candidate.crowd {
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
