//! Converts positions between degrees on WGS84 and metres of several systems, and units to metres.
//!
//! In: positions in degrees or metres. Out: positions in another system, lengths, areas and
//! directions.
//!
//! `ellipsoid` has the east-north plane of a survey, and the lengths and areas of drawn lines.
//! `projections` has the spherical Mercators that recorders and the paper use, and UTM, the metres
//! that survey programs expect in a file. `coordinates` formats a position for people. `crs` has
//! these and the other systems that files are written in, and converts any of them to a plane in
//! metres.

mod coordinates;
mod crs;
mod ellipsoid;
mod projections;

pub use coordinates::CoordinateFormat;
pub use crs::{Crs, CrsChoice, CrsError, MapPlane, SourceCrs};
pub(crate) use ellipsoid::east_of_deg;
pub use ellipsoid::{LocalFrame, area_m2, compass_deg, course_rad, distance_m, metres_per_degree};
pub use projections::{
    UtmZone, humminbird_mercator_inverse, lowrance_mercator, lowrance_mercator_inverse,
    web_mercator, web_mercator_inverse,
};

use super::outline;

/// A WGS84 position in degrees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LonLat {
    /// Longitude, degrees, positive to the east.
    pub lon_deg: f64,
    /// Latitude, degrees, positive to the north.
    pub lat_deg: f64,
}

impl LonLat {
    /// Creates a position from its longitude and latitude, degrees.
    pub const fn new(lon_deg: f64, lat_deg: f64) -> Self {
        Self { lon_deg, lat_deg }
    }

    /// Returns true if the position exists: longitude within 180 degrees, latitude within 90.
    pub fn is_on_earth(&self) -> bool {
        (-180.0..=180.0).contains(&self.lon_deg) && (-90.0..=90.0).contains(&self.lat_deg)
    }
}

/// Returns west, south, east and north of some positions, degrees; without positions, a box that
/// meets no other. The positions have to be within half of the earth; across the antimeridian the
/// east is above 180.
pub fn bounds_deg(positions: impl Iterator<Item = LonLat>) -> [f64; 4] {
    let mut first_deg = None;
    let places = positions.map(|at| {
        let first_deg = *first_deg.get_or_insert(at.lon_deg);
        let turns = ((first_deg - at.lon_deg) / 360.0).round();
        [at.lon_deg + 360.0 * if turns.is_nan() { 0.0 } else { turns }, at.lat_deg]
    });
    let [west, south, east, north] = outline::bounds(places);
    if west < -180.0 {
        [west + 360.0, south, east + 360.0, north]
    } else {
        [west, south, east, north]
    }
}

/// Returns true if two boxes of [`bounds_deg`] share a place.
pub fn boxes_meet(one: [f64; 4], [west, south, east, north]: [f64; 4]) -> bool {
    let turned = |turn: f64| [west + turn, south, east + turn, north];
    [0.0, 360.0, -360.0].into_iter().any(|turn| outline::boxes_meet(one, turned(turn)))
}

/// Metres in an international foot.
pub const METRES_PER_FOOT: f64 = 0.3048;
/// Metres a second in a knot.
pub const MPS_PER_KNOT: f64 = 1852.0 / 3600.0;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_box_across_the_antimeridian_is_as_wide_as_its_places_lie_apart() {
        let at = |lons: &[f64]| lons.iter().map(|lon| LonLat::new(*lon, -17.5)).collect::<Vec<_>>();
        let of = |lons: &[f64]| bounds_deg(at(lons).into_iter());
        assert_eq!(of(&[8.5, 8.25]), [8.25, -17.5, 8.5, -17.5]);
        for lons in [[179.5, -179.5], [-179.5, 179.5]] {
            assert_eq!(of(&lons), [179.5, -17.5, 180.5, -17.5]);
        }
        let across = of(&[179.5, -179.5]);
        assert!(boxes_meet(across, of(&[-179.75, -179.25])));
        assert!(boxes_meet(of(&[-179.75, -179.25]), across));
        assert!(!boxes_meet(across, of(&[-179.25, -179.0])));
        assert!(!boxes_meet(across, bounds_deg(std::iter::empty())));
    }
}
