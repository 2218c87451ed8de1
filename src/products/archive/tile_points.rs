//! The depths that the map of a tile is made of, each log at its height and its corrected
//! positions.

use super::error::ArchiveError;
use super::folders::POINTS;
use super::log_record::LogRecord;
use super::offsets::Offsets;
use super::point_rows::{self, PointRow};
use super::positions::moved;
use super::record::Archive;
use super::tile::TileId;
use bathyscope_bottom::bathymetry::DepthPoint;
use bathyscope_log::support::progress::Progress;

/// The points that count in a tile and its halo, the logs in the order of their hashes, with their
/// offsets and their positions corrected.
///
/// # Errors
/// When rows cannot be read, or the work was cancelled.
pub(super) fn depth_points(
    archive: &Archive,
    tile: TileId,
    logs: &[LogRecord],
    offsets: &Offsets,
    progress: &Progress,
) -> Result<Vec<DepthPoint>, ArchiveError> {
    let mut points = Vec::new();
    for log in logs {
        progress.check()?;
        points.extend(moved_points(archive, tile, log, offsets, |_| true)?);
    }
    Ok(points)
}

/// The rows of points of a log in a tile that lie where they are asked for, with its offset and its
/// positions corrected.
///
/// # Errors
/// When rows cannot be read.
pub(super) fn moved_points(
    archive: &Archive,
    tile: TileId,
    log: &LogRecord,
    offsets: &Offsets,
    lies_there: impl Fn([f64; 2]) -> bool,
) -> Result<Vec<DepthPoint>, ArchiveError> {
    if log.rows_in(tile).is_none_or(|rows| rows.points == 0) {
        return Ok(Vec::new());
    }
    let (offset_m, shift) = (offsets.of(&log.log), offsets.shift_of(&log.log));
    let path = archive.rows_path(POINTS, tile, &log.log);
    let rows = point_rows::read(&path)?.into_iter();
    let of_row = |row: PointRow| {
        let place = [row.depth.east_m, row.depth.north_m];
        let [east_m, north_m] = moved(place, shift, row.velocity_mps);
        lies_there(place).then_some(DepthPoint {
            east_m,
            north_m,
            // What is added to an elevation is taken off the depth.
            depth_m: row.depth.depth_m - offset_m,
            ..row.depth
        })
    };
    Ok(rows.filter_map(of_row).collect())
}
