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
/// Least contrast that is seen.
const LEAST_CONTRAST: f32 = 1.0;

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

/// How an object stands out, in standard deviations of the averaged ground beside it along the track at the same ranges.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contrast {
    /// By how much the brightest twentieth of the echo's box outdoes that of the ground: a thin object across a box fills
    /// little of it.
    pub echo: f32,
    /// By how much the darkest twentieth of what lies behind is darker than that of the ground; 0 without a shadow.
    pub shadow: f32,
}

impl Contrast {
    /// Compares the echo, and what the whole box holds behind it, with the ground before and after the box.
    pub fn of(picture: &Smoothed, echo: &Rect, whole: &Rect) -> Self {
        let behind = Rect {
            x0: echo.x1,
            ..*whole
        };
        let brighter = Comparison::new(picture, echo, whole);
        let darker = Comparison::new(picture, &behind, whole);
        Self {
            echo: brighter.map_or(0.0, |pair| pair.rise(0.95)),
            shadow: darker.map_or(0.0, |pair| -pair.rise(0.05)),
        }
    }

    /// Whether an eye finds it: echo or shadow stand out by a standard deviation.
    pub fn is_seen(&self) -> bool {
        self.echo.max(self.shadow) >= LEAST_CONTRAST
    }
}

/// Sorted levels of a place, and of the ground beside it.
struct Comparison {
    here: Vec<f32>,
    beside: Vec<f32>,
}

impl Comparison {
    /// `None` where either has too few pixels in the tile.
    fn new(picture: &Smoothed, place: &Rect, whole: &Rect) -> Option<Self> {
        let height = (whole.y1 - whole.y0).max(BESIDE_PX);
        let before = Rect {
            y0: whole.y0 - GAP_PX - height,
            y1: whole.y0 - GAP_PX,
            ..*place
        };
        let after = Rect {
            y0: whole.y1 + GAP_PX,
            y1: whole.y1 + GAP_PX + height,
            ..*place
        };
        let mut here = picture.of(place);
        let mut beside = [picture.of(&before), picture.of(&after)].concat();
        if here.len() < FEWEST || beside.len() < FEWEST {
            return None;
        }
        here.sort_by(f32::total_cmp);
        beside.sort_by(f32::total_cmp);
        Some(Self { here, beside })
    }

    /// By how much a quantile of the place exceeds that of the ground, in the ground's standard deviations.
    fn rise(&self, share: f64) -> f32 {
        let quantile = |sorted: &[f32]| sorted[(share * (sorted.len() - 1) as f64) as usize];
        let count = self.beside.len() as f32;
        let mean = self.beside.iter().sum::<f32>() / count;
        let squares = self.beside.iter().map(|level| (level - mean).powi(2));
        // Half a grey level at least: silence has no spread of its own.
        let spread = (squares.sum::<f32>() / count).sqrt().max(0.5);
        (quantile(&self.here) - quantile(&self.beside)) / spread
    }
}
