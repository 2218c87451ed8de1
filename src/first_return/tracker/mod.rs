//! The bottom edge as a whole line: the path over range, along the track, that gathers most evidence of a step from water
//! to bottom and jumps least.
//!
//! `runs` cuts the log where the line may break and into chunks, `rows` brings the picture, `score` measures the step at
//! every sample, `viterbi` finds the best path, `line` reads picks and their confidence off it.

mod line;
mod rows;
mod runs;
mod score;
mod viterbi;

use super::{FirstReturnSettings, Normalisation, Pick};
use crate::progress::{Cancelled, Progress};
use crate::survey::{Side, Survey};
use rayon::prelude::*;
use runs::Chunk;
use std::ops::Range;

/// What the tracker is set to, in metres; chosen on simulated ponds and looked at on the real river.
struct Tuning {
    /// Length of the windows compared on both sides of a step.
    window_m: f64,
    /// Largest jump of the line from ping to ping.
    jump_m: f64,
    /// Score that a metre of jump costs.
    jump_cost_per_m: f64,
    /// Score that lying outside the window around the recorded depth costs.
    depth_cost: f32,
    /// Window around the recorded depth, as shares of it.
    depth_window: (f64, f64),
}

const TUNING: Tuning = Tuning {
    window_m: 0.20,
    jump_m: 0.052,
    jump_cost_per_m: 117.0,
    depth_cost: 2.0,
    depth_window: (0.65, 1.12),
};

/// Picks of both sides (port, starboard) for `pings`, without canopy flags.
pub(super) fn track(
    survey: &Survey,
    normalisation: &Normalisation,
    settings: &FirstReturnSettings,
    pings: Range<usize>,
    progress: &Progress,
) -> Result<[Vec<Pick>; 2], Cancelled> {
    let mut sides = [Vec::new(), Vec::new()];
    let chunks = Side::BOTH.map(|side| runs::chunks(survey, side, &pings));
    progress.start(
        chunks
            .iter()
            .flatten()
            .map(|chunk| chunk.kept.len() as u64)
            .sum(),
    );
    for ((side, chunks), picks) in Side::BOTH.into_iter().zip(&chunks).zip(&mut sides) {
        let tracked = chunks
            .par_iter()
            .map_init(Workspace::default, |workspace, chunk| {
                progress.check()?;
                let picks = workspace.track(survey, normalisation, settings, side, chunk);
                progress.advance(chunk.kept.len() as u64);
                Ok(picks)
            })
            .collect::<Result<Vec<_>, Cancelled>>()?;
        picks.resize(pings.len(), Pick::NONE);
        for (chunk, tracked) in chunks.iter().zip(tracked) {
            for (&ping, pick) in chunk.kept_pings().iter().zip(tracked) {
                if pings.contains(&(ping as usize)) {
                    picks[ping as usize - pings.start] = pick;
                }
            }
        }
    }
    Ok(sides)
}

/// Buffers that a worker uses for one chunk after another.
#[derive(Default)]
struct Workspace {
    rows: rows::Rows,
    scores: score::Scores,
    paths: viterbi::Paths,
}

impl Workspace {
    fn track(
        &mut self,
        survey: &Survey,
        normalisation: &Normalisation,
        settings: &FirstReturnSettings,
        side: Side,
        chunk: &Chunk,
    ) -> Vec<Pick> {
        let cell_m = chunk.metres_per_sample * rows::cell(normalisation.samples) as f64;
        self.rows.load(survey, normalisation, side, chunk);
        self.scores.measure(
            &self.rows,
            &score::Kernel::new(normalisation, settings, chunk, cell_m),
        );
        for (row, &ping) in chunk.pings.iter().enumerate() {
            let depth_m = survey
                .side_scan
                .get(ping as usize)
                .map_or(f32::NAN, |ping| ping.depth_m);
            self.scores
                .weigh_depth(row, f64::from(depth_m), chunk, cell_m);
        }
        let jump = viterbi::Jump {
            limit: ((TUNING.jump_m / cell_m).ceil() as usize).clamp(2, 64),
            cost: (TUNING.jump_cost_per_m * cell_m) as f32,
        };
        self.paths.solve(&self.scores, &jump);
        line::read(&self.scores, &self.paths, chunk, cell_m, normalisation)
    }
}
