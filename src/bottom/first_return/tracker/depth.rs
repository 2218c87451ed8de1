//! Limits that the recorded depth sets to the place of the line.

use super::super::beyond_depth::farthest_m;
use super::TUNING;
use super::runs::TrackerChunk;
use super::score::Scores;
use bathyscope_log::survey::Survey;
use std::ops::Range;

/// Longest pause in a stretch, rows: rows that do not lie far beyond the depth.
const PAUSE: usize = 8;

/// The recorded depth along a chunk, in cells of its picture.
pub(super) struct Depths {
    /// NaN where there is none to believe.
    cells: Vec<f64>,
    /// Cells before the picture begins: it may start at a range beyond 0.
    near: f64,
    /// Length of a cell, metres.
    cell_m: f64,
}

impl Depths {
    /// The depths of a chunk's pings.
    pub(super) fn of(survey: &Survey, chunk: &TrackerChunk, cell_m: f64) -> Self {
        let depths = chunk.pings.iter().map(|&ping| {
            let depth_m = f64::from(survey.good_depth_m(ping as usize));
            if depth_m > 0.0 { depth_m / cell_m } else { f64::NAN }
        });
        Self { cells: depths.collect(), near: chunk.near_m / cell_m, cell_m }
    }

    /// Lowers what lies far from the recorded depth. Soft, since that depth may be wrong; no depth,
    /// no change.
    pub(super) fn weigh(&self, scores: &mut Scores) {
        let (near, far) = TUNING.depth_window;
        for (row, depth) in self.known() {
            scores.lower(row, ..self.cell(near * depth), TUNING.depth_cost);
            scores.lower(row, self.cell(far * depth).., TUNING.depth_cost);
        }
    }

    /// True where some of the line lies beyond the recorded depth: the bottom below the boat
    /// returns at that range, so nothing farther can be the first return. Under a boulder's or a
    /// wreck's echo the line runs on along the ground.
    pub(super) fn is_passed(&self, line: &[usize]) -> bool {
        self.known().any(|(row, depth)| line[row] > self.limit(depth))
    }

    /// The stretches in which the line lies far beyond the recorded depth, as where it leapt to a
    /// wall. A little beyond it is the edge of the bottom where the depth is late or rounded.
    pub(super) fn leaps(&self, line: &[usize]) -> Vec<Range<usize>> {
        let mut stretches: Vec<Range<usize>> = Vec::new();
        let is_far =
            |&(row, depth): &(usize, f64)| line[row] > self.cell(TUNING.leap_share * depth);
        for (row, _) in self.known().filter(is_far) {
            match stretches.last_mut() {
                Some(last) if row - last.end <= PAUSE => last.end = row + 1,
                _ => stretches.push(row..row + 1),
            }
        }
        stretches
    }

    /// Lowers what lies beyond the recorded depth in some rows.
    pub(super) fn forbid_beyond(&self, rows: &Range<usize>, scores: &mut Scores) {
        self.lower_beyond(rows, TUNING.farther_cost, scores);
    }

    /// Takes [`Depths::forbid_beyond`] back.
    pub(super) fn allow_beyond(&self, rows: &Range<usize>, scores: &mut Scores) {
        self.lower_beyond(rows, -TUNING.farther_cost, scores);
    }

    fn lower_beyond(&self, rows: &Range<usize>, cost: f32, scores: &mut Scores) {
        for (row, depth) in self.known().filter(|(row, _)| rows.contains(row)) {
            scores.lower(row, self.limit(depth).., cost);
        }
    }

    /// True where the depth bounds the line on nearly all pings of the chunk, and so has earned to
    /// be believed everywhere.
    pub(super) fn bounds(&self, line: &[usize]) -> bool {
        let nearest = |depth: f64| self.cell(TUNING.depth_window.0 * depth);
        let (mut known, mut agreeing) = (0, 0);
        for (row, depth) in self.known() {
            known += 1;
            agreeing += usize::from((nearest(depth)..=self.limit(depth)).contains(&line[row]));
        }
        agreeing as f64 >= TUNING.depth_trust * f64::from(known)
    }

    /// The farthest cell at which the bottom below the boat returns.
    fn limit(&self, depth: f64) -> usize {
        self.cell(farthest_m(depth * self.cell_m) / self.cell_m)
    }

    fn known(&self) -> impl Iterator<Item = (usize, f64)> {
        let all = self.cells.iter().copied().enumerate();
        all.filter(|(_, depth)| depth.is_finite())
    }

    /// The picture's cell at a range in cells.
    fn cell(&self, range: f64) -> usize {
        (range - self.near).max(0.0) as usize
    }
}
