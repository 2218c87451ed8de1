//! The plane that maps are drawn in: metres, whatever the unit of the system.

use super::crs::area_scale;
use super::wgs84::metres_per_degree;
use super::{Crs, LonLat};

/// A system that stretches the ground by less than this has metres that are metres enough.
const LEAST_STRETCH: f64 = 0.02;

/// A coordinate reference system as a plane in metres. One in degrees, or a Mercator that stretches
/// the ground, is scaled to metres on the ground at the survey's origin, so that cells and gaps
/// mean the same in every system; a grid of square cells is then one of oblong cells in degrees.
#[derive(Clone, Debug, PartialEq)]
pub struct MapPlane {
    /// The system.
    pub crs: Crs,
    /// Units of the system in a metre of the plane, east and north.
    pub units: [f64; 2],
}

impl MapPlane {
    /// The plane of a system around an origin.
    pub fn new(crs: Crs, origin: LonLat) -> Self {
        let stretch = area_scale(&crs, origin).sqrt();
        let units = match crs.is_degrees() {
            true => metres_per_degree(origin).map(f64::recip),
            false if (stretch - 1.0).abs() > LEAST_STRETCH => [stretch; 2],
            false => [1.0, 1.0],
        };
        Self { crs, units }
    }

    /// Metres east and north in the plane.
    pub fn place(&self, position: LonLat) -> [f64; 2] {
        let place = self.crs.place(position);
        [0, 1].map(|axis| place[axis] / self.units[axis])
    }

    /// Inverse of [`MapPlane::place`].
    pub fn to_lon_lat(&self, place: [f64; 2]) -> LonLat {
        self.crs.to_lon_lat(self.in_crs(place))
    }

    /// A place in the units of the system.
    pub fn in_crs(&self, place: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|axis| place[axis] * self.units[axis])
    }

    /// Square metres of the plane in a square metre on the ground at a place.
    pub fn area_scale_at(&self, place: [f64; 2]) -> f64 {
        area_scale(&self.crs, self.to_lon_lat(place)) / (self.units[0] * self.units[1])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::support::geo::CrsChoice;

    #[test]
    fn area_scales_are_those_of_proj() {
        // pyproj 3.7.2: Proj(...).get_factors(-111.48, 36.86).areal_scale. That of web Mercator is
        // its area over that of Geod.polygon_area_perimeter: PROJ's factors leave the ellipsoid
        // out.
        let at = LonLat::new(-111.48, 36.86);
        for (choice, scale) in [
            (CrsChoice::Utm, 0.999_245_248),
            (CrsChoice::WebMercator, 1.0),
            (CrsChoice::Wgs84, 1.0),
            (CrsChoice::Epsg(6350), 1.0),
        ] {
            let plane = MapPlane::new(choice.at(at).unwrap(), at);
            let found = plane.area_scale_at(plane.place(at));
            assert!((found - scale).abs() < 1e-6, "{choice:?}: {found}");
        }
        let web = CrsChoice::WebMercator.at(at).unwrap();
        assert!((area_scale(&web, at) - 1.565_056).abs() < 1e-5);
    }
}
