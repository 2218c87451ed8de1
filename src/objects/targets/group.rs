//! Joins sightings of the same object from several lines into one object, by the uncertainty of
//! their places.

use super::{ObjectHeight, Target};

/// Greatest distance between sightings of one object, in standard deviations of their joint
/// uncertainty.
const SIGMAS: f64 = 3.0;
/// Standard deviation of the receiver's own position between lines, metres, which
/// [`Target::sigma_m`] does not include.
const RECEIVER_SIGMA_M: f64 = 0.3;
/// Standard deviation of the position of a whole log, metres, due to another day or another
/// receiver. It is used between sightings of different logs.
const LOG_SIGMA_M: f64 = 1.0;
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

/// An object, joined from its sightings.
#[derive(Clone, Debug)]
pub struct Group {
    /// Indices of the sightings, growing.
    pub members: Vec<usize>,
    /// Mean of the places of the sightings, weighted by the inverse of their covariances, metres
    /// east of the survey's origin.
    pub east_m: f64,
    /// North part of the mean place, metres north of the survey's origin.
    pub north_m: f64,
    /// Standard deviation of the mean place in the worse direction, metres.
    pub sigma_m: f64,
    /// Class with the largest sum of scores; among equals, the class of the first sighting. `None`
    /// if no sighting has a class.
    pub class: Option<usize>,
    /// Height of the object, from all sightings together.
    pub height: ObjectHeight,
}

/// Joins sightings of the same object. The likeliest pairs are joined first, as long as all members
/// are within their uncertainty and size of the common place; two sightings that one pass saw apart
/// are never joined. A class is a hint: one wrong class does not split an object. A sighting with a
/// badly known place (in a sharp turn, under the boat) has a wide uncertainty, so it can still join
/// a neighbour, but only after well placed ones have been paired. An object with a single sighting
/// is a group of one. Groups are sorted by their first sighting.
pub fn group(sightings: &[Sighting<'_>]) -> Vec<Group> {
    let mut owner: Vec<usize> = (0..sightings.len()).collect();
    let mut members: Vec<Vec<usize>> = owner.iter().map(|&index| vec![index]).collect();
    for (a, b) in pairs(sightings) {
        let (a, b) = (owner[a], owner[b]);
        if a == b || !joins(sightings, &members[a], &members[b]) {
            continue;
        }
        let moved = std::mem::take(&mut members[b]);
        for &index in &moved {
            owner[index] = a;
        }
        members[a].extend(moved);
    }
    let mut groups: Vec<Group> = members
        .into_iter()
        .filter(|members| !members.is_empty())
        .map(|members| joined(sightings, members))
        .collect();
    groups.sort_by_key(|group| group.members[0]);
    groups
}

/// Returns true if two groups can be one object: no pass saw members of both as separate objects,
/// and every member is near enough to the common place.
fn joins(sightings: &[Sighting<'_>], ours: &[usize], theirs: &[usize]) -> bool {
    let seen_apart = ours.iter().any(|&one| {
        let mut others = theirs.iter();
        others.any(|&other| same_pass(&sightings[one], &sightings[other]))
    });
    if seen_apart {
        return false;
    }
    let both = || ours.iter().chain(theirs);
    let (place, _) = common(both().map(|&index| sightings[index].target));
    let of_one_log = both().all(|&index| sightings[index].log == sightings[ours[0]].log);
    let log_sigma_m = if of_one_log { 0.0 } else { LOG_SIGMA_M };
    let size_m = both().map(|&index| size_m(sightings[index].target)).fold(0.0, f64::max);
    both().all(|&index| {
        let target = sightings[index].target;
        let either = size_m * size_m + log_sigma_m * log_sigma_m;
        let spread = spread(target).plus(PositionCovariance::round(either));
        let off_m = [target.east_m - place[0], target.north_m - place[1]];
        spread.squared_sigmas(off_m) < SIGMAS * SIGMAS
    })
}

/// Returns the uncertainty of a sighting relative to sightings of other lines.
fn spread(target: &Target) -> PositionCovariance {
    PositionCovariance::of(target).plus(PositionCovariance::round(RECEIVER_SIGMA_M.powi(2)))
}

/// Returns the mean place, weighted by the inverse of the covariances, and its covariance.
fn common<'a>(targets: impl Iterator<Item = &'a Target>) -> ([f64; 2], PositionCovariance) {
    let (mut information, mut sum) = (PositionCovariance::round(0.0), [0.0; 2]);
    for target in targets {
        let weight = spread(target).inverse();
        let [east, north] = weight.times([target.east_m, target.north_m]);
        sum = [sum[0] + east, sum[1] + north];
        information = information.plus(weight);
    }
    let covariance = information.inverse();
    (covariance.times(sum), covariance)
}

fn joined(sightings: &[Sighting<'_>], mut members: Vec<usize>) -> Group {
    members.sort_unstable();
    let all = || members.iter().map(|&index| &sightings[index]);
    let ([east_m, north_m], covariance) = common(all().map(|sighting| sighting.target));
    let support = |class: usize| -> f64 {
        let same = all().filter(|sighting| sighting.class == Some(class));
        same.map(|sighting| sighting.score.max(0.0)).sum()
    };
    let best =
        |best: usize, other: usize| if support(other) > support(best) { other } else { best };
    let class = all().filter_map(|sighting| sighting.class).reduce(best);
    Group {
        east_m,
        north_m,
        sigma_m: covariance.widest_m(),
        class,
        height: ObjectHeight::of(all().map(|sighting| sighting.target)),
        members,
    }
}

/// Covariance of a place, square metres: variance east, covariance of east and north, variance
/// north.
#[derive(Clone, Copy, Debug, PartialEq)]
struct PositionCovariance {
    east: f64,
    both: f64,
    north: f64,
}

impl PositionCovariance {
    /// Creates a covariance that is the same in every direction.
    const fn round(variance_m2: f64) -> Self {
        Self { east: variance_m2, both: 0.0, north: variance_m2 }
    }

    /// Returns the covariance of a sighting, from its uncertainties along and across the heading of
    /// the boat.
    fn of(target: &Target) -> Self {
        let (sin, cos) = target.heading_rad.sin_cos();
        let along = target.along_sigma_m.powi(2);
        let across = target.across_sigma_m.powi(2);
        Self {
            east: along * sin * sin + across * cos * cos,
            both: (along - across) * sin * cos,
            north: along * cos * cos + across * sin * sin,
        }
    }

    fn plus(self, other: Self) -> Self {
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
    fn inverse(self) -> Self {
        let scale = self.determinant().max(f64::MIN_POSITIVE).recip();
        Self { east: scale * self.north, both: -scale * self.both, north: scale * self.east }
    }

    /// Returns the product with a vector.
    fn times(self, [east_m, north_m]: [f64; 2]) -> [f64; 2] {
        [self.east * east_m + self.both * north_m, self.both * east_m + self.north * north_m]
    }

    /// Returns the squared distance in standard deviations (Mahalanobis).
    fn squared_sigmas(self, apart_m: [f64; 2]) -> f64 {
        let [east, north] = self.inverse().times(apart_m);
        east * apart_m[0] + north * apart_m[1]
    }

    /// Returns the standard deviation in the direction in which it is largest, metres.
    fn widest_m(self) -> f64 {
        let middle = 0.5 * (self.east + self.north);
        let swing = (0.5 * (self.east - self.north)).hypot(self.both);
        (middle + swing).sqrt()
    }
}

/// Returns true if one pass saw the two sightings as separate objects. In a turn, a side sweeps
/// over the same place again, and under the boat both sides detect it; two boxes at the same time
/// and range, over the same echo or two halves of it, are not two objects.
fn same_pass(one: &Sighting<'_>, other: &Sighting<'_>) -> bool {
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
fn size_m(target: &Target) -> f64 {
    let size_m = target.length_m.max(target.width_m);
    // The size of a point is not known, but its uncertainty includes how far it may be off.
    if size_m.is_nan() { 0.0 } else { SIZE_SIGMA * size_m.min(LARGEST_M) }
}

/// Returns the squared distance of two sightings in standard deviations (larger if their classes
/// differ), and their joint covariance.
fn apart(a: &Sighting<'_>, b: &Sighting<'_>) -> (f64, PositionCovariance) {
    let size_m = size_m(a.target).max(size_m(b.target));
    let of_logs = if a.log == b.log { 0.0 } else { 2.0 * LOG_SIGMA_M.powi(2) };
    let either = 2.0 * RECEIVER_SIGMA_M.powi(2) + of_logs + size_m * size_m;
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
fn pairs(sightings: &[Sighting<'_>]) -> Vec<(usize, usize)> {
    let mut by_east: Vec<usize> = (0..sightings.len()).collect();
    by_east.sort_by(|&a, &b| {
        let [a, b] = [a, b].map(|index| sightings[index].target.east_m);
        a.total_cmp(&b)
    });
    let of_one_log = sightings.iter().all(|sighting| sighting.log == sightings[0].log);
    let log_sigma_m = if of_one_log { 0.0 } else { LOG_SIGMA_M };
    let reach_m = |sighting: &Sighting<'_>| {
        let receiver_sigma_m = RECEIVER_SIGMA_M.hypot(log_sigma_m);
        let sigma_m = sighting.target.sigma_m.hypot(receiver_sigma_m);
        SIGMAS * (sigma_m + size_m(sighting.target))
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
            let (squared, spread) = apart(one, other);
            if squared < SIGMAS * SIGMAS && !same_pass(one, other) {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Mark;
    use crate::testing::target;
    use bathyscope_log::survey::Side;

    /// Pings from the beginning of one log to the beginning of the next.
    const LOG_PINGS: usize = 1_000_000;

    /// Moves a sighting to another log.
    fn in_log(log: usize, mut target: Target) -> Target {
        target.mark.pings.start += log * LOG_PINGS;
        target.mark.pings.end += log * LOG_PINGS;
        target
    }

    /// Creates a sighting by a boat that heads north, from its place, the distance sailed, and the
    /// standard deviation in metres.
    fn seen(east_m: f64, sailed_m: f64, sigma_m: f64) -> Target {
        let ping = (10.0 * sailed_m) as usize;
        Target {
            mark: Mark::new(Side::Port, ping..ping + 5, [1.0, 2.0]),
            east_m,
            sigma_m,
            along_sigma_m: sigma_m,
            across_sigma_m: sigma_m,
            sailed_m,
            ..target()
        }
    }

    fn grouped(targets: &[Target], claims: &[(Option<usize>, f64)]) -> Vec<Group> {
        let claims = claims.iter().chain(std::iter::repeat(&(Some(0), 0.8)));
        let sightings: Vec<Sighting<'_>> = targets
            .iter()
            .zip(claims)
            .map(|(target, &(class, score))| Sighting {
                log: target.mark.pings.start / LOG_PINGS,
                target,
                class,
                score,
            })
            .collect();
        group(&sightings)
    }

    fn members(targets: &[Target]) -> Vec<Vec<usize>> {
        let groups = grouped(targets, &[]);
        groups.into_iter().map(|group| group.members).collect()
    }

    #[test]
    fn two_marks_of_one_pass_stay_two_objects() {
        // The second line sees one object between the two objects of the first line; it joins the
        // nearer.
        let targets = [seen(0.0, 10.0, 0.3), seen(1.0, 11.0, 0.3)];
        assert_eq!(members(&targets), [vec![0], vec![1]]);
        let between = [targets[0].clone(), targets[1].clone(), seen(0.7, 80.0, 0.3)];
        assert_eq!(members(&between), [vec![0], vec![1, 2]]);
        // The two objects are not joined by sightings of a third and a fourth line either.
        let targets = [
            seen(0.0, 10.0, 0.3),
            seen(0.6, 11.0, 0.3),
            seen(0.2, 80.0, 0.3),
            seen(0.4, 150.0, 0.3),
        ];
        assert_eq!(members(&targets), [vec![0, 2], vec![1, 3]]);
    }

    #[test]
    fn logs_of_other_days_see_one_object_farther_apart_and_at_the_same_way_sailed() {
        // The sightings are at the same time in two logs, 1.9 m apart: too far for two lines of one
        // log.
        let targets = [seen(0.0, 10.0, 0.3), seen(1.9, 10.0, 0.3)];
        assert_eq!(members(&targets).len(), 2);
        let [first, second] = targets.clone();
        let logs = [in_log(0, first.clone()), in_log(1, second)];
        assert_eq!(members(&logs), [vec![0, 1]]);
        // Four logs see the object; two sightings that one of the logs saw apart stay apart. They
        // are at different pings: at one ping and range, they would be two boxes over one echo.
        let others = [(1, 0.6, 10.0), (2, -0.5, 10.0), (3, 0.9, 10.0), (0, 1.3, 11.0)];
        let others = others.map(|(log, east_m, sailed_m)| in_log(log, seen(east_m, sailed_m, 0.3)));
        let all = [vec![in_log(0, first)], others.to_vec()].concat();
        let found = members(&all);
        assert_eq!(found.len(), 2, "{found:?}");
        let apart = |index: usize| found.iter().position(|group| group.contains(&index));
        assert_ne!(apart(0), apart(4));
    }

    #[test]
    fn a_turn_sweeps_over_an_object_again_and_both_sides_hear_what_lies_below() {
        let mut targets = [seen(0.0, 10.0, 0.3), seen(0.3, 14.0, 0.3)];
        targets[1].heading_rad = 1.2;
        assert_eq!(members(&targets), [vec![0, 1]]);
        // Two boxes over one echo are one object; a box at another range at the same time is
        // another object.
        targets[0].mark.pings.end = targets[1].mark.pings.start + 1;
        assert_eq!(members(&targets), [vec![0, 1]]);
        targets[1].mark.near_m += 0.8;
        assert_eq!(members(&targets), [vec![0], vec![1]]);
        let mut targets = [seen(-0.3, 10.0, 0.5), seen(0.3, 10.0, 0.5)];
        targets[1].mark.side = Side::Starboard;
        assert_eq!(members(&targets), [vec![0, 1]]);
    }

    #[test]
    fn a_confused_class_does_not_split_an_object_and_the_best_supported_one_counts() {
        let targets = [0.0, 1.3, 0.6].map(|east_m| seen(east_m, 100.0 * east_m, 0.3));
        let claims = [(Some(4), 0.4), (Some(2), 0.9), (Some(4), 0.4)];
        let [group] = &grouped(&targets, &claims)[..] else { panic!("one object") };
        assert_eq!((group.members.len(), group.class), (3, Some(2)));
        // The allowed distance is 3 x 0.61 m; with another class 2.45 x 0.61 m.
        let apart = |east_m, class| {
            let targets = [seen(0.0, 0.0, 0.3), seen(east_m, 50.0, 0.3)];
            grouped(&targets, &[(Some(0), 0.8), (class, 0.8)]).len()
        };
        assert_eq!([apart(1.8, Some(0)), apart(1.9, Some(0))], [1, 2]);
        assert_eq!([apart(1.45, Some(1)), apart(1.55, Some(1))], [1, 2]);
        // A box without a class contradicts no other class.
        assert_eq!([apart(1.8, None), apart(1.9, None)], [1, 2]);
    }

    #[test]
    fn a_sighting_without_a_name_leaves_the_name_to_the_others() {
        let targets = [0.0, 0.3].map(|east_m| seen(east_m, 100.0 * east_m, 0.3));
        let class = |claims: [Option<usize>; 2]| {
            let claims = claims.map(|class| (class, 0.5));
            grouped(&targets, &claims)[0].class
        };
        assert_eq!(class([None, Some(3)]), Some(3));
        assert_eq!(class([None, None]), None);
    }

    #[test]
    fn a_badly_placed_sighting_joins_a_neighbour_but_does_not_keep_sure_ones_apart() {
        // The first sighting is nearer to the second than the second is to the third, yet the last
        // two are joined first.
        let targets = [seen(-0.2, 0.0, 1.5), seen(0.6, 60.0, 0.2), seen(1.5, 120.0, 0.2)];
        assert_eq!(members(&targets), [vec![0, 1, 2]]);
        // Two objects that are clearly apart are not joined through an uncertain sighting between
        // them.
        let targets = [seen(0.0, 0.0, 1.5), seen(-1.4, 60.0, 0.2), seen(1.0, 120.0, 0.2)];
        assert_eq!(members(&targets), [vec![0, 2], vec![1]]);
    }

    #[test]
    fn the_middle_leans_to_the_surer_direction() {
        // With a heading to the north, the first sighting is certain along the track; with a
        // heading to the east, the second is: together they are certain in both directions.
        let mut targets = [seen(0.0, 0.0, 0.9), seen(0.4, 60.0, 0.9)];
        targets[0].along_sigma_m = 0.1;
        targets[1].along_sigma_m = 0.1;
        targets[1].heading_rad = std::f64::consts::FRAC_PI_2;
        targets[1].north_m = 0.8;
        let [group] = &grouped(&targets, &[])[..] else { panic!("one object") };
        // With the receiver's 0.3 m, the variances are 0.1 and 0.9 m2.
        let weights = [1.0 / 0.9, 1.0 / 0.1];
        let share = weights[1] / (weights[0] + weights[1]);
        assert!((group.east_m - share * 0.4).abs() < 1e-9);
        assert!((group.north_m - (1.0 - share) * 0.8).abs() < 1e-9);
        assert!((group.sigma_m - (weights[0] + weights[1]).sqrt().recip()).abs() < 1e-9);
    }
}
