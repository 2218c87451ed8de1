//! The depths of a tile with those from echo levels: they depend on what lies around the tile, in
//! its eight neighbours.

use super::echo_rows::StoredEchoes;
use super::error::ArchiveError;
use super::folders::ECHOES;
use super::log_record::LogRecord;
use super::offsets::Offsets;
use super::reach::{beside, tiles_read};
use super::record::Archive;
use super::tile::TileId;
use super::tile_points::moved_points;
use bathyscope_bottom::bathymetry::{DepthPoint, Grid, Surface, SwathDepth, local_surface};
use bathyscope_bottom::swath::{PART_DEPTHS_M, PART_PINGS_M, correct_part};
use bathyscope_log::support::progress::Progress;

/// The surface of a tile on a grid a few cells larger than it, with depths from echo levels.
///
/// # Errors
/// When rows cannot be read, or the work was cancelled.
pub(super) fn surface_from_levels(
    archive: &Archive,
    tile: TileId,
    grid: Grid,
    logs: &[LogRecord],
    offsets: &Offsets,
    progress: &Progress,
) -> Result<Surface, ArchiveError> {
    let settings = archive.settings()?.surface;
    let tiles = tiles_read(SwathDepth::Always, tile);
    let points_m = beside(tile.bounds_m(), PART_DEPTHS_M + archive.record.halo_m);
    let mut points: Vec<DepthPoint> = Vec::new();
    for log in logs {
        for one in &tiles {
            progress.check()?;
            let rows = moved_points(archive, *one, log, offsets, |place| {
                one.holds(place, 0.0) && is_within(points_m, place)
            })?;
            points.extend(rows);
        }
    }
    let around = tile.grid(PART_DEPTHS_M, grid.cell_m);
    let mut made = local_surface(&points, around, settings.max_gap_m, progress)?;
    let stored = echoes_around(archive, &tiles, tile, logs, offsets, progress)?;
    let (laid_out, learnt): (Vec<_>, Vec<_>) =
        stored.iter().filter_map(StoredEchoes::laid_out).unzip();
    correct_part(&mut made, tile.bounds_m(), &laid_out, &learnt, &points, progress)?;
    Ok(made.part(grid))
}

fn echoes_around(
    archive: &Archive,
    tiles: &[TileId],
    tile: TileId,
    logs: &[LogRecord],
    offsets: &Offsets,
    progress: &Progress,
) -> Result<Vec<StoredEchoes>, ArchiveError> {
    let within_m = beside(tile.bounds_m(), PART_PINGS_M);
    let mut stored = Vec::new();
    for log in logs {
        progress.check()?;
        let files = tiles.iter().filter(|tile| {
            let rows = log.rows_in(**tile);
            rows.is_some_and(|rows| !rows.sha256_of(ECHOES).is_empty())
        });
        let paths: Vec<_> = files.map(|tile| archive.rows_path(ECHOES, *tile, &log.log)).collect();
        stored.push(StoredEchoes::read(&paths, log, offsets, within_m)?);
    }
    Ok(stored)
}

fn is_within([west_m, south_m, east_m, north_m]: [f64; 4], [x, y]: [f64; 2]) -> bool {
    (west_m..east_m).contains(&x) && (south_m..north_m).contains(&y)
}
