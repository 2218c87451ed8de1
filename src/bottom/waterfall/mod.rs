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
mod levels;
mod line;
mod resample;
#[cfg(test)]
mod testing;
mod worker;

pub use axis::RangeAxis;
pub use levels::Levels;
pub(crate) use levels::{MOST_SAMPLED_PINGS, beyond_pulse};
pub use line::{LineSpan, LineStep, PickLines, RangeLine};
pub use worker::{Made, Tiler};

use bathyscope_log::survey::Side;
use std::collections::HashMap;
use std::hash::Hash;

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

/// Cache of the values that were used most recently, up to a number of bytes; values used in the
/// current frame are never dropped.
pub struct Lru<K, V> {
    entries: HashMap<K, CacheEntry<V>>,
    bytes: usize,
    budget: usize,
    frame: u64,
}

struct CacheEntry<V> {
    value: V,
    bytes: usize,
    used: u64,
}

impl<K: Copy + Eq + Hash, V> Lru<K, V> {
    /// Creates an empty cache of at most `budget` bytes.
    pub fn new(budget: usize) -> Self {
        Self { entries: HashMap::new(), bytes: 0, budget, frame: 0 }
    }

    /// Begins a frame: drops the least recently used values until the cache is within its budget.
    pub fn begin_frame(&mut self) {
        if self.bytes > self.budget {
            let mut by_age: Vec<(u64, K)> = self
                .entries
                .iter()
                .map(|(key, entry)| (entry.used, *key))
                .filter(|(used, _)| *used < self.frame)
                .collect();
            by_age.sort_unstable_by_key(|(used, _)| *used);
            for (_, key) in by_age {
                if self.bytes <= self.budget {
                    break;
                }
                if let Some(entry) = self.entries.remove(&key) {
                    self.bytes -= entry.bytes;
                }
            }
        }
        self.frame += 1;
    }

    /// Adds or replaces a value of a size of `bytes` bytes.
    pub fn insert(&mut self, key: K, value: V, bytes: usize) {
        let entry = CacheEntry { value, bytes, used: self.frame };
        if let Some(old) = self.entries.insert(key, entry) {
            self.bytes -= old.bytes;
        }
        self.bytes += bytes;
    }

    /// Returns a value, and marks it as used in this frame.
    pub fn use_now(&mut self, key: &K) -> Option<&mut V> {
        let entry = self.entries.get_mut(key)?;
        entry.used = self.frame;
        Some(&mut entry.value)
    }

    /// Calls a function with every key and value, to change values in place.
    pub fn change(&mut self, mut change: impl FnMut(&K, &mut V)) {
        for (key, entry) in &mut self.entries {
            change(key, &mut entry.value);
        }
    }

    /// Returns a value without marking it as used.
    pub fn peek(&self, key: &K) -> Option<&V> {
        self.entries.get(key).map(|entry| &entry.value)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn key(column: u32) -> WaterfallTileKey {
        WaterfallTileKey::at_boat(Side::Port, [0, 0], column)
    }

    #[test]
    fn drops_the_least_recently_used_beyond_the_budget() {
        let mut cache = Lru::new(30);
        for column in 0..3 {
            cache.begin_frame();
            cache.insert(key(column), column, 10);
        }
        cache.begin_frame();
        cache.use_now(&key(0));
        cache.insert(key(3), 3, 10);
        cache.begin_frame();
        let kept: Vec<u32> = (0..4).filter_map(|n| cache.peek(&key(n)).copied()).collect();
        assert_eq!(kept, [0, 2, 3]);
        assert_eq!(cache.bytes, 30);
    }

    #[test]
    fn keeps_what_the_last_frame_used_even_over_budget() {
        let mut cache = Lru::new(10);
        cache.begin_frame();
        for column in 0..5 {
            cache.insert(key(column), column, 10);
        }
        cache.begin_frame();
        assert_eq!((0..5).filter(|n| cache.peek(&key(*n)).is_some()).count(), 5);
        cache.begin_frame();
        assert_eq!(cache.bytes, 10);
    }
}
