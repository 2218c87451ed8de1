//! Refines the line from whole cells to the place of the edge within a fraction of a cell.
//!
//! The first search smooths along the track and so blurs a sloping edge. Here the picture is
//! aligned along the line and searched again near the line with shorter windows. The edge is then
//! read from the averaged profile at a fixed drop below the bottom's plateau. The recorders'
//! picture is logarithmic, so the edge of a strong echo starts earlier than that of a weak one; a
//! fixed drop in bytes is a fixed drop in decibels, at which both edges are equally far from the
//! true range.

use super::grid::{TrackerGrid, extract, gaussian, peak_offset, smooth, smooth_along, stretches};
use super::rows::SampleRows;
use super::score::{FLOOR, MOST};
use super::trend::Trend;
use super::viterbi::{MotionCost, Paths};
use bathyscope_log::support::statistics::upper_median;
use std::ops::Range;

/// Standard deviations of the smoothing, pings: of the line that the picture is aligned along, of
/// the picture that is searched again, and of the profile that the edge is read from.
const LINE_PINGS: f32 = 3.0;
const SEARCH_PINGS: f32 = 1.1;
const PROFILE_PINGS: f32 = 6.0;

/// Length of the windows that are compared before and after a step, metres.
const WINDOW_M: f64 = 0.1;
/// Largest distance from the smoothed line that is searched, metres.
const SEARCH_M: f64 = 0.2;
/// Largest movement of the second search from row to row, cells, and cost of each cell.
const MOVE: (usize, f32) = (4, 0.5);
/// Distances beyond the edge between which the bottom's plateau is measured, and before the edge
/// between which the water is, metres.
const PLATEAU_M: (f64, f64) = (0.05, 0.14);
const WATER_M: (f64, f64) = (0.07, 0.17);
/// Drop below the plateau at which the edge is read, as a share of the median contrast between
/// plateau and water.
const DROP: f32 = 0.6;
/// Least rise above the water at which the edge is read, as a share of the row's own contrast.
const LEAST_RISE: f32 = 0.15;

/// Buffers of the refinement of lines.
#[derive(Default)]
pub(super) struct Refiner {
    band: TrackerGrid,
    smoothed: TrackerGrid,
    scores: TrackerGrid,
    profiles: TrackerGrid,
    paths: Paths,
    onsets: Onsets,
}

impl Refiner {
    /// Returns the place of the edge on every row, cells. `limit` is the largest movement of the
    /// line from row to row beside the trend without a leap, cells.
    pub(super) fn refine(
        &mut self,
        rows: &SampleRows,
        line: &[usize],
        trend: &Trend,
        limit: usize,
        cell_m: f64,
    ) -> Vec<f32> {
        let reach = cells(WATER_M.1, cell_m, 5);
        self.profiles.reset(line.len(), 2 * reach + 1, 0.0);
        let mut places = Vec::with_capacity(line.len());
        let stretches = stretches(line, trend, limit);
        for stretch in stretches.iter().cloned() {
            // Beside the trend, whose kinks stay.
            let moved = |row: usize| trend.between(stretch.start, row as isize) as f32;
            let rough: Vec<f32> =
                stretch.clone().map(|row| line[row] as f32 - moved(row)).collect();
            let mut straight = smooth(&rough, &gaussian(LINE_PINGS));
            for (at, row) in straight.iter_mut().zip(stretch.clone()) {
                *at += moved(row);
            }
            let found = self.search(rows, &stretch, &straight, cell_m);
            extract(rows, &stretch, &found, reach, &mut self.band);
            smooth_along(&self.band, &gaussian(PROFILE_PINGS), &mut self.smoothed);
            for (index, row) in stretch.enumerate() {
                self.profiles.row_mut(row).copy_from_slice(self.smoothed.row(index));
            }
            places.extend(found);
        }
        let profiles: Vec<LineProfile> =
            (0..line.len()).map(|row| LineProfile::of(self.profiles.row(row), cell_m)).collect();
        let mut contrasts: Vec<f32> = profiles.iter().map(LineProfile::contrast).collect();
        let drop = DROP * upper_median(&mut contrasts, f32::total_cmp).unwrap_or(0.0);
        for (place, profile) in places.iter_mut().zip(&profiles) {
            *place += profile.edge(drop);
        }
        self.onsets.advance(rows, &stretches, &mut places, cell_m);
        places
    }

    /// Returns the places of the steps near `line`, searched again on the aligned picture.
    fn search(
        &mut self,
        rows: &SampleRows,
        stretch: &Range<usize>,
        line: &[f32],
        cell_m: f64,
    ) -> Vec<f32> {
        let window = cells(WINDOW_M, cell_m, 5);
        let half = cells(SEARCH_M, cell_m, 4) + window;
        extract(rows, stretch, line, half, &mut self.band);
        smooth_along(&self.band, &gaussian(SEARCH_PINGS), &mut self.smoothed);
        self.scores.reset(stretch.len(), 2 * half + 1, -1.0);
        for row in 0..stretch.len() {
            short_steps(self.smoothed.row(row), window, self.scores.row_mut(row));
        }
        let motion = MotionCost { limit: MOVE.0, cost: MOVE.1, leap: f32::INFINITY };
        let found = self.paths.line(&self.scores, &Trend::default(), &motion);
        let placed = found.iter().zip(line).enumerate().map(|(row, (&cell, &line))| {
            line - half as f32 + cell as f32 + peak_offset(self.scores.row(row), cell)
        });
        placed.collect()
    }
}

fn cells(metres: f64, cell_m: f64, least: usize) -> usize {
    ((metres / cell_m).round() as usize).clamp(least, 255)
}

/// Computes scores like those of the first search, with windows short enough to locate the edge,
/// over a few cells.
fn short_steps(cells: &[f32], window: usize, out: &mut [f32]) {
    for at in window..(cells.len() + 1).saturating_sub(window) {
        let (near, far) = (moments(&cells[at - window..at]), moments(&cells[at..at + window]));
        out[at] = ((far.0 - near.0) / (near.1 + far.1 + FLOOR).sqrt()).min(MOST);
    }
}

/// Returns mean and variance.
fn moments(values: &[f32]) -> (f32, f32) {
    let n = values.len() as f32;
    let (sum, square) = values
        .iter()
        .fold((0.0, 0.0), |(sum, square), &value| (sum + value, square + value * value));
    let mean = sum / n;
    (mean, (square / n - mean * mean).max(0.0))
}

/// Picture of a row, averaged along the line; the line is in the middle cell.
struct LineProfile<'a> {
    values: &'a [f32],
    /// Cell at the end of the plateau, where the search for the edge begins.
    plateau_end: usize,
    plateau: f32,
    water: f32,
}

impl<'a> LineProfile<'a> {
    fn of(values: &'a [f32], cell_m: f64) -> Self {
        let middle = values.len() / 2;
        let mean = |range: Range<usize>| moments(&values[range]).0;
        let beyond = |metres: f64, least: usize| middle + cells(metres, cell_m, least).min(middle);
        let before = |metres: f64, least: usize| middle - cells(metres, cell_m, least).min(middle);
        let plateau = beyond(PLATEAU_M.0, 1)..beyond(PLATEAU_M.1, 3);
        Self {
            values,
            plateau_end: plateau.end,
            plateau: mean(plateau),
            water: mean(before(WATER_M.1, 5)..before(WATER_M.0, 2)),
        }
    }

    fn contrast(&self) -> f32 {
        self.plateau - self.water
    }

    /// Returns the distance in cells from the middle to the place where, seen from the plateau, the
    /// profile has fallen by `drop`.
    fn edge(&self, drop: f32) -> f32 {
        let least = self.water + LEAST_RISE * self.contrast();
        let level = (self.plateau - drop).max(least);
        let middle = self.values.len() / 2;
        let below = self.values[..self.plateau_end].iter().rposition(|&value| value < level);
        let Some(below) = below.filter(|&below| below + 1 < self.values.len()) else {
            return 0.0;
        };
        let (low, high) = (self.values[below], self.values[below + 1]);
        let share = if high > low { (level - low) / (high - low) } else { 0.0 };
        below as f32 + share.clamp(0.0, 1.0) - middle as f32
    }
}

/// Standard deviation of the averaging along the track, pings, and length of the averaging along
/// the range, metres.
const ALONG_PINGS: f32 = 0.6;
const BLUR_M: f64 = 0.04;
/// Distances before the edge between which the water is measured, and beyond the edge between which
/// the bottom is, metres.
const ONSET_WATER_M: (f64, f64) = (0.45, 0.25);
const BOTTOM_M: (f64, f64) = (0.03, 0.12);
/// Rise above the water that is an onset, as a share of the usual contrast between bottom and
/// water.
const RISE: f32 = 0.18;
/// Least rise of an onset, in standard deviations of the water. A fainter rise cannot be
/// distinguished from noise, and the edge stays where it is.
const QUIET: f32 = 4.0;
/// Distance by which noise alone may make an onset earlier than usual, metres.
const NOISE_M: f64 = 0.003;

/// Buffers of the search for onsets in a chunk: the echo just before the edge, of a stone, the side
/// of a boulder or the crest of a bump.
///
/// The edge is read from a profile averaged over many pings, in which a stone of two pings
/// disappears. The echo of the stone is weaker than that of the ground behind it, but it is the
/// first return. Each row is therefore read once more, with hardly any averaging, to find the place
/// where the unbroken echo before the edge rises out of the water.
#[derive(Default)]
struct Onsets {
    band: TrackerGrid,
    averaged: TrackerGrid,
    /// Picture along the edge, one row for each ping, with the edge in the middle.
    picture: TrackerGrid,
    levels: Vec<EdgeLevels>,
}

/// Brightness of a row on both sides of the edge.
struct EdgeLevels {
    water: f32,
    deviation: f32,
    bottom: f32,
}

impl Onsets {
    /// Moves the places of the edge to earlier onsets as far as they exceed the noise.
    ///
    /// Every onset is a little before the edge of the averaged profile; this usual distance is not
    /// counted as a stone.
    fn advance(
        &mut self,
        rows: &SampleRows,
        stretches: &[Range<usize>],
        places: &mut [f32],
        cell_m: f64,
    ) {
        let cells = |metres: f64, least: usize| cells(metres, cell_m, least);
        let middle = cells(ONSET_WATER_M.0, 8);
        let water = 0..middle - cells(ONSET_WATER_M.1, 4).min(middle - 2);
        let bottom = middle + cells(BOTTOM_M.0, 1)..middle + cells(BOTTOM_M.1, 3).min(middle);
        self.lay_straight(rows, stretches, places, middle, cells(BLUR_M / 2.0, 1));
        self.levels.clear();
        for row in 0..places.len() {
            self.levels.push(EdgeLevels::of(self.picture.row(row), &water, &bottom));
        }
        let rise = RISE * self.median(|row| row.bottom - row.water);
        if rise < QUIET * self.median(|row| row.deviation) {
            return;
        }
        let leads: Vec<f32> = (self.levels.iter().enumerate())
            .map(|(row, levels)| {
                let picture = &self.picture.row(row)[..bottom.end];
                rises_above(levels.water + rise, picture).map_or(f32::NAN, |at| at - middle as f32)
            })
            .collect();
        let mut known: Vec<f32> = leads.iter().copied().filter(|lead| !lead.is_nan()).collect();
        let usual = upper_median(&mut known, f32::total_cmp).unwrap_or(0.0);
        let noise = (NOISE_M / cell_m) as f32;
        for (place, lead) in places.iter_mut().zip(&leads) {
            // Without an onset `early` is NaN, and the comparison false.
            let early = usual - lead;
            if early > noise {
                // The more the lead exceeds the noise, the larger is the part of it that is used.
                *place -= early * (1.0 - (noise / early).powi(2));
            }
        }
    }

    /// Fills the picture with the rows along the edge, averaged a little along the track and along
    /// the range.
    fn lay_straight(
        &mut self,
        rows: &SampleRows,
        stretches: &[Range<usize>],
        places: &[f32],
        middle: usize,
        blur: usize,
    ) {
        let weights = gaussian(ALONG_PINGS);
        self.picture.reset(places.len(), 2 * middle + 1, 0.0);
        for stretch in stretches {
            extract(rows, stretch, &places[stretch.clone()], middle, &mut self.band);
            smooth_along(&self.band, &weights, &mut self.averaged);
            for (index, row) in stretch.clone().enumerate() {
                blur_row(self.averaged.row(index), blur, self.picture.row_mut(row));
            }
        }
    }

    fn median(&self, of: impl Fn(&EdgeLevels) -> f32) -> f32 {
        let mut values: Vec<f32> = self.levels.iter().map(of).collect();
        upper_median(&mut values, f32::total_cmp).unwrap_or(0.0)
    }
}

impl EdgeLevels {
    fn of(picture: &[f32], water: &Range<usize>, bottom: &Range<usize>) -> Self {
        let mean = |values: &[f32]| values.iter().sum::<f32>() / values.len().max(1) as f32;
        let before = &picture[water.clone()];
        let quiet = mean(before);
        let squares = before.iter().map(|value| (value - quiet).powi(2));
        Self {
            water: quiet,
            deviation: (squares.sum::<f32>() / before.len().max(1) as f32).sqrt(),
            bottom: mean(&picture[bottom.clone()]),
        }
    }
}

/// Writes the mean over the cells up to `reach` to both sides of each cell; at the ends, over the
/// cells that exist.
fn blur_row(values: &[f32], reach: usize, out: &mut [f32]) {
    for (at, out) in out.iter_mut().enumerate() {
        let near = &values[at.saturating_sub(reach)..values.len().min(at + reach + 1)];
        *out = near.iter().sum::<f32>() / near.len() as f32;
    }
}

/// Returns the place, interpolated, at which the values fall below a level for the first time, seen
/// from the end; `None` where they never fall below it.
fn rises_above(level: f32, values: &[f32]) -> Option<f32> {
    let below = values.iter().rposition(|&value| value < level)?;
    let high = *values.get(below + 1)?;
    let low = values[below];
    Some(below as f32 + (level - low) / (high - low).max(f32::MIN_POSITIVE))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn onset_is_where_the_unbroken_echo_begins() {
        let values = [0.0, 40.0, 0.0, 10.0, 30.0, 25.0, 90.0, 80.0];
        assert_eq!(rises_above(20.0, &values), Some(3.5));
        assert_eq!(rises_above(35.0, &values), Some(5.0 + 10.0 / 65.0));
        assert_eq!(rises_above(85.0, &values), None);
        assert_eq!(rises_above(20.0, &values[4..]), None);
    }
}
