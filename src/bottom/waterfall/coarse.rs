//! Builds the store that the coarse levels are reduced from: the whole survey at 16 pings x 8 bins
//! a texel, or a little coarser.

use super::resample::resample;
use super::{Level, RangeAxis, TILE, WaterfallTile, WaterfallTileKey};
use bathyscope_log::survey::{Side, Survey};

/// Store in chunks of `TILE` rows, each of one side and `TILE * 16` pings over the whole range
/// axis.
pub(super) struct Coarse {
    level: Level,
    width: usize,
    /// Chunks of port and starboard of each stretch that is built so far.
    chunks: Vec<[Vec<[u8; 2]>; 2]>,
    chunk_count: usize,
}

impl Coarse {
    /// Creates an empty store.
    pub(super) fn new(axis: &RangeAxis) -> Self {
        let level = axis.store;
        Self {
            level,
            width: (axis.bins as usize).div_ceil(level.bins()),
            chunks: Vec::new(),
            chunk_count: axis.pings.div_ceil(TILE * level.pings()),
        }
    }

    /// Adapts the store to a longer log: stretches that reach beyond the unchanged pings will be
    /// built again.
    pub(super) fn grow(&mut self, axis: &RangeAxis, unchanged: usize) {
        let stretch = TILE * self.level.pings();
        self.chunks.truncate(unchanged / stretch);
        self.chunk_count = axis.pings.div_ceil(stretch);
    }

    /// Returns true if the whole store is built.
    pub(super) fn is_complete(&self) -> bool {
        self.chunks.len() == self.chunk_count
    }

    /// Returns the share of the store that is built, 0 to [`WaterfallTile::COMPLETE`].
    pub(super) fn completeness(&self) -> u8 {
        let whole = self.chunk_count.max(1);
        (self.chunks.len() * usize::from(WaterfallTile::COMPLETE) / whole) as u8
    }

    /// Builds the first stretch that is missing, if any.
    pub(super) fn build_next(&mut self, survey: &Survey, axis: &RangeAxis) {
        if self.is_complete() {
            return;
        }
        let first = self.chunks.len() * TILE * self.level.pings();
        let pings = first..(first + TILE * self.level.pings()).min(axis.pings);
        self.chunks
            .push(Side::BOTH.map(|side| {
                resample(survey, axis, side, self.level, pings.clone(), 0, self.width)
            }));
    }

    /// Returns a tile of the level of the store or a coarser one, from the stretches that are
    /// built; its completeness is the share of the store that existed.
    pub(super) fn tile(&self, axis: &RangeAxis, key: WaterfallTileKey) -> WaterfallTile {
        let (width, height) = size(axis, key);
        let step = Level {
            along: key.level.along - self.level.along,
            across: key.level.across - self.level.across,
        };
        let first_row = key.first_ping() / self.level.pings();
        let first_column = key.first_bin() / self.level.bins();
        let mut texels = Vec::with_capacity(width * height);
        let mut sums = vec![Mean::default(); width];
        for row in 0..height {
            sums.fill(Mean::default());
            let from = first_row + row * step.pings();
            for stored in from..from + step.pings() {
                let stored = self.row(key.side, stored);
                let stored = stored.get(first_column..).unwrap_or_default();
                for (sum, texels) in sums.iter_mut().zip(stored.chunks(step.bins())) {
                    texels.iter().for_each(|&texel| sum.add(texel));
                }
            }
            texels.extend(sums.iter().map(Mean::texel));
        }
        WaterfallTile { key, width, height, texels, completeness: self.completeness() }
    }

    /// Returns a row of the store; empty beyond the survey and where it is not built.
    fn row(&self, side: Side, row: usize) -> &[[u8; 2]] {
        let chunk = self.chunks.get(row / TILE);
        let texels = chunk.map_or(&[][..], |sides| &sides[side as usize]);
        let start = row % TILE * self.width;
        texels.get(start..start + self.width).unwrap_or_default()
    }
}

/// Returns the size of the part of a tile that the survey fills, texels: width over range, height
/// over pings.
pub(super) fn size(axis: &RangeAxis, key: WaterfallTileKey) -> (usize, usize) {
    let left = |extent: usize, first: usize, step: usize| {
        extent.saturating_sub(first).div_ceil(step).min(TILE)
    };
    (
        left(axis.bins as usize, key.first_bin(), key.level.bins()),
        left(axis.pings, key.first_ping(), key.level.pings()),
    )
}

/// Mean of means and maximum of maxima over the texels that have data.
#[derive(Clone, Copy, Default)]
struct Mean {
    total: u32,
    count: u32,
    max: u8,
}

impl Mean {
    fn add(&mut self, [mean, max]: [u8; 2]) {
        self.total += u32::from(mean);
        self.count += u32::from(max > 0);
        self.max = self.max.max(max);
    }

    fn texel(&self) -> [u8; 2] {
        let mean = (self.total + self.count / 2).checked_div(self.count);
        [mean.unwrap_or(0) as u8, self.max]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::waterfall::testing::even;

    fn complete(survey: &Survey) -> (RangeAxis, Coarse) {
        let axis = RangeAxis::of(survey).expect("an axis");
        let mut coarse = Coarse::new(&axis);
        while !coarse.is_complete() {
            coarse.build_next(survey, &axis);
        }
        (axis, coarse)
    }

    #[test]
    fn tiles_from_the_store_equal_those_from_the_samples() {
        // A little more than two chunks of the store, with full texels, so that a mean of means is
        // the mean.
        let survey = even(18_000, 200);
        let (axis, coarse) = complete(&survey);
        for (along, across) in [(4, 3), (5, 3), (6, 5)] {
            let level = Level { along, across };
            for column in 0..2 {
                let key = WaterfallTileKey::at_boat(Side::Starboard, [along, across], column);
                let stored = coarse.tile(&axis, key);
                let pings = key.first_ping().min(axis.pings)
                    ..(key.first_ping() + stored.height * level.pings()).min(axis.pings);
                let direct = resample(&survey, &axis, key.side, level, pings, 0, stored.width);
                assert_eq!(stored.texels.len(), direct.len());
                for (stored, direct) in stored.texels.iter().zip(&direct) {
                    assert_eq!(stored[1], direct[1], "maxima are exact");
                    assert!(stored[0].abs_diff(direct[0]) <= 1, "{stored:?} {direct:?}");
                }
            }
        }
    }

    #[test]
    fn the_store_is_small() {
        let (_, coarse) = complete(&even(5_000, 400));
        let bytes: usize = coarse.chunks.iter().flatten().map(|side| side.len() * 2).sum();
        assert!(bytes * 40 <= 5_000 * 800, "{bytes} bytes");
    }
}
