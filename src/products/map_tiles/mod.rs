//! Draws a depth map as the square pictures that web maps and plotters show: Web Mercator, 256
//! pixels a side, each zoom twice as fine as the one before.
//!
//! In: a depth map, or the parts of one. Out: the pictures of the tiles of each zoom.
//!
//! ```text
//! depths of a run or an archive --TileSource--> finest pixels --pyramid--> coarser ones --> pictures: colours, chart, depths
//! ```
//!
//! `web_tile` defines the places of tiles, `pixels` computes the places of their pixels in the
//! plane of a map, holds the depth and the light there and colours them, `chart` draws isobaths
//! with their depths over the colours; `pyramid` goes from the finest zoom to the coarsest,
//! so that only a few tiles are in memory. A source may keep parts of its map, so that unchanged
//! parts are not drawn again.

mod chart;
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
