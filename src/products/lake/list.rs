//! What exists of a lake, tile by tile.

use super::error::LakeError;
use super::record::Lake;
use super::tile::TileId;
use std::collections::BTreeMap;

/// The rows of a tile, of all logs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TileContent {
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
pub fn contents(lake: &Lake) -> Result<BTreeMap<TileId, TileContent>, LakeError> {
    let mut tiles: BTreeMap<TileId, TileContent> = BTreeMap::new();
    for log in lake.logs()? {
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
