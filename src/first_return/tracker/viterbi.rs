//! The best path through the scores: for every cell, the most that a path through it can gather.

use super::TUNING;
use super::grid::{Grid, highest};

/// What moving the line from one ping to the next costs.
pub(super) struct Motion {
    /// Cells that it may move without a leap.
    pub limit: usize,
    /// Cost of each.
    pub cost: f32,
    /// Cost of going anywhere.
    pub leap: f32,
}

impl Motion {
    /// The motion on a grid of cells of this length.
    pub fn at(cell_m: f64) -> Self {
        Self {
            limit: ((TUNING.move_m / cell_m).ceil() as usize).clamp(6, 64),
            cost: (TUNING.move_cost_per_m * cell_m).min(TUNING.move_cost_per_cell) as f32,
            leap: TUNING.leap_cost,
        }
    }
}

/// For every cell, the score of the best path through it.
#[derive(Default)]
pub(super) struct Paths {
    through: Grid,
    reach: Reach,
}

impl Paths {
    /// The cell in each row that the best path goes through.
    ///
    /// Solved forward, then backward: the best path through a cell gathers `forward + backward - score`, and the highest
    /// of a row lies on the best path of all.
    pub fn line(&mut self, scores: &Grid, motion: &Motion) -> Vec<usize> {
        let (width, rows) = (scores.width(), scores.len());
        self.through.reset(rows, width, 0.0);
        for row in 0..rows {
            let (before, out) = self.through.row_after(row);
            out.copy_from_slice(scores.row(row));
            if !before.is_empty() {
                for (out, best) in out.iter_mut().zip(self.reach.of(before, motion)) {
                    *out += best;
                }
            }
        }
        let mut line = vec![0; rows];
        // What a path gathers after this row, by the best way on from each cell.
        let mut onward = vec![0.0; width];
        for row in (0..rows).rev() {
            let through = self.through.row_mut(row);
            for (through, onward) in through.iter_mut().zip(&onward) {
                *through += onward;
            }
            line[row] = highest(through);
            for (onward, score) in onward.iter_mut().zip(scores.row(row)) {
                *onward += score;
            }
            let best = self.reach.of(&onward, motion);
            onward.copy_from_slice(best);
        }
        line
    }
}

/// `max over |k| <= limit of value[j + k] - cost |k|` by doubling, or the best of all less a leap.
#[derive(Default)]
struct Reach {
    right: Vec<f32>,
    left: Vec<f32>,
    spare: Vec<f32>,
}

impl Reach {
    fn of(&mut self, values: &[f32], motion: &Motion) -> &[f32] {
        self.right.clear();
        self.right.extend_from_slice(values);
        self.left.clear();
        self.left.extend_from_slice(values);
        self.spare.resize(values.len(), 0.0);
        let mut covered = 1;
        while covered <= motion.limit {
            let step = covered.min(motion.limit + 1 - covered);
            if step >= values.len() {
                break;
            }
            let cost = motion.cost * step as f32;
            let kept = values.len() - step;
            // The halves that a shift has nothing for stay as they are.
            self.spare[kept..].copy_from_slice(&self.right[kept..]);
            higher(&mut self.spare, &self.right, &self.right[step..], cost);
            std::mem::swap(&mut self.right, &mut self.spare);
            self.spare[..step].copy_from_slice(&self.left[..step]);
            higher(
                &mut self.spare[step..],
                &self.left[step..],
                &self.left,
                cost,
            );
            std::mem::swap(&mut self.left, &mut self.spare);
            covered += step;
        }
        let leap = maximum(values) - motion.leap;
        for (right, &left) in self.right.iter_mut().zip(&self.left) {
            *right = larger(larger(*right, left), leap);
        }
        &self.right
    }
}

/// `out = max(stay, moved - cost)`, for as long as all of them last.
fn higher(out: &mut [f32], stay: &[f32], moved: &[f32], cost: f32) {
    for ((out, &stay), &moved) in out.iter_mut().zip(stay).zip(moved) {
        *out = larger(stay, moved - cost);
    }
}

/// Scores are never NaN; without `f32::max`'s care for it this is a single instruction.
fn larger(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// The highest value; in lanes, so that it is not one long chain of comparisons.
fn maximum(values: &[f32]) -> f32 {
    let mut lanes = [f32::NEG_INFINITY; 16];
    let (blocks, rest) = values.as_chunks::<16>();
    for block in blocks {
        for (lane, &value) in lanes.iter_mut().zip(block) {
            *lane = larger(*lane, value);
        }
    }
    lanes
        .iter()
        .chain(rest)
        .copied()
        .fold(f32::NEG_INFINITY, larger)
}
