//! The survey's east-north plane.

use super::LonLat;

/// Equatorial radius of WGS84, metres.
pub(super) const A_M: f64 = 6_378_137.0;
/// Flattening of WGS84.
const F: f64 = 1.0 / 298.257_223_563;
/// First eccentricity squared of WGS84.
pub(super) const E2: f64 = F * (2.0 - F);

/// A local east-north frame tangent to the WGS84 ellipsoid at an origin (height 0).
///
/// Positions go through earth-centred coordinates, so that metres are metres on the ground in every
/// direction (a scaled Mercator is wrong by up to 4 m a kilometre). The third, vertical coordinate
/// is dropped: depths are measured from the water surface, which curves with the Earth.
#[derive(Clone, Debug)]
pub struct LocalFrame {
    origin: LonLat,
    /// Earth-centred position of the origin, metres.
    centre: [f64; 3],
    east: [f64; 3],
    north: [f64; 3],
    up: [f64; 3],
}

impl LocalFrame {
    /// A frame with its origin at `origin`.
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

    /// Metres east and north of the origin.
    pub fn to_enu(&self, position: LonLat) -> [f64; 2] {
        let at = earth_centred(position);
        let offset = [0, 1, 2].map(|axis| at[axis] - self.centre[axis]);
        [dot(self.east, offset), dot(self.north, offset)]
    }

    /// Inverse of [`LocalFrame::to_enu`]: the point of the ellipsoid above or below that place of
    /// the plane. Beyond the horizon of the origin (thousands of kilometres) the nearest direction
    /// is returned.
    pub fn to_lon_lat(&self, east_m: f64, north_m: f64) -> LonLat {
        let offset = [0, 1, 2].map(|axis| self.east[axis] * east_m + self.north[axis] * north_m);
        let drop = self.height_of_surface(offset);
        let [x, y, z] =
            [0, 1, 2].map(|axis| self.centre[axis] + offset[axis] + drop * self.up[axis]);
        // At height 0 the geodetic latitude has a closed form.
        LonLat::new(y.atan2(x).to_degrees(), z.atan2((1.0 - E2) * x.hypot(y)).to_degrees())
    }

    /// Direction of true north at a position, radians clockwise from the frame's north: 0 on the
    /// meridian of the origin, and 0.3 degrees 20 km east of it at 60 degrees north.
    pub(crate) fn true_north_rad(&self, position: LonLat) -> f64 {
        let (sin_lon, cos_lon) = position.lon_deg.to_radians().sin_cos();
        let (sin_lat, cos_lat) = position.lat_deg.to_radians().sin_cos();
        let north = [-sin_lat * cos_lon, -sin_lat * sin_lon, cos_lat];
        dot(self.east, north).atan2(dot(self.north, north))
    }

    /// Height of the ellipsoid above (negative: below) the tangent plane at `offset` from the
    /// origin.
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

/// Metres from the centre of the Earth of a position on the ellipsoid.
pub(super) fn earth_centred(position: LonLat) -> [f64; 3] {
    let (sin_lon, cos_lon) = position.lon_deg.to_radians().sin_cos();
    let (sin_lat, cos_lat) = position.lat_deg.to_radians().sin_cos();
    let normal_m = A_M / (1.0 - E2 * sin_lat * sin_lat).sqrt();
    [normal_m * cos_lat * cos_lon, normal_m * cos_lat * sin_lon, normal_m * (1.0 - E2) * sin_lat]
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
