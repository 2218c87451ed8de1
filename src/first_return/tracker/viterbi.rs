//! The best path through the scores: for every cell, the most that a path through it can gather.

use super::score::Scores;

/// What moving the line from one ping to the next costs.
pub(super) struct Jump {
    /// Cells that it may move.
    pub limit: usize,
    /// Cost of each.
    pub cost: f32,
}

/// For every cell, the score of the best path through it.
#[derive(Default)]
pub(super) struct Paths {
    through: Vec<f32>,
    width: usize,
    reach: Reach,
}

impl Paths {
    /// Solves forward, then backward; `through = forward + backward - score`.
    pub fn solve(&mut self, scores: &Scores, jump: &Jump) {
        let (width, rows) = (scores.width, scores.len());
        self.width = width;
        self.through.clear();
        self.through.resize(rows * width, 0.0);
        for row in 0..rows {
            let (done, rest) = self.through.split_at_mut(row * width);
            let out = &mut rest[..width];
            out.copy_from_slice(scores.row(row));
            if row > 0 {
                let best = self.reach.of(&done[(row - 1) * width..], jump);
                for (out, best) in out.iter_mut().zip(best) {
                    *out += best;
                }
            }
        }
        let mut backward = vec![0.0; width];
        for row in (0..rows).rev() {
            // What the path gathers after this row, by the best way on from each cell.
            if row + 1 < rows {
                let best = self.reach.of(&backward, jump);
                backward.copy_from_slice(best);
            }
            let through = &mut self.through[row * width..][..width];
            for ((through, backward), score) in
                through.iter_mut().zip(&mut backward).zip(scores.row(row))
            {
                *through += *backward;
                *backward += score;
            }
        }
    }

    /// The best path scores through the cells of a row.
    pub fn row(&self, row: usize) -> &[f32] {
        &self.through[row * self.width..][..self.width]
    }
}

/// `max over |k| <= limit of value[j + k] - cost |k|`, by doubling.
#[derive(Default)]
struct Reach {
    right: Vec<f32>,
    left: Vec<f32>,
}

impl Reach {
    fn of(&mut self, values: &[f32], jump: &Jump) -> &[f32] {
        self.right.clear();
        self.right.extend_from_slice(values);
        self.left.clear();
        self.left.extend_from_slice(values);
        let mut covered = 1;
        while covered <= jump.limit {
            let step = covered.min(jump.limit + 1 - covered);
            if step >= values.len() {
                break;
            }
            let cost = jump.cost * step as f32;
            for at in 0..values.len() - step {
                self.right[at] = self.right[at].max(self.right[at + step] - cost);
            }
            for at in (step..values.len()).rev() {
                self.left[at] = self.left[at].max(self.left[at - step] - cost);
            }
            covered += step;
        }
        for (right, left) in self.right.iter_mut().zip(&self.left) {
            *right = right.max(*left);
        }
        &self.right
    }
}
