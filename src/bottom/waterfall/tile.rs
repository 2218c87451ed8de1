//! Tiles of the picture: their places and their texels.

use bathyscope_log::survey::Side;

/// Texels of a tile along each axis, at most.
pub const TILE: usize = 512;

/// Power-of-two reductions: a texel covers `2^along` pings and `2^across` bins.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Level {
    /// Halvings along the track.
    pub along: u8,
    /// Halvings of the range axis.
    pub across: u8,
}

impl Level {
    /// Pings in a texel.
    pub fn pings(self) -> usize {
        1 << self.along
    }

    /// Bins in a texel.
    pub fn bins(self) -> usize {
        1 << self.across
    }

    /// Returns true if a tile of this level is quick to make from the samples: 64 million of them
    /// at most, 0.1 s or so.
    pub fn is_near(self) -> bool {
        self.along + self.across <= 8
    }

    /// Returns true if the other level can be reduced from this one.
    pub(crate) fn is_finer_or_equal(self, other: Level) -> bool {
        self.along <= other.along && self.across <= other.across
    }
}

/// A tile's place in the pyramid.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct WaterfallTileKey {
    /// Side of the boat.
    pub side: Side,
    /// Its reduction.
    pub level: Level,
    /// Index of its stretch of `TILE * level.pings()` pings.
    pub column: u32,
    /// Index of its stretch of `TILE * level.bins()` bins, 0 at the boat.
    pub row: u32,
}

impl WaterfallTileKey {
    /// Creates the key of a tile in the row next to the boat, at a level along and across.
    #[cfg(test)]
    pub fn at_boat(side: Side, [along, across]: [u8; 2], column: u32) -> Self {
        Self { side, level: Level { along, across }, column, row: 0 }
    }

    /// First ping of the tile.
    pub fn first_ping(&self) -> usize {
        self.column as usize * TILE * self.level.pings()
    }

    /// One past the last ping that the tile can hold.
    pub fn end_ping(&self) -> usize {
        self.first_ping() + TILE * self.level.pings()
    }

    /// First bin of the tile.
    pub fn first_bin(&self) -> usize {
        self.row as usize * TILE * self.level.bins()
    }
}

/// A tile that a view would like to draw.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Want {
    /// Place of the tile.
    pub key: WaterfallTileKey,
    /// Completeness of the tile that the view has ([`WaterfallTile::completeness`]); `None` when it
    /// has none.
    pub have: Option<u8>,
}

/// Echo strength over ping and range, two bytes a texel: mean and maximum.
///
/// 0 means that nothing was recorded there; a recorded 0 is stored as 1. The rows are pings, and
/// within a row the texels go outward from the boat.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct WaterfallTile {
    /// Its place.
    pub key: WaterfallTileKey,
    /// Texels in a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// `[mean, max]` of each texel, row by row.
    pub texels: Vec<[u8; 2]>,
    /// 0 to [`WaterfallTile::COMPLETE`]: how much of the store that it was reduced from existed.
    pub completeness: u8,
}

impl WaterfallTile {
    /// [`WaterfallTile::completeness`] of a tile that will not change any more.
    pub const COMPLETE: u8 = 16;

    /// Bytes of its texels.
    pub fn byte_count(&self) -> usize {
        self.texels.len() * 2
    }
}
