//! Finds the cells of a grid that lie in a strip, row by row.

use std::ops::Range;

/// The cells, within some columns and rows, whose middles lie in a polygon.
pub(super) struct Scan<'a> {
    /// Counted in cells from the middle of the first.
    corners: &'a [[f64; 2]; 4],
    columns: usize,
    /// The rows that it lies in.
    pub rows: Range<usize>,
    low: f64,
    high: f64,
}

impl<'a> Scan<'a> {
    /// Creates the scan of a polygon; its corners are counted in cells from the middle of the
    /// first.
    #[inline(always)]
    pub(super) fn new(corners: &'a [[f64; 2]; 4], columns: usize, rows: usize) -> Self {
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for corner in corners {
            (low, high) = (low.min(corner[1]), high.max(corner[1]));
        }
        Self { corners, columns, rows: cells(low, high, rows), low, high }
    }

    /// The columns that it lies in, in one of its rows.
    #[inline(always)]
    pub(super) fn columns(&self, row: usize) -> Range<usize> {
        // Of a row's middle that rounding puts beside the polygon, the edge.
        let row = (row as f64).max(self.low).min(self.high);
        let [from, to] = crossing(self.corners, row);
        cells(from, to, self.columns)
    }
}

/// Cells by which a span is too wide rather than too narrow: what lies on the edge of two polygons
/// must be in one of them, however their corners are rounded.
const MARGIN: f64 = 1e-6;

/// Whole cells whose middles lie between two places, within `0..count`.
#[inline(always)]
fn cells(from: f64, to: f64, count: usize) -> Range<usize> {
    let start = ((from - MARGIN).ceil().max(0.0) as usize).min(count);
    let end = (((to + MARGIN).floor() + 1.0).max(0.0) as usize).min(count);
    start..end.max(start)
}

/// Returns the first and the last place where a row crosses a polygon; the first is beyond the last
/// where it does not.
#[inline(always)]
fn crossing(corners: &[[f64; 2]; 4], row: f64) -> [f64; 2] {
    let (mut first, mut last) = (f64::INFINITY, f64::NEG_INFINITY);
    for index in 0..4 {
        let (a, b) = (corners[index], corners[(index + 1) % 4]);
        // The ends of an edge along the row belong to its neighbours too.
        if a[1] == b[1] || (a[1] - row) * (b[1] - row) > 0.0 {
            continue;
        }
        let column = a[0] + (b[0] - a[0]) * (row - a[1]) / (b[1] - a[1]);
        (first, last) = (first.min(column), last.max(column));
    }
    [first, last]
}
