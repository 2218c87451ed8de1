//! Computes a surface of which no cell depends on what lies far away, so that a map of many tiles
//! is the same as one of the whole.

use super::grid::{measured_cells, settle};
use super::nodes::merge_repeated_with;
use super::surface::{DepthField, Surface, SurfaceMethod};
use super::tin::largest_radius_m;
use super::{DepthPoint, Grid};
use bathyscope_log::support::progress::{Cancelled, Progress};

/// Standard deviation of a depth that is alone in its cell, metres: the scatter of differences
/// between two logs on a level bottom.
const ALONE_M: f64 = 0.03;
/// Number of cells beyond the edge of a tile that the lines through its cells depend on, however
/// often the corners of the lines are cut.
pub const LOCAL_MARGIN_CELLS: usize = 4;

/// Returns the greatest distance from a cell to the points that it depends on, metres, not counting
/// the size of the cells that these points fall into.
///
/// A triangle that counts, and all nodes that decide whether it is one, lie in its circumscribed
/// circle: no two places in the circle are farther apart than its diameter.
pub fn local_reach_m(max_gap_m: f64) -> f64 {
    2.0 * largest_radius_m(max_gap_m)
}

/// Computes the surface of [`super::surface()`] by linear triangles on a given grid. Each cell is
/// the same to the bit whatever points there are beyond [`local_reach_m`] of it and whatever cells
/// there are beside it, if the side of the cells is a power of two, the grid lies on multiples of
/// this side, and the points are in the same order.
///
/// # Errors
/// When the work was cancelled.
pub fn local_surface(
    points: &[DepthPoint],
    grid: Grid,
    max_gap_m: f64,
    progress: &Progress,
) -> Result<Surface, Cancelled> {
    let nodes = merge_repeated_with(points, grid.cell_m, ALONE_M);
    progress.check()?;
    let mut made = match DepthField::local(nodes.clone(), max_gap_m) {
        Some(field) => field.fill(grid, progress)?,
        // On one line no triangle has an area; only the measured cells are known.
        None => {
            let mut made = Surface::unknown(grid, SurfaceMethod::Linear);
            made.fill_measured(nodes.into_iter());
            made
        }
    };
    made.source = measured_cells(points, &grid);
    settle(&mut made.source, &made.depth_m);
    Ok(made)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bathymetry::testing::random;

    /// Winding tracks at random over uneven ground, in the metres of a zone.
    fn points() -> Vec<DepthPoint> {
        let mut random = random();
        let mut points = Vec::new();
        for _ in 0..40 {
            let [mut east_m, mut north_m] =
                [512_000.0 + 400.0 * random(), 5_261_000.0 + 400.0 * random()];
            let mut heading_rad = 6.3 * random();
            for _ in 0..900 {
                heading_rad += 0.2 * (random() - 0.5);
                east_m += 0.4 * heading_rad.sin();
                north_m += 0.4 * heading_rad.cos();
                let depth_m =
                    4.0 + (0.05 * east_m).sin() + (0.03 * north_m).cos() + 0.02 * random();
                points.push(DepthPoint {
                    weight: 0.5 + random(),
                    is_sounding: random() > 0.5,
                    ..DepthPoint::of_sounding([east_m, north_m], depth_m)
                });
            }
        }
        points
    }

    fn grid(west_m: f64, north_m: f64, columns: usize, rows: usize) -> Grid {
        Grid::at([west_m, north_m], 0.5, [columns, rows])
    }

    #[test]
    fn a_part_is_the_same_to_the_bit_as_the_whole() {
        const GAP_M: f64 = 12.0;
        let points = points();
        let whole = grid(511_900.0, 5_261_500.0, 1200, 1200);
        let all = local_surface(&points, whole, GAP_M, &Progress::new()).unwrap();
        let mut known = 0;
        for (west_m, north_m) in
            [(512_060.0, 5_261_300.0), (512_100.0, 5_261_260.0), (511_950.0, 5_261_420.0)]
        {
            let part = grid(west_m, north_m, 160, 120);
            let reach_m = local_reach_m(GAP_M) + 1.0;
            let (east_m, south_m) = (west_m + 80.0, north_m - 60.0);
            let near = points.iter().filter(|point| {
                (west_m - reach_m..east_m + reach_m).contains(&point.east_m)
                    && (south_m - reach_m..north_m + reach_m).contains(&point.north_m)
            });
            let near: Vec<DepthPoint> = near.copied().collect();
            assert!(near.len() < points.len() * 2 / 3);
            let made = local_surface(&near, part, GAP_M, &Progress::new()).unwrap();
            let first_row = (2.0 * (whole.north_m - north_m)) as usize;
            let first_column = (2.0 * (west_m - whole.west_m)) as usize;
            for cell in 0..part.len() {
                let row = first_row + cell / part.columns;
                let column = first_column + cell % part.columns;
                let of_all = row * whole.columns + column;
                for (one, other) in [
                    (&made.depth_m, &all.depth_m),
                    (&made.spread_m, &all.spread_m),
                    (&made.distance_m, &all.distance_m),
                ] {
                    assert_eq!(one[cell].to_bits(), other[of_all].to_bits(), "{row} {column}");
                }
                assert_eq!(made.source[cell], all.source[of_all]);
                known += usize::from(!made.depth_m[cell].is_nan());
            }
        }
        assert!(known > 5_000, "{known}");
    }

    #[test]
    fn a_single_line_is_the_cells_that_it_crosses() {
        let points: Vec<DepthPoint> = (0..100)
            .map(|index| DepthPoint::of_sounding([0.25 * f64::from(index), 5.25], 3.0))
            .collect();
        let made = local_surface(&points, grid(0.0, 10.0, 40, 20), 20.0, &Progress::new()).unwrap();
        let known = made.depth_m.iter().filter(|depth| **depth == 3.0).count();
        assert_eq!(known, 40);
    }
}
