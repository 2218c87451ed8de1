//! Finds pairs of sightings that may be of the same object, by the uncertainty of their places.

use super::Target;

/// Two sightings of one side that lie along the track by less than this, metres sailed, with less
/// change of heading than this, radians, are of one pass: a boat that goes straight on passes a
/// thing once.
const ONE_PASS_M: f64 = 8.0;
const ONE_PASS_RAD: f64 = 0.35;
/// Echoes that one ping receives begin at least so far apart where they are of two objects, metres.
const SAME_ECHO_M: f64 = 0.5;
/// Penalty for different classes in squared standard deviations: `-2 ln` of the rate at which a
/// detector takes an object for one of another class.
const OTHER_CLASS: f64 = 3.0;
/// Share of an object's extent by which the middle of what is seen of it from different sides may
/// move, and the largest extent that counts, metres.
const SIZE_SIGMA: f64 = 0.2;
const LARGEST_M: f64 = 4.0;

/// Limits of the distance between two sightings of one object.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GroupSettings {
    /// Standard deviations of the joint uncertainty that sightings of one object may lie apart.
    pub sigmas: f64,
    /// Standard deviation of the receiver's own position between lines, metres: it is not in
    /// [`Target::sigma_m`].
    pub receiver_sigma_m: f64,
    /// Standard deviation of the place of a whole log, metres: another day, another receiver. It
    /// counts between sightings of different logs.
    pub log_sigma_m: f64,
}

impl Default for GroupSettings {
    fn default() -> Self {
        Self { sigmas: 3.0, receiver_sigma_m: 0.3, log_sigma_m: 1.0 }
    }
}

/// One box that may show the same object as others.
#[derive(Clone, Copy, Debug)]
pub struct Sighting<'a> {
    /// Index of the log that saw it; places of all logs are in one plane.
    pub log: usize,
    /// Place and size of its object.
    pub target: &'a Target,
    /// Class of the object; `None` where it is not known.
    pub class: Option<usize>,
    /// Score of the box, 0 to 1.
    pub score: f64,
}

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

    fn determinant(self) -> f64 {
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

/// Returns true if one pass saw both apart. In a turn a side sweeps over the same place again, and
/// under the boat both sides detect it; two boxes over the same echo, or two halves of it, at one
/// time and one range, are no two objects.
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
/// what is seen and the middle of the object, metres.
pub(super) fn size_m(target: &Target) -> f64 {
    let size_m = target.length_m.max(target.width_m);
    // Of a point it is not known; its uncertainty says how far it may be off.
    if size_m.is_nan() { 0.0 } else { SIZE_SIGMA * size_m.min(LARGEST_M) }
}

/// Squared distance of two sightings in standard deviations, with their joint covariance; another
/// class adds to it.
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

/// Pairs that may be one object, the likeliest first: by `d^2 + ln det S`, so that two sure
/// sightings go before an unsure one that would fit anything.
pub(super) fn pairs(sightings: &[Sighting<'_>], settings: &GroupSettings) -> Vec<(usize, usize)> {
    let mut by_east: Vec<usize> = (0..sightings.len()).collect();
    by_east.sort_by(|&a, &b| {
        let [a, b] = [a, b].map(|index| sightings[index].target.east_m);
        a.total_cmp(&b)
    });
    let of_one_log = sightings.iter().all(|one| one.log == sightings[0].log);
    let log_sigma_m = if of_one_log { 0.0 } else { settings.log_sigma_m };
    let reach_m = |one: &Sighting<'_>| {
        let receiver_sigma_m = settings.receiver_sigma_m.hypot(log_sigma_m);
        let sigma_m = one.target.sigma_m.hypot(receiver_sigma_m);
        settings.sigmas * (sigma_m + size_m(one.target))
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
