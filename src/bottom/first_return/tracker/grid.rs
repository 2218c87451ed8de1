//! Stores rows of numbers, one row for each ping, with fast functions for their maxima, and
//! extracts bands of cells around the line, in which the line is level, so that they can be
//! averaged along the track without smearing a sloping edge.

use super::super::joined;
use super::rows::SampleRows;
use super::trend::Trend;
use std::ops::Range;

/// Rows of numbers, of equal width.
#[derive(Default)]
pub(super) struct TrackerGrid {
    cells: Vec<f32>,
    /// Number of cells in a row.
    pub width: usize,
}

impl TrackerGrid {
    /// Resizes the grid to `rows` by `width`, sets every cell to `fill` and keeps its memory.
    #[inline(always)]
    pub(super) fn reset(&mut self, rows: usize, width: usize, fill: f32) {
        self.width = width;
        self.cells.clear();
        self.cells.resize(rows * width, fill);
    }

    /// Returns the number of rows.
    pub(super) fn len(&self) -> usize {
        self.cells.len().checked_div(self.width).unwrap_or(0)
    }

    /// Returns a row.
    #[inline(always)]
    pub(super) fn row(&self, row: usize) -> &[f32] {
        &self.cells[row * self.width..][..self.width]
    }

    /// Returns a row, to be changed.
    #[inline(always)]
    pub(super) fn row_mut(&mut self, row: usize) -> &mut [f32] {
        &mut self.cells[row * self.width..][..self.width]
    }

    /// Returns the row before a row (empty for the first), and the row, to be changed.
    #[inline(always)]
    pub(super) fn row_after(&mut self, row: usize) -> (&[f32], &mut [f32]) {
        let (before, rest) = self.cells.split_at_mut(row * self.width);
        let last = before.len().saturating_sub(self.width);
        (&before[last..], &mut rest[..self.width])
    }
}

/// Number of values that [`highest`] compares at a time.
const BLOCK: usize = 64;

/// Returns the index of the highest value; of equal ones, the first.
#[inline(always)]
pub(super) fn highest(values: &[f32]) -> usize {
    let (mut start, mut most) = (0, f32::NEG_INFINITY);
    for (index, block) in values.chunks(BLOCK).enumerate() {
        let of_block = maximum(block);
        if of_block > most {
            (start, most) = (index * BLOCK, of_block);
        }
    }
    let offset = values[start..].iter().position(|value| *value == most);
    start + offset.unwrap_or(0)
}

/// Returns the highest value; computed in lanes, so that it is not one long chain of comparisons.
#[inline(always)]
pub(super) fn maximum(values: &[f32]) -> f32 {
    let mut lanes = [f32::NEG_INFINITY; 16];
    let (blocks, rest) = values.as_chunks::<16>();
    for block in blocks {
        for (lane, &value) in lanes.iter_mut().zip(block) {
            *lane = larger(*lane, value);
        }
    }
    let mut most = f32::NEG_INFINITY;
    for &value in rest {
        most = larger(most, value);
    }
    for lane in lanes {
        most = larger(most, lane);
    }
    most
}

/// Returns the larger score. Scores are never NaN; without the check of `f32::max` for NaN this is
/// a single instruction.
#[inline(always)]
pub(super) fn larger(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// Returns the peak of a parabola through three values, as an offset from the middle one, -0.5 to
/// 0.5.
pub(super) fn peak_offset(values: &[f32], at: usize) -> f32 {
    let before = at.checked_sub(1).and_then(|before| values.get(before));
    let (Some(&before), Some(&peak), Some(&after)) = (before, values.get(at), values.get(at + 1))
    else {
        return 0.0;
    };
    let curve = 2.0 * peak - before - after;
    if curve <= 0.0 {
        return 0.0;
    }
    (0.5 * (after - before) / curve).clamp(-0.5, 0.5)
}

/// Returns the stretches of rows over which the line moves no more than `limit` cells a row beside
/// the trend.
pub(super) fn stretches(line: &[usize], trend: &Trend, limit: usize) -> Vec<Range<usize>> {
    let moves = |row: usize| line[row] as isize - line[row - 1] as isize - trend.step(row);
    joined(0..line.len(), |_, row| moves(row).unsigned_abs() <= limit)
}

/// Returns half of a gaussian: weights at distances 0, 1, 2 ... up to three standard deviations.
pub(super) fn gaussian(deviation: f32) -> Vec<f32> {
    let reach = (3.0 * deviation).ceil() as usize;
    (0..=reach).map(|distance| (-0.5 * (distance as f32 / deviation).powi(2)).exp()).collect()
}

/// Returns the weighted mean of each value with its neighbours; at the ends, over the neighbours
/// that exist.
pub(super) fn smooth(values: &[f32], weights: &[f32]) -> Vec<f32> {
    (0..values.len())
        .map(|at| {
            let (mut sum, mut total) = (0.0, 0.0);
            for (value, weight) in neighbours(values.len(), at, weights) {
                sum += weight * values[value];
                total += weight;
            }
            sum / total
        })
        .collect()
}

/// Returns indices and weights of the neighbours of `at` (itself included) below `count`.
fn neighbours(count: usize, at: usize, weights: &[f32]) -> impl Iterator<Item = (usize, f32)> {
    let reach = weights.len() - 1;
    let range = at.saturating_sub(reach)..count.min(at + reach + 1);
    range.map(move |other| (other, weights[other.abs_diff(at)]))
}

/// Fills `band` with the cells from `half` before to `half` beyond the line on each row of a
/// stretch, interpolated. `line` holds the places of the stretch's rows; beyond the recorded cells,
/// the last one is repeated.
pub(super) fn extract(
    rows: &SampleRows,
    stretch: &Range<usize>,
    line: &[f32],
    half: usize,
    band: &mut TrackerGrid,
) {
    band.reset(stretch.len(), 2 * half + 1, 0.0);
    for (index, (row, &at)) in stretch.clone().zip(line).enumerate() {
        let cells = &rows.row(row as isize)[..rows.recorded[row]];
        let Some(last) = cells.len().checked_sub(1) else {
            continue;
        };
        let whole = at.floor();
        let share = at - whole;
        let cell = |offset: isize| {
            f32::from(cells[(whole as isize + offset).clamp(0, last as isize) as usize])
        };
        for (offset, out) in (-(half as isize)..).zip(band.row_mut(index)) {
            *out = cell(offset) * (1.0 - share) + cell(offset + 1) * share;
        }
    }
}

/// Writes the average of the band along the track to `out`.
pub(super) fn smooth_along(band: &TrackerGrid, weights: &[f32], out: &mut TrackerGrid) {
    out.reset(band.len(), band.width, 0.0);
    for row in 0..band.len() {
        let target = out.row_mut(row);
        let mut total = 0.0;
        for (other, weight) in neighbours(band.len(), row, weights) {
            total += weight;
            for (target, value) in target.iter_mut().zip(band.row(other)) {
                *target += weight * value;
            }
        }
        for target in target {
            *target /= total;
        }
    }
}
