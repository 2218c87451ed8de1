//! The same object, seen from several lines, as one.

use super::{Target, passes_over};
use crate::statistics::median;
use crate::survey::{Navigation, Survey};

/// How near two sightings of one object lie.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GroupSettings {
    /// Standard deviations of the joint uncertainty that two sightings may lie apart.
    pub sigmas: f64,
    /// Standard deviation of the receiver's own position between lines, metres: it is not in [`Target::sigma_m`].
    pub receiver_sigma_m: f64,
}

impl Default for GroupSettings {
    fn default() -> Self {
        Self {
            sigmas: 2.5,
            receiver_sigma_m: 0.3,
        }
    }
}

/// One object with all that was seen of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Group {
    /// Indices of its sightings, growing.
    pub members: Vec<usize>,
    /// Mean of their places, weighted by their certainty, metres east of the survey's origin.
    pub east_m: f64,
    /// The same, metres north.
    pub north_m: f64,
    /// Standard deviation of that place, metres, the receiver's own error left out.
    pub sigma_m: f64,
    /// Class that most of them have; of equals the one seen first.
    pub class: usize,
    /// Median of the heights that are known, metres; NaN without any.
    pub height_m: f64,
}

impl Group {
    /// How many passes of the boat covered the place, those that saw it included: `seen n of m` is
    /// `members.len()` of this.
    pub fn covered(&self, survey: &Survey, navigation: &Navigation) -> usize {
        let passes = passes_over(survey, navigation, [self.east_m, self.north_m]);
        passes.len().max(self.members.len())
    }
}

/// Two sightings that lie along the track by less than this are of one pass, metres sailed.
const ONE_PASS_M: f64 = 8.0;
/// Two classes make a doubt: such sightings have to lie nearer by this factor.
const OTHER_CLASS: f64 = 0.5;
/// Half of the larger footprint counts as nearness, but no more than this, metres.
const LARGEST_REACH_M: f64 = 2.0;

/// Joins sightings (a place and a class) of the same object: nearest first, while they lie within their joint uncertainty and
/// size, and never two of the same pass. An object seen once is a group of one. By first sighting.
pub fn group(targets: &[(Target, usize)], settings: &GroupSettings) -> Vec<Group> {
    let mut owner: Vec<usize> = (0..targets.len()).collect();
    let mut members: Vec<Vec<usize>> = owner.iter().map(|&index| vec![index]).collect();
    for (_, a, b) in pairs(targets, settings) {
        let (a, b) = (owner[a], owner[b]);
        let one_pass = members[a].iter().any(|&one| {
            let same = |&other: &usize| same_pass(&targets[one].0, &targets[other].0);
            members[b].iter().any(same)
        });
        if a == b || one_pass {
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
        .map(|members| joined(targets, members))
        .collect();
    groups.sort_by_key(|group| group.members[0]);
    groups
}

fn same_pass(a: &Target, b: &Target) -> bool {
    (a.sailed_m - b.sailed_m).abs() < ONE_PASS_M
}

/// Pairs that may be one object, the surest first: distance over what is allowed.
fn pairs(targets: &[(Target, usize)], settings: &GroupSettings) -> Vec<(f64, usize, usize)> {
    let mut by_east: Vec<usize> = (0..targets.len()).collect();
    by_east.sort_by(|&a, &b| targets[a].0.east_m.total_cmp(&targets[b].0.east_m));
    let reach_m = |index: usize| {
        let target = &targets[index].0;
        let size_m = target
            .length_m
            .max(target.width_m)
            .min(2.0 * LARGEST_REACH_M);
        (
            target.sigma_m.hypot(settings.receiver_sigma_m),
            0.5 * size_m,
        )
    };
    let widest_m = (0..targets.len())
        .map(|index| {
            let (sigma_m, half_m) = reach_m(index);
            2.0 * settings.sigmas * sigma_m + half_m
        })
        .fold(0.0, f64::max);
    let mut pairs = Vec::new();
    for (place, &a) in by_east.iter().enumerate() {
        let near = by_east[place + 1..]
            .iter()
            .take_while(|&&b| targets[b].0.east_m - targets[a].0.east_m <= widest_m);
        for &b in near {
            let ((one, class), (other, other_class)) = (&targets[a], &targets[b]);
            let (sigma_a, half_a) = reach_m(a);
            let (sigma_b, half_b) = reach_m(b);
            let mut allowed_m = settings.sigmas * sigma_a.hypot(sigma_b) + half_a.max(half_b);
            if class != other_class {
                allowed_m *= OTHER_CLASS;
            }
            let apart_m = f64::hypot(one.east_m - other.east_m, one.north_m - other.north_m);
            if apart_m < allowed_m && !same_pass(one, other) {
                pairs.push((apart_m / allowed_m, a.min(b), a.max(b)));
            }
        }
    }
    pairs.sort_by(|one, other| {
        one.0
            .total_cmp(&other.0)
            .then((one.1, one.2).cmp(&(other.1, other.2)))
    });
    pairs
}

fn joined(targets: &[(Target, usize)], mut members: Vec<usize>) -> Group {
    members.sort_unstable();
    let (mut weights, mut east_m, mut north_m) = (0.0, 0.0, 0.0);
    let mut heights_m = Vec::new();
    for &index in &members {
        let target = &targets[index].0;
        let weight = target.sigma_m.max(0.01).powi(-2);
        weights += weight;
        east_m += weight * target.east_m;
        north_m += weight * target.north_m;
        heights_m.extend(Some(target.height_m).filter(|height_m| height_m.is_finite()));
    }
    let votes = |class: usize| {
        members
            .iter()
            .filter(|&&one| targets[one].1 == class)
            .count()
    };
    let mut class = targets[members[0]].1;
    for &index in &members {
        if votes(targets[index].1) > votes(class) {
            class = targets[index].1;
        }
    }
    Group {
        east_m: east_m / weights,
        north_m: north_m / weights,
        sigma_m: weights.sqrt().recip(),
        class,
        height_m: median(&mut heights_m),
        members,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::detection::Mark;
    use crate::geo::LonLat;
    use crate::survey::Side;

    fn seen(east_m: f64, sailed_m: f64, class: usize) -> (Target, usize) {
        let target = Target {
            mark: Mark {
                side: Side::Port,
                pings: 0..1,
                near_m: 1.0,
                far_m: 2.0,
            },
            slant_m: 5.0,
            ground_m: 4.0,
            altitude_m: 3.0,
            east_m,
            north_m: 0.0,
            position: LonLat {
                lon_deg: 0.0,
                lat_deg: 0.0,
            },
            length_m: 0.6,
            width_m: 0.4,
            height_m: f64::NAN,
            depth_m: 3.0,
            sigma_m: 0.3,
            sailed_m,
        };
        (target, class)
    }

    fn members(targets: &[(Target, usize)]) -> Vec<Vec<usize>> {
        let groups = group(targets, &GroupSettings::default());
        groups.into_iter().map(|group| group.members).collect()
    }

    #[test]
    fn two_marks_of_one_pass_stay_two_objects() {
        // The second line sees one object between the two that the first line sees; it joins the nearer.
        let targets = [seen(0.0, 10.0, 0), seen(1.0, 11.0, 0), seen(0.7, 80.0, 0)];
        assert_eq!(members(&targets), [vec![0], vec![1, 2]]);
        // Nor do they meet through a third line.
        let targets = [
            seen(0.0, 10.0, 0),
            seen(0.6, 11.0, 0),
            seen(0.2, 80.0, 0),
            seen(0.4, 150.0, 0),
        ];
        let groups = members(&targets);
        assert!(
            !groups
                .iter()
                .any(|one| one.contains(&0) && one.contains(&1))
        );
        assert_eq!(groups.len(), 2);
    }

    #[test]
    fn another_class_has_to_lie_nearer() {
        // Allowed: 2.5 x 0.6 + 0.3 = 1.8 m, half of it across classes.
        let apart = |east_m, class| members(&[seen(0.0, 0.0, 0), seen(east_m, 50.0, class)]).len();
        assert_eq!([apart(1.7, 0), apart(1.9, 0)], [1, 2]);
        assert_eq!([apart(0.8, 1), apart(1.0, 1)], [1, 2]);
    }

    #[test]
    fn the_middle_leans_to_the_surer_sighting() {
        let mut targets = [seen(0.0, 0.0, 2), seen(1.0, 50.0, 1), seen(0.5, 100.0, 1)];
        targets[0].0.sigma_m = 0.1;
        targets[0].0.height_m = 0.5;
        let [one] = &group(&targets, &GroupSettings::default())[..] else {
            panic!("one object")
        };
        // Weights 100, 1 / 0.09 and 1 / 0.09.
        let expected = (1.0 + 0.5) / 0.09 / (100.0 + 2.0 / 0.09);
        assert!((one.east_m - expected).abs() < 1e-9);
        assert_eq!((one.class, one.height_m), (1, 0.5));
    }
}
