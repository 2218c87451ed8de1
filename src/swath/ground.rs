//! The depths that echoes are placed on: those of a surface, held a little beyond its edges.

use crate::bathymetry::Grid;

const NOWHERE: u32 = u32::MAX;
/// A cell farther than this from any depth has none, metres: what lies farther off may be beyond what a part of a map knows.
pub(super) const HELD_M: f64 = 16.0;

/// Depths of all cells of a grid; NaN far from any depth.
#[derive(Clone, Debug)]
pub struct Ground {
    grid: Grid,
    depth_m: Vec<f32>,
}

impl Ground {
    /// Of the depths of a surface, row by row; a cell without one takes that of the nearest cell that has one, up to [`HELD_M`] away. `None` where
    /// no cell has.
    pub fn new(grid: Grid, depth_m: &[f32]) -> Option<Self> {
        if depth_m.len() != grid.len() || depth_m.iter().all(|depth_m| depth_m.is_nan()) {
            return None;
        }
        let held2 = (HELD_M / grid.cell_m).powi(2);
        let nearest = nearest_known(&grid, depth_m).into_iter().enumerate();
        let filled = nearest.map(
            |(cell, known)| match distance2(&grid, cell, known) <= held2 {
                true => depth_m[known as usize],
                false => f32::NAN,
            },
        );
        Some(Self {
            grid,
            depth_m: filled.collect(),
        })
    }

    /// The same with something added to the depth at the middle of every cell, metres.
    #[must_use]
    pub fn with(&self, added_m: impl Fn([f64; 2]) -> f64) -> Self {
        let columns = self.grid.columns.max(1);
        let cells = self.depth_m.iter().enumerate();
        let moved = cells.map(|(cell, depth_m)| {
            let centre = self.grid.centre(cell / columns, cell % columns);
            (f64::from(*depth_m) + added_m(centre)) as f32
        });
        Self {
            grid: self.grid,
            depth_m: moved.collect(),
        }
    }

    /// Depth at a place east and north, metres: bilinear between the middles of cells.
    pub fn depth_at(&self, place: [f64; 2]) -> f64 {
        self.between(place, |row, column| self.depth(row, column))
    }

    /// How fast the depth grows along a unit vector east and north, metres a metre: bilinear between differences over two cells.
    pub fn slope_at(&self, place: [f64; 2], [east, north]: [f64; 2]) -> f64 {
        self.between(place, |row, column| {
            let [to_east, to_north] = self.gradient(row, column);
            to_east * east + to_north * north
        })
    }

    fn depth(&self, row: usize, column: usize) -> f64 {
        f64::from(self.depth_m[row * self.grid.columns + column])
    }

    fn gradient(&self, row: usize, column: usize) -> [f64; 2] {
        let around = |at: usize, count: usize| [at.saturating_sub(1), (at + 1).min(count - 1)];
        let per_m = |difference_m: f64, [from, to]: [usize; 2]| match to - from {
            0 => 0.0,
            cells => difference_m / (cells as f64 * self.grid.cell_m),
        };
        let columns = around(column, self.grid.columns);
        let rows = around(row, self.grid.rows);
        let east_m = self.depth(row, columns[1]) - self.depth(row, columns[0]);
        // Rows count from the north.
        let north_m = self.depth(rows[0], column) - self.depth(rows[1], column);
        [per_m(east_m, columns), per_m(north_m, rows)]
    }

    fn between(&self, place: [f64; 2], value: impl Fn(usize, usize) -> f64) -> f64 {
        let [rows, columns] = self.grid.about(place);
        let [down, right] = [rows.share, columns.share].map(|share| share.clamp(0.0, 1.0));
        let in_row = |row: usize| {
            let [left, next] = columns.cells;
            value(row, left) * (1.0 - right) + value(row, next) * right
        };
        in_row(rows.cells[0]) * (1.0 - down) + in_row(rows.cells[1]) * down
    }
}

/// The nearest cell with a depth, of every cell: two sweeps over the rows, each handing on what its neighbours found (Danielsson 1980).
fn nearest_known(grid: &Grid, depth_m: &[f32]) -> Vec<u32> {
    let columns = grid.columns;
    let mut nearest = vec![NOWHERE; grid.len()];
    for (cell, depth_m) in depth_m.iter().enumerate().take(nearest.len()) {
        if depth_m.is_finite() {
            nearest[cell] = cell as u32;
        }
    }
    let mut hand_on = |from: usize, to: usize| {
        if distance2(grid, to, nearest[from]) < distance2(grid, to, nearest[to]) {
            nearest[to] = nearest[from];
        }
    };
    let mut sweep = |row: usize, before: Option<usize>| {
        let here = row * columns;
        if let Some(before) = before.map(|row| row * columns) {
            for column in 0..columns {
                for beside in column.saturating_sub(1)..(column + 2).min(columns) {
                    hand_on(before + beside, here + column);
                }
            }
        }
        for column in 1..columns {
            hand_on(here + column - 1, here + column);
        }
        for column in (1..columns).rev() {
            hand_on(here + column, here + column - 1);
        }
    };
    for row in 0..grid.rows {
        sweep(row, row.checked_sub(1));
    }
    for row in (0..grid.rows).rev() {
        sweep(row, (row + 1 < grid.rows).then_some(row + 1));
    }
    nearest
}

/// Square of the distance between two cells, in cells; infinite to nowhere.
fn distance2(grid: &Grid, cell: usize, to: u32) -> f64 {
    if to == NOWHERE {
        return f64::INFINITY;
    }
    let [row, column] = [cell / grid.columns, cell % grid.columns];
    let to = to as usize;
    let rows = row as f64 - (to / grid.columns) as f64;
    let columns = column as f64 - (to % grid.columns) as f64;
    rows * rows + columns * columns
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_plane_has_its_depth_and_slope_and_edges_are_held() {
        let grid = Grid {
            west_m: 10.0,
            north_m: 30.0,
            cell_m: 0.5,
            columns: 20,
            rows: 12,
        };
        let depth = |[east_m, north_m]: [f64; 2]| 2.0 + 0.1 * east_m - 0.05 * north_m;
        let mut depth_m: Vec<f32> = (0..grid.len())
            .map(|cell| depth(grid.centre(cell / 20, cell % 20)) as f32)
            .collect();
        let ground = Ground::new(grid, &depth_m).unwrap();
        let place = [14.3, 27.1];
        assert!((ground.depth_at(place) - depth(place)).abs() < 1e-5);
        assert!((ground.slope_at(place, [0.6, 0.8]) - (0.06 - 0.04)).abs() < 1e-5);
        depth_m[0] = f32::NAN;
        let held = Ground::new(grid, &depth_m).unwrap();
        let known = [depth_m[1], depth_m[20]].map(f64::from);
        assert!(known.contains(&held.depth_at(grid.centre(0, 0))));
        assert!(Ground::new(grid, &[f32::NAN; 240]).is_none());
    }

    #[test]
    fn far_from_any_depth_there_is_none() {
        let grid = Grid {
            west_m: 0.0,
            north_m: 0.0,
            cell_m: 1.0,
            columns: 60,
            rows: 40,
        };
        let mut depth_m = vec![f32::NAN; grid.len()];
        depth_m[0] = 3.0;
        let ground = Ground::new(grid, &depth_m).unwrap();
        let at = |row, column| ground.depth_at(grid.centre(row, column));
        assert_eq!([at(0, 14), at(10, 10), at(14, 0)], [3.0; 3]);
        assert!(at(0, 17).is_nan() && at(12, 12).is_nan() && at(39, 59).is_nan());
    }
}
