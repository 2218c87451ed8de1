//! Defines web tiles and the squares of the earth that they show.

use bathyscope_bottom::bathymetry::isobaths::{Isobath, clipped};
use bathyscope_log::support::geo::{LonLat, web_mercator, web_mercator_inverse};

/// Number of pixels along a side of a tile.
pub(crate) const TILE_PIXELS: usize = 256;

/// Half the side of the square to which Web Mercator maps the earth, metres: half the equator of
/// its sphere.
const HALF_M: f64 = std::f64::consts::PI * 6_378_137.0;
/// Finest zoom, at which a pixel is some 4 cm.
const FINEST_ZOOM: u8 = 22;
/// Least length of the map at the coarsest zoom, pixels: the coarsest zoom is the one at which the
/// map is about this long, or zoom 0.
const LEAST_PIXELS: f64 = 32.0;

/// A tile, by its zoom, its column from the west, and its row from the north.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct WebTile {
    /// Zoom; 0 is a single tile of the whole earth.
    pub zoom: u8,
    /// Column, counted from 180 degrees west.
    pub x: u32,
    /// Row, counted from 85 degrees north.
    pub y: u32,
}

/// Converts a position to pixels from the west and from the north edge of the whole map at a zoom.
pub(crate) fn web_pixel(at: LonLat, zoom: u8) -> [f64; 2] {
    let [x, y] = web_mercator(at);
    let per_metre = pixels_across(zoom) / (2.0 * HALF_M);
    [(x + HALF_M) * per_metre, (HALF_M - y) * per_metre]
}

/// Converts a line of positions to pixels of a zoom. The line continues beyond the map's edge where
/// it crosses the antimeridian.
pub(crate) fn web_line(places: impl Iterator<Item = LonLat>, zoom: u8) -> Vec<[f64; 2]> {
    let across = pixels_across(zoom);
    let mut before = None;
    let point = |at: LonLat| {
        let [x, y] = web_pixel(at, zoom);
        let turns = before.map_or(0.0, |before: f64| ((before - x) / across).round());
        let x = x + turns * across;
        before = Some(x);
        [x, y]
    };
    places.map(point).collect()
}

fn pixels_across(zoom: u8) -> f64 {
    TILE_PIXELS as f64 * f64::from(1_u32 << zoom)
}

impl WebTile {
    /// Returns the tile that holds a place, given in pixels of the tile's zoom.
    pub(crate) fn at_pixel([x, y]: [f64; 2], zoom: u8) -> Self {
        let last = (1_u32 << zoom) - 1;
        let number = |pixels: f64| ((pixels / TILE_PIXELS as f64) as u32).min(last);
        Self { zoom, x: number(x), y: number(y) }
    }

    /// Returns the four tiles of the next zoom in this tile: north-west, north-east, south-west,
    /// south-east.
    pub fn children(&self) -> [Self; 4] {
        [[0, 0], [1, 0], [0, 1], [1, 1]].map(|[east, south]| Self {
            zoom: self.zoom + 1,
            x: 2 * self.x + east,
            y: 2 * self.y + south,
        })
    }

    /// Returns the north-west corner of the tile and its side, in pixels of its own or a finer
    /// zoom.
    pub(crate) fn corner_at(&self, zoom: u8) -> ([f64; 2], f64) {
        let side = TILE_PIXELS as f64 * f64::from(1_u32 << zoom.saturating_sub(self.zoom));
        ([self.x, self.y].map(|number| f64::from(number) * side), side)
    }

    /// Returns the edges of the tile in pixels of its own or a finer zoom: least from the west and
    /// from the north, then greatest, in the order of
    /// [`bathyscope_bottom::bathymetry::isobaths::clipped`].
    pub(crate) fn pixel_bounds(&self, zoom: u8) -> [f64; 4] {
        let ([west, north], side) = self.corner_at(zoom);
        [west, north, west + side, north + side]
    }

    /// Returns the parts of isobaths in the tile; lines are given in pixels of the finest zoom
    /// ([`web_line`]).
    pub(crate) fn isobaths<'a>(
        &self,
        lines: impl Iterator<Item = &'a Isobath>,
        zooms: &ZoomRange,
    ) -> Vec<Isobath> {
        let [west, north, east, south] = self.pixel_bounds(zooms.finest);
        let across = pixels_across(zooms.finest);
        let turns: &[f64] = if zooms.crosses_antimeridian() { &[0.0, 1.0, -1.0] } else { &[0.0] };
        let on_tile = |line: &'a Isobath| {
            turns.iter().flat_map(move |turn| {
                let by = turn * across;
                let mut parts = clipped(line, [west + by, north, east + by, south]);
                let points = parts.iter_mut().flat_map(|part| &mut part.points);
                points.for_each(|[x, _]| *x -= by);
                parts
            })
        };
        lines.flat_map(on_tile).collect()
    }

    /// Returns the position of a place in pixels of the tile; whole numbers are corners of pixels.
    pub fn place(&self, [x, y]: [f64; 2]) -> LonLat {
        let ([west, north], _) = self.corner_at(self.zoom);
        let metres = 2.0 * HALF_M / pixels_across(self.zoom);
        web_mercator_inverse((west + x) * metres - HALF_M, HALF_M - (north + y) * metres)
    }

    /// Returns the west, south, east and north edge, degrees.
    pub fn bounds_deg(&self) -> [f64; 4] {
        let side = TILE_PIXELS as f64;
        let [north_west, south_east] = [[0.0, 0.0], [side, side]].map(|corner| self.place(corner));
        [north_west.lon_deg, south_east.lat_deg, south_east.lon_deg, north_west.lat_deg]
    }

    /// Returns the number of the tile along Hilbert's curve, after all tiles of coarser zooms.
    /// PMTiles orders tiles by this number: neighbours are close to each other.
    pub(crate) fn hilbert_id(&self) -> u64 {
        let coarser = ((1_u64 << (2 * u32::from(self.zoom))) - 1) / 3;
        let (mut x, mut y) = (u64::from(self.x), u64::from(self.y));
        let mut along = 0;
        for level in (0..self.zoom).rev() {
            let half = 1_u64 << level;
            let mask = half - 1;
            let [right, lower] = [x, y].map(|number| u64::from(number & half > 0));
            along += half * half * ((3 * right) ^ lower);
            if lower == 0 {
                if right == 1 {
                    (x, y) = (mask.wrapping_sub(x), mask.wrapping_sub(y));
                }
                (x, y) = (y, x);
            }
            (x, y) = (x & mask, y & mask);
        }
        coarser + along
    }
}

/// Zooms and extent of a map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ZoomRange {
    /// Coarsest zoom.
    pub coarsest: u8,
    /// Finest zoom.
    pub finest: u8,
    /// West, south, east and north edge, degrees; the east edge is above 180 where the map crosses
    /// the antimeridian.
    pub bounds_deg: [f64; 4],
}

impl ZoomRange {
    /// Returns the zooms from the one at which the map is a few pixels long to the one whose pixels
    /// are no longer than a cell.
    pub(crate) fn of_map(bounds_deg: [f64; 4], cell_m: f64) -> Self {
        let [west, south, east, north] = bounds_deg;
        let middle_deg = 0.5 * (south + north);
        let pixel_m = 2.0 * HALF_M * middle_deg.to_radians().cos() / TILE_PIXELS as f64;
        let finest = (pixel_m / cell_m.max(1e-3)).log2().ceil();
        let finest = finest.clamp(0.0, f64::from(FINEST_ZOOM)) as u8;
        let [[x0, y0], [x1, y1]] = [[west, north], [east, south]]
            .map(|[lon_deg, lat_deg]| web_pixel(LonLat { lon_deg, lat_deg }, finest));
        let longer = (x1 - x0).max(y1 - y0);
        let zooms = (longer / LEAST_PIXELS).log2().floor().max(0.0) as u8;
        Self { coarsest: finest.saturating_sub(zooms), finest, bounds_deg }
    }

    fn crosses_antimeridian(&self) -> bool {
        self.bounds_deg[2] > 180.0
    }

    /// Returns the tiles of a zoom that the map reaches.
    pub fn tiles(&self, zoom: u8) -> Vec<WebTile> {
        let [west, south, east, north] = self.bounds_deg;
        let tile = |lon_deg, lat_deg| {
            WebTile::at_pixel(web_pixel(LonLat { lon_deg, lat_deg }, zoom), zoom)
        };
        let (first, last) = (tile(west, north), tile(east, south));
        let columns: Vec<u32> = if self.crosses_antimeridian() {
            // At coarse zooms both sides of the antimeridian may be the same tile.
            let beyond = tile(east - 360.0, south).x;
            (0..=beyond).chain(first.x.max(beyond + 1)..=last.x).collect()
        } else {
            (first.x..=last.x).collect()
        };
        let rows = first.y..=last.y;
        rows.flat_map(|y| columns.iter().map(move |&x| WebTile { zoom, x, y })).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bathyscope_log::support::geo::boxes_meet;

    #[test]
    fn numbers_along_the_curve_are_those_of_the_pmtiles_package() {
        // pmtiles 3.8.1 (Python): pmtiles.tile.zxy_to_tileid(z, x, y).
        for (zoom, x, y, id) in [
            (0, 0, 0, 0),
            (1, 0, 0, 1),
            (1, 0, 1, 2),
            (1, 1, 1, 3),
            (1, 1, 0, 4),
            (2, 0, 0, 5),
            (3, 5, 2, 76),
            (12, 3423, 1763, 19_078_479),
            (18, 49_890, 102_327, 36_602_579_054),
        ] {
            let found = WebTile { zoom, x, y }.hilbert_id();
            assert_eq!(found, id, "{zoom}/{x}/{y}");
        }
    }

    #[test]
    fn a_place_lies_in_its_tile_and_comes_back_from_its_pixel() {
        let at = LonLat { lon_deg: -111.48, lat_deg: 36.86 };
        let pixel = web_pixel(at, 18);
        let tile = WebTile::at_pixel(pixel, 18);
        // mercantile 1.2.1: tile(-111.48, 36.86, 18).
        assert_eq!((tile.x, tile.y), (49_894, 102_161));
        let ([west, north], side) = tile.corner_at(18);
        assert_eq!(side, 256.0);
        let back = tile.place([pixel[0] - west, pixel[1] - north]);
        assert!(
            (back.lon_deg - at.lon_deg).abs() < 1e-9 && (back.lat_deg - at.lat_deg).abs() < 1e-9
        );
        let meets = |bounds_deg| boxes_meet(tile.bounds_deg(), bounds_deg);
        assert!(meets([-111.48, 36.86, -111.48, 36.86]));
        assert!(!meets([-111.0, 36.86, -110.9, 36.87]));
        assert!(tile.children().iter().all(|child| child.corner_at(20).0[0] >= 4.0 * west));
    }

    #[test]
    fn the_finest_pixel_is_no_longer_than_a_cell() {
        let range = ZoomRange::of_map([-111.49, 36.85, -111.48, 36.86], 0.5);
        assert_eq!(range.finest, 18);
        let tiles: Vec<usize> = (range.coarsest..=18).map(|zoom| range.tiles(zoom).len()).collect();
        assert!(tiles[0] <= 4 && tiles[tiles.len() - 1] > 30, "{tiles:?}");
        let tiny = ZoomRange::of_map([0.0, 0.0, 1e-7, 1e-7], 0.1);
        assert_eq!(tiny.coarsest, tiny.finest);
    }

    #[test]
    fn a_map_across_the_antimeridian_has_tiles_on_both_sides_of_it_and_no_others() {
        let zooms = ZoomRange::of_map([179.999, -17.501, 180.001, -17.499], 0.25);
        assert!(zooms.coarsest > 10, "{zooms:?}");
        for zoom in zooms.coarsest..=zooms.finest {
            let tiles = zooms.tiles(zoom);
            let last = (1_u32 << zoom) - 1;
            assert!(
                tiles.iter().any(|tile| tile.x == 0) && tiles.iter().any(|tile| tile.x == last)
            );
            assert!(tiles.len() < 2000, "{zoom}: {}", tiles.len());
            let meets = |tile: &WebTile| boxes_meet(tile.bounds_deg(), zooms.bounds_deg);
            assert!(tiles.iter().all(meets));
        }
        assert_eq!(zooms.tiles(0), [WebTile { zoom: 0, x: 0, y: 0 }]);
        // An isobath across the antimeridian is drawn on both sides.
        let places = [179.9995, -179.9995].map(|lon| LonLat::new(lon, -17.5));
        let points = web_line(places.into_iter(), zooms.finest);
        let line = Isobath { depth_m: 2.0, points };
        let drawn = |x: u32| {
            let y = WebTile::at_pixel(line.points[0], zooms.finest).y;
            let tile = WebTile { zoom: zooms.finest, x, y };
            tile.isobaths(std::iter::once(&line), &zooms).len()
        };
        let last = (1_u32 << zooms.finest) - 1;
        assert_eq!([drawn(0), drawn(last), drawn(last / 2)], [1, 1, 0]);
    }
}
