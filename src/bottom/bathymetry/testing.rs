//! Provides depths and random numbers for tests, and sixty scattered soundings of a smooth bed with
//! the depths that other programs interpolate between them.

use super::{DepthPoint, Node, merge_repeated};

/// Creates a recorded depth at a place.
pub(super) fn point(east_m: f64, north_m: f64, depth_m: f64) -> DepthPoint {
    DepthPoint::of_sounding([east_m, north_m], depth_m)
}

/// Returns random numbers from 0 to 1, the same each time.
pub(super) fn random() -> impl FnMut() -> f64 {
    let mut seed = 7_u64;
    move || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        (seed >> 33) as f64 / (1_u64 << 31) as f64
    }
}

pub(super) struct Golden {
    pub place: [f64; 2],
    /// Depth by linear interpolation of scipy and of GDAL, metres.
    pub linear: f64,
    /// Depth by natural neighbours from exact Voronoi areas (shapely), metres.
    pub natural: f64,
    /// Depth by inverse distance from all points with the power 2, metres.
    pub inverse_distance: f64,
}

pub(super) const GOLDEN: [Golden; 5] = [
    golden([2.5, 2.5], [3.496619061, 3.491639204, 3.431749553]),
    golden([5.05, 4.9], [3.000069591, 3.000115009, 3.009016375]),
    golden([7.3, 4.1], [2.548652625, 2.550912455, 2.627238773]),
    golden([4.2, 8.0], [3.416673559, 3.412847094, 3.280785839]),
    golden([6.6, 1.9], [3.058094229, 3.054620815, 3.056288273]),
];

const fn golden(place: [f64; 2], [linear, natural, inverse_distance]: [f64; 3]) -> Golden {
    Golden { place, linear, natural, inverse_distance }
}

pub(super) fn golden_points() -> Vec<DepthPoint> {
    let along = |i: i32, step: f64| (0.5 + step * f64::from(i)).fract() * 10.0;
    (0..60)
        .map(|i| {
            let x = along(i, 0.754_877_666_246_692_7);
            let y = along(i, 0.569_840_290_998_053_2);
            point(x, y, 3.0 + 0.5 * (x / 2.0).sin() + 0.3 * (y / 1.7).cos())
        })
        .collect()
}

pub(super) fn golden_nodes() -> Vec<Node> {
    merge_repeated(&golden_points(), 0.0)
}
