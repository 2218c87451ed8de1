//! Transforms the texels of a tile into another plane: exact on a coarse net, linear between.

use super::tiles::{MapTileKey, SIDE};

/// Meshes of the net along a tile's side. In a tile of 65 km a projection bends a mesh of 8 km by
/// less than half a texel.
const MESHES: usize = 8;

/// Places of the texels of a tile's picture in another plane.
pub(super) struct Warp {
    nodes: Vec<[f64; 2]>,
}

impl Warp {
    /// Creates the places with `into`, which takes metres east and north of the survey's origin to
    /// the other plane.
    pub(super) fn new(key: MapTileKey, into: impl Fn([f64; 2]) -> [f64; 2]) -> Self {
        let [west, north] = key.corner();
        let step_m = key.texel_m() * SIDE as f64 / MESHES as f64;
        let node = |index: usize| {
            let (row, column) = (index / (MESHES + 1), index % (MESHES + 1));
            into([west + column as f64 * step_m, north - row as f64 * step_m])
        };
        Self { nodes: (0..(MESHES + 1) * (MESHES + 1)).map(node).collect() }
    }

    /// `looks` by `looks` places spread evenly over a texel.
    pub(super) fn places(
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

    /// Place at shares of the picture's width and height.
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
