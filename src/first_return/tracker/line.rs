//! Which rows of the line are picks, and how sure they are.

use super::grid::Grid;
use super::score::Scores;

/// A line whose mean score along these rows to both sides is lower is no bottom.
const LEAST_EVIDENCE: f32 = 0.8;

/// Rows to both sides that evidence is averaged over.
const ALONG: usize = 4;

/// Distance from the line at which another step is a rival, metres.
const RIVAL_M: f64 = 0.25;

/// How sure each row of the line is, 0 to 1; `None` where it is no pick.
///
/// The margin by which the line's score exceeds that of the strongest step elsewhere in the row, as a share of it.
pub(super) fn confidence(scores: &Grid, line: &[usize], cell_m: f64) -> Vec<Option<f32>> {
    let apart = (RIVAL_M / cell_m).ceil() as usize;
    let own: Vec<f32> = (0..line.len())
        .map(|row| scores.row(row)[line[row]])
        .collect();
    let rival: Vec<f32> = (0..line.len())
        .map(|row| strongest_apart(scores.row(row), line[row], apart))
        .collect();
    (0..line.len())
        .map(|row| {
            let near = row.saturating_sub(ALONG)..line.len().min(row + ALONG + 1);
            let evidence = mean(&own[near.clone()]);
            if own[row] <= Scores::CLOSED || evidence < LEAST_EVIDENCE {
                return None;
            }
            let margin = (evidence - mean(&rival[near]).max(0.0)) / evidence;
            Some(margin.clamp(0.0, 1.0))
        })
        .collect()
}

fn strongest_apart(scores: &[f32], line: usize, apart: usize) -> f32 {
    let nearer = &scores[..line.saturating_sub(apart)];
    let farther = &scores[scores.len().min(line + apart + 1)..];
    let all = nearer.iter().chain(farther).copied();
    all.fold(Scores::CLOSED, f32::max)
}

fn mean(values: &[f32]) -> f32 {
    values.iter().sum::<f32>() / values.len().max(1) as f32
}
