//! Neighbours that the map of a tile depends on: only where depths come from echo levels.

use super::error::ArchiveError;
use super::tile::{TILE_M, TileId};
use crate::pipeline::Settings;
use bathyscope_bottom::bathymetry::SwathDepth;
use bathyscope_bottom::swath::{PART_DEPTHS_M, PART_STEP_M};

const _: () = assert!(TILE_M % PART_STEP_M == 0.0);
/// Largest cells of an archive with depths from levels, metres: larger ones would not show what
/// these tell.
const MOST_CELL_M: f64 = 2.0;

/// Refuses settings whose maps depend on more than a tile and its neighbours.
///
/// # Errors
/// A sentence.
pub(super) fn check(settings: &Settings, cell_m: f64, halo_m: f64) -> Result<(), ArchiveError> {
    if settings.surface.swath != SwathDepth::Always {
        return Ok(());
    }
    if cell_m > MOST_CELL_M {
        return Err(ArchiveError::Refused(format!(
            "surface.cell_m is {cell_m}, but depths from echo levels need cells of {MOST_CELL_M} m at most; choose smaller ones, or surface.swath = off"
        )));
    }
    if PART_DEPTHS_M + halo_m > TILE_M {
        return Err(ArchiveError::Refused(format!(
            "surface.max_gap_m is {}, which is too far for depths from echo levels; choose at most 190, or surface.swath = off",
            settings.surface.max_gap_m
        )));
    }
    Ok(())
}

/// The tiles whose rows the map of one is made from, in order: its own, and its neighbours' where
/// depths come from echo levels.
pub(super) fn tiles_read(swath: SwathDepth, tile: TileId) -> Vec<TileId> {
    match swath {
        SwathDepth::Off | SwathDepth::Auto => vec![tile],
        SwathDepth::Always => TileId::touched(tile.zone, beside(tile.bounds_m(), 1.0)).collect(),
    }
}

/// A box made larger on all sides.
pub(super) fn beside([west_m, south_m, east_m, north_m]: [f64; 4], by_m: f64) -> [f64; 4] {
    [west_m - by_m, south_m - by_m, east_m + by_m, north_m + by_m]
}
