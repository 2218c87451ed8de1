//! A depth map as the square pictures that web maps and plotters show: Web Mercator, 256 pixels a
//! side, each zoom twice as fine as the one before.
//!
//! In: a depth map, or the parts of one. Out: the pictures of the tiles of each zoom.
//!
//! ```text
//! depths of a run or an archive --TileSource--> finest pixels --pyramid--> coarser ones --> pictures: colours, chart, depths
//! ```
//!
//! `web_tile` says where tiles lie, `pixels` where their pixels do in the plane of a map and what
//! is known there, holds that and colours it, `chart` draws isobaths over it, their depths by
//! `label`; `pyramid` walks from the finest zoom to the coarsest, so that no more than a few tiles
//! are in memory. A source may keep parts of its map, so that what did not change is not drawn
//! again.

mod chart;
mod label;
mod pixels;
mod pyramid;
mod web_tile;

#[cfg(test)]
pub(crate) use pixels::Pixel;
pub use pixels::Pixels;
pub(crate) use pixels::{LitSurface, PixelPlaces};
pub use pyramid::{KnownTile, MapPart, MapScales, PyramidSource, TileStyle, pyramid};
#[cfg(test)]
pub(crate) use web_tile::web_pixel;
pub(crate) use web_tile::{TILE_PIXELS, web_line};
pub use web_tile::{WebTile, ZoomRange};
