//! Defines the squares that an archive is divided into.

use bathyscope_bottom::bathymetry::{Grid, SwathDepth};
use bathyscope_log::formats::geotiff::{CellFormat, RasterSpec};
use bathyscope_log::support::geo::{Crs, LonLat, UtmZone, bounds_deg};
use std::fmt;
use std::str::FromStr;

/// Side of a tile, metres of its zone.
pub const TILE_M: f64 = 512.0;
/// Side of a tile in whole metres.
const TILE: i64 = 512;
/// Largest northing or easting of a tile, metres.
const FARTHEST: i64 = 20_000_000;

/// A square of 512 m of a UTM zone, aligned to the zone's grid. Its name is the zone, and the
/// easting and northing of its south-west corner in metres: `12N_455680_4077568`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct TileId {
    /// Zone of the tile.
    pub zone: UtmZone,
    /// Number of tiles from the zone's zero, east and north.
    index: [i64; 2],
}

impl TileId {
    /// Returns the tile that holds a place of a zone; for a place on an edge, the tile to the east
    /// or north.
    pub fn at(zone: UtmZone, place: [f64; 2]) -> Self {
        Self { zone, index: place.map(|metres| (metres / TILE_M).floor() as i64) }
    }

    /// Returns the tiles of a zone that a box (west, south, east and north, metres) touches.
    pub(crate) fn touched(
        zone: UtmZone,
        [west, south, east, north]: [f64; 4],
    ) -> impl Iterator<Item = Self> {
        let from = Self::at(zone, [west, south]).index;
        let to = Self::at(zone, [east, north]).index;
        let columns = from[0]..=to[0];
        columns.flat_map(move |column| {
            (from[1]..=to[1]).map(move |row| Self { zone, index: [column, row] })
        })
    }

    /// Returns the west, south, east and north edge, metres of the zone.
    pub fn bounds_m(&self) -> [f64; 4] {
        let [west, south] = self.index.map(|index| index as f64 * TILE_M);
        [west, south, west + TILE_M, south + TILE_M]
    }

    /// Returns true if the whole tile lies in its own zone; ground beyond the edge of the zone
    /// belongs to the other zone.
    pub(crate) fn is_within_zone(&self) -> bool {
        let [west, south, east, north] = self.bounds_m();
        let middle = [0.5 * (west + east), 0.5 * (south + north)];
        UtmZone::near(self.zone.to_lon_lat(middle), TILE_M) == [self.zone]
    }

    /// Returns the grid of the tile's cells and of a margin around it, which must be a multiple of
    /// the cell.
    pub(super) fn grid(&self, margin_m: f64, cell_m: f64) -> Grid {
        let [west_m, _, _, north_m] = self.bounds_m();
        let side = ((TILE_M + 2.0 * margin_m) / cell_m).round() as usize;
        Grid {
            west_m: west_m - margin_m,
            north_m: north_m + margin_m,
            cell_m,
            columns: side,
            rows: side,
        }
    }

    /// Returns the description of a raster over a grid in the tile's zone; the caller sets the kind
    /// of cells, the band and the text.
    pub(super) fn raster(&self, grid: &Grid) -> RasterSpec {
        RasterSpec {
            columns: grid.columns,
            rows: grid.rows,
            west: grid.west_m,
            north: grid.north_m,
            cell: [grid.cell_m; 2],
            crs: Crs::of_zone(self.zone),
            cells: CellFormat::Metres,
            band: None,
            description: String::new(),
        }
    }

    /// Returns true if the tile, made larger by `halo_m` on all sides, holds a place of its zone.
    pub fn holds(&self, place: [f64; 2], halo_m: f64) -> bool {
        is_within(beside(self.bounds_m(), halo_m), place)
    }
}

impl fmt::Display for TileId {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let UtmZone { number, north } = self.zone;
        let hemisphere = if north { 'N' } else { 'S' };
        let [easting, northing] = self.index.map(|index| index * TILE);
        write!(out, "{number}{hemisphere}_{easting}_{northing}")
    }
}

/// Error of a text that names no tile.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("`{0}` names no tile; `bathyscope tiles DIR` lists them, as 12N_455680_4077568")]
pub struct NoTile(String);

impl FromStr for TileId {
    type Err = NoTile;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let parsed = || {
            let mut parts = text.trim_start_matches("tile=").split('_');
            let zone = parts.next()?;
            let (number, hemisphere) = zone.split_at_checked(zone.len().checked_sub(1)?)?;
            let number: u8 = number.parse().ok().filter(|number| (1..=60).contains(number))?;
            let north = match hemisphere {
                "N" => true,
                "S" => false,
                _ => return None,
            };
            let mut index = || {
                let metres: i64 = parts.next()?.parse().ok()?;
                let is_edge = metres % TILE == 0 && metres.abs() <= FARTHEST;
                is_edge.then_some(metres / TILE)
            };
            let index = [index()?, index()?];
            let zone = UtmZone { number, north };
            parts.next().is_none().then_some(Self { zone, index })
        };
        parsed().ok_or_else(|| NoTile(text.to_owned()))
    }
}

/// Returns the corners of a box of a zone (west, south, east and north) as a closed ring of
/// longitude and latitude in degrees.
pub(super) fn ring(zone: UtmZone, [west, south, east, north]: [f64; 4]) -> [[f64; 2]; 5] {
    [[west, south], [east, south], [east, north], [west, north], [west, south]].map(|place| {
        let at = zone.to_lon_lat(place);
        [at.lon_deg, at.lat_deg].map(|degrees| (degrees * 1e8).round() / 1e8)
    })
}

/// Returns the west, south, east and north edge of some tiles, degrees.
pub(super) fn tile_bounds_deg(tiles: &[TileId]) -> [f64; 4] {
    zone_bounds_deg(tiles.iter().map(|tile| (tile.zone, tile.bounds_m())))
}

/// Returns the west, south, east and north edge of some boxes of zones, degrees.
pub(super) fn zone_bounds_deg(boxes: impl Iterator<Item = (UtmZone, [f64; 4])>) -> [f64; 4] {
    let all = boxes.flat_map(|(zone, bounds_m)| ring(zone, bounds_m));
    bounds_deg(all.map(|[lon_deg, lat_deg]| LonLat { lon_deg, lat_deg }))
}

/// Returns the tiles whose rows the map of a tile is made from, in order: the tile itself and,
/// where depths come from echo levels, its neighbours.
pub(super) fn tiles_read(swath: SwathDepth, tile: TileId) -> Vec<TileId> {
    match swath {
        SwathDepth::Off | SwathDepth::Auto => vec![tile],
        SwathDepth::Always => TileId::touched(tile.zone, beside(tile.bounds_m(), 1.0)).collect(),
    }
}

/// Returns true if a place is in a box (west, south, east and north) or on its west or south edge.
pub(super) fn is_within([west_m, south_m, east_m, north_m]: [f64; 4], [x, y]: [f64; 2]) -> bool {
    (west_m..east_m).contains(&x) && (south_m..north_m).contains(&y)
}

/// Returns a box made larger by `by_m` on all sides.
pub(super) fn beside([west_m, south_m, east_m, north_m]: [f64; 4], by_m: f64) -> [f64; 4] {
    [west_m - by_m, south_m - by_m, east_m + by_m, north_m + by_m]
}

#[cfg(test)]
mod tests {
    use super::*;

    const ZONE: UtmZone = UtmZone { number: 32, north: true };

    #[test]
    fn a_tile_is_named_after_its_corner_and_found_by_its_name() {
        let tile = TileId::at(ZONE, [512_345.6, 5_261_000.1]);
        assert_eq!(tile.to_string(), "32N_512000_5260800");
        assert_eq!(tile.to_string().parse(), Ok(tile));
        assert_eq!("tile=32N_512000_5260800".parse(), Ok(tile));
        assert_eq!(tile.bounds_m(), [512_000.0, 5_260_800.0, 512_512.0, 5_261_312.0]);
        for wrong in
            ["", "N_0_0", "32N_512001_0", "61N_0_0", "32X_0_0", "32N_0", "32N_0_0_0", "é_0_0"]
        {
            assert!(wrong.parse::<TileId>().is_err(), "{wrong}");
        }
    }

    #[test]
    fn a_place_lies_in_one_tile_and_in_the_halo_of_its_neighbours() {
        let place = [512_500.0, 5_261_000.0];
        let tile_count = |halo_m: f64| {
            let [x, y] = place;
            let around = [x - halo_m, y - halo_m, x + halo_m, y + halo_m];
            let touched = TileId::touched(ZONE, around);
            touched.filter(|tile| tile.holds(place, halo_m)).count()
        };
        assert_eq!([tile_count(0.0), tile_count(64.0), tile_count(250.0)], [1, 2, 4]);
        assert!(TileId::at(ZONE, place).holds(place, 0.0));
        let edge = [512_000.0, 5_260_800.0];
        assert_eq!(TileId::at(ZONE, edge).bounds_m()[..2], edge);
    }
}
