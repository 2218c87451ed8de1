//! Finds the bottom edge as a whole line: the path over range, along the track, with most evidence
//! of a step from water to bottom and the fewest leaps.
//!
//! In: a survey, with the normalisation of its picture. Out: a first return with its evidence for
//! each ping on both sides.
//!
//! `rows` divides the log where the line may break, and into chunks, and loads the picture. `score`
//! measures the step at every sample and limits the line by the recorded depth, and `viterbi` finds
//! the best path; where the bottom moves fast, both follow a `trend`. `refine` finds the edge
//! within a fraction of a sample on the picture that `grid` aligns along the line, with the earlier
//! echoes just before it.
//!
//! The settings were chosen on simulated ponds and verified on real recordings. Lengths that depend
//! on the bottom are in metres, with limits in cells of the picture where they depend on the
//! recorder's grid: a range of 37 m in 512 samples is coarser than any step.

mod grid;
mod refine;
mod rows;
mod score;
mod trend;
mod viterbi;

use super::confidence::MethodPick;
use super::{FirstReturnSettings, Normalisation};
use bathyscope_log::support::progress::{Cancelled, Progress};
use bathyscope_log::support::statistics::usual_step;
use bathyscope_log::survey::{Side, Survey};
use grid::TrackerGrid;
use rayon::prelude::*;
use rows::TrackerChunk;
use score::Scores;
use std::ops::Range;
use trend::Trend;

/// Cost in score of a place beyond the limit of a believed depth: more than any step gathers.
const FARTHER_COST: f32 = 8.0;
/// Least mean score at which a line before the recorded depth is the bottom, whatever is beyond:
/// beside walls, and over ground beside boulders, the mean is 2.2 to 3.5 where the bottom is before
/// the depth, and below 1.2 where it is not (a slope, a depth that is late).
const WITHIN_EVIDENCE: f32 = 1.7;
/// Least mean score of a line over [`ALONG`] rows to both sides; a line with less is no bottom.
const LEAST_EVIDENCE: f32 = 0.8;
/// Number of rows before and after a row that its evidence is averaged over.
const ALONG: usize = 4;
/// Distance from the line beyond which another step is a rival, metres.
const RIVAL_M: f64 = 0.25;

/// Tracks the bottom on both sides (port, starboard) of `pings`.
pub(super) fn track(
    survey: &Survey,
    normalisation: &Normalisation,
    settings: &FirstReturnSettings,
    pings: Range<usize>,
    progress: &Progress,
) -> Result<[Vec<MethodPick>; 2], Cancelled> {
    let mut sides = [Vec::new(), Vec::new()];
    let chunks = Side::BOTH.map(|side| rows::chunks(survey, side, &pings));
    progress.start(chunks.iter().flatten().map(|chunk| chunk.kept.len() as u64).sum());
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
        picks.resize(pings.len(), MethodPick::NONE);
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

/// Conditions that the line of a chunk is found under.
struct Task {
    kernel: score::Kernel,
    depths: score::Depths,
    motion: viterbi::MotionCost,
    /// Usual time between two pings, seconds.
    interval_s: f64,
    /// Length of a cell, metres.
    cell_m: f64,
}

/// Line through a chunk, with a value of each kind for each row.
struct FoundLine {
    /// Cell of the line.
    cells: Vec<usize>,
    /// Trend that the line follows.
    trend: Trend,
    /// Mean score around the row; `None` where the line gives no pick.
    evidence: Vec<Option<f32>>,
    /// Lead over the best line that passes nearer, and over the best that passes farther.
    margins: Vec<[f32; 2]>,
    /// Score that the whole line gathers.
    gathered: f32,
}

impl FoundLine {
    /// Returns true if the line gives a pick on each row and never moves more than `limit` cells.
    fn is_whole(&self, limit: usize) -> bool {
        let leaps = self.cells.windows(2).any(|pair| pair[0].abs_diff(pair[1]) > limit);
        !leaps && self.evidence.iter().all(Option::is_some)
    }
}

/// Buffers that a worker thread reuses for one chunk after another.
#[derive(Default)]
struct Workspace {
    rows: rows::SampleRows,
    scores: score::Scores,
    paths: viterbi::Paths,
    refiner: refine::Refiner,
}

impl Workspace {
    /// Returns the best line. It stays before the recorded depth where the echo shows a bottom
    /// there too.
    fn line_within(&mut self, trend: &Trend, task: &Task) -> Vec<usize> {
        let Task { depths, motion, .. } = task;
        let line = self.paths.line(&self.scores.grid, trend, motion);
        if !depths.is_passed(&line) {
            return line;
        }
        if depths.bounds(&line) {
            depths.lower_beyond(&(0..line.len()), FARTHER_COST, &mut self.scores);
            return self.paths.line(&self.scores.grid, trend, motion);
        }
        let leaps = depths.leaps(&line);
        if leaps.is_empty() {
            return line;
        }
        for rows in &leaps {
            depths.lower_beyond(rows, FARTHER_COST, &mut self.scores);
        }
        let bounded_line = self.paths.line(&self.scores.grid, trend, motion);
        let mut is_restored = false;
        for rows in &leaps {
            let evidence = mean_score(&self.scores.grid, &bounded_line, rows);
            if evidence < WITHIN_EVIDENCE {
                depths.lower_beyond(rows, -FARTHER_COST, &mut self.scores);
                is_restored = true;
            }
        }
        if is_restored { self.paths.line(&self.scores.grid, trend, motion) } else { bounded_line }
    }

    /// Finds the line along the trend that the rows are averaged along.
    fn found_line(&mut self, trend: Trend, task: &Task) -> FoundLine {
        task.depths.weigh(&mut self.scores);
        let cells = self.line_within(&trend, task);
        let apart = (RIVAL_M / task.cell_m).ceil() as usize;
        FoundLine {
            evidence: evidence(&self.scores.grid, &cells),
            margins: self.paths.margins(&cells, apart),
            gathered: self.paths.gathered(),
            cells,
            trend,
        }
    }

    /// Returns the line with the trend with which it gathers most: none, or, where the line leaps
    /// or is lost, that of a loose line or of the recorded depths.
    fn best_line(&mut self, task: &Task) -> FoundLine {
        self.scores.measure(&self.rows, &task.kernel);
        let mut best = self.found_line(Trend::default(), task);
        if best.is_whole(task.motion.limit) {
            return best;
        }
        let loose = self.paths.line(&self.scores.grid, &Trend::default(), &task.motion.loose());
        let loose: Vec<f64> = loose.iter().map(|&cell| cell as f64).collect();
        let Task { depths, interval_s, cell_m, .. } = task;
        for trend in Trend::candidates(&loose, &depths.cells, *interval_s, *cell_m) {
            self.scores.measure_along(&trend, &self.rows, &task.kernel);
            let found = self.found_line(trend, task);
            if found.gathered > best.gathered {
                best = found;
            }
        }
        best
    }

    fn track(
        &mut self,
        survey: &Survey,
        normalisation: &Normalisation,
        settings: &FirstReturnSettings,
        side: Side,
        chunk: &TrackerChunk,
    ) -> Vec<MethodPick> {
        let cell_m = chunk.metres_per_sample * rows::cell(normalisation.samples) as f64;
        self.rows.load(survey, normalisation, side, chunk);
        let motion = viterbi::MotionCost::at(cell_m);
        let limit = motion.limit;
        let times_s = chunk.pings.iter().map(|&ping| survey.side_scan[ping as usize].time_s);
        let line = self.best_line(&Task {
            kernel: score::Kernel::new(normalisation, settings, chunk, cell_m),
            depths: score::Depths::of(survey, chunk, cell_m),
            motion,
            interval_s: usual_step(times_s),
            cell_m,
        });
        let FoundLine { cells, trend, evidence, margins, .. } = line;
        let places = self.refiner.refine(&self.rows, &cells, &trend, limit, cell_m);
        let samples_per_cell = rows::cell(normalisation.samples) as f32;
        let kept = chunk.kept.clone();
        kept.map(|row| match evidence[row] {
            None => MethodPick::NONE,
            Some(evidence) => MethodPick {
                sample: places[row] * samples_per_cell,
                signs: [evidence, margins[row][0], margins[row][1]],
            },
        })
        .collect()
    }
}

/// Returns the mean score of the line around each row; `None` where the line gives no pick.
fn evidence(scores: &TrackerGrid, line: &[usize]) -> Vec<Option<f32>> {
    let own: Vec<f32> = (0..line.len()).map(|row| scores.row(row)[line[row]]).collect();
    (0..line.len())
        .map(|row| {
            let near = row.saturating_sub(ALONG)..line.len().min(row + ALONG + 1);
            let evidence = mean(&own[near]);
            (own[row] > Scores::CLOSED && evidence >= LEAST_EVIDENCE).then_some(evidence)
        })
        .collect()
}

/// Returns the mean score of the line over some rows.
fn mean_score(scores: &TrackerGrid, line: &[usize], rows: &Range<usize>) -> f32 {
    let own: Vec<f32> = rows.clone().map(|row| scores.row(row)[line[row]]).collect();
    mean(&own)
}

fn mean(values: &[f32]) -> f32 {
    values.iter().sum::<f32>() / values.len().max(1) as f32
}
