//! Creates targets for the unit tests of several modules.

use super::Target;
use crate::{Mark, ObjectExtent};
use bathyscope_log::support::geo::LonLat;
use bathyscope_log::survey::Side;

/// Creates a sighting at the survey's origin by a boat that heads north, without a height.
pub(crate) fn target() -> Target {
    Target {
        mark: Mark::new(Side::Port, 100..105, [1.0, 2.0]),
        extent: ObjectExtent::Found,
        measured_shadow: None,
        parts: None,
        slant_m: 5.0,
        ground_m: 4.0,
        altitude_m: 3.0,
        east_m: 0.0,
        north_m: 0.0,
        position: LonLat::new(0.0, 0.0),
        length_m: 0.6,
        width_m: 0.4,
        height_m: f64::NAN,
        shadow_m: [f64::NAN; 2],
        height_sigma_m: f64::NAN,
        depth_m: 3.0,
        sigma_m: 0.3,
        along_sigma_m: 0.3,
        across_sigma_m: 0.3,
        heading_rad: 0.0,
        sailed_m: 10.0,
    }
}
