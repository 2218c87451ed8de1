//! Uncertainty of a place on the plane.

use super::Target;

/// Covariance of a place, square metres: of east, of both, of north.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct PositionCovariance {
    east: f64,
    both: f64,
    north: f64,
}

impl PositionCovariance {
    /// The same in every direction.
    pub(super) const fn round(variance_m2: f64) -> Self {
        Self { east: variance_m2, both: 0.0, north: variance_m2 }
    }

    /// Returns the covariance of a sighting, from its uncertainties along and across the heading of
    /// the boat.
    pub(super) fn of(target: &Target) -> Self {
        let (sin, cos) = target.heading_rad.sin_cos();
        let along = target.along_sigma_m.powi(2);
        let across = target.across_sigma_m.powi(2);
        Self {
            east: along * sin * sin + across * cos * cos,
            both: (along - across) * sin * cos,
            north: along * cos * cos + across * sin * sin,
        }
    }

    pub(super) fn plus(self, other: Self) -> Self {
        Self {
            east: self.east + other.east,
            both: self.both + other.both,
            north: self.north + other.north,
        }
    }

    pub(super) fn determinant(self) -> f64 {
        self.east * self.north - self.both * self.both
    }

    /// The information: what is known well weighs much.
    pub(super) fn inverse(self) -> Self {
        let scale = self.determinant().max(f64::MIN_POSITIVE).recip();
        Self { east: scale * self.north, both: -scale * self.both, north: scale * self.east }
    }

    /// The product with a vector.
    pub(super) fn times(self, [east_m, north_m]: [f64; 2]) -> [f64; 2] {
        [self.east * east_m + self.both * north_m, self.both * east_m + self.north * north_m]
    }

    /// Squared distance in standard deviations (Mahalanobis).
    pub(super) fn squared_sigmas(self, apart_m: [f64; 2]) -> f64 {
        let [east, north] = self.inverse().times(apart_m);
        east * apart_m[0] + north * apart_m[1]
    }

    /// Standard deviation in the direction in which it is largest, metres.
    pub(super) fn widest_m(self) -> f64 {
        let middle = 0.5 * (self.east + self.north);
        let swing = (0.5 * (self.east - self.north)).hypot(self.both);
        (middle + swing).sqrt()
    }
}
