//! Part of a tile that one log shows, in numbers that can be stored and joined with those of other
//! logs at any later time.

use super::layout::TILE_CELLS;
use super::overlap::CellSum;
use super::paint::{MosaicTile, painted_log};
use super::{MosaicLog, MosaicSettings, Overlap, TileIndex};
use crate::bathymetry::Grid;

/// Part of a tile that one log shows.
#[derive(Clone, Debug, PartialEq)]
pub struct MosaicPart {
    /// Rows of [`TILE_CELLS`] levels: 0 where nothing was seen, else 1 to 255.
    pub levels: Vec<u8>,
    /// Weight of each level where it is joined with those of other logs, 0 where nothing was seen;
    /// empty where `mosaic.overlap` uses no weights.
    pub weights: Vec<f32>,
}

impl MosaicPart {
    /// Returns true if no cell was seen.
    pub fn is_empty(&self) -> bool {
        self.levels.iter().all(|&level| level == 0)
    }

    /// The same with all levels times a factor.
    #[must_use]
    pub fn brightened(mut self, factor: f32) -> Self {
        for level in self.levels.iter_mut().filter(|level| **level > 0) {
            *level = (f32::from(*level) * factor).round().clamp(1.0, 255.0) as u8;
        }
        self
    }
}

/// Draws what a log shows of the tile of a row and column of tiles.
pub fn part(
    log: &MosaicLog,
    index: &TileIndex,
    grid: &Grid,
    settings: &MosaicSettings,
    place: [usize; 2],
) -> MosaicPart {
    let canvas = painted_log(log, index, grid, settings, place);
    let sums = canvas.sums();
    let weights = if settings.overlap.is_weighted() {
        sums.iter().map(|sum| stepped(sum.weight())).collect()
    } else {
        Vec::new()
    };
    MosaicPart { levels: sums.iter().map(CellSum::level).collect(), weights }
}

/// A weight in whole steps. Levels times such weights add up exactly in 32 bits, those of 256 logs
/// in any order, and such weights pack to a third of the size.
fn stepped(weight: f32) -> f32 {
    const STEPS: f32 = 256.0;
    (weight * STEPS).round() / STEPS
}

/// A tile of several logs from the part of each, one after the other by the rule of
/// `mosaic.overlap`: one of a single log is as [`super::tile`] draws it.
///
/// # Errors
/// Those of the parts.
pub fn join_parts<E>(
    parts: impl Iterator<Item = Result<MosaicPart, E>>,
    overlap: Overlap,
) -> Result<MosaicTile, E> {
    let mut sums = vec![CellSum::default(); TILE_CELLS * TILE_CELLS];
    for part in parts {
        let MosaicPart { levels, weights } = part?;
        let weights = weights.into_iter().chain(std::iter::repeat(1.0));
        for ((sum, level), weight) in sums.iter_mut().zip(levels).zip(weights) {
            if level > 0 {
                overlap.join(sum, CellSum::of(f32::from(level), weight));
            }
        }
    }
    Ok(MosaicTile { levels: sums.iter().map(CellSum::level).collect() })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::convert::Infallible;

    fn part_of(cells: &[(u8, f32)], is_weighted: bool) -> MosaicPart {
        let mut levels: Vec<u8> = cells.iter().map(|cell| cell.0).collect();
        levels.resize(TILE_CELLS * TILE_CELLS, 0);
        let mut weights: Vec<f32> = cells.iter().map(|cell| stepped(cell.1)).collect();
        weights.resize(TILE_CELLS * TILE_CELLS, 0.0);
        MosaicPart { levels, weights: if is_weighted { weights } else { Vec::new() } }
    }

    fn joined(overlap: Overlap, parts: &[&[(u8, f32)]]) -> Vec<u8> {
        let parts = parts.iter();
        let parts = parts.map(|cells| Ok::<_, Infallible>(part_of(cells, overlap.is_weighted())));
        let Ok(tile) = join_parts(parts, overlap);
        tile.levels[..3].to_vec()
    }

    #[test]
    fn parts_are_joined_by_the_rule_of_the_mosaic() {
        // The first log saw the first and the second cell, the second log the second and the third.
        let one: &[(u8, f32)] = &[(10, 0.5), (200, 0.9), (0, 0.0)];
        let other: &[(u8, f32)] = &[(0, 0.0), (100, 0.3), (7, 0.03)];
        assert_eq!(joined(Overlap::Later, &[one, other]), [10, 100, 7]);
        assert_eq!(joined(Overlap::Later, &[other, one]), [10, 200, 7]);
        for order in [[one, other], [other, one]] {
            assert_eq!(joined(Overlap::Brighter, &order), [10, 200, 7]);
            assert_eq!(joined(Overlap::Middle, &order), [10, 200, 7]);
            assert_eq!(joined(Overlap::Blend, &order), [10, 175, 7]);
        }
    }

    #[test]
    fn a_mean_of_many_parts_does_not_hang_on_their_order() {
        let logs: Vec<[(u8, f32); 3]> = (0..40_u8)
            .map(|log| {
                let level = |step: u8| 1 + log.wrapping_mul(step) % 255;
                let weight = f32::from(log + 1) / 41.0;
                [(level(7), weight), (level(31), 1.0 - weight), (level(3), 0.03)]
            })
            .collect();
        let forward: Vec<&[(u8, f32)]> = logs.iter().map(|log| &log[..]).collect();
        let backward: Vec<&[(u8, f32)]> = logs.iter().rev().map(|log| &log[..]).collect();
        assert_eq!(joined(Overlap::Blend, &forward), joined(Overlap::Blend, &backward));
    }
}
