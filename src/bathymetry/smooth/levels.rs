//! Ever coarser grids that ease the equations of a plate: what is bent far and wide is settled where it is few cells.
//!
//! One V-cycle of multigrid (A. Brandt 1977) is the preconditioner of the conjugate gradients: each level smooths by a Chebyshev polynomial
//! of the Jacobi iteration, leaves the rest to the level of half as many rows and columns, takes back what that found by bilinear shares,
//! and smooths again. On the coarsest level a Cholesky factor solves what is left.

use super::equations::{CELLS_AT_ONCE, Equations, Knot, add, dot};
use super::plate::around;
use crate::bathymetry::{CentresAbout, Grid};
use rayon::prelude::*;

/// Cells along the longer side of the coarsest grid, at least; at most about twice as many.
pub const COARSEST: usize = 6;
/// The part of the equations' spectrum, over their diagonal, that a level smooths: all of bending that the next level cannot show (a wave
/// of four cells has `(2 - 2 cos(pi / 2))^2 / 20`), up to the most that there is (four cells share a sounding).
const SMOOTHED: [f64; 2] = [0.2, 4.0];
/// Steps of the polynomial.
const SWEEPS: usize = 4;

/// The equations on every grid from theirs to the coarsest.
pub struct Levels {
    finer: Vec<Level>,
    last: Equations,
    /// That of the last.
    coarsest: Cholesky,
}

struct Level {
    equations: Equations,
    diagonal: Vec<f64>,
    /// Where each row and column lies between those of the next level.
    rows: Vec<CentresAbout>,
    columns: Vec<CentresAbout>,
    coarser: Grid,
}

impl Levels {
    /// Of equations on a grid.
    pub fn of(grid: &Grid, mut equations: Equations) -> Self {
        let mut finer = Vec::new();
        let mut grid = *grid;
        while grid.columns.max(grid.rows) >= 2 * COARSEST {
            let coarser = grid.coarser(2);
            let next = coarsened(&grid, &equations, &coarser);
            let row = |row| coarser.about(grid.centre(row, 0))[0];
            let column = |column| coarser.about(grid.centre(0, column))[1];
            finer.push(Level {
                diagonal: equations.diagonal(),
                equations,
                rows: (0..grid.rows).map(row).collect(),
                columns: (0..grid.columns).map(column).collect(),
                coarser,
            });
            (grid, equations) = (coarser, next);
        }
        Self {
            finer,
            coarsest: Cholesky::of(&equations),
            last: equations,
        }
    }

    /// The equations that these are the levels of.
    pub fn finest(&self) -> &Equations {
        let first = self.finer.first();
        first.map_or(&self.last, |level| &level.equations)
    }

    /// Nearly what the equations make `left` of.
    pub fn eased(&self, left: &[f64]) -> Vec<f64> {
        self.eased_from(0, left)
    }

    fn eased_from(&self, level: usize, left: &[f64]) -> Vec<f64> {
        let Some(here) = self.finer.get(level) else {
            return self.coarsest.solved(left);
        };
        let mut found = vec![0.0; left.len()];
        let mut rest = left.to_vec();
        here.smooth(&mut found, &mut rest);
        let coarse = self.eased_from(level + 1, &here.gathered(&rest));
        let moved = here.spread(&coarse);
        add(&mut found, 1.0, &moved);
        let mut pull = vec![0.0; left.len()];
        here.equations.times(&moved, &mut pull);
        add(&mut rest, -1.0, &pull);
        here.smooth(&mut found, &mut rest);
        found
    }
}

impl Level {
    /// Chebyshev's steps (Y. Saad, Iterative methods for sparse linear systems, 2003, algorithm 12.1): moves `found`, and `rest` with it.
    fn smooth(&self, found: &mut [f64], rest: &mut [f64]) {
        let [least, most] = SMOOTHED;
        let (middle, half) = (0.5 * (most + least), 0.5 * (most - least));
        let slope = middle / half;
        let mut share = 1.0 / slope;
        let mut step: Vec<f64> = rest
            .iter()
            .zip(&self.diagonal)
            .map(|(rest, diagonal)| rest / (middle * diagonal))
            .collect();
        let mut pull = vec![0.0; rest.len()];
        for sweep in 0..SWEEPS {
            add(found, 1.0, &step);
            self.equations.times(&step, &mut pull);
            add(rest, -1.0, &pull);
            if sweep + 1 == SWEEPS {
                break;
            }
            let next = 1.0 / (2.0 * slope - share);
            let parts = step.par_iter_mut().zip(&*rest).zip(&self.diagonal);
            let parts = parts.with_min_len(CELLS_AT_ONCE);
            parts.for_each(|((step, rest), diagonal)| {
                *step = next * share * *step + 2.0 * next / half * rest / diagonal;
            });
            share = next;
        }
    }

    /// What pulls at each cell of the next level: the transpose of [`Level::spread`].
    fn gathered(&self, pull: &[f64]) -> Vec<f64> {
        let across = self.coarser.columns;
        let mut narrow = vec![0.0; self.rows.len() * across];
        let lines = pull.par_chunks(self.columns.len());
        lines
            .zip(narrow.par_chunks_mut(across))
            .for_each(|(line, narrow)| {
                for (pull, about) in line.iter().zip(&self.columns) {
                    narrow[about.cells[0]] += (1.0 - about.share) * pull;
                    narrow[about.cells[1]] += about.share * pull;
                }
            });
        let mut gathered = vec![0.0; self.coarser.len()];
        for (line, about) in narrow.chunks(across).zip(&self.rows) {
            for (row, share) in [
                (about.cells[0], 1.0 - about.share),
                (about.cells[1], about.share),
            ] {
                add(&mut gathered[row * across..][..across], share, line);
            }
        }
        gathered
    }

    /// Depths of the next level between its cells.
    fn spread(&self, depth_m: &[f64]) -> Vec<f64> {
        let across = self.coarser.columns;
        let mut spread = vec![0.0; self.rows.len() * self.columns.len()];
        let lines = spread.par_chunks_mut(self.columns.len());
        lines.zip(&self.rows).for_each(|(line, about)| {
            let [north, south] = about.cells.map(|row| &depth_m[row * across..][..across]);
            let at =
                |column: usize| (1.0 - about.share) * north[column] + about.share * south[column];
            for (depth_m, about) in line.iter_mut().zip(&self.columns) {
                *depth_m =
                    (1.0 - about.share) * at(about.cells[0]) + about.share * at(about.cells[1]);
            }
        });
        spread
    }
}

/// The same energy on cells twice as long: bending costs less, as its differences are wider apart, and the soundings of a cell count as one in
/// their midst.
fn coarsened(grid: &Grid, equations: &Equations, coarser: &Grid) -> Equations {
    // Weight, and weighted east and north.
    let mut sums = vec![[0.0; 3]; coarser.len()];
    for knot in &equations.knots {
        let mut place = [0.0; 2];
        for (cell, share) in knot.cells.iter().zip(&knot.shares) {
            let centre = grid.centre(cell / grid.columns, cell % grid.columns);
            place = [0, 1].map(|axis| place[axis] + share * centre[axis]);
        }
        if let Some(sum) = coarser
            .index_at(place[0], place[1])
            .and_then(|cell| sums.get_mut(cell))
        {
            for (sum, part) in sum.iter_mut().zip([1.0, place[0], place[1]]) {
                *sum += knot.weight * part;
            }
        }
    }
    let held = sums.into_iter().filter(|[weight, ..]| *weight > 0.0);
    let knots = held.map(|[weight, east, north]| {
        let (cells, shares) = around(coarser, [east / weight, north / weight]);
        Knot {
            cells,
            shares,
            depth_m: 0.0,
            weight,
        }
    });
    let stiffness = equations.stiffness * (grid.cell_m / coarser.cell_m).powi(2);
    Equations::new([coarser.columns, coarser.rows], stiffness, knots.collect())
}

/// Of a few equations, the factor `L` of `L L^T`, row by row.
struct Cholesky {
    factor: Vec<f64>,
    count: usize,
}

impl Cholesky {
    fn of(equations: &Equations) -> Self {
        let count = equations.columns * equations.rows;
        let mut factor = vec![0.0; count * count];
        let mut unit = vec![0.0; count];
        for (row, line) in factor.chunks_mut(count).enumerate() {
            unit[row] = 1.0;
            equations.times(&unit, line);
            unit[row] = 0.0;
        }
        // A plane that no sounding holds costs nothing: this much keeps it level.
        let least = 1e-9
            * (0..count)
                .map(|at| factor[at * (count + 1)])
                .fold(0.0, f64::max);
        for row in 0..count {
            for column in 0..=row {
                let [a, b] = [row, column].map(|line| &factor[line * count..][..column]);
                let rest = factor[row * count + column] - dot(a, b);
                factor[row * count + column] = match row == column {
                    true => rest.max(least).sqrt(),
                    false => rest / factor[column * (count + 1)],
                };
            }
        }
        Self { factor, count }
    }

    fn solved(&self, right: &[f64]) -> Vec<f64> {
        let mut found = right.to_vec();
        for row in 0..self.count {
            let line = &self.factor[row * self.count..][..row];
            found[row] -= dot(line, &found[..row]);
            found[row] /= self.factor[row * (self.count + 1)];
        }
        for row in (0..self.count).rev() {
            found[row] /= self.factor[row * (self.count + 1)];
            let (before, from) = found.split_at_mut(row);
            add(before, -from[0], &self.factor[row * self.count..][..row]);
        }
        found
    }
}
