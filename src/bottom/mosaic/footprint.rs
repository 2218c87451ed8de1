//! Computes the outline of the insonified ground.

use super::MosaicLayout;
use super::canvas::Scan;
use super::layout::{bounds_of, grid_over};
use crate::bathymetry::isobaths::{Polygon, depth_areas};
use crate::bathymetry::{Grid, Surface};
use bathyscope_log::support::progress::{Cancelled, Progress};

/// Side of the squares that the ground is sampled with, metres; longer where there would be more
/// than [`MOST_SQUARES`] along a side.
const SQUARE_M: f64 = 0.5;
const MOST_SQUARES: f64 = 2000.0;

/// Returns the polygons of the ground that the strips of all logs cover, in the plane that their
/// layouts share, to half a square. Empty where nothing is shown.
///
/// # Errors
/// When the work was cancelled.
pub fn footprint(layouts: &[MosaicLayout], progress: &Progress) -> Result<Vec<Polygon>, Cancelled> {
    let Some(bounds) = bounds_of(layouts.iter()) else {
        return Ok(Vec::new());
    };
    let rough = grid_over(bounds, SQUARE_M);
    let most = rough.columns.max(rough.rows) as f64;
    let side_m = SQUARE_M * (most / MOST_SQUARES).max(1.0);
    let grid = with_margin(grid_over(bounds, side_m));
    let mut covered = vec![0.0_f32; grid.len()];
    for layout in layouts {
        for (_, _, strip) in layout.strips() {
            progress.check()?;
            cover(&grid, layout.corners(&strip), &mut covered);
        }
    }
    let surface = Surface::of_depths(grid, covered);
    // The grid is 1 where the ground was insonified and 0 elsewhere: its outline lies at 0.5.
    let areas = depth_areas(&surface, &[0.5, 2.0], progress)?;
    Ok(areas.into_iter().flat_map(|area| area.polygons).collect())
}

/// Returns the grid with one more square on every side, so that the outline closes within it.
fn with_margin(grid: Grid) -> Grid {
    Grid {
        west_m: grid.west_m - grid.cell_m,
        north_m: grid.north_m + grid.cell_m,
        columns: grid.columns + 2,
        rows: grid.rows + 2,
        ..grid
    }
}

/// Marks the squares whose centre is in a strip.
fn cover(grid: &Grid, corners: [[f64; 2]; 4], covered: &mut [f32]) {
    let cells = |metres: f64| metres / grid.cell_m - 0.5;
    let corners = corners.map(|[x, y]| [cells(x - grid.west_m), cells(grid.north_m - y)]);
    let scan = Scan::new(&corners, grid.columns, grid.rows);
    for row in scan.rows.clone() {
        let (first, columns) = (row * grid.columns, scan.columns(row));
        if let Some(line) = covered.get_mut(first + columns.start..first + columns.end) {
            line.fill(1.0);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strips_side_by_side_cover_all_between_them() {
        let grid = Grid::at([0.0, 20.0], 0.5, [80, 40]);
        let mut covered = vec![0.0; grid.len()];
        // Thin slanting strips side by side: the parallelogram from x = 1 to 9 at the bottom, 6 m
        // to the right on top.
        for strip in 0..80 {
            let [from, to] = [strip, strip + 1].map(|edge| 1.0 + 0.1 * f64::from(edge));
            cover(
                &grid,
                [[from, 1.0], [from + 6.0, 19.0], [to + 6.0, 19.0], [to, 1.0]],
                &mut covered,
            );
        }
        let squares = covered.iter().filter(|square| **square == 1.0).count();
        let area_m2 = 0.25 * squares as f64;
        assert!((area_m2 - 8.0 * 18.0).abs() < 4.0, "{area_m2}");
    }
}
