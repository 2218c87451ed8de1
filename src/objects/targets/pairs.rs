//! Finds pairs of sightings that may be of the same object, by the uncertainty of their places.

use super::Target;

/// Limits of the distance sailed, metres, and of the change of heading, radians, below which two
/// sightings on the same side are of one pass: a boat that goes straight on passes an object once.
const ONE_PASS_M: f64 = 8.0;
const ONE_PASS_RAD: f64 = 0.35;
/// Difference between the near edges of two boxes on the same ping above which they show two
/// objects, metres.
const SAME_ECHO_M: f64 = 0.5;
/// Penalty for different classes, in squared standard deviations: `-2 ln` of the rate at which a
/// detector proposes a wrong class.
const OTHER_CLASS: f64 = 3.0;
/// Standard deviation of the middle of the visible part of an object, seen from different sides, as
/// a share of the object's extent; and the largest extent that is used, metres.
const SIZE_SIGMA: f64 = 0.2;
const LARGEST_M: f64 = 4.0;

/// Limits of the distance between two sightings of one object.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GroupSettings {
    /// Greatest distance between sightings of one object, in standard deviations of their joint
    /// uncertainty.
    pub sigmas: f64,
    /// Standard deviation of the receiver's own position between lines, metres, which
    /// [`Target::sigma_m`] does not include.
    pub receiver_sigma_m: f64,
    /// Standard deviation of the position of a whole log, metres, due to another day or another
    /// receiver. It is used between sightings of different logs.
    pub log_sigma_m: f64,
}

impl Default for GroupSettings {
    fn default() -> Self {
        Self { sigmas: 3.0, receiver_sigma_m: 0.3, log_sigma_m: 1.0 }
    }
}

/// A box that may show the same object as other boxes.
#[derive(Clone, Copy, Debug)]
pub struct Sighting<'a> {
    /// Index of the log of the box; places of all logs are in one plane.
    pub log: usize,
    /// Position and size of the box.
    pub target: &'a Target,
    /// Class of the object; `None` where it is not known.
    pub class: Option<usize>,
    /// Score of the box, 0 to 1.
    pub score: f64,
}

/// Covariance of a place, square metres: variance east, covariance of east and north, variance
/// north.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct PositionCovariance {
    east: f64,
    both: f64,
    north: f64,
}

impl PositionCovariance {
    /// Creates a covariance that is the same in every direction.
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

    fn determinant(self) -> f64 {
        self.east * self.north - self.both * self.both
    }

    /// Returns the inverse covariance, which is the weight of a place in a mean.
    pub(super) fn inverse(self) -> Self {
        let scale = self.determinant().max(f64::MIN_POSITIVE).recip();
        Self { east: scale * self.north, both: -scale * self.both, north: scale * self.east }
    }

    /// Returns the product with a vector.
    pub(super) fn times(self, [east_m, north_m]: [f64; 2]) -> [f64; 2] {
        [self.east * east_m + self.both * north_m, self.both * east_m + self.north * north_m]
    }

    /// Returns the squared distance in standard deviations (Mahalanobis).
    pub(super) fn squared_sigmas(self, apart_m: [f64; 2]) -> f64 {
        let [east, north] = self.inverse().times(apart_m);
        east * apart_m[0] + north * apart_m[1]
    }

    /// Returns the standard deviation in the direction in which it is largest, metres.
    pub(super) fn widest_m(self) -> f64 {
        let middle = 0.5 * (self.east + self.north);
        let swing = (0.5 * (self.east - self.north)).hypot(self.both);
        (middle + swing).sqrt()
    }
}

/// Returns true if one pass saw the two sightings as separate objects. In a turn, a side sweeps
/// over the same place again, and under the boat both sides detect it; two boxes at the same time
/// and range, over the same echo or two halves of it, are not two objects.
pub(super) fn same_pass(one: &Sighting<'_>, other: &Sighting<'_>) -> bool {
    if one.log != other.log {
        return false;
    }
    let (a, b) = (one.target, other.target);
    if a.mark.side != b.mark.side {
        return false;
    }
    if a.mark.pings.start <= b.mark.pings.end && b.mark.pings.start <= a.mark.pings.end {
        return (a.mark.near_m - b.mark.near_m).abs() > SAME_ECHO_M;
    }
    let straight = (a.heading_rad - b.heading_rad).cos() > ONE_PASS_RAD.cos();
    straight && (a.sailed_m - b.sailed_m).abs() < ONE_PASS_M
}

/// Returns the standard deviation, due to the object's size, of the distance between the middle of
/// the visible part and the middle of the object, metres.
pub(super) fn size_m(target: &Target) -> f64 {
    let size_m = target.length_m.max(target.width_m);
    // The size of a point is not known, but its uncertainty includes how far it may be off.
    if size_m.is_nan() { 0.0 } else { SIZE_SIGMA * size_m.min(LARGEST_M) }
}

/// Returns the squared distance of two sightings in standard deviations (larger if their classes
/// differ), and their joint covariance.
fn apart(
    a: &Sighting<'_>,
    b: &Sighting<'_>,
    settings: &GroupSettings,
) -> (f64, PositionCovariance) {
    let size_m = size_m(a.target).max(size_m(b.target));
    let of_logs = if a.log == b.log { 0.0 } else { 2.0 * settings.log_sigma_m.powi(2) };
    let either = 2.0 * settings.receiver_sigma_m.powi(2) + of_logs + size_m * size_m;
    let spread = PositionCovariance::of(a.target)
        .plus(PositionCovariance::of(b.target))
        .plus(PositionCovariance::round(either));
    let off_m = [a.target.east_m - b.target.east_m, a.target.north_m - b.target.north_m];
    let confused = match (a.class, b.class) {
        (Some(a), Some(b)) if a != b => OTHER_CLASS,
        _ => 0.0,
    };
    (spread.squared_sigmas(off_m) + confused, spread)
}

/// Returns the pairs that may be one object, the likeliest first. The order is by `d^2 + ln det S`,
/// so that two certain sightings come before an uncertain one that fits anything.
pub(super) fn pairs(sightings: &[Sighting<'_>], settings: &GroupSettings) -> Vec<(usize, usize)> {
    let mut by_east: Vec<usize> = (0..sightings.len()).collect();
    by_east.sort_by(|&a, &b| {
        let [a, b] = [a, b].map(|index| sightings[index].target.east_m);
        a.total_cmp(&b)
    });
    let of_one_log = sightings.iter().all(|sighting| sighting.log == sightings[0].log);
    let log_sigma_m = if of_one_log { 0.0 } else { settings.log_sigma_m };
    let reach_m = |sighting: &Sighting<'_>| {
        let receiver_sigma_m = settings.receiver_sigma_m.hypot(log_sigma_m);
        let sigma_m = sighting.target.sigma_m.hypot(receiver_sigma_m);
        settings.sigmas * (sigma_m + size_m(sighting.target))
    };
    let widest_m = 2.0 * sightings.iter().map(reach_m).fold(0.0, f64::max);
    let mut pairs = Vec::new();
    for (place, &a) in by_east.iter().enumerate() {
        let one = &sightings[a];
        let near = by_east[place + 1..]
            .iter()
            .take_while(|&&b| sightings[b].target.east_m - one.target.east_m <= widest_m);
        for &b in near {
            let other = &sightings[b];
            let (squared, spread) = apart(one, other, settings);
            if squared < settings.sigmas * settings.sigmas && !same_pass(one, other) {
                let unlikely = squared + spread.determinant().ln();
                pairs.push((unlikely, a.min(b), a.max(b)));
            }
        }
    }
    pairs.sort_by(|one, other| {
        one.0.total_cmp(&other.0).then((one.1, one.2).cmp(&(other.1, other.2)))
    });
    pairs.into_iter().map(|(_, a, b)| (a, b)).collect()
}
