//! Draws picture tiles of the side-scan: a pyramid of means and maxima over ping and range, built
//! where it is viewed.
//!
//! In: a survey with its first returns. Out: a range axis, picture tiles, and lines over them.
//!
//! A picture is laid out over ping (across the rows of a tile) and slant range (along a row), each
//! side separately, near to far. Its range axis has one scale for the whole survey ([`RangeAxis`]),
//! so that every ping is placed by its metres even where the recorder's range changed within a log.
//! Tiles of at most [`TILE`] x [`TILE`] texels exist at every pair of power-of-two reductions along
//! the track and across it. Fine tiles are resampled from the mapped file when they become visible;
//! coarse tiles come from a store of 16 pings x 8 bins or more a texel, which a worker thread
//! builds once.

mod axis;
mod cache;
mod coarse;
mod levels;
mod line;
mod resample;
#[cfg(test)]
mod testing;
mod tile;
mod worker;

pub use axis::RangeAxis;
pub use cache::Lru;
pub use levels::Levels;
pub(crate) use levels::{MOST_SAMPLED_PINGS, beyond_pulse};
pub use line::{LineSpan, LineStep, PickLines, RangeLine};
pub use tile::{Level, TILE, Want, WaterfallTile, WaterfallTileKey};
pub use worker::{Made, Tiler};
