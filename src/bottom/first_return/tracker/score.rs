//! Scores how much every cell of every row looks like the step from water to bottom, and limits the
//! place of the line by the recorded depth.

use super::super::{FirstReturnSettings, Normalisation, SampleMode, joined};
use super::grid::TrackerGrid;
use super::rows::{SampleRows, TrackerChunk};
use super::trend::{Trend, overlap};
use crate::first_return::confidence::farthest_m;
use crate::vectors::{VectorLoop, vectorised};
use bathyscope_log::survey::Survey;
use std::ops::Range;

/// Length of the windows that are compared before and after a step, metres.
const WINDOW_M: f64 = 0.20;
/// Least number of cells in such a window: a bright line one or two cells wide must not fill it.
const WINDOW_CELLS: usize = 10;
/// Largest rise of the echo before a step above quiet water, in standard deviations of the noise,
/// without a cost. Over the boulders of the real river the step from a boulder to the ground behind
/// it is often the greater one; the first is the one from the water.
const QUIET: f32 = 1.0;
/// Cost in score of each further standard deviation. On the river any cost from 0.3 on finds the
/// boulders; on ponds none up to 1 changes the error by more than a tenth of a millimetre.
const LOUD_COST: f32 = 0.5;
/// Largest growth of the water's brightness with range, bytes a metre.
const WATER_GROWS_PER_M: f64 = 8.0;

/// Number of rows on either side that a row is averaged with.
const ALONG: usize = 3;
/// Weights of the smoothing along the track: a gaussian of 1.2 pings that sums to 64.
const WEIGHTS: [u16; ALONG + 1] = [22, 15, 5, 1];

/// Factor of smoothed values on bytes: they are kept as integers, so that sums over windows are
/// exact.
const FINE: f32 = 8.0;

/// Variance of the noise floor, bytes squared: even the level of quiet water has an uncertainty of
/// 3 bytes.
pub(super) const FLOOR: f32 = 9.0;

/// Number of pings before and after a ping whose echo may reach the threshold in its place: speckle
/// may fade the echo of any one ping.
const LOUD_ALONG: isize = 2;

/// Number of windows before a step whose mean must be dark.
const LONG_WINDOWS: usize = 5;

/// Largest score: one very bright echo must not move the line over many pings.
pub(super) const MOST: f32 = 6.0;

/// Windows, limits and threshold of the score, in the units of a chunk's picture.
pub(super) struct Kernel {
    /// Number of cells in each of the two windows.
    window: usize,
    /// First cell that can be a return.
    first: usize,
    /// Least byte that some cell within the far window must have, on this ping or a neighbour; 256
    /// if no byte reaches the threshold.
    level: u16,
    /// Largest growth of the water's brightness from cell to cell, in units of 1 / [`FINE`] byte.
    creep: f32,
}

impl Kernel {
    /// Creates the kernel for the scale of a chunk.
    pub(super) fn new(
        normalisation: &Normalisation,
        settings: &FirstReturnSettings,
        chunk: &TrackerChunk,
        cell_m: f64,
    ) -> Self {
        let level = match normalisation.samples {
            SampleMode::Bytes => normalisation.raw_level(settings.threshold) as f32,
            SampleMode::Words => settings.threshold * 255.0,
        };
        Self {
            window: ((WINDOW_M / cell_m).round() as usize).clamp(WINDOW_CELLS, 255),
            // The limit is far beyond any row: sums of indices must not wrap where the range of a
            // header is close to 0.
            first: ((settings.dead_zone_m - chunk.near_m) / cell_m).ceil().clamp(0.0, 1e9) as usize,
            level: level.ceil().clamp(0.0, 256.0) as u16,
            creep: FINE * (WATER_GROWS_PER_M * cell_m).min(255.0) as f32,
        }
    }
}

/// Scores of all cells of a chunk; cells that cannot be a return have [`Scores::CLOSED`].
#[derive(Default)]
pub(super) struct Scores {
    /// Scores of all rows.
    pub grid: TrackerGrid,
    /// Trend that the rows are averaged along.
    trend: Trend,
    /// True for each row that was measured last.
    is_new: Vec<bool>,
    /// True if scores were lowered otherwise than by [`Depths::weigh`].
    is_lowered: bool,
    fine: Vec<i16>,
    loudest: Vec<u8>,
    spare: Vec<u8>,
    /// Running sums of the rows that are processed together.
    sums: [RunningSums; TOGETHER],
    quiet: [Vec<f32>; TOGETHER],
    before: Vec<f32>,
}

/// Number of rows that are processed together: the brightness of water at a cell depends on that at
/// the cell before, so the work on the other rows fills the waiting time of one row.
const TOGETHER: usize = 4;

/// Running sums over the first cells of a row, from none to all. The sums may wrap; differences
/// over a window do not.
#[derive(Default)]
struct RunningSums {
    sums: Vec<u32>,
    squares: Vec<u32>,
}

impl Scores {
    /// Score of a cell that does not pass the threshold or cannot be measured.
    pub(super) const CLOSED: f32 = -1.0;

    /// Replaces the scores with those of the rows, averaged with their neighbours.
    pub(super) fn measure(&mut self, rows: &SampleRows, kernel: &Kernel) {
        self.grid.reset(rows.len(), rows.width, Self::CLOSED);
        self.trend = Trend::default();
        self.is_new.clear();
        self.is_new.resize(rows.len(), true);
        self.is_lowered = false;
        vectorised(Measure { scores: self, rows, kernel });
    }

    /// Replaces the scores of the same rows with those averaged along another trend.
    pub(super) fn measure_along(&mut self, trend: &Trend, rows: &SampleRows, kernel: &Kernel) {
        for first in (0..rows.len()).step_by(TOGETHER) {
            let together = first..rows.len().min(first + TOGETHER);
            let averaged = first.saturating_sub(ALONG)..together.end + ALONG;
            let is_new = [&self.trend, trend].iter().any(|trend| trend.moves_over(&averaged));
            if is_new || self.is_lowered {
                together.clone().for_each(|row| self.grid.row_mut(row).fill(Self::CLOSED));
            }
            self.is_new[together].fill(is_new || self.is_lowered);
        }
        self.trend.clone_from(trend);
        self.is_lowered = false;
        vectorised(Measure { scores: self, rows, kernel });
    }

    /// Lowers the scores of some cells of a row; cells beyond the row are ignored.
    fn lower(&mut self, row: usize, cells: Range<usize>, cost: f32) {
        let row = self.grid.row_mut(row);
        let (start, end) = (cells.start.min(row.len()), cells.end.min(row.len()));
        for score in &mut row[start..end] {
            *score -= cost;
        }
    }

    #[inline(always)]
    fn smooth(&mut self, rows: &SampleRows, row: usize) {
        let at = |offset: isize| rows.row(row as isize + offset);
        let moved = |offset: isize| self.trend.between(row, row as isize + offset);
        self.fine.clear();
        self.fine.resize(at(0).len(), 0);
        for (fine, &byte) in self.fine.iter_mut().zip(at(0)) {
            *fine = (WEIGHTS[0] * u16::from(byte)) as i16;
        }
        for (offset, &weight) in (0isize..).zip(&WEIGHTS).skip(1) {
            if moved(-offset) != 0 || moved(offset) != 0 {
                for offset in [-offset, offset] {
                    let (here, there, count) = overlap(self.fine.len(), moved(offset));
                    let cells = self.fine[here..][..count].iter_mut().zip(&at(offset)[there..]);
                    cells.for_each(|(fine, &byte)| *fine += (weight * u16::from(byte)) as i16);
                }
                continue;
            }
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

    /// Finds for every cell the largest byte in the window that begins there, over this ping and
    /// its neighbours.
    #[inline(always)]
    fn find_loudest(&mut self, rows: &SampleRows, row: usize, window: usize) {
        self.loudest.clear();
        self.loudest.extend_from_slice(rows.row(row as isize));
        for offset in (-LOUD_ALONG..=LOUD_ALONG).filter(|&offset| offset != 0) {
            let other = row as isize + offset;
            let (here, there, count) = overlap(self.loudest.len(), self.trend.between(row, other));
            let cells = self.loudest[here..][..count].iter_mut().zip(&rows.row(other)[there..]);
            for (loudest, &byte) in cells {
                *loudest = byte.max(*loudest);
            }
        }
        window_maximum(&mut self.loudest, &mut self.spare, window);
    }
}

impl RunningSums {
    /// Replaces the sums with those of a row.
    #[inline(always)]
    fn of(&mut self, fine: &[i16]) {
        let (mut sum, mut square) = (0u32, 0u32);
        for sums in [&mut self.sums, &mut self.squares] {
            sums.clear();
            sums.resize(fine.len() + 1, 0);
        }
        let ends = self.sums[1..].iter_mut().zip(&mut self.squares[1..]);
        for ((sum_end, square_end), &fine) in ends.zip(fine) {
            let fine = fine as u32;
            sum = sum.wrapping_add(fine);
            square = square.wrapping_add(fine * fine);
            (*sum_end, *square_end) = (sum, square);
        }
    }
}

/// Arguments of [`Scores::measure`] for the vectorised loop.
struct Measure<'a> {
    scores: &'a mut Scores,
    rows: &'a SampleRows,
    kernel: &'a Kernel,
}

impl VectorLoop for Measure<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { scores, rows, kernel } = self;
        for first in (0..rows.len()).step_by(TOGETHER) {
            if !scores.is_new[first] {
                continue;
            }
            let last = rows.len() - 1;
            for index in 0..TOGETHER {
                // Where fewer rows are left, the last one is processed again.
                scores.smooth(rows, last.min(first + index));
                scores.sums[index].of(&scores.fine);
            }
            quiet_water(&mut scores.quiet, &scores.sums, kernel);
            for (index, row) in (first..=last).take(TOGETHER).enumerate() {
                let RunningSums { sums, squares } = &scores.sums[index];
                brightness_before(&mut scores.before, sums, kernel);
                let water = (&scores.before[..], &scores.quiet[index][..]);
                let out = scores.grid.row_mut(row);
                step_scores(out, (sums, squares), water, kernel, rows.recorded[row]);
                scores.find_loudest(rows, row, kernel.window);
                close_below_level(scores.grid.row_mut(row), &scores.loudest, kernel.level);
            }
        }
    }
}

/// Writes for every cell the mean of all cells before it from the dead zone on, or the mean of the
/// last [`LONG_WINDOWS`] windows if that is brighter: this must be dark for a step to be the first
/// one. For a step in the shadow of a boulder, the boulder is among these cells.
#[inline(always)]
fn brightness_before(out: &mut Vec<f32>, sums: &[u32], kernel: &Kernel) {
    let first = kernel.first.min(sums.len());
    let window = LONG_WINDOWS * kernel.window;
    out.clear();
    out.resize(sums.len(), 0.0);
    let start = sums.get(first).copied().unwrap_or(0);
    // Signed numbers convert faster.
    for (count, (mean, sum)) in (0_i32..).zip(out[first..].iter_mut().zip(&sums[first..])) {
        *mean = sum.wrapping_sub(start) as i32 as f32 / count.max(1) as f32;
    }
    let per = 1.0 / window as f32;
    let lasts = sums.iter().skip(first).zip(sums.iter().skip(first + window));
    for (mean, (before, here)) in out.iter_mut().skip(first + window).zip(lasts) {
        let last = here.wrapping_sub(*before) as i32 as f32 * per;
        *mean = if last > *mean { last } else { *mean };
    }
}

/// Writes for every cell the brightness of the darkest window up to the one that ends there; it may
/// grow slowly with range. Where a brighter echo continues without a gap from that water to a step,
/// the step is not the first one.
#[inline(always)]
fn quiet_water(out: &mut [Vec<f32>; TOGETHER], rows: &[RunningSums; TOGETHER], kernel: &Kernel) {
    let per = 1.0 / kernel.window as f32;
    let length = rows[0].sums.len();
    // Until there are two whole windows, the brightness of the water is not known.
    let known = (kernel.first + 2 * kernel.window).min(length);
    for out in out.iter_mut() {
        out.clear();
        out.resize(length, f32::INFINITY);
    }
    if known == length {
        return;
    }
    let windows = rows.each_ref().map(|row| {
        let starts = &row.sums[kernel.first..];
        [starts, &starts[kernel.window..]].map(|sums| &sums[..length - known])
    });
    let outs = out.each_mut().map(|out| &mut out[known..]);
    let mut quiet = [f32::INFINITY; TOGETHER];
    for cell in 0..length - known {
        for row in 0..TOGETHER {
            let [starts, ends] = windows[row];
            let mean = ends[cell].wrapping_sub(starts[cell]) as i32 as f32 * per;
            let crept = quiet[row] + kernel.creep;
            quiet[row] = if mean < crept { mean } else { crept };
            outs[row][cell] = quiet[row];
        }
    }
}

/// Computes `(mean after - mean before) / sqrt(variance after + variance before + floor)` at every
/// cell, less a cost where the cells before it are not quiet water. The brightness of the water
/// before every cell is that of [`brightness_before`] and of [`quiet_water`].
#[inline(always)]
fn step_scores(
    out: &mut [f32],
    (sums, squares): (&[u32], &[u32]),
    (before, quiet): (&[f32], &[f32]),
    kernel: &Kernel,
    recorded: usize,
) {
    let window = kernel.window;
    let last = recorded.saturating_sub(window);
    let full = (kernel.first + window).min(last);
    let per = 1.0 / window as f32;
    // Just beyond the dead zone the near window is shorter, so that it does not hold the ring-down.
    let short = kernel.first + window / 4;
    for (cell, out) in out.iter_mut().enumerate().take(full).skip(short) {
        let near = 1.0 / (cell - kernel.first) as f32;
        let near = Moments::between(sums, squares, kernel.first, cell, near);
        let far = Moments::between(sums, squares, cell, cell + window, per);
        *out = far.step_from(near, before[cell], quiet[cell]);
    }
    if full < kernel.first + window {
        return;
    }
    let count = last - full;
    let starts = [full - window, full, full + window];
    let [s0, s1, s2] = starts.map(|start| &sums[start..][..count]);
    let [q0, q1, q2] = starts.map(|start| &squares[start..][..count]);
    let [before, quiet] = [before, quiet].map(|water| &water[full..][..count]);
    for (cell, out) in out[full..last].iter_mut().enumerate() {
        let near = Moments::of(s0[cell], s1[cell], q0[cell], q1[cell], per);
        let far = Moments::of(s1[cell], s2[cell], q1[cell], q2[cell], per);
        *out = far.step_from(near, before[cell], quiet[cell]);
    }
}

/// Mean and variance of a window of fine values.
struct Moments {
    mean: f32,
    variance: f32,
}

impl Moments {
    /// Creates the moments from the running sums at both ends; `per` is 1 divided by the number of
    /// cells.
    #[inline(always)]
    fn of(sum: u32, sum_end: u32, square: u32, square_end: u32, per: f32) -> Self {
        // A window of 255 cells stays below 2^31, and signed numbers convert faster.
        let mean = sum_end.wrapping_sub(sum) as i32 as f32 * per;
        let square = square_end.wrapping_sub(square) as i32 as f32 * per;
        Self { mean, variance: square - mean * mean }
    }

    #[inline(always)]
    fn between(sums: &[u32], squares: &[u32], start: usize, end: usize, per: f32) -> Self {
        Self::of(sums[start], sums[end], squares[start], squares[end], per)
    }

    #[inline(always)]
    fn step_from(&self, near: Self, before: f32, quiet: f32) -> f32 {
        let noise = (near.variance + self.variance + FLOOR * FINE * FINE).sqrt();
        let dark = if before > near.mean { before } else { near.mean };
        let score = (self.mean - dark) / noise;
        let score = if score < MOST { score } else { MOST };
        let level = (near.mean - quiet) / noise - QUIET;
        let cost = if level > 0.0 { LOUD_COST * level } else { 0.0 };
        score - cost
    }
}

/// Sets the score of the cells behind which nothing reaches the threshold to [`Scores::CLOSED`].
#[inline(always)]
fn close_below_level(out: &mut [f32], loudest: &[u8], level: u16) {
    for (score, &loudest) in out.iter_mut().zip(loudest) {
        *score = if u16::from(loudest) >= level { *score } else { Scores::CLOSED };
    }
}

/// Replaces every value with the maximum of the `window` values that start there.
#[inline(always)]
fn window_maximum(values: &mut Vec<u8>, spare: &mut Vec<u8>, window: usize) {
    let mut covered = 1;
    while covered < window.min(values.len()) {
        let step = covered.min(window - covered);
        spare.clear();
        spare.extend_from_slice(values);
        for (larger, &other) in spare.iter_mut().zip(&values[step..]) {
            *larger = other.max(*larger);
        }
        std::mem::swap(values, spare);
        covered += step;
    }
}

/// Cost in score of a place outside the window around the recorded depth.
const DEPTH_COST: f32 = 1.2;
/// Window around the recorded depth, as shares of the depth.
const DEPTH_WINDOW: (f64, f64) = (0.65, 1.12);
/// Share of the pings whose line must be within the limits of the depth for the depth to be
/// believed everywhere.
const DEPTH_TRUST: f64 = 0.9;
/// Multiple of the recorded depth beyond which the line has leapt.
const LEAP_SHARE: f64 = 1.25;
/// Largest number of consecutive rows within a stretch that are not far beyond the depth.
const PAUSE: usize = 8;

/// Recorded depths along a chunk, in cells of its picture.
pub(super) struct Depths {
    /// Depth at each row, cells of range; NaN where there is none to believe.
    pub cells: Vec<f64>,
    /// Range at which the picture starts, cells: it may be more than 0.
    near: f64,
    /// Length of a cell, metres.
    cell_m: f64,
}

impl Depths {
    /// Creates the depths of the pings of a chunk.
    pub(super) fn of(survey: &Survey, chunk: &TrackerChunk, cell_m: f64) -> Self {
        let depths = chunk.pings.iter().map(|&ping| {
            let depth_m = f64::from(survey.good_depth_m(ping as usize));
            if depth_m > 0.0 { depth_m / cell_m } else { f64::NAN }
        });
        Self { cells: depths.collect(), near: chunk.near_m / cell_m, cell_m }
    }

    /// Lowers the scores of cells far from the recorded depth. The cost is small, since that depth
    /// may be wrong; without a depth nothing changes. Rows that were not measured last are weighed
    /// already.
    pub(super) fn weigh(&self, scores: &mut Scores) {
        let (near, far) = DEPTH_WINDOW;
        for (row, depth) in self.known() {
            if scores.is_new[row] {
                scores.lower(row, 0..self.cell(near * depth), DEPTH_COST);
                scores.lower(row, self.cell(far * depth)..usize::MAX, DEPTH_COST);
            }
        }
    }

    /// Returns true if some of the line is beyond the recorded depth: the bottom below the boat
    /// returns at that range, so nothing farther can be the first return. Under the echo of a
    /// boulder or a wreck the line continues along the ground.
    pub(super) fn is_passed(&self, line: &[usize]) -> bool {
        self.known().any(|(row, depth)| line[row] > self.limit(depth))
    }

    /// Returns the stretches of rows in which the line is far beyond the recorded depth, for
    /// example where it leapt to a wall. A line a little beyond the depth is the edge of the bottom
    /// where the depth is late or rounded.
    pub(super) fn leaps(&self, line: &[usize]) -> Vec<Range<usize>> {
        let is_far = |&(row, depth): &(usize, f64)| line[row] > self.cell(LEAP_SHARE * depth);
        let far = self.known().filter(is_far).map(|(row, _)| row);
        joined(far, |end, row| row - end <= PAUSE)
    }

    /// Lowers the scores of cells beyond the recorded depth in some rows by a cost; a cost below
    /// zero raises them again.
    pub(super) fn lower_beyond(&self, rows: &Range<usize>, cost: f32, scores: &mut Scores) {
        for (row, depth) in self.known().filter(|(row, _)| rows.contains(row)) {
            scores.lower(row, self.limit(depth)..usize::MAX, cost);
            scores.is_lowered = true;
        }
    }

    /// Returns true if the line is within the limits of the depth on nearly all pings of the chunk,
    /// so that the depth can be believed at every ping.
    pub(super) fn bounds(&self, line: &[usize]) -> bool {
        let nearest = |depth: f64| self.cell(DEPTH_WINDOW.0 * depth);
        let (mut known, mut agreeing) = (0, 0);
        for (row, depth) in self.known() {
            known += 1;
            agreeing += usize::from((nearest(depth)..=self.limit(depth)).contains(&line[row]));
        }
        agreeing as f64 >= DEPTH_TRUST * f64::from(known)
    }

    /// Returns the farthest cell at which the bottom below the boat returns; `depth` is in cells.
    fn limit(&self, depth: f64) -> usize {
        self.cell(farthest_m(depth * self.cell_m) / self.cell_m)
    }

    fn known(&self) -> impl Iterator<Item = (usize, f64)> {
        let all = self.cells.iter().copied().enumerate();
        all.filter(|(_, depth)| depth.is_finite())
    }

    /// Returns the index of the cell of the picture at a range in cells.
    fn cell(&self, range: f64) -> usize {
        (range - self.near).max(0.0) as usize
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn window_maximum_is_that_of_every_window() {
        let values: Vec<u8> = (0..97).map(|i: u32| (i * 7919 % 101) as u8).collect();
        for window in [1, 2, 3, 8, 24, 97, 200] {
            let mut found = values.clone();
            window_maximum(&mut found, &mut Vec::new(), window);
            let expected = (0..values.len())
                .map(|at| values[at..values.len().min(at + window)].iter().copied().max().unwrap());
            assert!(found.iter().copied().eq(expected), "window {window}");
        }
    }
}
