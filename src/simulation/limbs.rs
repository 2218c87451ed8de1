//! Models objects of round members that lie on the ground: a tree trunk with branches, a body with
//! limbs.

use super::arithmetic::{cos, sin};
use super::random::Random;

/// A tapering round member between two points (`ends`, metres along and across the object).
#[derive(Clone, Copy)]
struct Limb {
    ends: [[f64; 2]; 2],
    /// Radius at each end, metres.
    radius_m: [f64; 2],
    /// Height of the member's axis above the ground at each end, metres.
    axis_m: [f64; 2],
}

/// Members that together make an object.
pub(super) struct Limbs {
    limbs: Vec<Limb>,
    /// Height of the thickest member, metres.
    top_m: f64,
}

/// Thinnest radius of a branch, metres.
const TWIG_M: f64 = 0.05;
/// Smallest number of branches of a trunk, and largest number of additional ones.
const BRANCHES: (u64, u64) = (3, 5);
/// Number of pieces that a bent trunk is made of.
const TRUNK_PIECES: usize = 5;

impl Limb {
    /// Creates a member that touches the ground along its whole length.
    fn new(from: [f64; 2], to: [f64; 2], radius_m: [f64; 2]) -> Self {
        Self { ends: [from, to], radius_m, axis_m: radius_m }
    }

    /// Returns the height of the member's upper side above the ground at a place, metres; 0 beside
    /// it. The space below the member counts as filled.
    fn height_m(&self, place: [f64; 2]) -> f64 {
        let [from, to] = self.ends;
        let way = [to[0] - from[0], to[1] - from[1]];
        let off = [place[0] - from[0], place[1] - from[1]];
        let square = (way[0] * way[0] + way[1] * way[1]).max(1e-12);
        let share = ((off[0] * way[0] + off[1] * way[1]) / square).clamp(0.0, 1.0);
        let here = |[first, second]: [f64; 2]| first + (second - first) * share;
        let radius = here(self.radius_m);
        let aside = [off[0] - share * way[0], off[1] - share * way[1]];
        let rest = radius * radius - aside[0] * aside[0] - aside[1] * aside[1];
        if rest > 0.0 { here(self.axis_m) + rest.sqrt() } else { 0.0 }
    }
}

impl Limbs {
    /// Creates a trunk that tapers and bends, with stout branches on both sides and often its root
    /// plate. `height_m` is the diameter of its thick end; the branches are within the width. All
    /// this distinguishes a tree from a pipe: a bare trunk looks like a pipe to people and to
    /// networks, so no scene has one.
    pub(super) fn log(length_m: f64, width_m: f64, height_m: f64, random: &mut Random) -> Self {
        let thick = 0.5 * height_m;
        let tip = thick * random.between(0.25, 0.5);
        let bend = random.between(-0.3, 0.3) * width_m;
        let trunk = |share: f64| {
            let along = (share - 0.5) * length_m;
            [along, bend * (4.0 * share * (1.0 - share) - 0.5)]
        };
        let radius = |share: f64| thick + (tip - thick) * share;
        let mut limbs: Vec<Limb> = (0..TRUNK_PIECES)
            .map(|piece| {
                let [from, to] = [piece, piece + 1].map(|end| end as f64 / TRUNK_PIECES as f64);
                Limb::new(trunk(from), trunk(to), [radius(from), radius(to)])
            })
            .collect();
        let first = if random.chance(0.5) { 1.0 } else { -1.0 };
        for branch in 0..BRANCHES.0 + random.bits() % (BRANCHES.1 + 1) {
            let share = random.between(0.2, 0.95);
            let side = if branch % 2 == 0 { first } else { -first };
            let angle = random.between(0.5, 1.3);
            let reach = random.between(0.3, 0.5) * width_m / sin(angle);
            let from = trunk(share);
            let to = [from[0] + reach * cos(angle), from[1] + side * reach * sin(angle)];
            let stout = (radius(share) * random.between(0.45, 0.75)).max(TWIG_M);
            // The branch begins at the axis of the trunk and rises off the ground, but not above
            // the trunk.
            let rise = (thick * random.between(0.7, 2.0) - TWIG_M).max(TWIG_M);
            limbs.push(Limb {
                axis_m: [radius(share), rise],
                ..Limb::new(from, to, [stout, TWIG_M])
            });
        }
        if random.chance(0.5) {
            let root = trunk(0.0);
            let plate = 2.0 * thick;
            limbs.push(Limb::new(
                [root[0], root[1] - plate],
                [root[0], root[1] + plate],
                [0.9 * thick; 2],
            ));
        }
        Self::fitted(limbs, length_m, width_m)
    }

    /// Creates a body on its back or face: head, torso, and limbs in any pose. `height_m` is the
    /// height of the torso.
    pub(super) fn body(length_m: f64, width_m: f64, height_m: f64, random: &mut Random) -> Self {
        let scale = length_m / 1.7;
        let at = |along: f64, across: f64| [along * scale, across * scale];
        let torso = 0.5 * height_m;
        let mut limbs = vec![
            Limb::new(at(0.74, 0.0), at(0.78, 0.0), [0.1 * scale; 2]),
            Limb::new(at(0.52, 0.1), at(0.02, 0.08), [torso, 0.9 * torso]),
            Limb::new(at(0.52, -0.1), at(0.02, -0.08), [torso, 0.9 * torso]),
        ];
        for side in [1.0, -1.0] {
            let arm = Member {
                from: [0.55, 0.17],
                lengths: [0.3, 0.32],
                radii: [0.3 * torso, 0.28 * torso, 0.22 * torso],
            };
            // An angle of 0 points to the feet, half a turn to the head.
            let shoulder = random.between(0.15, 2.6);
            limbs.extend(arm.limbs(side, shoulder, random.between(-0.9, 0.9), scale));
            let leg = Member {
                from: [-0.02, 0.09],
                lengths: [0.43, 0.42],
                radii: [0.6 * torso, 0.45 * torso, 0.3 * torso],
            };
            let hip = random.between(0.0, 0.7);
            limbs.extend(leg.limbs(side, hip, random.between(-0.8, 0.2), scale));
        }
        Self::fitted(limbs, length_m, width_m)
    }

    /// Moves and scales the members so that they fill the length and do not exceed the width.
    fn fitted(mut limbs: Vec<Limb>, length_m: f64, width_m: f64) -> Self {
        for (axis, extent_m) in [(0, length_m), (1, width_m)] {
            let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
            for limb in &limbs {
                for (end, radius) in limb.ends.iter().zip(limb.radius_m) {
                    low = low.min(end[axis] - radius);
                    high = high.max(end[axis] + radius);
                }
            }
            let middle = 0.5 * (low + high);
            let stretch = extent_m / (high - low).max(1e-9);
            let stretch = if axis == 0 { stretch } else { stretch.min(1.0) };
            for end in limbs.iter_mut().flat_map(|limb| &mut limb.ends) {
                end[axis] = (end[axis] - middle) * stretch;
            }
        }
        let radii = limbs.iter().flat_map(|limb| limb.radius_m);
        let top_m = 2.0 * radii.fold(0.0, f64::max);
        Self { limbs, top_m }
    }

    /// Returns the height at a place along and across the object as a share of its whole height.
    pub(super) fn share(&self, along_m: f64, across_m: f64) -> f64 {
        let heights = self.limbs.iter().map(|limb| limb.height_m([along_m, across_m]));
        heights.fold(0.0, f64::max) / self.top_m
    }
}

/// An arm or a leg of a body 1.7 m long, before it is posed.
struct Member {
    from: [f64; 2],
    /// Lengths of the upper and the lower part, metres.
    lengths: [f64; 2],
    /// Radii at the shoulder or hip, the middle joint and the end, metres.
    radii: [f64; 3],
}

impl Member {
    /// Returns the two parts as limbs, the first at `first_rad` from the body's axis, the second
    /// bent by `second_rad` at the joint.
    fn limbs(&self, side: f64, first_rad: f64, second_rad: f64, scale: f64) -> [Limb; 2] {
        let start = [self.from[0] * scale, side * self.from[1] * scale];
        let next = |from: [f64; 2], length: f64, angle: f64| {
            let length = length * scale;
            [from[0] - length * cos(angle), from[1] + side * length * sin(angle)]
        };
        let joint = next(start, self.lengths[0], first_rad);
        let end = next(joint, self.lengths[1], first_rad + second_rad);
        let [thick, middle, thin] = self.radii;
        [Limb::new(start, joint, [thick, middle]), Limb::new(joint, end, [middle, thin])]
    }
}
