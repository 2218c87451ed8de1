//! Shapes objects and places them on the ground, as heights above it, so that highlight and shadow
//! follow from the geometry alone.

use super::arithmetic::{cos, from_db, sin};
use super::path::Path;
use super::random::{NoiseField, Random, RandomPurpose};
use super::scene::{ObjectKind, ObjectSettings, Scene};
use std::f64::consts::PI;

/// An object at its place.
pub(super) struct PlacedObject {
    /// Kind, place and size of the object.
    pub settings: ObjectSettings,
    /// Radius of the circle around the object, metres.
    pub reach_m: f64,
    /// Strength of the object's echoes relative to the ground, as a factor.
    pub strength: f64,
    forward: [f64; 2],
    shape: Shape,
}

/// Strength of the echoes of stone, wood and metal relative to the ground, as a factor, where the
/// scene does not state a strength (6 dB).
const USUAL_STRENGTH: f64 = 4.0;

impl PlacedObject {
    fn new(settings: ObjectSettings, seed: u64) -> Self {
        let heading = settings.heading_deg.to_radians();
        let (length, width) = (settings.length_m, settings.width_m);
        Self {
            reach_m: 0.5 * (length * length + width * width).sqrt() + SIDE_M,
            strength: settings.strength_db.map_or(USUAL_STRENGTH, from_db),
            forward: [sin(heading), cos(heading)],
            shape: Shape::new(&settings, seed),
            settings,
        }
    }

    /// Returns the height of the object's surface above the ground at a place, metres; 0 beside the
    /// object.
    pub(super) fn height_m(&self, east_m: f64, north_m: f64) -> f64 {
        let object = &self.settings;
        let (east, north) = (east_m - object.east_m, north_m - object.north_m);
        if east * east + north * north > self.reach_m * self.reach_m {
            return 0.0;
        }
        let along = east * self.forward[0] + north * self.forward[1];
        let across = east * self.forward[1] - north * self.forward[0];
        let size_m = [object.length_m, object.width_m];
        let share = self.shape.share(along, across, size_m, [east, north]);
        (object.height_m * share - object.buried_m).max(0.0)
    }
}

/// Returns all objects of the scene: those that the scene lists, then those scattered beside the
/// lines.
pub(super) fn place(scene: &Scene, path: &Path, seed: u64) -> Vec<PlacedObject> {
    let mut random = Random::new(seed, RandomPurpose::Objects, 0);
    let scattered = (0..scene.scattered_objects).map(|_| scatter(path, &mut random));
    let all = scene.objects.iter().cloned().chain(scattered).enumerate();
    all.map(|(index, settings)| PlacedObject::new(settings, seed.wrapping_add(index as u64)))
        .collect()
}

/// Largest distance of scattered objects from the way, metres. Objects may be under the boat, as in
/// a real survey, where their places are unknown before; such an object gives the first return.
const OFF_M: f64 = 7.0;

/// Creates a random object beside or below a random point of the way.
fn scatter(path: &Path, random: &mut Random) -> ObjectSettings {
    let pose = path.at(random.unit() * path.length_m());
    let off = random.between(-OFF_M, OFF_M);
    let [forward_east, forward_north] = pose.forward();
    let kind = ObjectKind::ALL[(random.bits() % 4) as usize];
    let (length_m, width_m, height_m) = match kind {
        ObjectKind::Rock => {
            let size = random.between(0.5, 1.2);
            (size, size * random.between(0.7, 1.0), 0.5 * size)
        }
        ObjectKind::Block => (random.between(0.5, 1.2), random.between(0.4, 0.8), 0.5),
        ObjectKind::Cylinder => (random.between(1.5, 4.0), 0.4, 0.4),
        _ => (0.7, 0.7, 0.22),
    };
    ObjectSettings {
        kind,
        east_m: pose.east_m + off * forward_north,
        north_m: pose.north_m - off * forward_east,
        length_m,
        width_m,
        height_m,
        heading_deg: (random.between(0.0, PI)).to_degrees(),
        buried_m: 0.0,
        strength_db: None,
    }
}

/// Shape of one object, with the random details drawn from its seed.
enum Shape {
    /// A rounded boulder with bumps.
    Rock(NoiseField),
    /// A block with steep sides and a flat top.
    Block,
    /// A cylinder with a round section along the length.
    Cylinder,
    /// A tyre: a ring.
    Tyre,
    /// A sunken boat.
    Hull(Hull),
    /// A log or a body, made of round members.
    Limbs(Limbs),
}

/// Horizontal width of steep sides, metres, wide enough for the rays to meet them.
const SIDE_M: f64 = 0.04;

impl Shape {
    /// Creates the shape of an object; `seed` determines its bumps, branches or pose.
    fn new(object: &ObjectSettings, seed: u64) -> Self {
        let (length, width, height) = (object.length_m, object.width_m, object.height_m);
        let mut random = Random::new(seed, RandomPurpose::Shape, 0);
        match object.kind {
            ObjectKind::Rock => {
                Shape::Rock(NoiseField::new(seed, RandomPurpose::Bumps, 0.3 * length.min(width)))
            }
            ObjectKind::Block => Shape::Block,
            ObjectKind::Cylinder => Shape::Cylinder,
            ObjectKind::Tyre => Shape::Tyre,
            ObjectKind::Boat => Shape::Hull(Hull::new(&mut random)),
            ObjectKind::Log => Shape::Limbs(Limbs::log(length, width, height, &mut random)),
            ObjectKind::Effigy => Shape::Limbs(Limbs::body(length, width, height, &mut random)),
        }
    }

    /// Returns the height at a place as a share of the object's whole height. The place is
    /// `along_m` and `across_m` from the centre of the object; `offset` is the same offset to the
    /// east and north, metres.
    fn share(&self, along_m: f64, across_m: f64, size_m: [f64; 2], offset: [f64; 2]) -> f64 {
        let [length_m, width_m] = size_m;
        // Distances from the centre in half lengths and half widths.
        let (u, v) = (2.0 * along_m / length_m, 2.0 * across_m / width_m);
        match self {
            Shape::Rock(bumps) => {
                let bumpy = 1.0 + 0.12 * bumps.at(offset[0], offset[1]);
                bumpy * (1.0 - u * u - v * v).max(0.0).sqrt()
            }
            Shape::Block => {
                let inside = (0.5 * length_m - along_m.abs()).min(0.5 * width_m - across_m.abs());
                ((inside + SIDE_M) / SIDE_M).clamp(0.0, 1.0)
            }
            Shape::Cylinder if u.abs() > 1.0 => 0.0,
            Shape::Cylinder => round(v),
            // The middle of the ring is at 0.7 of the outer radius, its half thickness is 0.3 of
            // the radius.
            Shape::Tyre => round(((u * u + v * v).sqrt() - 0.7) / 0.3),
            Shape::Hull(hull) => hull.share(along_m, across_m, size_m),
            Shape::Limbs(limbs) => limbs.share(along_m, across_m),
        }
    }
}

/// Returns the height of the upper half of a round section that lies on the ground: 1 at the
/// middle, 1/2 at the widest, 0 beyond.
fn round(offset: f64) -> f64 {
    if offset.abs() >= 1.0 {
        return 0.0;
    }
    0.5 + 0.5 * (1.0 - offset * offset).sqrt()
}

/// The hull of a sunken boat: an open hull on its keel, or one that lies keel up. Its bow points
/// along the heading.
struct Hull {
    keel_up: bool,
    /// List of the hull: relative gain in height of one side and loss of the other; signed.
    list: f64,
    /// Height of the inner floor (planks, or mud that fills the hull) as a share of the height.
    floor: f64,
    /// Places of the thwarts along the hull, half lengths.
    thwarts: [f64; 3],
    /// Half width of the transom as a share of the greatest half width.
    transom: f64,
}

/// Width of the rim of a hull (gunwale and planking), metres.
const RIM_M: f64 = 0.08;
/// Half of a thwart's width, metres.
const THWART_M: f64 = 0.11;
/// Height of a thwart as a share of the height.
const THWART: f64 = 0.75;
/// Half of a keel's width, metres.
const KEEL_M: f64 = 0.05;

impl Hull {
    /// Creates a hull of random build and pose.
    fn new(random: &mut Random) -> Self {
        let keel_up = random.chance(0.4);
        let forward = random.between(-0.1, 0.1);
        Self {
            keel_up,
            list: random.between(-0.35, 0.35),
            floor: random.between(0.1, 0.4),
            thwarts: [-0.5, 0.0, 0.45].map(|at| at + forward),
            transom: random.between(0.6, 0.9),
        }
    }

    /// Returns the half width at a place along the hull (in half lengths, the bow at 1) as a share
    /// of the greatest half width.
    fn outline(&self, u: f64) -> f64 {
        if u < 0.0 { 1.0 - (1.0 - self.transom) * u * u } else { 1.0 - u * u * (0.3 + 0.7 * u) }
    }

    /// Returns the height at a place as a share of the whole height.
    fn share(&self, along_m: f64, across_m: f64, size_m: [f64; 2]) -> f64 {
        let [half_length, half_width] = size_m.map(|size| 0.5 * size);
        let (u, v) = (along_m / half_length, across_m / half_width);
        let beam_m = self.outline(u.clamp(-1.0, 1.0)) * half_width;
        let inside_m = (beam_m - across_m.abs()).min(half_length - along_m.abs());
        let side = ((inside_m + SIDE_M) / SIDE_M).clamp(0.0, 1.0);
        if side == 0.0 {
            return 0.0;
        }
        let upright = if self.keel_up {
            self.bottom(across_m, beam_m, inside_m, u)
        } else {
            self.open(along_m, half_length, inside_m, u)
        };
        let listing = 1.0 + self.list * v;
        side * upright * listing / (1.0 + self.list.abs())
    }

    /// Returns the height of an upright hull (gunwale, thwarts or floor) as a share of the whole;
    /// the gunwale is a little higher towards the ends.
    fn open(&self, along_m: f64, half_length: f64, inside_m: f64, u: f64) -> f64 {
        if inside_m < RIM_M {
            return 0.85 + 0.15 * u * u;
        }
        let on_thwart = |at: &f64| (along_m - at * half_length).abs() < THWART_M;
        if self.thwarts.iter().any(on_thwart) { THWART } else { self.floor }
    }

    /// Returns the height of a hull that lies keel up as a share of the whole: a vault with a
    /// ridge.
    fn bottom(&self, across_m: f64, beam_m: f64, inside_m: f64, u: f64) -> f64 {
        if across_m.abs() < KEEL_M && inside_m > 0.0 {
            return 1.0 - 0.25 * u * u;
        }
        let v = (across_m / beam_m.max(1e-9)).clamp(-1.0, 1.0);
        let vault = 0.45 + 0.45 * (1.0 - v * v).sqrt();
        vault * (1.0 - 0.3 * u * u)
    }
}

/// A tapering round member between two points (`ends`, metres along and across the object).
#[derive(Clone, Copy)]
struct Limb {
    ends: [[f64; 2]; 2],
    /// Radius at each end, metres.
    radius_m: [f64; 2],
    /// Height of the member's axis above the ground at each end, metres.
    axis_m: [f64; 2],
}

/// Members that together make an object that lies on the ground: a tree trunk with branches, or a
/// body with limbs.
struct Limbs {
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
    fn log(length_m: f64, width_m: f64, height_m: f64, random: &mut Random) -> Self {
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
    fn body(length_m: f64, width_m: f64, height_m: f64, random: &mut Random) -> Self {
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
    fn share(&self, along_m: f64, across_m: f64) -> f64 {
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

#[cfg(test)]
mod tests {
    use super::*;

    fn top(kind: ObjectKind, along: f64, across: f64) -> f64 {
        let settings = ObjectSettings {
            kind,
            east_m: 10.0,
            north_m: -4.0,
            length_m: 2.0,
            width_m: 1.0,
            height_m: 0.5,
            heading_deg: 90.0,
            buried_m: 0.0,
            strength_db: None,
        };
        // Heading 90 degrees: along is east, across is south.
        PlacedObject::new(settings, 1).height_m(10.0 + along, -4.0 - across)
    }

    #[test]
    fn shapes_have_their_extents_and_heights() {
        assert_eq!(top(ObjectKind::Block, 0.9, 0.4), 0.5);
        assert_eq!(top(ObjectKind::Block, 1.1, 0.0), 0.0);
        assert_eq!(top(ObjectKind::Block, 0.0, 0.6), 0.0);
        assert!((top(ObjectKind::Cylinder, 0.9, 0.0) - 0.5).abs() < 1e-12);
        assert!((top(ObjectKind::Cylinder, 0.0, 0.4999) - 0.25).abs() < 0.01);
        assert_eq!(top(ObjectKind::Tyre, 0.0, 0.0), 0.0);
        assert!((top(ObjectKind::Tyre, 0.7, 0.0) - 0.5).abs() < 1e-12);
        assert!((0.35..0.65).contains(&top(ObjectKind::Rock, 0.0, 0.0)));
        assert_eq!(top(ObjectKind::Rock, 0.8, 0.4), 0.0);
    }
}
