//! Counts the neighbours of each point, row by row, or in a tree of boxes for points among so many
//! others that testing each would take too long.

use super::CellPoints;
use bathyscope_log::support::progress::{Cancelled, Progress};
use rayon::prelude::*;
use std::collections::VecDeque;
use std::ops::Range;
use std::sync::OnceLock;

/// Number of rows that a worker takes at a time.
const ROWS_A_TASK: usize = 64;
/// Number of tests between two checks whether a point has enough neighbours.
const BLOCK: usize = 8;
/// Number of tests of one point after which the tree counts instead: in the densest survey a point
/// has enough neighbours sooner.
const MOST_TESTS: usize = 2048;

/// Returns a flag for each sorted point, true if more than `min_neighbors` points lie strictly
/// within the radius, itself included.
pub(super) fn flags(
    cells: &CellPoints,
    radius_m: f64,
    min_neighbors: usize,
    progress: &Progress,
) -> Result<Vec<bool>, Cancelled> {
    let row_count = cells.rows.len() - 1;
    progress.start(row_count as u64);
    let tasks: Vec<Range<usize>> = (0..row_count)
        .step_by(ROWS_A_TASK)
        .map(|start| start..row_count.min(start + ROWS_A_TASK))
        .collect();
    let counter = Counter {
        points: &cells.points,
        square: radius_m * radius_m,
        enough: min_neighbors.saturating_add(1),
        tree: OnceLock::new(),
    };
    let sweep_task = |rows: &Range<usize>| {
        progress.check()?;
        let mut flags = Vec::new();
        for row in rows.clone() {
            sweep_row(cells, row, &counter, &mut flags);
        }
        progress.advance(rows.len() as u64);
        Ok(flags)
    };
    let swept: Vec<Vec<bool>> = tasks.par_iter().map(sweep_task).collect::<Result<_, _>>()?;
    Ok(swept.concat())
}

/// Part of a row that lies within a cell of the current cell; it slides along with this cell.
#[derive(Clone, Copy, Default)]
struct RowSlice {
    start: usize,
    end: usize,
    row_end: usize,
}

impl RowSlice {
    fn slide_to(&mut self, cell: u32, x_cells: &[u32]) {
        while self.start < self.row_end && x_cells[self.start] + 1 < cell {
            self.start += 1;
        }
        self.end = self.end.max(self.start);
        while self.end < self.row_end && x_cells[self.end] <= cell + 1 {
            self.end += 1;
        }
    }
}

/// Appends the flags of a row's points.
fn sweep_row(cells: &CellPoints, row: usize, counter: &Counter, flags: &mut Vec<bool>) {
    let (mut around, count) = neighbour_rows(cells, row);
    let around = &mut around[..count];
    let mut own = slice_of(cells, row);
    let mut first = own.start;
    while first < own.row_end {
        let cell = cells.x_cells[first];
        let length = cells.x_cells[first..own.row_end].iter().take_while(|&&x| x == cell).count();
        own.slide_to(cell, &cells.x_cells);
        for slice in around.iter_mut() {
            slice.slide_to(cell, &cells.x_cells);
        }
        for point in &cells.points[first..first + length] {
            // The own cell comes first: its points are the likeliest neighbours.
            let own_row = [first..own.end, own.start..first];
            let others = around.iter().map(|slice| slice.start..slice.end);
            flags.push(counter.has_enough(point, own_row.into_iter().chain(others)));
        }
        first += length;
    }
}

fn slice_of(cells: &CellPoints, row: usize) -> RowSlice {
    let start = cells.rows[row].start as usize;
    RowSlice { start, end: start, row_end: cells.rows[row + 1].start as usize }
}

/// Returns the occupied rows around a row, without the row itself: two beside it, and three in each
/// of the layers below and above.
fn neighbour_rows(cells: &CellPoints, row: usize) -> ([RowSlice; 8], usize) {
    let rows = &cells.rows[..cells.rows.len() - 1];
    let key = rows[row].key;
    let mut around = [RowSlice::default(); 8];
    let mut count = 0;
    let mut add = |first: usize, keys: Range<u64>| {
        let rows_within = rows[first..].iter().take_while(|row| row.key < keys.end);
        for index in first..first + rows_within.count() {
            if index != row {
                around[count] = slice_of(cells, index);
                count += 1;
            }
        }
    };
    let beside = row - usize::from(row > 0 && rows[row - 1].key + 1 == key);
    add(beside, key - 1..key + 2);
    if !cells.flat {
        let layers = [key.checked_sub(cells.stride), key.checked_add(cells.stride)];
        for middle in layers.into_iter().flatten() {
            let keys = middle.saturating_sub(1)..middle + 2;
            add(rows.partition_point(|row| row.key < keys.start), keys);
        }
    }
    (around, count)
}

struct Counter<'a> {
    points: &'a [[f64; 3]],
    /// Square of the radius.
    square: f64,
    /// Number of points within the radius, itself included, that keep a point.
    enough: usize,
    /// Tree of all points, created when it is first needed.
    tree: OnceLock<Tree>,
}

impl Counter<'_> {
    fn has_enough(
        &self,
        at: &[f64; 3],
        slices: impl Iterator<Item = Range<usize>> + Clone,
    ) -> bool {
        let candidates: usize = slices.clone().map(|slice| slice.len()).sum();
        if candidates < self.enough {
            return false;
        }
        let (mut found, mut tested) = (0, 0);
        for slice in slices {
            // Blocks have no branch in them; the check of the count after each keeps dense cells
            // cheap.
            for block in self.points[slice].chunks(BLOCK) {
                found +=
                    block.iter().filter(|point| distance_square(at, point) < self.square).count();
                if found >= self.enough {
                    return true;
                }
                tested += BLOCK;
                if tested >= MOST_TESTS {
                    let tree = self.tree.get_or_init(|| Tree::new(self.points.to_vec()));
                    return tree.has_enough(at, self.square, self.enough);
                }
            }
        }
        false
    }
}

/// Largest number of points of a box that is not halved.
const LEAF: usize = 16;

/// Boxes around runs of points, halves of each other.
///
/// A box that lies within the radius as a whole is counted by its number of points, and a box that
/// lies beyond is skipped, so that a million points at one place cost one test. Rounding is
/// monotonic: the square of the distance to the far corner of a box, computed as for a point, is
/// never below that of a point in the box, so that the result is the same as by testing each point.
struct Tree {
    /// Points, those of a box side by side.
    points: Vec<[f64; 3]>,
    /// The box around all points, then both halves of each box: box `n` has the halves `2 n + 1`
    /// and `2 n + 2`.
    boxes: Vec<PointBounds>,
}

/// Smallest and largest coordinates of some points.
#[derive(Clone, Copy, Debug)]
struct PointBounds {
    low: [f64; 3],
    high: [f64; 3],
}

impl PointBounds {
    const NONE: Self = Self { low: [f64::INFINITY; 3], high: [f64::NEG_INFINITY; 3] };

    fn of(points: &[[f64; 3]]) -> Self {
        points.iter().fold(Self::NONE, |Self { low, high }, point| {
            let pick = |of: fn(f64, f64) -> f64, bound: [f64; 3]| {
                [0, 1, 2].map(|axis| of(bound[axis], point[axis]))
            };
            Self { low: pick(f64::min, low), high: pick(f64::max, high) }
        })
    }

    fn longest_axis(&self) -> usize {
        let length = |axis: &usize| self.high[*axis] - self.low[*axis];
        let longest = (0..3).max_by(|a, b| length(a).total_cmp(&length(b)));
        longest.unwrap_or(0)
    }

    /// Returns the squares of the distances from a place to the nearest and the farthest point of
    /// the box.
    fn distance_squares(&self, at: &[f64; 3]) -> [f64; 2] {
        let (mut near, mut far) = ([0.0_f64; 3], [0.0_f64; 3]);
        for axis in 0..3 {
            let [low, high] = [at[axis] - self.low[axis], self.high[axis] - at[axis]];
            near[axis] = 0.0_f64.max(-low).max(-high);
            far[axis] = low.max(high);
        }
        [near, far].map(|[x, y, z]| x * x + y * y + z * z)
    }
}

impl Tree {
    /// Creates a tree of points that are all finite.
    fn new(mut points: Vec<[f64; 3]>) -> Self {
        let mut boxes = Vec::new();
        halve(&mut points, 0, &mut boxes);
        Self { points, boxes }
    }

    /// Returns true if at least `enough` points lie strictly within the radius, of which the square
    /// is given. Large boxes are tested first, so that the answer is often known before any point
    /// is tested.
    fn has_enough(&self, at: &[f64; 3], square: f64, enough: usize) -> bool {
        let (mut found, mut possible) = (0, self.points.len());
        let mut open = VecDeque::from([(0, 0..self.points.len())]);
        while let Some((index, range)) = open.pop_front() {
            let [near, far] = self.boxes[index].distance_squares(at);
            let inside = match halves(&range) {
                _ if far < square => range.len(),
                _ if near >= square => 0,
                Some([left, right]) => {
                    open.push_back((2 * index + 1, left));
                    open.push_back((2 * index + 2, right));
                    continue;
                }
                None => {
                    let points = self.points[range.clone()].iter();
                    points.filter(|point| distance_square(at, point) < square).count()
                }
            };
            found += inside;
            possible -= range.len() - inside;
            if found >= enough {
                return true;
            }
            if possible < enough {
                return false;
            }
        }
        false
    }
}

/// Returns the halves of a run of points; `None` for a run that is not halved.
fn halves(range: &Range<usize>) -> Option<[Range<usize>; 2]> {
    let middle = range.start + range.len() / 2;
    (range.len() > LEAF).then_some([range.start..middle, middle..range.end])
}

fn halve(points: &mut [[f64; 3]], index: usize, boxes: &mut Vec<PointBounds>) {
    if boxes.len() <= index {
        boxes.resize(index + 1, PointBounds::NONE);
    }
    boxes[index] = PointBounds::of(points);
    let Some([left, _]) = halves(&(0..points.len())) else {
        return;
    };
    let axis = boxes[index].longest_axis();
    points.select_nth_unstable_by(left.end, |a, b| a[axis].total_cmp(&b[axis]));
    let (left, right) = points.split_at_mut(left.end);
    halve(left, 2 * index + 1, boxes);
    halve(right, 2 * index + 2, boxes);
}

/// Returns the square of the distance between two points.
fn distance_square(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    let [x, y, z] = [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
    x * x + y * y + z * z
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tree_counts_as_testing_each_point_does() {
        // A lattice, so that many points lie at the radius exactly, some of it twice, with a crowd
        // at one place.
        let lattice = (0..4096).map(|i| [i % 16, i / 16 % 16, i / 256].map(f64::from));
        let crowd = std::iter::repeat_n([7.5, 7.5, 7.25], 3000);
        let points: Vec<[f64; 3]> =
            lattice.clone().chain(lattice.step_by(3)).chain(crowd).collect();
        let tree = Tree::new(points.clone());
        for square in [1.0, 4.0, 6.75, 81.0, f64::INFINITY] {
            for at in points.iter().step_by(97) {
                let near = |point: &&[f64; 3]| distance_square(at, point) < square;
                let count = points.iter().filter(near).count();
                assert!(tree.has_enough(at, square, count));
                assert!(!tree.has_enough(at, square, count + 1), "{at:?} {square}");
            }
        }
    }
}
