//! Determines the position of a box's object in the world, its size, height and shape.
//!
//! In: boxes of a survey, with its navigation and calibration. Out: places, sizes and shapes of
//! objects.
//!
//! `echo` finds the echo and the shadow inside a box (`profile` computes the levels and the edges),
//! `seen` computes distances and a height from them, `shadow` computes a height from a shadow that
//! the analyst measures, `place` computes the position on the bottom, `passes` finds the passes of
//! the boat that covered a place, `group` joins sightings from several lines into one object,
//! `object_height` combines their heights into one, `shape` fits a solid to the recorded levels.

mod echo;
mod group;
mod object_height;
mod passes;
mod place;
mod profile;
mod seen;
mod shadow;
mod shape;

pub use echo::{Parts, TopShape, parts};
pub use group::{Group, Sighting, group};
pub use object_height::{HeightSource, ObjectHeight};
pub(crate) use passes::distinct_passes;
pub use passes::{LogPings, PassCount, PassLog, passes_over};
pub use place::Placer;
pub use shadow::{ShadowError, ShadowHeight};
pub use shape::{
    BoxLevels, FittedShape, PosedSolid, ShapeError, ShapeKind, ShapeOnPing, Solid, fit_shape,
};

use super::{Mark, MeasuredShadow, ObjectExtent};
use bathyscope_log::support::geo::LonLat;

/// Position and size of one box in the world. Metres; NaN if unknown.
#[derive(Clone, Debug, PartialEq)]
pub struct Target {
    /// The box.
    pub mark: Mark,
    /// Source of the extent of the object.
    pub extent: ObjectExtent,
    /// Shadow that the analyst has measured, which then determines the height; `None` if there is
    /// none.
    pub measured_shadow: Option<MeasuredShadow>,
    /// Echo and shadow in the box, in the recorder's scale; `None` for a point, and if none were
    /// found.
    pub parts: Option<Parts>,
    /// Slant range of the middle of the echo, by the current calibration.
    pub slant_m: f64,
    /// Distance from the track to the middle of the object, on the bottom.
    pub ground_m: f64,
    /// Height of the transducer above the bottom.
    pub altitude_m: f64,
    /// Middle of the object, metres east of the survey's origin.
    pub east_m: f64,
    /// Middle of the object, metres north of the survey's origin.
    pub north_m: f64,
    /// Middle of the object in longitude and latitude.
    pub position: LonLat,
    /// Extent along the track, less the width of the beam; NaN for a point.
    pub length_m: f64,
    /// Extent of the visible part across the track; NaN for a point.
    pub width_m: f64,
    /// Height above the bottom from the length of the longest shadow; NaN without a shadow that
    /// ends within the range. For a round top, it is the height at which the last ray touches the
    /// far flank.
    pub height_m: f64,
    /// Slant ranges of start and end of the longest shadow by the current calibration: the height
    /// is the altitude times the difference of the two, divided by the end. The start is NaN
    /// without a shadow; the end is NaN if the shadow continues beyond the range.
    pub shadow_m: [f64; 2],
    /// Standard deviation of the height; NaN without a height. It includes the sharpness of both
    /// ends of the shadow, the distance between its end and that of the box, a bottom that slopes
    /// by two degrees, and a top that may be flat or round. It does not include parts that cast no
    /// shadow of their own (the far side of a wide object, a branch in the shadow of the trunk).
    pub height_sigma_m: f64,
    /// Depth of the bottom below the transducer; once the pipeline has corrected it, below the
    /// level that depths are measured from.
    pub depth_m: f64,
    /// Standard deviation of the position in the worse direction. It includes the resolution in
    /// range, the heading and the rounding of the fixes, but not the receiver's own error, which is
    /// the same for all objects of a line.
    pub sigma_m: f64,
    /// Standard deviation of the position along the track: the heading error times the distance,
    /// worst in turns.
    pub along_sigma_m: f64,
    /// Standard deviation of the position across the track: edges, altitude and height, worst under
    /// the boat.
    pub across_sigma_m: f64,
    /// Heading of the boat in the middle of the box, radians clockwise from north.
    pub heading_rad: f64,
    /// Distance sailed up to the middle of the box.
    pub sailed_m: f64,
}

impl Target {
    /// Returns the corners of the footprint, metres east and north: length along the track, width
    /// across it. An unknown length or width counts as 0, so all corners of a point are at its
    /// place.
    pub fn corners(&self) -> [[f64; 2]; 4] {
        let (sin, cos) =
            if self.heading_rad.is_finite() { self.heading_rad.sin_cos() } else { (0.0, 1.0) };
        let half_m = |size_m: f64| if size_m.is_nan() { 0.0 } else { 0.5 * size_m };
        let [along_m, across_m] = [self.length_m, self.width_m].map(half_m);
        [(1.0, 1.0), (1.0, -1.0), (-1.0, -1.0), (-1.0, 1.0)].map(|(ahead, right)| {
            let (along_m, across_m) = (ahead * along_m, right * across_m);
            [
                self.east_m + along_m * sin + across_m * cos,
                self.north_m + along_m * cos - across_m * sin,
            ]
        })
    }
}
