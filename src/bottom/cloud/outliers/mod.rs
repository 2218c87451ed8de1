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

mod sweep;

use bathyscope_log::support::progress::{Cancelled, Progress};
use bathyscope_log::support::statistics::{ends, sorted};
use rayon::prelude::*;
use std::collections::HashMap;

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

/// Cells along one axis. Long empty stretches can be left out, so that a far outlier costs one
/// cell, not a grid.
#[derive(Debug)]
struct CellAxis {
    /// Start of each occupied stretch, ascending, with its first cell number.
    stretches: Vec<(f64, u32)>,
    cells_per_m: f64,
    /// Number of cells.
    len: u64,
}

impl CellAxis {
    /// Largest number of cells along an axis whose numbers are exact: with more, empty stretches
    /// must be left out.
    const MAX_DIRECT: f64 = 1e9;

    /// Creates an axis with one cell for everything.
    fn single() -> Self {
        Self { stretches: vec![(0.0, 0)], cells_per_m: 0.0, len: 1 }
    }

    /// Numbers cells evenly from the smallest to the largest of the values; `None` when there would
    /// be too many cells to number.
    fn even(values: impl Iterator<Item = f64>, cell_m: f64) -> Option<Self> {
        let [min, max] = ends(values);
        let last = (max - min) / cell_m;
        (last < Self::MAX_DIRECT).then(|| Self {
            stretches: vec![(min, 0)],
            cells_per_m: 1.0 / cell_m,
            len: last as u64 + 1,
        })
    }

    /// Numbers cells as [`CellAxis::even`] does, but a gap of more than a cell between two values
    /// starts a new stretch, which is numbered on with one empty cell between. Values on the two
    /// sides of a gap are no neighbours.
    fn compact(values: impl Iterator<Item = f64>, cell_m: f64) -> Self {
        let sorted = sorted(values);
        let cells_per_m = 1.0 / cell_m;
        let mut stretches = vec![(sorted[0], 0)];
        for pair in sorted.windows(2) {
            if pair[1] - pair[0] > cell_m {
                let (start, first) = stretches[stretches.len() - 1];
                let last = first + ((pair[0] - start) * cells_per_m) as u32;
                stretches.push((pair[1], last + 2));
            }
        }
        let mut axis = Self { stretches, cells_per_m, len: 0 };
        axis.len = u64::from(axis.cell(sorted[sorted.len() - 1])) + 1;
        axis
    }

    /// Returns the cell of a value that the axis was made from.
    fn cell(&self, value: f64) -> u32 {
        let (start, first) = match self.stretches.as_slice() {
            [only] => *only,
            many => many[many.partition_point(|&(start, _)| start <= value).max(1) - 1],
        };
        first + ((value - start) * self.cells_per_m) as u32
    }
}

/// Largest number of cells per point that are sorted by counting: a grid with more is mostly empty,
/// and sorting by comparison is cheaper.
const DENSE_CELLS_PER_POINT: u64 = 4;
/// Largest number of points that are examined to find out whether the cloud is flat.
const FLATNESS_POINTS: usize = 1_000_000;
/// Number of columns that are examined to find out whether the cloud is flat.
const FLATNESS_COLUMNS: usize = 256;

/// Row of cells that holds points.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct CellRow {
    /// `z cell * row stride + y cell`.
    key: u64,
    /// Index of the row's first point in sorted order.
    start: u32,
}

/// Points sorted by row, then by cell along x.
struct CellPoints {
    /// Index of each sorted point among the points given.
    order: Vec<u32>,
    /// The points in sorted order.
    points: Vec<[f64; 3]>,
    /// Cell along x of each sorted point.
    x_cells: Vec<u32>,
    /// Rows that hold points, ascending by key, and a last one past the end.
    rows: Vec<CellRow>,
    /// Number of rows in a layer, with room for a neighbour beyond either end.
    stride: u64,
    /// True if there is one layer only (columns).
    flat: bool,
}

/// The three axes of the grid.
struct Axes {
    x: CellAxis,
    y: CellAxis,
    z: CellAxis,
}

impl Axes {
    /// Creates the smallest grid that the points `order` allow; its cells are at least `cell_m`
    /// wide.
    fn new(place: &impl PointPlace, order: &[u32], cell_m: f64) -> Self {
        let along = |axis: usize| order.iter().map(move |&index| place(index)[axis]);
        let even = |axis: usize| CellAxis::even(along(axis), cell_m);
        let few = |axes: &Axes| axes.cell_count().is_some_and(|count| is_dense(count, order.len()));
        if let (Some(x), Some(y)) = (even(0), even(1)) {
            let flat = is_flat(place, order, &x, &y, cell_m);
            let z = if flat { Some(CellAxis::single()) } else { even(2) };
            if let Some(axes) = z.map(|z| Self { x, y, z }).filter(few) {
                return axes;
            }
        }
        let compact = |axis: usize| CellAxis::compact(along(axis), cell_m);
        let (x, y) = (compact(0), compact(1));
        let flat = is_flat(place, order, &x, &y, cell_m);
        let z = if flat { CellAxis::single() } else { compact(2) };
        Self { x, y, z }
    }

    fn cell_count(&self) -> Option<u64> {
        self.x.len.checked_mul(self.stride())?.checked_mul(self.z.len)
    }

    fn stride(&self) -> u64 {
        self.y.len + 2
    }

    fn row(&self, point: &[f64; 3]) -> u64 {
        u64::from(self.z.cell(point[2])) * self.stride() + u64::from(self.y.cell(point[1])) + 1
    }
}

fn is_dense(cell_count: u64, points: usize) -> bool {
    cell_count <= DENSE_CELLS_PER_POINT * points as u64 + 4096 && cell_count < u64::from(u32::MAX)
}

/// Returns true if most of the points in a column of cells are within a cell of each other in
/// height: then columns cost fewer tests than cells. Judged on a sample.
fn is_flat(
    place: &impl PointPlace,
    order: &[u32],
    x: &CellAxis,
    y: &CellAxis,
    cell_m: f64,
) -> bool {
    let column = |point: &[f64; 3]| (x.cell(point[0]), y.cell(point[1]));
    let step = (order.len() / FLATNESS_COLUMNS).max(1);
    let probes = order.iter().step_by(step).map(|&index| place(index));
    let heights: HashMap<(u32, u32), f64> =
        probes.map(|point| (column(&point), point[2])).collect();
    let step = order.len().div_ceil(FLATNESS_POINTS).max(1);
    let (mut near, mut all) = (0, 0);
    for &index in order.iter().step_by(step) {
        let point = place(index);
        if let Some(height) = heights.get(&column(&point)) {
            all += 1;
            near += usize::from((point[2] - height).abs() < 1.5 * cell_m);
        }
    }
    2 * near > all
}

impl CellPoints {
    /// Sorts the points `order`, which lie at `place`, into cells `cell_m` wide.
    fn sorted(
        place: &impl PointPlace,
        order: Vec<u32>,
        cell_m: f64,
        progress: &Progress,
    ) -> Result<Self, Cancelled> {
        let axes = Axes::new(place, &order, cell_m);
        progress.check()?;
        let order = match axes.cell_count().filter(|&count| is_dense(count, order.len())) {
            Some(count) => by_counting(place, &order, &axes, count as usize),
            None => by_comparing(place, order, &axes),
        };
        progress.check()?;
        let sorted: Vec<[f64; 3]> = order.par_iter().map(|&index| place(index)).collect();
        let x_cells = sorted.par_iter().map(|point| axes.x.cell(point[0])).collect();
        Ok(Self {
            rows: rows(&sorted, &axes),
            points: sorted,
            x_cells,
            stride: axes.stride(),
            flat: axes.z.len == 1,
            order,
        })
    }
}

/// Sorts by counting, which is stable, so that points of a cell keep their order.
fn by_counting(place: &impl PointPlace, order: &[u32], axes: &Axes, cell_count: usize) -> Vec<u32> {
    let cell = |index: &u32| {
        let point = &place(*index);
        (axes.row(point) * axes.x.len + u64::from(axes.x.cell(point[0]))) as u32
    };
    let cells: Vec<u32> = order.par_iter().map(cell).collect();
    let mut next = vec![0_u32; cell_count + 1];
    for &cell in &cells {
        next[cell as usize + 1] += 1;
    }
    for index in 1..next.len() {
        next[index] += next[index - 1];
    }
    let mut sorted = vec![0; order.len()];
    for (&index, &cell) in order.iter().zip(&cells) {
        let place = &mut next[cell as usize];
        sorted[*place as usize] = index;
        *place += 1;
    }
    sorted
}

fn by_comparing(place: &impl PointPlace, mut order: Vec<u32>, axes: &Axes) -> Vec<u32> {
    order.par_sort_by_cached_key(|&index| {
        let point = &place(index);
        (axes.row(point), axes.x.cell(point[0]))
    });
    order
}

fn rows(sorted: &[[f64; 3]], axes: &Axes) -> Vec<CellRow> {
    let keys: Vec<u64> = sorted.par_iter().map(|point| axes.row(point)).collect();
    let mut rows: Vec<CellRow> = Vec::new();
    for (start, &key) in keys.iter().enumerate() {
        if rows.last().is_none_or(|row| row.key != key) {
            rows.push(CellRow { key, start: start as u32 });
        }
    }
    rows.push(CellRow { key: u64::MAX, start: sorted.len() as u32 });
    rows
}
