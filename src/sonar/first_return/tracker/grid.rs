//! Rows of numbers, one row a ping.

/// Rows of equal width.
#[derive(Default)]
pub(super) struct TrackerGrid {
    cells: Vec<f32>,
    width: usize,
}

impl TrackerGrid {
    /// Makes it `rows` by `width`, every cell `fill`; memory is kept.
    pub(super) fn reset(&mut self, rows: usize, width: usize, fill: f32) {
        self.width = width;
        self.cells.clear();
        self.cells.resize(rows * width, fill);
    }

    /// Number of rows.
    pub(super) fn len(&self) -> usize {
        self.cells.len().checked_div(self.width).unwrap_or(0)
    }

    /// Cells in a row.
    pub(super) fn width(&self) -> usize {
        self.width
    }

    /// One row.
    pub(super) fn row(&self, row: usize) -> &[f32] {
        &self.cells[row * self.width..][..self.width]
    }

    /// One row, to be changed.
    pub(super) fn row_mut(&mut self, row: usize) -> &mut [f32] {
        &mut self.cells[row * self.width..][..self.width]
    }

    /// One row to be changed, with the row before it (empty for the first).
    pub(super) fn row_after(&mut self, row: usize) -> (&[f32], &mut [f32]) {
        let (before, rest) = self.cells.split_at_mut(row * self.width);
        let last = before.len().saturating_sub(self.width);
        (&before[last..], &mut rest[..self.width])
    }
}

/// Index of the highest value.
pub(super) fn highest(values: &[f32]) -> usize {
    let mut best = 0;
    for (at, &value) in values.iter().enumerate() {
        if value > values[best] {
            best = at;
        }
    }
    best
}

/// Where between its neighbours a parabola through three values peaks, -0.5 to 0.5.
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
