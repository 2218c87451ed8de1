//! A plate through the soundings: the depths on a grid that bend least.
//!
//! What is least is `sum h (d(place) - sounding)^2 + sum (d_xx^2 + 2 d_xy^2 + d_yy^2) / (give cell)^2`, the differences taken between
//! cells: the thin plate of G. Wahba (Spline models for observational data, 1990) on a grid. The weights `h` follow P. J. Huber, so that a
//! sounding that all others contradict pulls no harder than one at the edge of what is usual.

use crate::bathymetry::{Grid, Node};
use crate::progress::{Cancelled, Progress};
use crate::statistics::{SIGMA_PER_MAD, median};
use rayon::prelude::*;

/// Cells along the longer side of the grid that the work begins on.
const COARSEST: usize = 6;
/// The gradient falls to this share of its length at a flat plate before a grid counts as solved, in at most so many steps.
const SOLVED: f64 = 1e-5;
const MOST_STEPS: usize = 400;
/// Times that the soundings are weighed anew once the plate is found.
const REWEIGHTED: usize = 2;
/// Beyond this many usual misfits a sounding pulls no harder.
const USUAL: f64 = 2.0;
/// Cells that the bending of a cell reaches.
const REACH: usize = 2;
/// Rows that a worker takes at least: fewer are done sooner than given away.
const ROWS_AT_ONCE: usize = 64;
/// Least misfit that counts as unusual, metres: recorders write centimetres.
const LEAST_MISFIT_M: f64 = 0.01;

/// Depths at the centres of the cells of a grid, everywhere known.
#[derive(Clone, Debug)]
pub struct Plate {
    grid: Grid,
    depth_m: Vec<f64>,
}

/// A sounding between the centres of four cells.
struct Knot {
    cells: [usize; 4],
    shares: [f64; 4],
    depth_m: f64,
    weight: f64,
}

impl Knot {
    fn depth_of(&self, depth_m: &[f64]) -> f64 {
        let parts = self.cells.iter().zip(&self.shares);
        parts.map(|(cell, share)| depth_m[*cell] * share).sum()
    }
}

impl Plate {
    /// Through some soundings. `give` says how far the plate gives way to them, for each metre of their usual error: small for a board,
    /// large for a sheet. From coarse to fine, so that far reaches are settled where they are few cells.
    ///
    /// # Errors
    /// When the work was cancelled.
    pub fn through(
        grid: &Grid,
        nodes: &[Node],
        give: f64,
        progress: &Progress,
    ) -> Result<Self, Cancelled> {
        let halvings = halvings(grid);
        let mean_m = nodes.iter().map(|node| node.depth_m).sum::<f64>() / nodes.len() as f64;
        let mut plate = Self::level(grid.coarser(1 << halvings), mean_m);
        let mut weights = vec![1.0; nodes.len()];
        for halving in (0..=halvings).rev() {
            plate = plate.on(grid.coarser(1 << halving));
            plate.settle(nodes, &weights, give, progress)?;
        }
        for _ in 0..REWEIGHTED {
            weights = plate.weights(nodes);
            plate.settle(nodes, &weights, give, progress)?;
        }
        Ok(plate)
    }

    /// Steps of progress that [`Plate::through`] makes.
    pub fn steps(grid: &Grid) -> u64 {
        u64::from(halvings(grid)) + 1 + REWEIGHTED as u64
    }

    /// As deep everywhere.
    fn level(grid: Grid, depth_m: f64) -> Self {
        Self {
            depth_m: vec![depth_m; grid.len()],
            grid,
        }
    }

    /// Depth at a place, bilinear between the centres of cells; outside of them it goes on as between the outermost two.
    pub fn depth_at(&self, place: [f64; 2]) -> f64 {
        let (cells, shares) = around(&self.grid, place);
        let parts = cells.into_iter().zip(shares);
        parts.map(|(cell, share)| self.depth_m[cell] * share).sum()
    }

    /// The same plate on other cells.
    fn on(&self, grid: Grid) -> Self {
        let columns = grid.columns;
        let depth = |cell| self.depth_at(grid.centre(cell / columns, cell % columns));
        Self {
            depth_m: (0..grid.len()).into_par_iter().map(depth).collect(),
            grid,
        }
    }

    /// Finds the depths by conjugate gradients.
    fn settle(
        &mut self,
        nodes: &[Node],
        weights: &[f64],
        give: f64,
        progress: &Progress,
    ) -> Result<(), Cancelled> {
        let knots = nodes.iter().zip(weights).map(|(node, weight)| {
            let (cells, shares) = around(&self.grid, [node.east_m, node.north_m]);
            Knot {
                cells,
                shares,
                depth_m: node.depth_m,
                weight: *weight,
            }
        });
        let equations = Equations {
            columns: self.grid.columns,
            rows: self.grid.rows,
            stiffness: (give * self.grid.cell_m).powi(-2),
            knots: knots.collect(),
        };
        equations.solve(&mut self.depth_m, progress)?;
        progress.advance(1);
        Ok(())
    }

    /// What each sounding counts by how far it is missed.
    fn weights(&self, nodes: &[Node]) -> Vec<f64> {
        let misfit_m =
            |node: &Node| (self.depth_at([node.east_m, node.north_m]) - node.depth_m).abs();
        let misfits_m: Vec<f64> = nodes.iter().map(misfit_m).collect();
        let usual_m = (SIGMA_PER_MAD * median(&mut misfits_m.clone())).max(LEAST_MISFIT_M);
        let weight = |misfit_m: f64| (USUAL * usual_m / misfit_m).min(1.0);
        misfits_m.into_iter().map(weight).collect()
    }
}

/// How often the grid is made coarser by half before the work begins.
fn halvings(grid: &Grid) -> u32 {
    (grid.columns.max(grid.rows) / COARSEST).max(1).ilog2()
}

/// The four cells whose centres lie about a place, and their bilinear shares, which continue the plane beyond the outermost centres.
fn around(grid: &Grid, place: [f64; 2]) -> ([usize; 4], [f64; 4]) {
    let [rows, columns] = grid.about(place);
    let ([north, south], [west, east]) = (rows.cells, columns.cells);
    let (down, right) = (rows.share, columns.share);
    let cell = |row: usize, column: usize| row * grid.columns + column;
    (
        [
            cell(north, west),
            cell(north, east),
            cell(south, west),
            cell(south, east),
        ],
        [
            (1.0 - down) * (1.0 - right),
            (1.0 - down) * right,
            down * (1.0 - right),
            down * right,
        ],
    )
}

/// The normal equations, never written out.
struct Equations {
    columns: usize,
    rows: usize,
    stiffness: f64,
    knots: Vec<Knot>,
}

impl Equations {
    /// Preconditioned conjugate gradients (M. R. Hestenes, E. Stiefel 1952), from what `depth_m` holds.
    fn solve(&self, depth_m: &mut [f64], progress: &Progress) -> Result<(), Cancelled> {
        let diagonal = self.diagonal();
        let mut left = vec![0.0; depth_m.len()];
        self.times(depth_m, &mut left);
        for left in &mut left {
            *left = -*left;
        }
        for knot in &self.knots {
            for (cell, share) in knot.cells.iter().zip(&knot.shares) {
                left[*cell] += knot.weight * share * knot.depth_m;
            }
        }
        let mut eased: Vec<f64> = left.iter().zip(&diagonal).map(|(l, d)| l / d).collect();
        let mut direction = eased.clone();
        let mut moved = vec![0.0; depth_m.len()];
        let mut size = dot(&left, &eased);
        let goal = self.flat(&diagonal) * SOLVED * SOLVED;
        for _ in 0..MOST_STEPS {
            if size <= goal || size <= 0.0 {
                break;
            }
            progress.check()?;
            self.times(&direction, &mut moved);
            let length = size / dot(&direction, &moved);
            add(depth_m, length, &direction);
            add(&mut left, -length, &moved);
            for ((eased, left), diagonal) in eased.iter_mut().zip(&left).zip(&diagonal) {
                *eased = left / diagonal;
            }
            let next = dot(&left, &eased);
            for (direction, eased) in direction.iter_mut().zip(&eased) {
                *direction = eased + next / size * *direction;
            }
            size = next;
        }
        Ok(())
    }

    /// The square of the gradient's length at a flat plate in the middle of the soundings: what is still to be done is held against it,
    /// wherever the work begins.
    fn flat(&self, diagonal: &[f64]) -> f64 {
        let middle_m =
            self.knots.iter().map(|knot| knot.depth_m).sum::<f64>() / self.knots.len() as f64;
        let mut pull = vec![0.0; diagonal.len()];
        for knot in &self.knots {
            for (cell, share) in knot.cells.iter().zip(&knot.shares) {
                pull[*cell] += knot.weight * share * (knot.depth_m - middle_m);
            }
        }
        pull.iter()
            .zip(diagonal)
            .map(|(pull, diagonal)| pull * pull / diagonal)
            .sum()
    }

    /// What the equations make of some depths.
    fn times(&self, depth_m: &[f64], made: &mut [f64]) {
        made.par_chunks_mut(self.columns)
            .with_min_len(ROWS_AT_ONCE)
            .enumerate()
            .for_each(|(row, made)| self.bend_row(depth_m, row, made));
        for knot in &self.knots {
            let pull = knot.weight * knot.depth_of(depth_m);
            for (cell, share) in knot.cells.iter().zip(&knot.shares) {
                made[*cell] += share * pull;
            }
        }
    }

    /// [`Equations::bending`] of a row, times the stiffness; where no edge is near by the stencil that it then is.
    fn bend_row(&self, depth_m: &[f64], row: usize, made: &mut [f64]) {
        let columns = self.columns;
        let is_inside = row >= REACH && row + REACH < self.rows && columns > 2 * REACH;
        let edges = match is_inside {
            true => REACH..columns - REACH,
            false => columns..columns,
        };
        for column in (0..edges.start).chain(edges.end..columns) {
            made[column] = self.stiffness * self.bending(depth_m, row, column);
        }
        if !is_inside {
            return;
        }
        let line = |down: usize| &depth_m[(row + down - REACH) * columns..][..columns];
        let [far_north, north, here, south, far_south] = [0, 1, 2, 3, 4].map(line);
        for (column, made) in made.iter_mut().enumerate().take(edges.end).skip(REACH) {
            let beside = here[column - 1] + here[column + 1] + north[column] + south[column];
            let across =
                north[column - 1] + north[column + 1] + south[column - 1] + south[column + 1];
            let away = here[column - 2] + here[column + 2] + far_north[column] + far_south[column];
            *made = self.stiffness * (20.0 * here[column] - 8.0 * beside + 2.0 * across + away);
        }
    }

    /// By how much the bending of the whole plate grows with the depth of a cell: second differences of second differences, without those
    /// that reach over the edge.
    fn bending(&self, depth_m: &[f64], row: usize, column: usize) -> f64 {
        let (columns, rows) = (self.columns, self.rows);
        let at = |row: usize, column: usize| depth_m[row * columns + column];
        let along = |column: usize| match column {
            0 => 0.0,
            _ if column + 1 >= columns => 0.0,
            _ => at(row, column - 1) - 2.0 * at(row, column) + at(row, column + 1),
        };
        let down = |row: usize| match row {
            0 => 0.0,
            _ if row + 1 >= rows => 0.0,
            _ => at(row - 1, column) - 2.0 * at(row, column) + at(row + 1, column),
        };
        let twist = |row: usize, column: usize| match row + 1 < rows && column + 1 < columns {
            true => {
                at(row, column) + at(row + 1, column + 1)
                    - at(row, column + 1)
                    - at(row + 1, column)
            }
            false => 0.0,
        };
        let (west, north) = (column.checked_sub(1), row.checked_sub(1));
        let mut sum = along(column + 1) - 2.0 * along(column) + west.map_or(0.0, along);
        sum += down(row + 1) - 2.0 * down(row) + north.map_or(0.0, down);
        let mut twists = twist(row, column);
        twists -= west.map_or(0.0, |west| twist(row, west));
        twists -= north.map_or(0.0, |north| twist(north, column));
        if let (Some(west), Some(north)) = (west, north) {
            twists += twist(north, west);
        }
        sum + 2.0 * twists
    }

    /// The diagonal of the equations, that of bending as it is away from the edge.
    fn diagonal(&self) -> Vec<f64> {
        let mut diagonal = vec![20.0 * self.stiffness; self.columns * self.rows];
        for knot in &self.knots {
            for (cell, share) in knot.cells.iter().zip(&knot.shares) {
                diagonal[*cell] += knot.weight * share * share;
            }
        }
        diagonal
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn add(to: &mut [f64], times: f64, what: &[f64]) {
    for (to, what) in to.iter_mut().zip(what) {
        *to += times * what;
    }
}
