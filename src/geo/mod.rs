//! WGS84 to local metres and back; the two Mercators that recorders and the paper use; units.

/// A WGS84 position in degrees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LonLat {
    /// East positive.
    pub lon_deg: f64,
    /// North positive.
    pub lat_deg: f64,
}

/// Metres in an international foot.
pub const METRES_PER_FOOT: f64 = 0.3048;
/// Metres a second in a knot.
pub const MPS_PER_KNOT: f64 = 1852.0 / 3600.0;

/// A local east-north frame tangent to the WGS84 ellipsoid at an origin (height 0).
#[derive(Clone, Debug)]
pub struct LocalFrame {
    origin: LonLat,
}

impl LocalFrame {
    /// A frame with its origin at `origin`.
    pub fn new(origin: LonLat) -> Self {
        Self { origin }
    }

    /// Where east and north are zero.
    pub fn origin(&self) -> LonLat {
        self.origin
    }

    /// Metres east and north of the origin.
    pub fn to_enu(&self, _position: LonLat) -> [f64; 2] {
        todo!()
    }

    /// Inverse of [`LocalFrame::to_enu`].
    pub fn to_lon_lat(&self, _east_m: f64, _north_m: f64) -> LonLat {
        todo!()
    }
}

/// EPSG:3857 x, y in metres.
pub fn web_mercator(_position: LonLat) -> [f64; 2] {
    todo!()
}

/// Inverse of [`web_mercator`].
pub fn web_mercator_inverse(_x: f64, _y: f64) -> LonLat {
    todo!()
}

/// Lowrance's Mercator (sphere of the WGS84 polar radius) to WGS84.
pub fn lowrance_mercator_inverse(_x: f64, _y: f64) -> LonLat {
    todo!()
}

/// WGS84 to Lowrance's Mercator metres (before the recorder's rounding).
pub fn lowrance_mercator(_position: LonLat) -> [f64; 2] {
    todo!()
}
