//! Where a box's object lies in the world, and how large it is.
//!
//! `echo` finds the echo and the shadow inside a box, `place` puts them on the bottom, `passes` tells which passes of the
//! boat covered a place, `group` makes one object of the same object seen from several lines.

mod echo;
mod group;
mod passes;
mod place;

pub use echo::{Parts, parts};
pub use group::{Group, GroupSettings, group};
pub use passes::{Pass, passes_over};
pub use place::Placer;

use super::Mark;
use crate::geo::LonLat;

/// One box in the world. Metres; what cannot be known is NaN.
#[derive(Clone, Debug, PartialEq)]
pub struct Target {
    /// The box.
    pub mark: Mark,
    /// Slant range of the middle of the echo, by the calibration in force.
    pub slant_m: f64,
    /// Distance from the track to the middle of the object, on the bottom.
    pub ground_m: f64,
    /// Height of the transducer above the bottom.
    pub altitude_m: f64,
    /// Middle of the object, metres east of the survey's origin.
    pub east_m: f64,
    /// Middle of the object, metres north of the survey's origin.
    pub north_m: f64,
    /// Middle of the object.
    pub position: LonLat,
    /// Extent along the track, the width of the beam taken off.
    pub length_m: f64,
    /// Extent of what is seen of it across the track.
    pub width_m: f64,
    /// Height above the bottom from the length of the shadow; NaN without a shadow that ends within the range.
    pub height_m: f64,
    /// Depth of the bottom below the transducer.
    pub depth_m: f64,
    /// Standard deviation of the position in any direction. It holds the resolution in range, the heading and the rounding
    /// of the fixes, not the receiver's own error, which is the same for all objects of a line.
    pub sigma_m: f64,
    /// Distance sailed up to the middle of the box.
    pub sailed_m: f64,
}
