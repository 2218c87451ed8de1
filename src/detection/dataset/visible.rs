//! Whether an object can be seen in a picture: its echo or its shadow must stand out from the ground beside it.

use crate::detection::{Rect, TILE_PX};
use std::ops::Range;

/// Half of the square that pixels are averaged over before they are compared: 5 x 5 pixels, so that speckle counts for
/// little.
const HALF_PX: usize = 2;
/// Gap between a box and the ground beside it that it is compared with, pixels.
const GAP_PX: f32 = 4.0;
/// Least height of that ground on either side along the track, pixels.
const BESIDE_PX: f32 = 25.0;
/// Fewest pixels that make a comparison.
const FEWEST: usize = 20;
/// Least share of a place, beyond a tenth, that is seen.
const LEAST_AREA: f32 = 0.15;

/// A tile averaged over small squares.
pub struct Smoothed(Vec<f32>);

impl Smoothed {
    /// Averages along rows, then along columns.
    pub fn new(pixels: &[u8]) -> Self {
        let levels: Vec<f32> = pixels.iter().map(|&pixel| f32::from(pixel)).collect();
        let along_rows = blur(&levels, 1, TILE_PX);
        Self(blur(&along_rows, TILE_PX, 1))
    }

    /// The pixels of a box, as far as it lies in the tile.
    fn of(&self, rect: &Rect) -> Vec<f32> {
        let span = |low: f32, high: f32| -> Range<usize> {
            let clamped = |value: f32| value.round().clamp(0.0, TILE_PX as f32) as usize;
            clamped(low)..clamped(high)
        };
        let columns = span(rect.x0, rect.x1);
        let rows = span(rect.y0, rect.y1).map(|row| row * TILE_PX);
        if columns.is_empty() {
            return Vec::new();
        }
        rows.flat_map(|row| &self.0[row + columns.start..row + columns.end])
            .copied()
            .collect()
    }
}

/// Running mean over `2 HALF_PX + 1` pixels in one direction: `step` to the next pixel, `line` to the next line.
fn blur(levels: &[f32], step: usize, line: usize) -> Vec<f32> {
    let mut out = vec![0.0; levels.len()];
    let width = (2 * HALF_PX + 1) as f32;
    for start in (0..TILE_PX).map(|index| index * line) {
        let at = |index: usize| levels[start + index.min(TILE_PX - 1) * step];
        let mut sum: f32 = (0..=HALF_PX).map(at).sum::<f32>() + HALF_PX as f32 * at(0);
        for index in 0..TILE_PX {
            out[start + index * step] = sum / width;
            sum += at(index + HALF_PX + 1) - at(index.saturating_sub(HALF_PX));
        }
    }
    out
}

/// How an object stands out from the averaged ground beside it along the track, at the same ranges.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contrast {
    /// Of its echo: brighter.
    pub echo: Standing,
    /// Of what lies behind the echo, its shadow: darker.
    pub shadow: Standing,
}

/// One part of an object against the ground beside it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Standing {
    /// By how much its strongest twentieth outdoes that of the ground, in the ground's standard deviations: a thin object
    /// across a box fills little of it.
    pub rise: f32,
    /// Which share of it lies beyond the ground's strongest tenth, less that tenth, over the share that chance alone
    /// reaches: a large shadow is seen on ground that is as dark in spots.
    pub area: f32,
}

impl Standing {
    /// Whether an eye finds it. Both bounds lie low: an object that is seen but not asked for teaches a detector to be
    /// blind, one that is asked for but hardly seen costs less.
    pub fn is_seen(&self) -> bool {
        self.rise >= 0.7 || self.area >= 0.6
    }
}

impl Contrast {
    /// Compares the echo, and what the whole box holds behind it, with the ground before and after the box.
    pub fn of(picture: &Smoothed, echo: &Rect, whole: &Rect) -> Self {
        let behind = Rect {
            x0: echo.x1,
            ..*whole
        };
        Self {
            echo: standing(picture, echo, whole, 1.0),
            shadow: standing(picture, &behind, whole, -1.0),
        }
    }

    /// Whether an eye finds its echo or its shadow.
    pub fn is_seen(&self) -> bool {
        self.echo.is_seen() || self.shadow.is_seen()
    }
}

/// Compares a place with the ground before and after the whole box; `sign` is 1 where the place should be brighter, -1
/// where it should be darker. None where either has too few pixels in the tile.
fn standing(picture: &Smoothed, place: &Rect, whole: &Rect, sign: f32) -> Standing {
    let height = (whole.y1 - whole.y0).max(BESIDE_PX);
    let ground = |y0: f32| {
        picture.of(&Rect {
            y0,
            y1: y0 + height,
            ..*place
        })
    };
    let mut here = picture.of(place);
    let mut beside = [
        ground(whole.y0 - GAP_PX - height),
        ground(whole.y1 + GAP_PX),
    ]
    .concat();
    if here.len() < FEWEST || beside.len() < FEWEST {
        return Standing::default();
    }
    let levels = |levels: &mut Vec<f32>| {
        levels.iter_mut().for_each(|level| *level *= sign);
        levels.sort_by(f32::total_cmp);
    };
    levels(&mut here);
    levels(&mut beside);
    let quantile =
        |sorted: &[f32], share: f64| sorted[(share * (sorted.len() - 1) as f64) as usize];
    let strong = quantile(&beside, 0.9);
    let beyond = here.len() - here.partition_point(|&level| level <= strong);
    let share = beyond as f32 / here.len() as f32;
    // The share of independent squares that exceed a tenth scatters by sqrt(0.1 0.9 / n); three times that is beyond chance.
    let squares = here.len() as f32 / ((2 * HALF_PX + 1) * (2 * HALF_PX + 1)) as f32;
    let chance = (0.9 / squares.sqrt()).max(LEAST_AREA);
    Standing {
        rise: (quantile(&here, 0.95) - quantile(&beside, 0.95)) / spread(&beside),
        area: (share - 0.1) / chance,
    }
}

/// Standard deviation; half a grey level at least, for silence has no spread of its own.
fn spread(levels: &[f32]) -> f32 {
    let count = levels.len() as f32;
    let mean = levels.iter().sum::<f32>() / count;
    let squares = levels.iter().map(|level| (level - mean).powi(2));
    (squares.sum::<f32>() / count).sqrt().max(0.5)
}
