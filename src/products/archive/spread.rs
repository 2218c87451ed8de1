//! Assigns the rows of a log to tiles.

use super::tile::TileId;
use bathyscope_log::formats::parquet_table::{Column, Values};
use bathyscope_log::support::geo::{LonLat, UtmZone};
use std::collections::BTreeMap;

/// A row of a tile: what it is of, and where that lies.
#[derive(Clone, Copy, Debug)]
pub(super) struct TileRow {
    /// Index of the point or ping in the log.
    pub index: usize,
    /// Its place.
    pub at: LonLat,
    /// The zone of the tile.
    pub zone: UtmZone,
    /// The place in metres of that zone.
    pub place: [f64; 2],
    /// True if it lies in the tile itself.
    pub is_core: bool,
}

/// The places of rows as a column.
pub(super) fn geometry(rows: &[TileRow]) -> Column {
    let places = rows.iter().map(|row| row.at).collect();
    Column::new("geometry", Values::Points(places))
}

/// Rows by tile, those of a tile in the order of the log.
pub(super) type RowsByTile = BTreeMap<TileId, Vec<TileRow>>;

/// Points, each in the tile that holds it and in those whose halo does, in the neighbouring zone
/// too.
pub(super) fn by_tile(points: impl Iterator<Item = (usize, LonLat)>, halo_m: f64) -> RowsByTile {
    let mut tiles = RowsByTile::new();
    for (index, at) in points {
        let zones = UtmZone::near(at, halo_m);
        for (rank, zone) in zones.into_iter().enumerate() {
            let place = zone.to_metres(at);
            let [x, y] = place;
            if !(x.is_finite() && y.is_finite()) {
                continue;
            }
            let own = (rank == 0).then(|| TileId::at(zone, place));
            let around = [x - halo_m, y - halo_m, x + halo_m, y + halo_m];
            for tile in TileId::touched(zone, around).filter(|tile| tile.holds(place, halo_m)) {
                tiles.entry(tile).or_default().push(TileRow {
                    index,
                    at,
                    zone,
                    place,
                    is_core: own == Some(tile),
                });
            }
        }
    }
    tiles
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_point_is_in_one_core_and_in_halos_across_the_meridian() {
        let at = LonLat { lon_deg: 11.9999, lat_deg: 47.5 };
        let tiles = by_tile([(7, at)].into_iter(), 64.0);
        let rows: Vec<(TileId, TileRow)> =
            tiles.into_iter().map(|(tile, rows)| (tile, rows[0])).collect();
        assert_eq!(rows.iter().filter(|(_, row)| row.is_core).count(), 1);
        let zones: Vec<u8> = rows.iter().map(|(tile, _)| tile.zone.number).collect();
        assert!(zones.contains(&32) && zones.contains(&33), "{zones:?}");
        for (tile, row) in rows {
            assert_eq!(row.index, 7);
            assert!(tile.holds(row.place, 64.0));
            assert!(!row.is_core || tile.zone.number == 32 && tile.holds(row.place, 0.0));
        }
    }
}
