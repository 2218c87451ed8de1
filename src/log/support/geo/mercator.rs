//! Spherical Mercators: EPSG:3857, Lowrance's, Humminbird's. All stretch the ground by about 1 /
//! cos(latitude).

use super::LonLat;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

/// Radius of the EPSG:3857 sphere: the equatorial radius of WGS84, metres.
const WEB_RADIUS_M: f64 = 6_378_137.0;
/// Radius of Lowrance's sphere: the polar radius of WGS84, metres.
const LOWRANCE_RADIUS_M: f64 = 6_356_752.314_2;
/// Radius of Humminbird's sphere: the equatorial radius of International 1924, metres.
const HUMMINBIRD_RADIUS_M: f64 = 6_378_388.0;
/// tan(geodetic latitude) / tan(spherical latitude) of Humminbird's logs, as its readers use it
/// (close to, but not exactly, (a / b) squared of International 1924).
const HUMMINBIRD_TAN_RATIO: f64 = 1.006_764_292_7;

/// EPSG:3857 x, y in metres: the geodetic latitude taken for a spherical one, as EPSG defines it.
pub fn web_mercator(position: LonLat) -> [f64; 2] {
    forward(position, WEB_RADIUS_M)
}

/// Inverse of [`web_mercator`].
pub fn web_mercator_inverse(x: f64, y: f64) -> LonLat {
    inverse(x, y, WEB_RADIUS_M)
}

/// Lowrance's Mercator (sphere of the WGS84 polar radius) to WGS84.
pub fn lowrance_mercator_inverse(x: f64, y: f64) -> LonLat {
    inverse(x, y, LOWRANCE_RADIUS_M)
}

/// WGS84 to Lowrance's Mercator metres (before the recorder's rounding).
pub fn lowrance_mercator(position: LonLat) -> [f64; 2] {
    forward(position, LOWRANCE_RADIUS_M)
}

/// Humminbird's Mercator (International 1924 sphere, then to geodetic latitude) to WGS84.
pub fn humminbird_mercator_inverse(x: f64, y: f64) -> LonLat {
    let spherical = inverse(x, y, HUMMINBIRD_RADIUS_M);
    let tangent = spherical.lat_deg.to_radians().tan() * HUMMINBIRD_TAN_RATIO;
    LonLat { lat_deg: tangent.atan().to_degrees(), ..spherical }
}

fn forward(position: LonLat, radius_m: f64) -> [f64; 2] {
    let half_colatitude = FRAC_PI_4 + position.lat_deg.to_radians() / 2.0;
    [radius_m * position.lon_deg.to_radians(), radius_m * half_colatitude.tan().ln()]
}

fn inverse(x: f64, y: f64, radius_m: f64) -> LonLat {
    LonLat::new(
        (x / radius_m).to_degrees(),
        (2.0 * (y / radius_m).exp().atan() - FRAC_PI_2).to_degrees(),
    )
}
