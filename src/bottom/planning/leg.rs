//! A straight line to sail.

use super::turns::TurnPose;

/// A straight line, from its start to its end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Leg {
    /// Metres east and north.
    pub from: [f64; 2],
    /// Metres east and north.
    pub to: [f64; 2],
}

impl Leg {
    /// Metres.
    pub fn length_m(&self) -> f64 {
        apart_m(self.from, self.to)
    }

    /// Radians clockwise from north.
    pub fn heading_rad(&self) -> f64 {
        let [east, north] = self.way();
        east.atan2(north)
    }

    /// The same line sailed the other way.
    #[must_use]
    pub fn turned(self) -> Self {
        Self { from: self.to, to: self.from }
    }

    /// Place and course at its start.
    pub(super) fn start(&self) -> TurnPose {
        self.pose(self.from)
    }

    /// Place and course at its end.
    pub(super) fn end(&self) -> TurnPose {
        self.pose(self.to)
    }

    fn pose(&self, place: [f64; 2]) -> TurnPose {
        let [east, north] = self.way();
        TurnPose { place, course_rad: north.atan2(east) }
    }

    fn way(&self) -> [f64; 2] {
        [self.to[0] - self.from[0], self.to[1] - self.from[1]]
    }
}

/// Distance of two places, metres.
pub(super) fn apart_m(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}
