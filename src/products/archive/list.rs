//! Lists the rows in an archive, tile by tile.

use super::error::ArchiveError;
use super::record::Archive;
use super::tile::TileId;
use std::collections::BTreeMap;

/// The rows of a tile, of all logs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TileRowCounts {
    /// Logs with rows of points or pings.
    pub logs: usize,
    /// Rows of points, those of the halo among them.
    pub points: usize,
    /// Points in the tile itself.
    pub core_points: usize,
    /// Rows of pings.
    pub pings: usize,
}

/// All tiles that have rows, in order.
///
/// # Errors
/// When a record cannot be used.
pub fn contents(archive: &Archive) -> Result<BTreeMap<TileId, TileRowCounts>, ArchiveError> {
    let mut tiles: BTreeMap<TileId, TileRowCounts> = BTreeMap::new();
    for log in archive.logs()? {
        for rows in &log.tiles {
            let content = tiles.entry(rows.tile).or_default();
            content.logs += 1;
            content.points += rows.points;
            content.core_points += rows.core_points;
            content.pings += rows.pings;
        }
    }
    Ok(tiles)
}
