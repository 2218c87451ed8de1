//! Limits the place of the line by the recorded depth.

use super::rows::TrackerChunk;
use super::score::Scores;
use crate::first_return::confidence::farthest_m;
use bathyscope_log::survey::Survey;
use std::ops::Range;

/// Cost in score of a place outside the window around the recorded depth.
const DEPTH_COST: f32 = 1.2;
/// Window around the recorded depth, as shares of the depth.
const DEPTH_WINDOW: (f64, f64) = (0.65, 1.12);
/// Share of the pings whose line must be within the limits of the depth for the depth to be
/// believed everywhere.
const DEPTH_TRUST: f64 = 0.9;
/// Multiple of the recorded depth beyond which the line has leapt.
const LEAP_SHARE: f64 = 1.25;
/// Largest number of consecutive rows within a stretch that are not far beyond the depth.
const PAUSE: usize = 8;

/// Recorded depths along a chunk, in cells of its picture.
pub(super) struct Depths {
    /// Depth at each row, cells of range; NaN where there is none to believe.
    cells: Vec<f64>,
    /// Range at which the picture starts, cells: it may be more than 0.
    near: f64,
    /// Length of a cell, metres.
    cell_m: f64,
}

impl Depths {
    /// Creates the depths of the pings of a chunk.
    pub(super) fn of(survey: &Survey, chunk: &TrackerChunk, cell_m: f64) -> Self {
        let depths = chunk.pings.iter().map(|&ping| {
            let depth_m = f64::from(survey.good_depth_m(ping as usize));
            if depth_m > 0.0 { depth_m / cell_m } else { f64::NAN }
        });
        Self { cells: depths.collect(), near: chunk.near_m / cell_m, cell_m }
    }

    /// Lowers the scores of cells far from the recorded depth. The cost is small, since that depth
    /// may be wrong; without a depth nothing changes.
    pub(super) fn weigh(&self, scores: &mut Scores) {
        let (near, far) = DEPTH_WINDOW;
        for (row, depth) in self.known() {
            scores.lower(row, ..self.cell(near * depth), DEPTH_COST);
            scores.lower(row, self.cell(far * depth).., DEPTH_COST);
        }
    }

    /// Returns true if some of the line is beyond the recorded depth: the bottom below the boat
    /// returns at that range, so nothing farther can be the first return. Under the echo of a
    /// boulder or a wreck the line continues along the ground.
    pub(super) fn is_passed(&self, line: &[usize]) -> bool {
        self.known().any(|(row, depth)| line[row] > self.limit(depth))
    }

    /// Returns the stretches of rows in which the line is far beyond the recorded depth, for
    /// example where it leapt to a wall. A line a little beyond the depth is the edge of the bottom
    /// where the depth is late or rounded.
    pub(super) fn leaps(&self, line: &[usize]) -> Vec<Range<usize>> {
        let mut stretches: Vec<Range<usize>> = Vec::new();
        let is_far = |&(row, depth): &(usize, f64)| line[row] > self.cell(LEAP_SHARE * depth);
        for (row, _) in self.known().filter(is_far) {
            match stretches.last_mut() {
                Some(last) if row - last.end <= PAUSE => last.end = row + 1,
                _ => stretches.push(row..row + 1),
            }
        }
        stretches
    }

    /// Lowers the scores of cells beyond the recorded depth in some rows by a cost; a cost below
    /// zero raises them again.
    pub(super) fn lower_beyond(&self, rows: &Range<usize>, cost: f32, scores: &mut Scores) {
        for (row, depth) in self.known().filter(|(row, _)| rows.contains(row)) {
            scores.lower(row, self.limit(depth).., cost);
        }
    }

    /// Returns true if the line is within the limits of the depth on nearly all pings of the chunk,
    /// so that the depth can be believed at every ping.
    pub(super) fn bounds(&self, line: &[usize]) -> bool {
        let nearest = |depth: f64| self.cell(DEPTH_WINDOW.0 * depth);
        let (mut known, mut agreeing) = (0, 0);
        for (row, depth) in self.known() {
            known += 1;
            agreeing += usize::from((nearest(depth)..=self.limit(depth)).contains(&line[row]));
        }
        agreeing as f64 >= DEPTH_TRUST * f64::from(known)
    }

    /// Returns the farthest cell at which the bottom below the boat returns; `depth` is in cells.
    fn limit(&self, depth: f64) -> usize {
        self.cell(farthest_m(depth * self.cell_m) / self.cell_m)
    }

    fn known(&self) -> impl Iterator<Item = (usize, f64)> {
        let all = self.cells.iter().copied().enumerate();
        all.filter(|(_, depth)| depth.is_finite())
    }

    /// Returns the index of the cell of the picture at a range in cells.
    fn cell(&self, range: f64) -> usize {
        (range - self.near).max(0.0) as usize
    }
}
