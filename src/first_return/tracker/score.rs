//! How much every cell of every row looks like the step from water to bottom.

use super::super::{FirstReturnSettings, Normalisation, SampleMode};
use super::TUNING;
use super::rows::Rows;
use super::runs::Chunk;

/// Weights of the smoothing along the track: a gaussian of 1.2 pings that sums to 64.
const ALONG: [u16; 4] = [22, 15, 5, 1];

/// Smoothed values are kept as 8 times a byte, in integers, so that sums over windows are exact.
const FINE: f32 = 8.0;

/// Variance of the noise floor, bytes squared: even quiet water is not certain to less than 3 bytes.
const FLOOR: f32 = 9.0;

/// Scores are cut here: one glaring echo must not pull the line off for many pings.
const MOST: f32 = 6.0;

/// What the score compares.
pub(super) struct Kernel {
    /// Cells of each of the two windows.
    window: usize,
    /// First cell that can be a return.
    first: usize,
    /// Fine value that a cell within the far window must reach.
    level: i16,
}

impl Kernel {
    /// The kernel for the scale of a chunk.
    pub fn new(
        normalisation: &Normalisation,
        settings: &FirstReturnSettings,
        chunk: &Chunk,
        cell_m: f64,
    ) -> Self {
        let level = match normalisation.samples {
            SampleMode::Bytes => normalisation.raw_level(settings.threshold) as f32,
            SampleMode::Words => settings.threshold * 255.0,
        };
        Self {
            window: ((TUNING.window_m / cell_m).round() as usize).clamp(3, 255),
            first: (((settings.dead_zone_m - chunk.near_m) / cell_m)
                .ceil()
                .max(0.0)) as usize,
            level: (FINE * level).clamp(0.0, f32::from(i16::MAX)) as i16,
        }
    }
}

/// Scores of all cells of a chunk; cells that cannot be a return have [`Scores::CLOSED`].
#[derive(Default)]
pub(super) struct Scores {
    cells: Vec<f32>,
    /// Cells in a row.
    pub width: usize,
    fine: Vec<i16>,
    sums: Vec<u32>,
    squares: Vec<u32>,
}

impl Scores {
    /// The score of a cell that does not pass the threshold or cannot be measured.
    pub const CLOSED: f32 = -1.0;

    /// Replaces the scores by those of the rows.
    pub fn measure(&mut self, rows: &Rows, kernel: &Kernel) {
        self.width = rows.width;
        self.cells.clear();
        self.cells.resize(rows.len() * rows.width, Self::CLOSED);
        for row in 0..rows.len() {
            self.smooth(rows, row);
            self.sum_up();
            let out = &mut self.cells[row * self.width..][..self.width];
            step_scores(out, &self.sums, &self.squares, kernel, rows.recorded[row]);
            close_below_level(out, &mut self.fine, kernel);
        }
    }

    /// Number of rows.
    pub fn len(&self) -> usize {
        self.cells.len().checked_div(self.width).unwrap_or(0)
    }

    /// Scores of one row.
    pub fn row(&self, row: usize) -> &[f32] {
        &self.cells[row * self.width..][..self.width]
    }

    /// Lowers what lies far from the recorded depth. Soft, since that depth may be wrong; no depth, no change.
    pub fn weigh_depth(&mut self, row: usize, depth_m: f64, chunk: &Chunk, cell_m: f64) {
        if !depth_m.is_finite() || depth_m <= 0.0 {
            return;
        }
        let cell = |share: f64| {
            let cell = (share * depth_m - chunk.near_m) / cell_m;
            (cell.max(0.0) as usize).min(self.width)
        };
        let (near, far) = TUNING.depth_window;
        let window = cell(near)..cell(far);
        let row = &mut self.cells[row * self.width..][..self.width];
        for score in &mut row[..window.start] {
            *score -= TUNING.depth_cost;
        }
        for score in &mut row[window.end..] {
            *score -= TUNING.depth_cost;
        }
    }

    fn smooth(&mut self, rows: &Rows, row: usize) {
        let at = |offset: isize| rows.row(row as isize + offset);
        self.fine.clear();
        self.fine.extend(
            at(0)
                .iter()
                .map(|&byte| (ALONG[0] * u16::from(byte)) as i16),
        );
        for (offset, &weight) in (0isize..).zip(&ALONG).skip(1) {
            for (fine, (&before, &after)) in
                self.fine.iter_mut().zip(at(-offset).iter().zip(at(offset)))
            {
                *fine += (weight * (u16::from(before) + u16::from(after))) as i16;
            }
        }
        for fine in &mut self.fine {
            *fine >>= 3;
        }
    }

    /// Running sums; they may wrap, differences over a window do not.
    fn sum_up(&mut self) {
        let (mut sum, mut square) = (0u32, 0u32);
        self.sums.clear();
        self.squares.clear();
        self.sums.push(0);
        self.squares.push(0);
        for &fine in &self.fine {
            let fine = fine as u32;
            sum = sum.wrapping_add(fine);
            square = square.wrapping_add(fine * fine);
            self.sums.push(sum);
            self.squares.push(square);
        }
    }
}

/// `(mean after - mean before) / sqrt(variance after + variance before + floor)` at every cell.
fn step_scores(out: &mut [f32], sums: &[u32], squares: &[u32], kernel: &Kernel, recorded: usize) {
    let window = kernel.window;
    let first = kernel.first + window / 4;
    let full = (kernel.first + window).min(recorded);
    let last = recorded.saturating_sub(window);
    // Just beyond the dead zone the near window is cut short, so that the ring-down stays out of it.
    for cell in first..full.min(last) {
        out[cell] = step(sums, squares, (kernel.first, cell), (cell, cell + window));
    }
    if full >= last {
        return;
    }
    for cell in full..last {
        out[cell] = step(sums, squares, (cell - window, cell), (cell, cell + window));
    }
}

fn step(sums: &[u32], squares: &[u32], near: (usize, usize), far: (usize, usize)) -> f32 {
    let moments = |(start, end): (usize, usize)| {
        let n = (end - start) as f32;
        let mean = sums[end].wrapping_sub(sums[start]) as f32 / n;
        let square = squares[end].wrapping_sub(squares[start]) as f32 / n;
        (mean, square - mean * mean)
    };
    let (near_mean, near_variance) = moments(near);
    let (far_mean, far_variance) = moments(far);
    let noise = near_variance + far_variance + FLOOR * FINE * FINE;
    ((far_mean - near_mean) / noise.max(1.0).sqrt()).min(MOST)
}

/// Closes the cells behind which, within the window, nothing reaches the threshold.
fn close_below_level(out: &mut [f32], fine: &mut [i16], kernel: &Kernel) {
    window_maximum(fine, kernel.window);
    for (score, &highest) in out.iter_mut().zip(&*fine) {
        *score = if highest >= kernel.level {
            *score
        } else {
            Scores::CLOSED
        };
    }
}

/// Replaces every value by the maximum of the `window` values that start there.
fn window_maximum(values: &mut [i16], window: usize) {
    let mut covered = 1;
    while covered < window {
        let step = covered.min(window - covered);
        for at in 0..values.len().saturating_sub(step) {
            values[at] = values[at].max(values[at + step]);
        }
        covered += step;
    }
}
