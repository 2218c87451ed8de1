//! Finds the echo just before the edge: of a stone, the side of a boulder or the crest of a bump.
//!
//! The edge is read from a profile averaged over many pings, in which a stone of two pings
//! disappears. The echo of the stone is weaker than that of the ground behind it, but it is the
//! first return. Each row is therefore read once more, with hardly any averaging, to find the place
//! where the unbroken echo before the edge rises out of the water.

use super::grid::{TrackerGrid, extract, gaussian, smooth_along};
use super::rows::SampleRows;
use bathyscope_log::support::statistics::upper_median;
use std::ops::Range;

/// Standard deviation of the averaging along the track, pings, and length of the averaging along
/// the range, metres.
const ALONG_PINGS: f32 = 0.6;
const BLUR_M: f64 = 0.04;
/// Distances before the edge between which the water is measured, and beyond the edge between which
/// the bottom is, metres.
const WATER_M: (f64, f64) = (0.45, 0.25);
const BOTTOM_M: (f64, f64) = (0.03, 0.12);
/// Rise above the water that is an onset, as a share of the usual contrast between bottom and
/// water.
const RISE: f32 = 0.18;
/// Least rise of an onset, in standard deviations of the water. A fainter rise cannot be
/// distinguished from noise, and the edge stays where it is.
const QUIET: f32 = 4.0;
/// Distance by which noise alone may make an onset earlier than usual, metres.
const NOISE_M: f64 = 0.003;

/// Buffers of the search for onsets in a chunk.
#[derive(Default)]
pub(super) struct Onsets {
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
    pub(super) fn advance(
        &mut self,
        rows: &SampleRows,
        stretches: &[Range<usize>],
        places: &mut [f32],
        cell_m: f64,
    ) {
        let cells =
            |metres: f64, least: usize| ((metres / cell_m).round() as usize).clamp(least, 255);
        let middle = cells(WATER_M.0, 8);
        let water = 0..middle - cells(WATER_M.1, 4).min(middle - 2);
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
