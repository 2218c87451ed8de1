//! Finds the best path through the scores, from the largest score that a path through each cell can
//! gather.

use super::grid::{TrackerGrid, highest, larger, maximum};
use super::trend::{Trend, overlap};
use crate::vectors::{VectorLoop, vectorised};

/// Largest movement of the line from ping to ping without a leap, metres.
const MOVE_M: f64 = 0.08;
/// Cost in score of a metre of such a movement, limited to [`MOVE_COST_PER_CELL`] for each cell.
/// The cost is low because a bottom that slopes 20 degrees along the track moves 5 cm at every
/// ping, and the line must follow it.
const MOVE_COST_PER_M: f64 = 35.0;
/// Largest cost of a cell of such a movement.
const MOVE_COST_PER_CELL: f64 = 0.3;
/// Cost in score of a leap to any cell: at the edge of a boulder, a weed bed or a wall.
const LEAP_COST: f32 = 7.0;

/// Cost of moving the line from one ping to the next.
pub(super) struct MotionCost {
    /// Largest movement of the line without a leap, cells.
    pub limit: usize,
    /// Cost of each cell of movement.
    pub cost: f32,
    /// Cost of a leap to any cell.
    pub leap: f32,
}

impl MotionCost {
    /// Creates the cost of motion on a grid with cells of this length in metres.
    pub(super) fn at(cell_m: f64) -> Self {
        Self {
            limit: ((MOVE_M / cell_m).ceil() as usize).clamp(6, 64),
            cost: (MOVE_COST_PER_M * cell_m).min(MOVE_COST_PER_CELL) as f32,
            leap: LEAP_COST,
        }
    }

    /// Returns the cost of a line that follows banks whose movement from row to row is not known.
    pub(super) fn loose(&self) -> Self {
        Self { limit: LOOSER * self.limit, cost: self.cost / LOOSER as f32, ..*self }
    }
}

/// Factor by which a loose line moves farther at the same cost.
const LOOSER: usize = 8;

/// Score of the best path through every cell, with buffers.
#[derive(Default)]
pub(super) struct Paths {
    through: TrackerGrid,
    reach: Reach,
    /// Scores of a row, moved along a trend.
    moved: Vec<f32>,
}

impl Paths {
    /// Returns the cell of each row that the best path goes through.
    ///
    /// The path is solved forward, then backward: the best path through a cell gathers `forward +
    /// backward - score`, and the cell with the highest sum of a row is on the best path of all.
    /// Movement along `trend` has no cost.
    pub(super) fn line(
        &mut self,
        scores: &TrackerGrid,
        trend: &Trend,
        motion: &MotionCost,
    ) -> Vec<usize> {
        vectorised(BestLine { paths: self, scores, trend, motion })
    }

    /// Returns the score that the line gathers that was found last.
    pub(super) fn gathered(&self) -> f32 {
        if self.through.len() == 0 { 0.0 } else { maximum(self.through.row(0)) }
    }

    /// Returns for each row the difference in score between the line and the best path that passes
    /// more than `apart` cells nearer, or farther; at most [`MOST_MARGIN`]. `line` must be the line
    /// that was found last.
    pub(super) fn margins(&self, line: &[usize], apart: usize) -> Vec<[f32; 2]> {
        vectorised(Margins { paths: self, line, apart })
    }
}

/// Arguments of [`Paths::line`] for the vectorised loop.
struct BestLine<'a> {
    paths: &'a mut Paths,
    scores: &'a TrackerGrid,
    trend: &'a Trend,
    motion: &'a MotionCost,
}

impl VectorLoop for BestLine<'_> {
    type Output = Vec<usize>;

    #[inline(always)]
    fn run(self) -> Vec<usize> {
        let Self { paths, scores, trend, motion } = self;
        let (width, rows) = (scores.width, scores.len());
        paths.through.reset(rows, width, 0.0);
        for row in 0..rows {
            let (before, out) = paths.through.row_after(row);
            out.copy_from_slice(scores.row(row));
            if !before.is_empty() {
                let before = moved(before, trend.step(row), &mut paths.moved);
                for (out, best) in out.iter_mut().zip(paths.reach.of(before, motion)) {
                    *out += best;
                }
            }
        }
        let mut line = vec![0; rows];
        // Score that the best path from each cell gathers after this row.
        let mut onward = vec![0.0; width];
        for row in (0..rows).rev() {
            let through = paths.through.row_mut(row);
            for (through, onward) in through.iter_mut().zip(&onward) {
                *through += onward;
            }
            line[row] = highest(through);
            for (onward, score) in onward.iter_mut().zip(scores.row(row)) {
                *onward += score;
            }
            let behind = moved(&onward, -trend.step(row), &mut paths.moved);
            let best = paths.reach.of(behind, motion);
            onward.copy_from_slice(best);
        }
        line
    }
}

/// Arguments of [`Paths::margins`] for the vectorised loop.
struct Margins<'a> {
    paths: &'a Paths,
    line: &'a [usize],
    apart: usize,
}

impl VectorLoop for Margins<'_> {
    type Output = Vec<[f32; 2]>;

    #[inline(always)]
    fn run(self) -> Vec<[f32; 2]> {
        let Self { paths, line, apart } = self;
        let mut margins = Vec::with_capacity(line.len());
        for (row, &at) in line.iter().enumerate() {
            let through = paths.through.row(row);
            let nearer = maximum(&through[..at.saturating_sub(apart)]);
            let farther = maximum(&through[through.len().min(at + apart + 1)..]);
            let margin = |others: f32| (through[at] - others).min(MOST_MARGIN);
            margins.push([margin(nearer), margin(farther)]);
        }
        margins
    }
}

/// Upper limit of a margin: two leaps and the row's own step. A larger margin has no further
/// meaning.
const MOST_MARGIN: f32 = 20.0;

/// Buffers for the best score that each cell can be reached with: `max over |k| <= limit of value[j
/// + k] - cost |k|`, computed by doubling, or the best of all cells less the cost of a leap.
#[derive(Default)]
struct Reach {
    right: Vec<f32>,
    left: Vec<f32>,
    spare: Vec<f32>,
}

impl Reach {
    #[inline(always)]
    fn of(&mut self, values: &[f32], motion: &MotionCost) -> &[f32] {
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
            // Cells without a shifted counterpart stay as they are.
            self.spare[kept..].copy_from_slice(&self.right[kept..]);
            higher(&mut self.spare, &self.right, &self.right[step..], cost);
            std::mem::swap(&mut self.right, &mut self.spare);
            self.spare[..step].copy_from_slice(&self.left[..step]);
            higher(&mut self.spare[step..], &self.left[step..], &self.left, cost);
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

/// Score of a cell that moved into the picture.
const UNSEEN: f32 = -1e6;

/// Returns the values of a row moved by some cells to the next row.
#[inline(always)]
fn moved<'a>(values: &'a [f32], by: isize, buffer: &'a mut Vec<f32>) -> &'a [f32] {
    if by == 0 {
        return values;
    }
    buffer.clear();
    buffer.resize(values.len(), UNSEEN);
    let (from, to, count) = overlap(values.len(), by);
    buffer[to..][..count].copy_from_slice(&values[from..][..count]);
    buffer
}

/// Computes `out = max(stay, moved - cost)` up to the end of the shortest slice.
#[inline(always)]
fn higher(out: &mut [f32], stay: &[f32], moved: &[f32], cost: f32) {
    for ((out, &stay), &moved) in out.iter_mut().zip(stay).zip(moved) {
        *out = larger(stay, moved - cost);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the score that a path gathers.
    fn gathered(scores: &TrackerGrid, path: &[usize], motion: &MotionCost) -> f32 {
        let cost = |from: usize, to: usize| {
            let cells = from.abs_diff(to);
            let walk = motion.cost * cells as f32;
            if cells <= motion.limit && walk < motion.leap { walk } else { motion.leap }
        };
        let on_rows = path.iter().enumerate().map(|(row, &at)| scores.row(row)[at]);
        let moves = path.windows(2).map(|pair| cost(pair[0], pair[1]));
        on_rows.sum::<f32>() - moves.sum::<f32>()
    }

    #[test]
    fn line_is_the_best_of_all_paths() {
        let (rows, width) = (5, 7);
        let mut seed = 1_u32;
        for round in 0..40 {
            let mut scores = TrackerGrid::default();
            scores.reset(rows, width, 0.0);
            for row in 0..rows {
                for score in scores.row_mut(row) {
                    seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                    *score = (seed >> 20) as f32 / 512.0;
                }
            }
            let motion = MotionCost {
                limit: 1 + round % 4,
                cost: 0.7,
                leap: if round % 3 == 0 { f32::INFINITY } else { 2.5 },
            };
            let line = Paths::default().line(&scores, &Trend::default(), &motion);
            let best = (0..width.pow(rows as u32))
                .map(|number| {
                    let path: Vec<usize> =
                        (0..rows).map(|row| number / width.pow(row as u32) % width).collect();
                    gathered(&scores, &path, &motion)
                })
                .fold(f32::NEG_INFINITY, f32::max);
            let found = gathered(&scores, &line, &motion);
            assert!((found - best).abs() < 1e-4, "{found} against {best}");
        }
    }
}
