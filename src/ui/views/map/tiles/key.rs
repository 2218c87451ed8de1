//! Defines the keys of the tiles of a map, which are squares of 256 texels whose side is a power of
//! two in metres, and finds the places of their texels in another plane.

use crate::ui::views::map::transform::GroundBounds;

/// Number of texels along a tile's side.
pub(super) const TEXELS: usize = 256;
/// Number of texels around a tile that belong to its neighbours: with them a smooth picture has no
/// seams.
pub(super) const BORDER: usize = 1;
/// Number of texels along the side of a tile's picture.
pub(crate) const SIDE: usize = TEXELS + 2 * BORDER;
/// Finest and coarsest level.
const LEVELS: [i8; 2] = [-8, 24];
/// Meshes of the net of a [`Warp`] along a tile's side. In a tile of 65 km, a projection bends a
/// mesh of 8 km by less than half a texel.
const MESHES: usize = 8;

/// The key of a tile.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct MapTileKey {
    /// Level: the side of a texel is 2 to the power of it, metres.
    pub level: i8,
    /// Column, counted eastwards from the survey's origin.
    pub column: i32,
    /// Row, counted northwards from the survey's origin.
    pub row: i32,
}

impl MapTileKey {
    /// Returns the side of a texel, metres.
    pub(crate) fn texel_m(self) -> f64 {
        2f64.powi(i32::from(self.level))
    }

    /// Returns west, south, east and north of the tile without its border, metres.
    pub(crate) fn bounds(self) -> GroundBounds {
        let side_m = TEXELS as f64 * self.texel_m();
        let edge = |count: i32| f64::from(count) * side_m;
        [edge(self.column), edge(self.row), edge(self.column + 1), edge(self.row + 1)]
    }

    /// Returns the west and north edge of the picture with its border, metres.
    pub(crate) fn corner(self) -> [f64; 2] {
        let [west, _, _, north] = self.bounds();
        let border_m = BORDER as f64 * self.texel_m();
        [west - border_m, north + border_m]
    }

    /// Returns the tile of twice the side that contains this tile.
    pub(crate) fn parent(self) -> Self {
        Self {
            level: self.level + 1,
            column: self.column.div_euclid(2),
            row: self.row.div_euclid(2),
        }
    }

    /// Returns the part of the picture of `forebear`, which is `self` or a tile that contains it,
    /// that shows this tile: left, top, right and bottom as shares.
    pub(crate) fn part_of(self, forebear: MapTileKey) -> [f32; 4] {
        let up = u32::from((forebear.level - self.level).max(0).unsigned_abs());
        let count = f64::from(2u32.pow(up.min(30)));
        let east = f64::from(self.column) - f64::from(forebear.column) * count;
        let north = f64::from(self.row) - f64::from(forebear.row) * count;
        let share =
            |tiles: f64| ((BORDER as f64 + TEXELS as f64 * tiles / count) / SIDE as f64) as f32;
        [share(east), share(count - north - 1.0), share(east + 1.0), share(count - north)]
    }
}

/// Returns the level whose texels come nearest to the size of a pixel.
pub(super) fn level_for(metres_per_pixel: f64) -> i8 {
    let level = metres_per_pixel.log2().round();
    level.clamp(f64::from(LEVELS[0]), f64::from(LEVELS[1])) as i8
}

/// Returns the finest level at which at most two by two tiles contain all of `bounds`.
pub(super) fn overview_level(bounds: GroundBounds) -> i8 {
    let [west, south, east, north] = bounds;
    let extent_m = (east - west).max(north - south).max(1e-3);
    let level = (extent_m / TEXELS as f64).log2().ceil();
    level.clamp(f64::from(LEVELS[0]), f64::from(LEVELS[1])) as i8
}

/// Returns the tiles of a level that touch both `view` and `all`, sorted by the distance to the
/// middle of `view`.
pub(super) fn tiles(level: i8, view: GroundBounds, all: GroundBounds) -> Vec<MapTileKey> {
    let side_m = TEXELS as f64 * 2f64.powi(i32::from(level));
    let both: [f64; 4] = std::array::from_fn(|edge| {
        if edge < 2 { view[edge].max(all[edge]) } else { view[edge].min(all[edge]) }
    });
    let [west, south, east, north] = both;
    // Also catches NaN.
    if !(west < east && south < north) {
        return Vec::new();
    }
    let span = |from: f64, to: f64| {
        (from / side_m).floor() as i32..=((to / side_m).ceil() as i32).saturating_sub(1)
    };
    let mut found: Vec<MapTileKey> = span(south, north)
        .flat_map(|row| span(west, east).map(move |column| MapTileKey { level, column, row }))
        .collect();
    let middle = [0.5 * (view[0] + view[2]), 0.5 * (view[1] + view[3])];
    let off = |key: &MapTileKey| {
        let [west, south, east, north] = key.bounds();
        (0.5 * (west + east) - middle[0]).hypot(0.5 * (south + north) - middle[1])
    };
    found.sort_by(|a, b| off(a).total_cmp(&off(b)));
    found
}

/// Places of the texels of a tile's picture in another plane: exact on a coarse net, and linear
/// between its nodes.
pub(crate) struct Warp {
    nodes: Vec<[f64; 2]>,
}

impl Warp {
    /// Computes the places with `into`, which converts metres east and north of the survey's origin
    /// to the other plane.
    pub(crate) fn new(key: MapTileKey, into: impl Fn([f64; 2]) -> [f64; 2]) -> Self {
        let [west, north] = key.corner();
        let step_m = key.texel_m() * SIDE as f64 / MESHES as f64;
        let node = |index: usize| {
            let (row, column) = (index / (MESHES + 1), index % (MESHES + 1));
            into([west + column as f64 * step_m, north - row as f64 * step_m])
        };
        Self { nodes: (0..(MESHES + 1) * (MESHES + 1)).map(node).collect() }
    }

    /// Returns `looks` by `looks` places spread evenly over a texel.
    pub(crate) fn places(
        &self,
        row: usize,
        column: usize,
        looks: usize,
    ) -> impl Iterator<Item = [f64; 2]> {
        let share = move |texel: usize, look: usize| {
            (texel as f64 + (look as f64 + 0.5) / looks as f64) / SIDE as f64
        };
        (0..looks * looks)
            .map(move |look| self.at([share(column, look % looks), share(row, look / looks)]))
    }

    /// Returns the place at shares of the picture's width and height.
    fn at(&self, shares: [f64; 2]) -> [f64; 2] {
        let [(left, right), (top, down)] = shares.map(|share| {
            let place = share * MESHES as f64;
            let mesh = (place as usize).min(MESHES - 1);
            (mesh, place - mesh as f64)
        });
        let node = |row: usize, column: usize| self.nodes[row * (MESHES + 1) + column];
        let mix = |a: [f64; 2], b: [f64; 2], share: f64| {
            [0, 1].map(|axis| a[axis] + (b[axis] - a[axis]) * share)
        };
        let upper = mix(node(top, left), node(top, left + 1), right);
        let lower = mix(node(top + 1, left), node(top + 1, left + 1), right);
        mix(upper, lower, down)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bathyscope_log::support::geo::{LocalFrame, LonLat, UtmZone};

    #[test]
    fn tiles_cover_what_is_seen_of_what_there_is() {
        let all = [-300.0, -40.0, 500.0, 90.0];
        let view = [-100.0, -1000.0, 130.0, 20.0];
        let keys = tiles(-2, view, all);
        // 64 m a side: columns -2 to 2, rows -1 and 0.
        assert_eq!(keys.len(), 10);
        for place in [[-99.0, -39.0], [129.0, 19.0], [0.0, 0.0]] {
            let covered = keys.iter().any(|key| {
                let [west, south, east, north] = key.bounds();
                (west..=east).contains(&place[0]) && (south..=north).contains(&place[1])
            });
            assert!(covered, "{place:?}");
        }
        assert!(tiles(-2, [600.0, 0.0, 700.0, 1.0], all).is_empty());
        assert!(tiles(overview_level(all), all, all).len() <= 4);
    }

    #[test]
    fn a_texel_is_about_a_pixel() {
        assert_eq!(level_for(0.25), -2);
        assert_eq!(level_for(0.3), -2);
        assert_eq!(level_for(0.4), -1);
        assert_eq!(level_for(1e12), LEVELS[1]);
    }

    #[test]
    fn a_forebear_s_picture_shows_the_tile_where_it_lies() {
        let key = MapTileKey { level: 0, column: -3, row: 5 };
        let share = |texels: f64| ((1.0 + texels) / SIDE as f64) as f32;
        assert_eq!(key.part_of(key), [share(0.0), share(0.0), share(256.0), share(256.0)]);
        // Column -3 is the eastern half of -2, row 5 the northern half of 2.
        assert_eq!(
            key.part_of(key.parent()),
            [share(128.0), share(0.0), share(256.0), share(128.0)]
        );
        // Column -2 is the western half of -1, row 2 the southern half of 1.
        assert_eq!(
            key.part_of(key.parent().parent()),
            [share(64.0), share(128.0), share(128.0), share(192.0)]
        );
    }

    #[test]
    fn a_tile_of_kilometres_is_bent_by_less_than_half_a_texel() {
        let origin = LonLat { lon_deg: -111.5, lat_deg: 36.9 };
        let (frame, zone) = (LocalFrame::new(origin), UtmZone::of(origin));
        let into = |[east_m, north_m]: [f64; 2]| zone.to_metres(frame.to_lon_lat(east_m, north_m));
        for level in [-4, 4, 8] {
            let key = MapTileKey { level, column: 0, row: -1 };
            let warp = Warp::new(key, into);
            let [west, north] = key.corner();
            for (row, column) in [(0, 0), (17, 200), (129, 130), (257, 3)] {
                let half_m = 0.5 * key.texel_m();
                let east_m = west + column as f64 * key.texel_m() + half_m;
                let north_m = north - row as f64 * key.texel_m() - half_m;
                let exact = into([east_m, north_m]);
                let by_net = warp.places(row, column, 1).next().unwrap();
                let off_m = (exact[0] - by_net[0]).hypot(exact[1] - by_net[1]);
                assert!(off_m < half_m, "{level} {row} {column}: {off_m} m");
            }
        }
    }
}
