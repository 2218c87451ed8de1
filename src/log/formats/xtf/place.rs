//! Positions, in degrees or in metres of an unknown projection.

use crate::support::geo::{LonLat, distance_m};
use crate::survey::ProjectedTrack;

/// Navigation units of the file header that are degrees.
pub(super) const DEGREES: u16 = 3;

/// Turns the positions of a file into degrees.
#[derive(Debug)]
pub(super) struct PositionConverter {
    units: Option<u16>,
    /// First projected position, where positions are in metres.
    origin: Option<[f64; 2]>,
}

impl PositionConverter {
    /// `units` as the file header has them; `None` when the header is damaged. `origin` is that of
    /// a log whose tail is read.
    pub(super) fn new(units: Option<u16>, origin: Option<[f64; 2]>) -> Self {
        Self { units, origin }
    }

    /// Easting and northing of the place that stands at longitude 0, latitude 0, where positions
    /// were metres of a system that is not named.
    pub(super) fn origin_m(&self) -> Option<[f64; 2]> {
        self.origin
    }

    /// Returns true if a position is in degrees: some programs write degrees and state metres.
    fn is_degrees(&self, [x, y]: [f64; 2]) -> bool {
        let fits_degrees = x.abs() <= 180.0 && y.abs() <= 90.0;
        self.units == Some(DEGREES) || (self.origin.is_none() && fits_degrees)
    }

    /// Distance between two recorded positions, metres.
    pub(super) fn apart_m(&self, one: [f64; 2], other: [f64; 2]) -> f64 {
        let [[x, y], [other_x, other_y]] = [one, other];
        if self.is_degrees(one) && self.is_degrees(other) {
            distance_m(LonLat::new(x, y), LonLat::new(other_x, other_y))
        } else {
            (x - other_x).hypot(y - other_y)
        }
    }

    /// The place of a recorded position.
    pub(super) fn place(&mut self, [x, y]: [f64; 2]) -> LonLat {
        if self.is_degrees([x, y]) {
            return LonLat::new(x, y);
        }
        let [x0, y0] = *self.origin.get_or_insert([x, y]);
        ProjectedTrack::frame().to_lon_lat(x - x0, y - y0)
    }
}

/// A position, if it was recorded: 0 stands for none.
pub(super) fn recorded([x, y]: [f64; 2]) -> Option<[f64; 2]> {
    (x.is_finite() && y.is_finite() && x != 0.0 && y != 0.0).then_some([x, y])
}
