//! What the recorded depth says about where the line can lie.

use super::TUNING;
use super::runs::TrackerChunk;
use super::score::Scores;
use bathyscope_log::survey::Survey;

/// The recorded depth along a chunk, in cells of its picture.
pub(super) struct Depths {
    /// NaN where there is none to believe.
    cells: Vec<f64>,
    /// Cells before the picture begins: it may start at a range beyond 0.
    near: f64,
}

impl Depths {
    /// The depths of a chunk's pings.
    pub(super) fn of(survey: &Survey, chunk: &TrackerChunk, cell_m: f64) -> Self {
        let depths = chunk.pings.iter().map(|&ping| {
            let depth_m = f64::from(survey.locked_depth_m(ping as usize));
            if depth_m > 0.0 { depth_m / cell_m } else { f64::NAN }
        });
        Self { cells: depths.collect(), near: chunk.near_m / cell_m }
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

    /// Lowers what lies beyond the recorded depth, if any of the line does: the bottom below the
    /// boat returns at that range, so nothing farther can be the first return. Under a boulder's or
    /// a wreck's echo the line would else run on along the ground. Returns whether anything was
    /// lowered.
    ///
    /// The depth must have earned it: it is believed where it bounds the line on nearly all pings
    /// of the chunk.
    pub(super) fn forbid_beyond(&self, line: &[usize], scores: &mut Scores) -> bool {
        let nearest = |depth: f64| self.cell(TUNING.depth_window.0 * depth);
        let limit = |depth: f64| self.cell(TUNING.farthest_share * depth);
        let (mut known, mut agreeing, mut beyond) = (0, 0, 0);
        for (row, depth) in self.known() {
            known += 1;
            agreeing += usize::from((nearest(depth)..=limit(depth)).contains(&line[row]));
            beyond += usize::from(line[row] > limit(depth));
        }
        if beyond == 0 || (agreeing as f64) < TUNING.depth_trust * f64::from(known) {
            return false;
        }
        for (row, depth) in self.known() {
            scores.lower(row, limit(depth).., TUNING.farther_cost);
        }
        true
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
