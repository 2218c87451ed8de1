//! Computes on the ellipsoid of WGS84: the local east-north plane of a survey, metres in a degree,
//! and lengths, courses and areas of lines that a user draws.

use super::LonLat;
use crate::support::outline::edges;

/// Equatorial radius of WGS84, metres.
const A_M: f64 = 6_378_137.0;
/// Flattening of WGS84.
const F: f64 = 1.0 / 298.257_223_563;
/// First eccentricity squared of WGS84.
const E2: f64 = F * (2.0 - F);

/// A local coordinate frame, east and north, tangent to the WGS84 ellipsoid at an origin (height
/// 0).
///
/// Positions are converted through earth-centred coordinates, so that its metres are metres on the
/// ground in every direction (a scaled Mercator is wrong by up to 4 m a kilometre). The third,
/// vertical coordinate is dropped: depths are measured from the water surface, which curves with
/// the Earth.
#[derive(Clone, Debug)]
pub struct LocalFrame {
    origin: LonLat,
    /// Earth-centred position of the origin, metres.
    centre: [f64; 3],
    east: [f64; 3],
    north: [f64; 3],
    up: [f64; 3],
}

impl Default for LocalFrame {
    /// Creates the frame at longitude 0, latitude 0.
    fn default() -> Self {
        Self::new(LonLat::new(0.0, 0.0))
    }
}

impl LocalFrame {
    /// Creates the frame with its origin at `origin`.
    pub fn new(origin: LonLat) -> Self {
        let (sin_lon, cos_lon) = origin.lon_deg.to_radians().sin_cos();
        let (sin_lat, cos_lat) = origin.lat_deg.to_radians().sin_cos();
        Self {
            origin,
            centre: earth_centred(origin),
            east: [-sin_lon, cos_lon, 0.0],
            north: [-sin_lat * cos_lon, -sin_lat * sin_lon, cos_lat],
            up: [cos_lat * cos_lon, cos_lat * sin_lon, sin_lat],
        }
    }

    /// Returns the position where east and north are zero.
    pub fn origin(&self) -> LonLat {
        self.origin
    }

    /// Returns the place of a position, metres east and north of the origin.
    pub fn to_enu(&self, position: LonLat) -> [f64; 2] {
        let at = earth_centred(position);
        let offset = [0, 1, 2].map(|axis| at[axis] - self.centre[axis]);
        [dot(self.east, offset), dot(self.north, offset)]
    }

    /// Inverse of [`LocalFrame::to_enu`]: returns the point of the ellipsoid above or below a place
    /// of the plane. For a place beyond the horizon of the origin (thousands of kilometres) the
    /// point in the nearest direction is returned.
    pub fn to_lon_lat(&self, east_m: f64, north_m: f64) -> LonLat {
        let offset = [0, 1, 2].map(|axis| self.east[axis] * east_m + self.north[axis] * north_m);
        let drop = self.height_of_surface(offset);
        let [x, y, z] =
            [0, 1, 2].map(|axis| self.centre[axis] + offset[axis] + drop * self.up[axis]);
        // At height 0 the geodetic latitude has a closed form.
        LonLat::new(y.atan2(x).to_degrees(), z.atan2((1.0 - E2) * x.hypot(y)).to_degrees())
    }

    /// Returns the direction of true north at a position, radians clockwise from the frame's north:
    /// 0 on the meridian of the origin, and 0.3 degrees at 20 km east of the origin at 60 degrees
    /// north.
    pub(crate) fn true_north_rad(&self, position: LonLat) -> f64 {
        let north = Self::new(position).north;
        dot(self.east, north).atan2(dot(self.north, north))
    }

    /// Returns the height of the ellipsoid above (negative: below) the tangent plane at `offset`
    /// from the origin.
    ///
    /// In axes scaled to a unit sphere, `|centre + offset + u up| = 1` is a quadratic in `u`;
    /// `|centre| = 1` cancels, so that nothing large is subtracted.
    fn height_of_surface(&self, offset: [f64; 3]) -> f64 {
        let scale = [1.0 / A_M, 1.0 / A_M, 1.0 / (A_M * (1.0 - F))];
        let unit = |vector: [f64; 3]| [0, 1, 2].map(|axis| vector[axis] * scale[axis]);
        let (centre, offset, up) = (unit(self.centre), unit(offset), unit(self.up));
        let a = dot(up, up);
        let half_b = dot(up, centre) + dot(up, offset);
        let c = 2.0 * dot(centre, offset) + dot(offset, offset);
        -c / (half_b + (half_b * half_b - a * c).max(0.0).sqrt())
    }
}

/// Returns the metres on WGS84 in a degree of longitude and of latitude, from the radii of the
/// prime vertical and of the meridian.
pub fn metres_per_degree(at: LonLat) -> [f64; 2] {
    let (sin, cos) = at.lat_deg.to_radians().sin_cos();
    let w2 = 1.0 - E2 * sin * sin;
    let vertical_m = A_M / w2.sqrt();
    let meridian_m = vertical_m * (1.0 - E2) / w2;
    // At a pole a degree of longitude has no width; 1 m avoids a division by zero.
    [(vertical_m * cos).max(1.0), meridian_m].map(f64::to_radians)
}

/// Returns the degrees from one meridian east to another, -180 to 180: across the antimeridian
/// 179.9 and -179.9 are neighbours.
pub(crate) fn east_of_deg(from_deg: f64, to_deg: f64) -> f64 {
    let east_deg = to_deg - from_deg;
    east_deg - 360.0 * (east_deg / 360.0).round()
}

/// Returns the metres along the shortest line on WGS84 between two positions.
///
/// The chord between the positions is bent to the ellipsoid's curvature in its direction at its
/// middle (Euler's radius): accurate within 0.1 mm of the geodesic up to 20 km and within a
/// millionth up to 500 km.
pub fn distance_m(from: LonLat, to: LonLat) -> f64 {
    let ends = [from, to].map(earth_centred);
    let squares = [0, 1, 2].map(|axis| (ends[1][axis] - ends[0][axis]).powi(2));
    let chord_m = squares.iter().sum::<f64>().sqrt();
    let middle = middle([from, to].into_iter());
    let frame = LocalFrame::new(middle);
    let [a, b] = [from, to].map(|at| frame.to_enu(at));
    let [east_m, north_m] = [b[0] - a[0], b[1] - a[1]];
    let sin_lat = middle.lat_deg.to_radians().sin();
    let bend = 1.0 - E2 * sin_lat * sin_lat;
    let across_m = A_M / bend.sqrt();
    let along_m = across_m * (1.0 - E2) / bend;
    let north_share = (north_m / east_m.hypot(north_m).max(f64::MIN_POSITIVE)).powi(2);
    let radius_m = 1.0 / (north_share / along_m + (1.0 - north_share) / across_m);
    2.0 * radius_m * (0.5 * chord_m / radius_m).min(1.0).asin()
}

/// Returns the initial course from one position to another, radians clockwise from north, 0 to 2
/// pi; NaN where they coincide.
pub fn course_rad(from: LonLat, to: LonLat) -> f64 {
    let [east_m, north_m] = LocalFrame::new(from).to_enu(to);
    if east_m == 0.0 && north_m == 0.0 {
        f64::NAN
    } else {
        east_m.atan2(north_m).rem_euclid(std::f64::consts::TAU)
    }
}

/// Returns the square metres inside a closed line on WGS84, whichever way round it runs; where the
/// line crosses itself, the areas of loops of opposite sense are subtracted.
///
/// The area is computed by the shoelace formula in the plane that touches the ellipsoid at the
/// middle of the corners; at a distance `d` from there lengths shrink by `(d / 6371 km)^2 / 2`,
/// which is an error of a ten-millionth of the area of a polygon 5 km across.
pub fn area_m2(corners: &[LonLat]) -> f64 {
    let frame = LocalFrame::new(middle(corners.iter().copied()));
    let places: Vec<[f64; 2]> = corners.iter().map(|at| frame.to_enu(*at)).collect();
    let twice = edges(&places).map(|[a, b]| a[0] * b[1] - b[0] * a[1]);
    0.5 * twice.sum::<f64>().abs()
}

/// Converts a direction to degrees clockwise from north, rounded to some decimals; at least 0 and
/// below 360 after the rounding. NaN stays NaN.
pub fn compass_deg(heading_rad: f64, decimals: i32) -> f64 {
    let parts = 10_f64.powi(decimals);
    let whole = (heading_rad.to_degrees() * parts).round();
    // Adding 0 makes a -0 a 0.
    whole.rem_euclid(360.0 * parts) / parts + 0.0
}

/// Returns the earth-centred coordinates of a position on the ellipsoid, metres.
fn earth_centred(position: LonLat) -> [f64; 3] {
    let (sin_lon, cos_lon) = position.lon_deg.to_radians().sin_cos();
    let (sin_lat, cos_lat) = position.lat_deg.to_radians().sin_cos();
    let normal_m = A_M / (1.0 - E2 * sin_lat * sin_lat).sqrt();
    [normal_m * cos_lat * cos_lon, normal_m * cos_lat * sin_lon, normal_m * (1.0 - E2) * sin_lat]
}

/// Returns the mean of some positions, which may be on both sides of the date line; an arbitrary
/// position where there are none.
fn middle(positions: impl Iterator<Item = LonLat> + Clone) -> LonLat {
    let count = positions.clone().count().max(1) as f64;
    let first_deg = positions.clone().next().map_or(0.0, |at| at.lon_deg);
    let beyond = positions.clone().map(|at| east_of_deg(first_deg, at.lon_deg));
    LonLat::new(
        first_deg + beyond.sum::<f64>() / count,
        positions.map(|at| at.lat_deg).sum::<f64>() / count,
    )
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_stay_below_a_full_turn() {
        assert_eq!(compass_deg(359.996_f64.to_radians(), 2), 0.0);
        assert_eq!(compass_deg(-90_f64.to_radians(), 2), 270.0);
        assert_eq!(format!("{:.0}", compass_deg(-0.001, 0)), "0");
        assert!(compass_deg(f64::NAN, 2).is_nan());
    }

    fn at((lon_deg, lat_deg): (f64, f64)) -> LonLat {
        LonLat { lon_deg, lat_deg }
    }

    #[test]
    fn lengths_and_courses_are_those_of_the_geodesic() {
        // pyproj 3.7.2: Geod(ellps="WGS84").inv.
        let goldens = [
            ((-111.5163, 36.8771), (-111.5151, 36.8779), 139.024288, 50.312474),
            ((-82.11, 29.41), (-82.05, 29.47), 8838.494947, 41.181638),
            ((10.3951, 63.4305), (10.3951, 63.6), 18894.129581, 0.0),
            ((179.98, -41.2), (-179.97, -41.15), 6959.703245, 37.090292),
            ((0.0, 0.0), (0.1, 0.0), 11131.949079, 90.0),
            ((5.0, 52.0), (5.9, 52.3), 70065.503774, 61.193237),
            ((20.0, 85.0), (25.0, 85.05), 48735.008113, 80.936023),
            ((-70.0, -33.0), (-66.5, -31.0), 398157.740439, 57.092822),
        ];
        for (from, to, length_m, course_deg) in goldens {
            let (from, to) = (at(from), at(to));
            let off_m = (distance_m(from, to) - length_m).abs();
            let allowed_m = if length_m < 20e3 { 1e-4 } else { 1e-6 * length_m };
            assert!(off_m < allowed_m, "{off_m} m of {length_m}");
            let off_deg = east_of_deg(course_deg, course_rad(from, to).to_degrees());
            assert!(off_deg.abs() < 1e-4 + 1e-8 * length_m, "{off_deg} of {course_deg}");
        }
        let here = at((5.0, 52.0));
        assert_eq!(distance_m(here, here), 0.0);
        assert!(course_rad(here, here).is_nan());
    }

    #[test]
    fn areas_are_those_between_geodesics() {
        // pyproj 3.7.2: Geod(ellps="WGS84").polygon_area_perimeter.
        let bend =
            [(-111.5163, 36.8771), (-111.5151, 36.8779), (-111.514, 36.8765), (-111.516, 36.876)];
        let date_line = [(179.98, -41.2), (-179.99, -41.2), (-179.99, -41.17), (179.98, -41.17)];
        let notched = [(5.0, 52.0), (5.07, 52.0), (5.07, 52.045), (5.03, 52.02), (5.0, 52.045)];
        let large = [(10.0, 63.0), (10.4, 63.0), (10.4, 63.2), (10.0, 63.2)];
        let goldens = [
            (&bend[..], 24289.7956, 1e-8),
            (&date_line[..], 8385900.2871, 2e-7),
            (&notched[..], 17378016.4188, 3e-7),
            (&large[..], 450303490.0111, 3e-6),
        ];
        for (corners, area, allowed) in goldens {
            let mut corners: Vec<LonLat> = corners.iter().copied().map(at).collect();
            let off = area_m2(&corners) / area - 1.0;
            assert!(off.abs() < allowed, "{off:e} of {area}");
            corners.reverse();
            assert!((area_m2(&corners) / area - 1.0).abs() < allowed);
        }
        assert_eq!(area_m2(&[]), 0.0);
        assert_eq!(area_m2(&[at((5.0, 52.0)), at((5.1, 52.0))]), 0.0);
    }
}
