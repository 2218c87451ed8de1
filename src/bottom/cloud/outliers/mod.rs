//! Removes outliers by radius, with the exact rule of Open3D's `PointCloud::remove_radius_outlier`.
//!
//! In: places, a radius and a number of neighbours. Out: which places are kept.
//!
//! A point is kept when more than `min_neighbors` points, itself included, lie strictly nearer than
//! the radius. The points are sorted into cells one radius wide, so that all neighbours of a point
//! lie in the cells around its own, and the cells of a row lie side by side in memory. Counting
//! stops as soon as a point is known to be kept. A flat cloud is sorted into columns instead,
//! because its cells above and below are empty. Where a cell is so full that testing all its points
//! would take too long, a tree of boxes counts instead.

mod cells;
mod sweep;
mod tree;

use bathyscope_log::support::progress::{Cancelled, Progress};
use cells::CellPoints;

/// Width of a cell as a multiple of the radius: a little wider, so that rounding never puts
/// neighbours two cells apart.
const CELL_MARGIN: f64 = 1.0 + 1e-6;

/// Returns a flag for each point, true if more than `min_neighbors` points (itself included) lie
/// strictly within `radius_m`.
///
/// Distances are compared in f64. Points with a coordinate that is not finite are dropped and do
/// not count as neighbours. Memory is proportional to the number of points, however far apart they
/// lie.
pub fn keep(
    points: &[[f64; 3]],
    radius_m: f64,
    min_neighbors: usize,
    progress: &Progress,
) -> Result<Vec<bool>, Cancelled> {
    let place = |index: u32| points[index as usize];
    keep_places(points.len(), &place, radius_m, min_neighbors, progress)
}

/// Function that returns the place of the point of an index, metres.
trait PointPlace: Fn(u32) -> [f64; 3] + Sync {}

impl<P: Fn(u32) -> [f64; 3] + Sync> PointPlace for P {}

/// Does the same as [`keep`] for points that need not lie side by side in memory.
pub(super) fn keep_places(
    count: usize,
    place: &(impl Fn(u32) -> [f64; 3] + Sync),
    radius_m: f64,
    min_neighbors: usize,
    progress: &Progress,
) -> Result<Vec<bool>, Cancelled> {
    let mut kept = vec![false; count];
    let finite = |index: &u32| place(*index).iter().all(|value| value.is_finite());
    let finite_count = (0..count as u32).filter(finite).count();
    let mut order = Vec::with_capacity(finite_count);
    order.extend((0..count as u32).filter(finite));
    // A radius that is NaN or not above 0 keeps nothing.
    if order.is_empty() || radius_m.is_nan() || radius_m <= 0.0 {
        return Ok(kept);
    }
    let cells = CellPoints::sorted(place, order, radius_m * CELL_MARGIN, progress)?;
    for (&index, flag) in
        cells.order.iter().zip(sweep::flags(&cells, radius_m, min_neighbors, progress)?)
    {
        kept[index as usize] = flag;
    }
    Ok(kept)
}
