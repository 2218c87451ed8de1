//! Determines the place of a box's object in the world, and its size.
//!
//! In: boxes of a survey, with its navigation and calibration. Out: places, sizes and shapes of
//! objects.
//!
//! `echo` finds the echo and the shadow inside a box (`profile` has the levels and the edges),
//! `seen` makes distances and a height of them, `shadow` a height of a shadow that the analyst
//! measures, `place` puts them on the bottom, `passes` tells which passes of the boat covered a
//! place, `group` makes one object of the same object seen from several lines (`pairs` says which
//! sightings may be one, and how sure their places are), `object_height` makes one height of all
//! their heights, `shape` fits a solid to what they recorded of it.

mod echo;
mod group;
mod object_height;
mod pairs;
mod passes;
mod place;
mod profile;
mod seen;
mod shadow;
mod shape;
#[cfg(test)]
pub(crate) mod testing;

pub use echo::{Parts, TopShape, parts};
pub use group::{Group, group};
pub use object_height::{HeightSource, ObjectHeight};
pub use pairs::{GroupSettings, Sighting};
pub(crate) use passes::count_seen;
pub use passes::{LogPings, PassCount, PassLog, passes_over};
pub use place::Placer;
pub use shadow::{ShadowError, ShadowHeight};
pub use shape::{
    BoxLevels, FittedShape, PosedSolid, ShapeError, ShapeKind, ShapeOnPing, Solid, fit_shape,
};

use super::{Mark, MeasuredShadow, ObjectExtent};
use bathyscope_log::support::geo::LonLat;

/// One box in the world. Metres; what cannot be known is NaN.
#[derive(Clone, Debug, PartialEq)]
pub struct Target {
    /// The box.
    pub mark: Mark,
    /// Source of its extent.
    pub extent: ObjectExtent,
    /// The shadow that the analyst has measured, which tells the height then.
    pub measured_shadow: Option<MeasuredShadow>,
    /// Echo and shadow in the box, by the recorder's scale; `None` of a point, and where nothing
    /// was found.
    pub parts: Option<Parts>,
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
    /// ObjectExtent along the track, the width of the beam taken off; NaN of a point.
    pub length_m: f64,
    /// ObjectExtent of what is seen of it across the track; NaN of a point.
    pub width_m: f64,
    /// Height above the bottom from the length of the longest shadow; NaN without a shadow that
    /// ends within the range. Of a round top it is that of the far flank where the last ray touches
    /// it.
    pub height_m: f64,
    /// Slant ranges of start and end of that shadow by the calibration in force: the height is the
    /// altitude times what lies between them, over the end. The start is NaN without a shadow, the
    /// end where it runs off the range.
    pub shadow_m: [f64; 2],
    /// Standard deviation of the height; NaN without a height. It holds how sharp both ends of the
    /// shadow are, how far its end is from the box's, a bottom that slopes by two degrees, and a
    /// top that may be flat or round. What casts no shadow of its own (the far side of a wide
    /// object, a branch in the shadow of the trunk) cannot be known.
    pub height_sigma_m: f64,
    /// Depth of the bottom below the transducer; below the level that depths count from, once the
    /// pipeline has corrected it.
    pub depth_m: f64,
    /// Standard deviation of the position in the worse direction. It holds the resolution in range,
    /// the heading and the rounding of the fixes, not the receiver's own error, which is the same
    /// for all objects of a line.
    pub sigma_m: f64,
    /// The same along the track: the heading times the distance, worst in turns.
    pub along_sigma_m: f64,
    /// The same across the track: edges, altitude and height, worst under the boat.
    pub across_sigma_m: f64,
    /// Heading of the boat in the middle of the box, radians clockwise from north.
    pub heading_rad: f64,
    /// Distance sailed up to the middle of the box.
    pub sailed_m: f64,
}

impl Target {
    /// Corners of its footprint, metres east and north: length along the track, width across it.
    /// What is not known counts as nothing: those of a point all lie in its place.
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
