//! Stores rows of numbers, one row for each ping, with fast functions for their maxima.

/// Rows of numbers, of equal width.
#[derive(Default)]
pub(super) struct TrackerGrid {
    cells: Vec<f32>,
    width: usize,
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

    /// Returns the number of cells in a row.
    pub(super) fn width(&self) -> usize {
        self.width
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
