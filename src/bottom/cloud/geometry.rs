//! Place of a first return, seen from the boat.

use super::Geometry;
use bathyscope_log::survey::{PingNav, Side};

/// A place on the bottom, seen from the boat.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BottomPoint {
    /// Depth below the transducer, metres.
    pub depth_m: f64,
    /// Distance out to the beam's own side, metres.
    pub across_m: f64,
}

/// The bottom point of a first return at slant range `range_m` in the geometries that need nothing
/// but the range.
///
/// - published: `z = r cos(alpha_2)`, `y = r sin(alpha_2)`, equations (5) and (6) of the paper;
/// - self-consistent: with `PPD' = p_0 cos(alpha_2) / d_0` in place of `p_0 / d_0` the published
///   equations give back the depth they were calibrated on: `z = r`, `y = r tan(alpha_2)` in terms
///   of the unchanged range;
/// - nadir, and [`Geometry::Slope`] before the slope is known: `z = r`, `y = 0`.
pub fn fixed_bottom_point(geometry: Geometry, range_m: f64, alpha2_deg: f64) -> BottomPoint {
    let (sin, cos) = alpha2_deg.to_radians().sin_cos();
    let (depth_m, across_m) = match geometry {
        Geometry::Published => (range_m * cos, range_m * sin),
        Geometry::SelfConsistent => (range_m, range_m * sin / cos),
        Geometry::Nadir | Geometry::Slope => (range_m, 0.0),
    };
    BottomPoint { depth_m, across_m }
}

/// The place `across_m` out to one side of the boat; `None` without heading or position.
pub fn across_track(place: &PingNav, side: Side, across_m: f64) -> Option<[f64; 2]> {
    place.abeam(side, across_m).filter(|[east_m, _]| east_m.is_finite())
}
