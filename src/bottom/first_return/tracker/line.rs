//! Selects the rows of the line that are picks, and measures the evidence for them.

use super::grid::TrackerGrid;
use super::score::Scores;
use std::ops::Range;

/// A line whose mean score along these rows to both sides is lower is no bottom.
const LEAST_EVIDENCE: f32 = 0.8;

/// Rows to both sides that evidence is averaged over.
const ALONG: usize = 4;

/// Distance from the line at which another step is a rival, metres.
pub(super) const RIVAL_M: f64 = 0.25;

/// The mean score of the line around each row; `None` where it is no pick.
pub(super) fn evidence(scores: &TrackerGrid, line: &[usize]) -> Vec<Option<f32>> {
    let own: Vec<f32> = (0..line.len()).map(|row| scores.row(row)[line[row]]).collect();
    (0..line.len())
        .map(|row| {
            let near = row.saturating_sub(ALONG)..line.len().min(row + ALONG + 1);
            let evidence = mean(&own[near]);
            (own[row] > Scores::CLOSED && evidence >= LEAST_EVIDENCE).then_some(evidence)
        })
        .collect()
}

/// The mean score of the line over some rows.
pub(super) fn mean_score(scores: &TrackerGrid, line: &[usize], rows: &Range<usize>) -> f32 {
    let own: Vec<f32> = rows.clone().map(|row| scores.row(row)[line[row]]).collect();
    mean(&own)
}

fn mean(values: &[f32]) -> f32 {
    values.iter().sum::<f32>() / values.len().max(1) as f32
}
