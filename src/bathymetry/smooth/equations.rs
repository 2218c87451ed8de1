//! The equations of a plate on a grid, and how they are solved.

use super::levels::Levels;
use crate::progress::{Cancelled, Progress};
use rayon::prelude::*;
use std::cmp::Ordering;

/// A grid counts as solved after so many steps at most.
const MOST_STEPS: usize = 100;
/// Cells that the bending of a cell reaches.
const REACH: usize = 2;
/// Rows that a worker takes at least: fewer are done sooner than given away.
const ROWS_AT_ONCE: usize = 64;
/// And cells.
pub const CELLS_AT_ONCE: usize = 1 << 15;

/// A sounding between the centres of four cells.
pub struct Knot {
    /// The cells.
    pub cells: [usize; 4],
    /// What each counts.
    pub shares: [f64; 4],
    /// The sounding, metres.
    pub depth_m: f64,
    /// What the sounding counts.
    pub weight: f64,
}

impl Knot {
    /// Spreads what is pulled over the cells.
    fn add_to(&self, cells: &mut [f64], pull: f64) {
        for (cell, share) in self.cells.iter().zip(&self.shares) {
            cells[*cell] += share * pull;
        }
    }
}

/// The normal equations: the bending is never written out, what the soundings hold is.
pub struct Equations {
    /// Cells from west to east.
    pub columns: usize,
    /// Cells from north to south.
    pub rows: usize,
    /// What bending costs against the misfit of a sounding: `1 / (give cell)^2`.
    pub stiffness: f64,
    /// The soundings.
    pub knots: Vec<Knot>,
    held: Held,
}

/// How the soundings tie each cell to itself and to four of its neighbours; the other four have it the other way round. However many
/// soundings there are, the work is that of the cells.
struct Held {
    own: Vec<f64>,
    east: Vec<f64>,
    south_west: Vec<f64>,
    south: Vec<f64>,
    south_east: Vec<f64>,
}

impl Held {
    fn by(knots: &[Knot], columns: usize, rows: usize) -> Self {
        let none = || vec![0.0; columns * rows];
        let mut held = Self {
            own: none(),
            east: none(),
            south_west: none(),
            south: none(),
            south_east: none(),
        };
        for knot in knots {
            for (at, &from) in knot.cells.iter().enumerate() {
                held.own[from] += knot.weight * knot.shares[at].powi(2);
                for (&to, share) in knot.cells.iter().zip(&knot.shares).skip(at + 1) {
                    let tie = knot.weight * knot.shares[at] * share;
                    let [[row, column], [down, right]] =
                        [from, to].map(|cell| [cell / columns, cell % columns]);
                    match (down > row, right.cmp(&column)) {
                        // In a grid of one row or one column both are the same cell.
                        (false, Ordering::Equal) => held.own[from] += 2.0 * tie,
                        (false, Ordering::Greater) => held.east[from] += tie,
                        (false, Ordering::Less) => held.east[to] += tie,
                        (true, Ordering::Less) => held.south_west[from] += tie,
                        (true, Ordering::Equal) => held.south[from] += tie,
                        (true, Ordering::Greater) => held.south_east[from] += tie,
                    }
                }
            }
        }
        held
    }

    /// Adds what the soundings make of the depths of a row.
    fn add_row(&self, depth_m: &[f64], row: usize, made: &mut [f64]) {
        let columns = made.len();
        let start = row * columns;
        let here = &depth_m[start..][..columns];
        add_products(made, &self.own[start..][..columns], here);
        let east = &self.east[start..][..columns - 1];
        add_products(made, east, &here[1..]);
        add_products(&mut made[1..], east, here);
        if let Some(before) = start.checked_sub(columns) {
            let north = &depth_m[before..][..columns];
            add_products(made, &self.south[before..][..columns], north);
            add_products(
                &mut made[1..],
                &self.south_east[before..][..columns - 1],
                north,
            );
            add_products(
                made,
                &self.south_west[before + 1..][..columns - 1],
                &north[1..],
            );
        }
        if let Some(south) = depth_m
            .get(start + columns..)
            .and_then(|rest| rest.get(..columns))
        {
            add_products(made, &self.south[start..][..columns], south);
            add_products(made, &self.south_east[start..][..columns - 1], &south[1..]);
            add_products(
                &mut made[1..],
                &self.south_west[start + 1..][..columns - 1],
                south,
            );
        }
    }
}

/// Adds the products of two lists, as long as the shorter.
fn add_products(to: &mut [f64], a: &[f64], b: &[f64]) {
    for ((to, a), b) in to.iter_mut().zip(a).zip(b) {
        *to += a * b;
    }
}

impl Equations {
    /// Of the soundings on a grid of cells.
    pub fn new([columns, rows]: [usize; 2], stiffness: f64, knots: Vec<Knot>) -> Self {
        Self {
            held: Held::by(&knots, columns, rows),
            columns,
            rows,
            stiffness,
            knots,
        }
    }

    /// Preconditioned conjugate gradients (M. R. Hestenes, E. Stiefel 1952), from what `depth_m` holds, until what is still to be done is
    /// the share `solved` of that at a flat plate; `levels` are those of the same equations.
    pub fn solve(
        &self,
        levels: &Levels,
        solved: f64,
        depth_m: &mut [f64],
        progress: &Progress,
    ) -> Result<(), Cancelled> {
        let mut left = vec![0.0; depth_m.len()];
        self.times(depth_m, &mut left);
        for left in &mut left {
            *left = -*left;
        }
        for knot in &self.knots {
            knot.add_to(&mut left, knot.weight * knot.depth_m);
        }
        let mut eased = levels.eased(&left);
        let mut direction = eased.clone();
        let mut moved = vec![0.0; depth_m.len()];
        let mut size = dot(&left, &eased);
        let goal = self.flat(levels) * solved * solved;
        for _ in 0..MOST_STEPS {
            if size <= goal || size <= 0.0 {
                break;
            }
            progress.check()?;
            self.times(&direction, &mut moved);
            let length = size / dot(&direction, &moved);
            add(depth_m, length, &direction);
            add(&mut left, -length, &moved);
            eased = levels.eased(&left);
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
    fn flat(&self, levels: &Levels) -> f64 {
        let middle_m =
            self.knots.iter().map(|knot| knot.depth_m).sum::<f64>() / self.knots.len() as f64;
        let mut pull = vec![0.0; self.columns * self.rows];
        for knot in &self.knots {
            knot.add_to(&mut pull, knot.weight * (knot.depth_m - middle_m));
        }
        dot(&pull, &levels.eased(&pull))
    }

    /// What the equations make of some depths.
    pub fn times(&self, depth_m: &[f64], made: &mut [f64]) {
        made.par_chunks_mut(self.columns)
            .with_min_len(ROWS_AT_ONCE)
            .enumerate()
            .for_each(|(row, made)| {
                self.bend_row(depth_m, row, made);
                self.held.add_row(depth_m, row, made);
            });
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
    pub fn diagonal(&self) -> Vec<f64> {
        let own = self.held.own.iter();
        own.map(|held| 20.0 * self.stiffness + held).collect()
    }
}

/// The sum of products, in one order: the same depths give the same plate to the bit.
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Adds a multiple.
pub fn add(to: &mut [f64], times: f64, what: &[f64]) {
    let cells = to.par_iter_mut().zip(what).with_min_len(CELLS_AT_ONCE);
    cells.for_each(|(to, what)| *to += times * what);
}
