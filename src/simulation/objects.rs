//! Shapes objects and places them on the ground, as heights above it, so that highlight and shadow
//! follow from the geometry alone.

use super::arithmetic::{cos, from_db, sin};
use super::limbs::Limbs;
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
