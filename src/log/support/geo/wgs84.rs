//! WGS84: its metres in a degree, and its degrees as the beginning or the end of a projection.

use super::LonLat;
use proj4rs::{Proj, transform::transform};
use std::sync::LazyLock;

/// Metres on WGS84 in a degree of longitude and of latitude: radii of the prime vertical and of the
/// meridian.
pub fn metres_per_degree(at: LonLat) -> [f64; 2] {
    const A_M: f64 = 6_378_137.0;
    const F: f64 = 1.0 / 298.257_223_563;
    let (sin, cos) = at.lat_deg.to_radians().sin_cos();
    let e2 = F * (2.0 - F);
    let w2 = 1.0 - e2 * sin * sin;
    let vertical_m = A_M / w2.sqrt();
    let meridian_m = vertical_m * (1.0 - e2) / w2;
    // At a pole all longitudes are one place: any width will do.
    [(vertical_m * cos).max(1.0), meridian_m].map(f64::to_radians)
}

/// Longitude and latitude on WGS84, radians.
#[allow(clippy::expect_used, reason = "a text that a test reads")]
pub(super) fn wgs84() -> &'static Proj {
    static WGS84_RADIANS: LazyLock<Proj> = LazyLock::new(|| {
        let made = Proj::from_proj_string("+proj=longlat +datum=WGS84 +no_defs");
        made.expect("the words are those of the library's own documentation")
    });
    &WGS84_RADIANS
}

/// Some coordinates of one system in another; NaN where that does not reach.
pub(super) fn transformed(from: &Proj, to: &Proj, [x, y]: [f64; 2]) -> [f64; 2] {
    let mut point = (x, y, 0.0);
    match transform(from, to, &mut point) {
        Ok(()) => [point.0, point.1],
        Err(_) => [f64::NAN; 2],
    }
}
