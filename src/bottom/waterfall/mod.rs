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
mod levels;
mod line;
mod resample;
#[cfg(test)]
mod testing;
mod worker;

pub use axis::RangeAxis;
pub use cache::Lru;
pub use levels::Levels;
pub(crate) use levels::{MOST_SAMPLED_PINGS, beyond_pulse};
pub use line::{LineSpan, LineStep, PickLines, RangeLine};
pub use worker::{Made, Tiler};

use bathyscope_log::survey::Side;

/// Largest number of texels of a tile along each axis.
pub const TILE: usize = 512;

/// Level of detail as power-of-two reductions: a texel covers `2^along` pings and `2^across` bins.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Level {
    /// Number of halvings along the track.
    pub along: u8,
    /// Number of halvings of the range axis.
    pub across: u8,
}

impl Level {
    /// Returns the number of pings in a texel.
    pub fn pings(self) -> usize {
        1 << self.along
    }

    /// Returns the number of bins in a texel.
    pub fn bins(self) -> usize {
        1 << self.across
    }

    /// Returns true if a tile of this level is quick to make from the samples: from at most 64
    /// million of them, in about 0.1 s.
    pub fn is_near(self) -> bool {
        self.along + self.across <= 8
    }

    /// Returns true if the other level can be reduced from this one.
    pub(crate) fn is_finer_or_equal(self, other: Level) -> bool {
        self.along <= other.along && self.across <= other.across
    }
}

/// Place of a tile in the pyramid.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct WaterfallTileKey {
    /// Side of the boat.
    pub side: Side,
    /// Reduction of the tile.
    pub level: Level,
    /// Index of the tile along the track, in stretches of `TILE * level.pings()` pings.
    pub column: u32,
    /// Index of the tile across the track, in stretches of `TILE * level.bins()` bins, 0 at the
    /// boat.
    pub row: u32,
}

impl WaterfallTileKey {
    /// Creates the key of a tile in the row next to the boat, at a level along and across.
    #[cfg(test)]
    pub fn at_boat(side: Side, [along, across]: [u8; 2], column: u32) -> Self {
        Self { side, level: Level { along, across }, column, row: 0 }
    }

    /// Returns the first ping of the tile.
    pub fn first_ping(&self) -> usize {
        self.column as usize * TILE * self.level.pings()
    }

    /// Returns the ping after the last one that the tile can hold.
    pub fn end_ping(&self) -> usize {
        self.first_ping() + TILE * self.level.pings()
    }

    /// Returns the first bin of the tile.
    pub fn first_bin(&self) -> usize {
        self.row as usize * TILE * self.level.bins()
    }
}

/// Tile that a view requests.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Want {
    /// Place of the tile.
    pub key: WaterfallTileKey,
    /// Completeness of the tile that the view already has ([`WaterfallTile::completeness`]); `None`
    /// when it has none.
    pub have: Option<u8>,
}

/// Tile of echo strength over ping and range, two bytes a texel: mean and maximum.
///
/// A texel of 0 means that nothing was recorded there; a recorded 0 is stored as 1. The rows are
/// pings, and within a row the texels go outward from the boat.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct WaterfallTile {
    /// Place of the tile.
    pub key: WaterfallTileKey,
    /// Number of texels in a row.
    pub width: usize,
    /// Number of rows.
    pub height: usize,
    /// `[mean, max]` of each texel, row by row.
    pub texels: Vec<[u8; 2]>,
    /// Completeness, 0 to [`WaterfallTile::COMPLETE`]: the share of the store that existed when the
    /// tile was reduced from it.
    pub completeness: u8,
}

impl WaterfallTile {
    /// Value of [`WaterfallTile::completeness`] for a tile that will not change any more.
    pub const COMPLETE: u8 = 16;

    /// Returns the size of the texels in bytes.
    pub fn byte_count(&self) -> usize {
        self.texels.len() * 2
    }
}
