//! Which cells of a grid lie in a strip, row by row.

use crate::support::statistics::ends;
use std::ops::Range;

/// Rows and columns of the cells, within so many columns and rows, whose middles lie in a polygon; its corners are counted in
/// cells from the middle of the first.
pub(super) fn spans(
    corners: &[[f64; 2]; 4],
    columns: usize,
    rows: usize,
) -> impl Iterator<Item = (usize, Range<usize>)> {
    let [low, high] = ends(corners.map(|corner| corner[1]));
    cells(low, high, rows).filter_map(move |row| {
        let [from, to] = crossing(corners, (row as f64).clamp(low, high))?;
        Some((row, cells(from, to, columns)))
    })
}

/// Cells by which a span is too wide rather than too narrow: what lies on the edge of two polygons must be in one of them,
/// however their corners are rounded.
const MARGIN: f64 = 1e-6;

/// Whole cells whose middles lie between two places, within `0..count`.
fn cells(from: f64, to: f64, count: usize) -> std::ops::Range<usize> {
    let start = (from - MARGIN).ceil().max(0.0) as usize;
    let end = (((to + MARGIN).floor() + 1.0).max(0.0) as usize).min(count);
    start..end.max(start)
}

/// Where a row crosses a polygon, first and last.
fn crossing(corners: &[[f64; 2]; 4], row: f64) -> Option<[f64; 2]> {
    let mut span: Option<[f64; 2]> = None;
    for index in 0..4 {
        let (a, b) = (corners[index], corners[(index + 1) % 4]);
        // The ends of an edge along the row belong to its neighbours too.
        if a[1] == b[1] || (a[1] - row) * (b[1] - row) > 0.0 {
            continue;
        }
        let column = a[0] + (b[0] - a[0]) * (row - a[1]) / (b[1] - a[1]);
        span = Some(span.map_or([column; 2], |[low, high]| {
            [low.min(column), high.max(column)]
        }));
    }
    span
}
