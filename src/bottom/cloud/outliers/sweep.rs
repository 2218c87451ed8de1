//! Counts the neighbours of each point, row by row.

use super::cells::CellPoints;
use super::tree::{Tree, distance_square};
use bathyscope_log::support::progress::{Cancelled, Progress};
use rayon::prelude::*;
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
