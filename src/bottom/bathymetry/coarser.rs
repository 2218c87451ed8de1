//! Resamples a surface to larger cells, and computes the direction that it faces.

use super::{CellSource, Grid, Surface};
use rayon::prelude::*;

impl Surface {
    /// Returns the surface in cells `times` as long: each holds the mean of the known values of its
    /// parts, and the best of their sources.
    #[must_use]
    pub fn coarser(&self, times: usize) -> Self {
        let grid = self.grid.coarser(times);
        let means = |values: &[f32]| means(&self.grid, values, &grid, times);
        let best = best(&self.grid, &self.source, &grid, times);
        self.on_grid(grid, means, best)
    }

    /// Returns the unit vector perpendicular to the bottom at the centre of a cell: east, north,
    /// up. Differences are taken between known neighbours only; where there are none, and outside
    /// of the grid, the bottom counts as level.
    pub fn normal(&self, row: usize, column: usize) -> [f32; 3] {
        let at = |row: Option<usize>, column: Option<usize>| {
            let (row, column) = (row?, column?);
            let is_inside = row < self.grid.rows && column < self.grid.columns;
            let depth_m = is_inside.then(|| self.depth_m[row * self.grid.columns + column])?;
            (!depth_m.is_nan()).then_some(f64::from(depth_m))
        };
        let (up, down) = (row.checked_sub(1), row.checked_add(1));
        let (left, right) = (column.checked_sub(1), column.checked_add(1));
        let here = at(Some(row), Some(column));
        let cell_m = self.grid.cell_m;
        // Depths grow downwards: a bottom that falls towards the east faces east.
        let east = slope(at(Some(row), left), here, at(Some(row), right), cell_m);
        let north = slope(at(down, Some(column)), here, at(up, Some(column)), cell_m);
        let length = (1.0 + east * east + north * north).sqrt();
        [east / length, north / length, 1.0 / length].map(|part| part as f32)
    }
}

/// Returns the growth of a value per metre, from its known values before, here and behind; 0 where
/// these are too few.
fn slope(before: Option<f64>, here: Option<f64>, behind: Option<f64>, cell_m: f64) -> f64 {
    match (before, here, behind) {
        (Some(before), _, Some(behind)) => (behind - before) / (2.0 * cell_m),
        (Some(before), Some(here), None) => (here - before) / cell_m,
        (None, Some(here), Some(behind)) => (behind - here) / cell_m,
        _ => 0.0,
    }
}

/// Returns values in larger cells: the mean of the known values of each cell's parts; NaN without
/// any.
pub(super) fn means(fine: &Grid, values: &[f32], coarse: &Grid, times: usize) -> Vec<f32> {
    let mut made = vec![f32::NAN; coarse.len()];
    made.par_chunks_mut(coarse.columns.max(1)).enumerate().for_each(|(row, made)| {
        let rows = row * times..((row + 1) * times).min(fine.rows);
        for (column, made) in made.iter_mut().enumerate() {
            let columns = column * times..((column + 1) * times).min(fine.columns);
            let parts = rows.clone().flat_map(|row| {
                values[row * fine.columns..][columns.clone()].iter().filter(|value| !value.is_nan())
            });
            let (sum, count) =
                parts.fold((0.0, 0), |(sum, count), value| (sum + f64::from(*value), count + 1));
            if count > 0 {
                *made = (sum / f64::from(count)) as f32;
            }
        }
    });
    made
}

/// Returns the best source among the parts of each larger cell.
fn best(fine: &Grid, values: &[CellSource], coarse: &Grid, times: usize) -> Vec<CellSource> {
    let mut made = vec![CellSource::None; coarse.len()];
    for (row, line) in values.chunks(fine.columns.max(1)).enumerate() {
        for (column, value) in line.iter().enumerate() {
            let cell = &mut made[row / times * coarse.columns + column / times];
            *cell = (*cell).max(*value);
        }
    }
    made
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 5 x 3 cells of 0.5 m: a plane that falls 1 in 2 towards the east and rises 1 in 4 towards
    /// the north, with a hole.
    fn plane() -> Surface {
        let grid = Grid::at([10.0, 20.0], 0.5, [5, 3]);
        let depth = |cell: usize| {
            let [east_m, north_m] = grid.centre_of(cell);
            match cell {
                7 => f32::NAN,
                _ => (0.5 * east_m - 0.25 * north_m) as f32,
            }
        };
        let depth_m: Vec<f32> = (0..grid.len()).map(depth).collect();
        Surface { spread_m: depth_m.clone(), ..Surface::of_depths(grid, depth_m) }
    }

    #[test]
    fn a_plane_faces_one_way_everywhere_beside_its_hole_too() {
        let surface = plane();
        let length = (1.0f32 + 0.25 + 0.0625).sqrt();
        let expected = [0.5 / length, -0.25 / length, 1.0 / length];
        for (row, column) in [(0, 0), (0, 1), (1, 1), (1, 3), (2, 4), (2, 3)] {
            let normal = surface.normal(row, column);
            let near = |(a, b): (f32, f32)| (a - b).abs() < 1e-5;
            let pairs = normal.into_iter().zip(expected);
            assert!(pairs.clone().all(near), "{row} {column}: {normal:?}");
        }
        assert_eq!(surface.normal(9, 9), [0.0, 0.0, 1.0]);
    }

    #[test]
    fn larger_cells_hold_the_mean_of_what_is_known_of_them() {
        let (surface, coarse) = (plane(), plane().coarser(2));
        assert_eq!((coarse.grid.columns, coarse.grid.rows), (3, 2));
        assert_eq!(coarse.grid.cell_m, 1.0);
        let of = |cells: &[usize]| {
            let sum: f32 = cells.iter().map(|cell| surface.depth_m[*cell]).sum();
            sum / cells.len() as f32
        };
        assert!((coarse.depth_m[0] - of(&[0, 1, 5, 6])).abs() < 1e-5);
        assert!((coarse.depth_m[1] - of(&[2, 3, 8])).abs() < 1e-5, "without the hole");
        assert!((coarse.depth_m[5] - of(&[14])).abs() < 1e-5, "at the edge");
        let mut parts = plane();
        parts.source = vec![CellSource::Interpolated; 15];
        parts.source[8] = CellSource::FirstReturn;
        let sources = parts.coarser(2).source;
        let others = [0, 2, 3, 4, 5].map(|cell| sources[cell]);
        assert_eq!(sources[1], CellSource::FirstReturn);
        assert_eq!(others, [CellSource::Interpolated; 5]);
        assert_eq!(surface.grid.times_coarser(6), 2);
        assert_eq!(surface.grid.times_coarser(15), 1);
    }
}
