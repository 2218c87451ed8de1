//! A depth map as the square pictures that web maps and plotters show: Web Mercator, 256 pixels a
//! side, each zoom twice as fine as the one before.
//!
//! In: a depth map, or the parts of one. Out: the pictures of the tiles of each zoom.
//!
//! ```text
//! depths of a run or an archive --TileSource--> finest pixels --pyramid--> coarser ones --> pictures: colours, chart, depths
//! ```
//!
//! `web_tile` says where tiles lie, `pixel_places` where their pixels do in the plane of a map,
//! `lit_surface` what is known at a place, `pixels` holds what is known of a tile and colours it,
//! `chart` draws isobaths over that, their depths by `label` and both by `stroke`; `pyramid` walks
//! from the finest zoom to the coarsest, so that no more than a few tiles are in memory. A source
//! may keep parts of its map, so that what did not change is not drawn again.

mod chart;
mod label;
mod lit_surface;
mod pixel_places;
mod pixels;
mod pyramid;
mod stroke;
mod web_tile;

pub(crate) use lit_surface::LitSurface;
pub(crate) use pixel_places::PixelPlaces;
pub(crate) use pixels::Pixel;
pub use pixels::Pixels;
pub use pyramid::{KnownTile, MapPart, MapScales, PyramidSource, TileStyle, pyramid};
#[cfg(test)]
pub(crate) use web_tile::web_pixel;
pub(crate) use web_tile::{TILE_PIXELS, web_line};
pub use web_tile::{WebTile, ZoomRange};
