//! A plate through the soundings: the depths on a grid that bend least.
//!
//! What is least is `sum h (d(place) - sounding)^2 + sum (d_xx^2 + 2 d_xy^2 + d_yy^2) / (give cell)^2`, the differences taken between
//! cells: the thin plate of G. Wahba (Spline models for observational data, 1990) on a grid. The weights `h` follow P. J. Huber, so that a
//! sounding that all others contradict pulls no harder than one at the edge of what is usual.

use super::equations::{Equations, Knot};
use super::levels::{COARSEST, Levels};
use crate::bathymetry::{Grid, Node};
use crate::progress::{Cancelled, Progress};
use crate::statistics::{SIGMA_PER_MAD, median};
use rayon::prelude::*;

/// Times that the soundings are weighed anew once the plate is found.
const REWEIGHTED: usize = 2;
/// Beyond this many usual misfits a sounding pulls no harder.
const USUAL: f64 = 2.0;
/// Least misfit that counts as unusual, metres: recorders write centimetres.
const LEAST_MISFIT_M: f64 = 0.01;

/// How a plate is looked for.
#[derive(Clone, Copy, Debug)]
pub struct Search {
    /// How far the plate gives way to the soundings, for each metre of their usual error: small for a board, large for a sheet.
    pub give: f64,
    /// It is found when what is still to be done is this share of that at a flat plate.
    pub solved: f64,
}

/// Depths at the centres of the cells of a grid, everywhere known.
#[derive(Clone, Debug)]
pub struct Plate {
    grid: Grid,
    depth_m: Vec<f64>,
}

impl Plate {
    /// Through some soundings, from coarse to fine, so that far reaches are settled where they are few cells.
    ///
    /// # Errors
    /// When the work was cancelled.
    pub fn through(
        grid: &Grid,
        nodes: &[Node],
        search: Search,
        progress: &Progress,
    ) -> Result<Self, Cancelled> {
        let halvings = halvings(grid);
        let mean_m = nodes.iter().map(|node| node.depth_m).sum::<f64>() / nodes.len() as f64;
        let mut plate = Self::level(grid.coarser(1 << halvings), mean_m);
        let mut weights = vec![1.0; nodes.len()];
        for halving in (0..=halvings).rev() {
            plate = plate.on(grid.coarser(1 << halving));
            plate.settle(nodes, &weights, search, progress)?;
        }
        for _ in 0..REWEIGHTED {
            weights = plate.weights(nodes);
            plate.settle(nodes, &weights, search, progress)?;
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

    /// Finds the depths.
    fn settle(
        &mut self,
        nodes: &[Node],
        weights: &[f64],
        search: Search,
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
        let size = [self.grid.columns, self.grid.rows];
        let stiffness = (search.give * self.grid.cell_m).powi(-2);
        let equations = Equations::new(size, stiffness, knots.collect());
        let levels = Levels::of(&self.grid, equations);
        levels
            .finest()
            .solve(&levels, search.solved, &mut self.depth_m, progress)?;
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
pub fn around(grid: &Grid, place: [f64; 2]) -> ([usize; 4], [f64; 4]) {
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
