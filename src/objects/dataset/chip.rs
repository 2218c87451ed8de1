//! A tile with the boxes in it.

use super::KnownObject;
use crate::{Labelled, Raster, RasterTile, TILE_PX, level};
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder as _};

/// A levelled tile with its boxes.
#[derive(Clone, Debug, PartialEq)]
pub struct Chip {
    /// [`TILE_PX`] rows of [`TILE_PX`] grey levels.
    pub pixels: Vec<u8>,
    /// Boxes of the objects in it.
    pub boxes: PictureBoxes,
}

/// The boxes of a picture, in its pixels.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PictureBoxes {
    /// Boxes (echo and shadow) that a detector should find.
    pub labels: Vec<Labelled>,
    /// The outline of each label as a polygon of columns and rows; empty where only its box is
    /// known.
    pub outlines: Vec<Vec<[f32; 2]>>,
    /// Boxes that it may find or not: cut off by the tile's edge, or too small or faint to be seen.
    pub ignored: Vec<Labelled>,
}

impl Chip {
    /// Labels a tile, then levels it. An object whose part in the tile can be asked for
    /// ([`super::part::ObjectPart::is_plain`]) has a label; others that reach into the tile have an
    /// ignored box.
    pub fn new(mut tile: RasterTile, raster: &Raster, known: &[KnownObject]) -> Self {
        let mut boxes = PictureBoxes::default();
        for object in known.iter().filter(|object| object.whole.side == tile.side) {
            let Some(part) = object.part_in(&tile, raster) else {
                continue;
            };
            let label = Labelled { class: object.class, rect: part.rect };
            if part.is_plain() {
                boxes.labels.push(label);
                boxes.outlines.push(part.outline);
            } else {
                boxes.ignored.push(label);
            }
        }
        level(&mut tile.pixels);
        Self { pixels: tile.pixels, boxes }
    }

    /// The picture as PNG: 8-bit grey, compressed fast. Each row is written as its difference from
    /// the one before, since one ping is much like the last: with the rows as they are, speckle
    /// hardly shrinks.
    pub fn png(&self) -> Vec<u8> {
        let mut bytes = Vec::new();
        let encoder =
            PngEncoder::new_with_quality(&mut bytes, CompressionType::Fast, FilterType::Up);
        let side = TILE_PX as u32;
        // Writing to memory does not fail, and the pixels fit the size.
        encoder.write_image(&self.pixels, side, side, ExtendedColorType::L8).ok();
        bytes
    }
}
