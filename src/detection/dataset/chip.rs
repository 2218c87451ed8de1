//! A tile with the boxes in it.

use super::visible::{Contrast, Smoothed};
use crate::detection::{Labelled, Mark, Raster, Rect, TILE_PX, Tile, level};
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder as _};

/// An object whose place is known.
#[derive(Clone, Debug, PartialEq)]
pub struct Known {
    /// Index into the class names.
    pub class: usize,
    /// Around its echo.
    pub echo: Mark,
    /// Around what is shown of its echo and its shadow.
    pub whole: Mark,
    /// Whether anything is shown of it. What a person has seen is.
    pub shown: bool,
}

/// A levelled tile with its boxes.
#[derive(Clone, Debug, PartialEq)]
pub struct Chip {
    /// [`TILE_PX`] rows of [`TILE_PX`] grey levels.
    pub pixels: Vec<u8>,
    /// What is in it.
    pub boxes: Boxes,
}

/// The boxes of a picture, in its pixels.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Boxes {
    /// Boxes (echo and shadow) that a detector should find.
    pub labels: Vec<Labelled>,
    /// Boxes that it may find or not: cut off by the tile's edge, or too small or faint to be seen.
    pub ignored: Vec<Labelled>,
}

/// Least share of a box that lies in the tile.
const LEAST_SHARE: f32 = 0.4;
/// Least width and height of a box, pixels.
const LEAST_PX: f32 = 6.0;

impl Chip {
    /// Labels a tile, then levels it. A box is a label when at least 40 % of its area lies in the tile, what lies there is
    /// at least 6 pixels wide and high, something of the object is shown, and its echo or its shadow stands out ([`Contrast::is_seen`]); other boxes that
    /// reach into the tile are ignored ones.
    pub fn new(mut tile: Tile, raster: &Raster, known: &[Known]) -> Self {
        let smoothed = Smoothed::new(&tile.pixels);
        let mut boxes = Boxes::default();
        for object in known.iter().filter(|object| object.whole.side == tile.side) {
            let place = |mark: &Mark| {
                let rect = raster.rect_of(mark);
                rect.shifted(-(tile.column as f32), -(tile.row as f32))
            };
            let (echo, whole) = (place(&object.echo), place(&object.whole));
            let inside = whole.intersection(&FRAME);
            if inside.area() <= 0.0 {
                continue;
            }
            let label = Labelled {
                class: object.class,
                rect: inside,
            };
            let large = (inside.x1 - inside.x0).min(inside.y1 - inside.y0) >= LEAST_PX;
            let whole_enough = inside.area() >= LEAST_SHARE * whole.area();
            let seen = || Contrast::of(&smoothed, &echo, &whole).is_seen();
            if object.shown && large && whole_enough && seen() {
                boxes.labels.push(label);
            } else {
                boxes.ignored.push(label);
            }
        }
        level(&mut tile.pixels);
        Self {
            pixels: tile.pixels,
            boxes,
        }
    }

    /// The picture as PNG: 8-bit grey, compressed fast. Each row is written as its difference from the one before, since one
    /// ping is much like the last: with the rows as they are, speckle hardly shrinks.
    pub fn png(&self) -> Vec<u8> {
        let mut bytes = Vec::new();
        let encoder =
            PngEncoder::new_with_quality(&mut bytes, CompressionType::Fast, FilterType::Up);
        let side = TILE_PX as u32;
        // Writing to memory does not fail, and the pixels fit the size.
        encoder
            .write_image(&self.pixels, side, side, ExtendedColorType::L8)
            .ok();
        bytes
    }
}

/// The tile.
pub const FRAME: Rect = Rect {
    x0: 0.0,
    y0: 0.0,
    x1: TILE_PX as f32,
    y1: TILE_PX as f32,
};
