//! The depths of a tile corrected by shading: they depend on what lies around the tile, in its eight neighbours.

use super::echo_rows::{ECHOES, StoredEchoes};
use super::error::LakeError;
use super::log_record::LogRecord;
use super::offsets::Offsets;
use super::point_rows::POINTS;
use super::record::Lake;
use super::tile::{TILE_M, TileId};
use super::tile_map::{moved_points, part_of};
use crate::bathymetry::{DepthPoint, Grid, Surface, SwathDepth, local_surface};
use crate::pipeline::Settings;
use crate::progress::Progress;
use crate::swath::{PART_GROUND_M, PART_MOST_CELL_M, PART_PINGS_M, PART_STEP_M, shade_part};

const _: () = assert!(TILE_M % PART_STEP_M == 0.0);

/// Refuses settings whose maps depend on more than a tile and its neighbours.
///
/// # Errors
/// A sentence.
pub(super) fn check(settings: &Settings, cell_m: f64, halo_m: f64) -> Result<(), LakeError> {
    if settings.surface.swath == SwathDepth::Off {
        return Ok(());
    }
    if cell_m > PART_MOST_CELL_M {
        return Err(LakeError::Refused(format!(
            "surface.cell_m is {cell_m}, but a lake is shaded in cells of {PART_MOST_CELL_M} m at most; choose smaller ones, or surface.swath = off"
        )));
    }
    if PART_GROUND_M + halo_m > TILE_M {
        return Err(LakeError::Refused(format!(
            "surface.max_gap_m is {}, which is too far for a lake that is shaded; choose at most 125, or surface.swath = off",
            settings.surface.max_gap_m
        )));
    }
    Ok(())
}

/// The tiles whose rows the map of one is made from, in order: its own, and its neighbours' where depths are corrected by shading.
pub(super) fn tiles_read(swath: SwathDepth, tile: TileId) -> Vec<TileId> {
    match swath {
        SwathDepth::Off => vec![tile],
        SwathDepth::Shaded => TileId::touched(tile.zone, beside(tile.bounds_m(), 1.0)).collect(),
    }
}

fn beside([west_m, south_m, east_m, north_m]: [f64; 4], by_m: f64) -> [f64; 4] {
    [west_m - by_m, south_m - by_m, east_m + by_m, north_m + by_m]
}

/// The surface of a tile on a grid a few cells larger than it, corrected by shading.
///
/// # Errors
/// When rows cannot be read, or the work was cancelled.
pub(super) fn shaded_surface(
    lake: &Lake,
    tile: TileId,
    grid: Grid,
    logs: &[LogRecord],
    offsets: &Offsets,
    progress: &Progress,
) -> Result<Surface, LakeError> {
    let settings = lake.settings()?.surface;
    let tiles = tiles_read(SwathDepth::Shaded, tile);
    let points_m = beside(tile.bounds_m(), PART_GROUND_M + lake.record.halo_m);
    let mut points: Vec<DepthPoint> = Vec::new();
    for log in logs {
        for one in &tiles {
            progress.check()?;
            let rows = moved_points(lake, *one, log, offsets, |place| {
                one.holds(place, 0.0) && is_within(points_m, place)
            })?;
            points.extend(rows);
        }
    }
    let around = around(tile, grid.cell_m);
    let mut made = local_surface(&points, around, settings.max_gap_m, progress)?;
    let stored = echoes_around(lake, &tiles, tile, logs, offsets, progress)?;
    let laid_out: Vec<_> = stored.iter().map(StoredEchoes::laid_out).collect();
    shade_part(&mut made, tile.bounds_m(), &laid_out, &points, progress)?;
    Ok(part_of(&made, grid))
}

/// The grid of the ground that the correction of a tile depends on.
fn around(tile: TileId, cell_m: f64) -> Grid {
    let [west_m, _, _, north_m] = tile.bounds_m();
    let side = ((TILE_M + 2.0 * PART_GROUND_M) / cell_m).round() as usize;
    Grid {
        west_m: west_m - PART_GROUND_M,
        north_m: north_m + PART_GROUND_M,
        cell_m,
        columns: side,
        rows: side,
    }
}

fn echoes_around(
    lake: &Lake,
    tiles: &[TileId],
    tile: TileId,
    logs: &[LogRecord],
    offsets: &Offsets,
    progress: &Progress,
) -> Result<Vec<StoredEchoes>, LakeError> {
    let within_m = beside(tile.bounds_m(), PART_PINGS_M);
    let mut stored = Vec::new();
    for log in logs {
        progress.check()?;
        let files = tiles.iter().filter(|tile| {
            let rows = log.rows_in(**tile);
            rows.is_some_and(|rows| !rows.sha256_of(ECHOES).is_empty())
        });
        let paths: Vec<_> = files
            .map(|tile| lake.folder().join(Lake::rows_name(ECHOES, *tile, &log.log)))
            .collect();
        stored.push(StoredEchoes::read(&paths, log, offsets, within_m)?);
    }
    Ok(stored)
}

fn is_within([west_m, south_m, east_m, north_m]: [f64; 4], [x, y]: [f64; 2]) -> bool {
    (west_m..east_m).contains(&x) && (south_m..north_m).contains(&y)
}

/// SHA-256 of the rows of a log that the map of a tile is made from, by tile, kind after kind.
pub(super) fn hashes_read(swath: SwathDepth, tile: TileId, log: &LogRecord) -> Vec<String> {
    let kinds: &[&str] = match swath {
        SwathDepth::Off => &[POINTS],
        SwathDepth::Shaded => &[POINTS, ECHOES],
    };
    let tiles = tiles_read(swath, tile);
    let rows = tiles
        .iter()
        .filter_map(|one| Some((one, log.rows_in(*one)?)));
    rows.flat_map(|(one, rows)| {
        let hashes = kinds.iter().map(|kind| rows.sha256_of(kind));
        hashes
            .filter(|hash| !hash.is_empty())
            .map(move |hash| format!("{one} {hash}"))
    })
    .collect()
}
