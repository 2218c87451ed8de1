//! Reads the picks off the best path: the cell, the place within it, and how sure it is.

use super::super::{Normalisation, Pick};
use super::rows;
use super::runs::Chunk;
use super::score::Scores;
use super::viterbi::Paths;

/// A path whose mean score along these pings to both sides is lower is no bottom.
const LEAST_EVIDENCE: f32 = 0.8;

/// Pings to both sides that evidence is averaged over.
const ALONG: usize = 4;

/// Distance from the line at which another step is a rival, metres.
const RIVAL_M: f64 = 0.25;

/// Picks of the pings that the chunk answers for.
pub(super) fn read(
    scores: &Scores,
    paths: &Paths,
    chunk: &Chunk,
    cell_m: f64,
    normalisation: &Normalisation,
) -> Vec<Pick> {
    if scores.width < 3 {
        return vec![Pick::NONE; chunk.kept.len()];
    }
    let line: Vec<usize> = (0..scores.len())
        .map(|row| highest(paths.row(row)))
        .collect();
    let apart = (RIVAL_M / cell_m).ceil() as usize;
    let own: Vec<f32> = (0..line.len())
        .map(|row| scores.row(row)[line[row]])
        .collect();
    let rival: Vec<f32> = (0..line.len())
        .map(|row| strongest_apart(scores.row(row), line[row], apart))
        .collect();
    let samples_per_cell = rows::cell(normalisation.samples) as f32;
    chunk
        .kept
        .clone()
        .map(|row| {
            let near = row.saturating_sub(ALONG)..line.len().min(row + ALONG + 1);
            let evidence = mean(&own[near.clone()]);
            if own[row] <= Scores::CLOSED || evidence < LEAST_EVIDENCE {
                return Pick::NONE;
            }
            let margin = (evidence - mean(&rival[near]).max(0.0)) / evidence;
            Pick {
                sample: (line[row] as f32 + peak_offset(scores.row(row), line[row]))
                    * samples_per_cell,
                confidence: margin.clamp(0.0, 1.0),
                canopy: false,
            }
        })
        .collect()
}

fn highest(values: &[f32]) -> usize {
    let mut best = 0;
    for (at, &value) in values.iter().enumerate() {
        if value > values[best] {
            best = at;
        }
    }
    best
}

fn strongest_apart(scores: &[f32], line: usize, apart: usize) -> f32 {
    let nearer = &scores[..line.saturating_sub(apart)];
    let farther = &scores[scores.len().min(line + apart + 1)..];
    nearer
        .iter()
        .chain(farther)
        .copied()
        .fold(Scores::CLOSED, f32::max)
}

fn mean(values: &[f32]) -> f32 {
    values.iter().sum::<f32>() / values.len().max(1) as f32
}

/// Where between its neighbours a parabola through three scores peaks, -0.5 to 0.5.
fn peak_offset(scores: &[f32], at: usize) -> f32 {
    let (Some(&before), Some(&after)) = (
        at.checked_sub(1).and_then(|before| scores.get(before)),
        scores.get(at + 1),
    ) else {
        return 0.0;
    };
    let curve = 2.0 * scores[at] - before - after;
    if curve <= 0.0 {
        return 0.0;
    }
    (0.5 * (after - before) / curve).clamp(-0.5, 0.5)
}
