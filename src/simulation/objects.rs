//! Objects that lie on the ground, as heights above it: highlight and shadow then come from the geometry alone.

use super::arithmetic::{cos, sin};
use super::noise::Field;
use super::path::Path;
use super::random::{Purpose, Random};
use super::scene::{ObjectSettings, Scene};
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// What an object is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ObjectKind {
    /// A rounded, bumpy boulder.
    Rock,
    /// A crate or block with steep sides and a flat top.
    Block,
    /// A pipe, log or drum lying on its side.
    Cylinder,
    /// A tyre lying flat: a ring.
    Tyre,
}

impl ObjectKind {
    /// All kinds.
    pub const ALL: [ObjectKind; 4] = [
        ObjectKind::Rock,
        ObjectKind::Block,
        ObjectKind::Cylinder,
        ObjectKind::Tyre,
    ];

    /// One word, as in scenes and tables.
    pub fn name(self) -> &'static str {
        match self {
            ObjectKind::Rock => "rock",
            ObjectKind::Block => "block",
            ObjectKind::Cylinder => "cylinder",
            ObjectKind::Tyre => "tyre",
        }
    }
}

/// An object in its place.
pub struct Placed {
    /// What and where.
    pub settings: ObjectSettings,
    /// Radius of the circle that holds it, metres.
    pub reach_m: f64,
    forward: [f64; 2],
    bumps: Field,
}

/// Width of the sides of a block, metres: steep, but wide enough to be met by the rays.
const SIDE_M: f64 = 0.04;

impl Placed {
    fn new(settings: ObjectSettings, seed: u64) -> Self {
        let heading = settings.heading_deg.to_radians();
        let (length, width) = (settings.length_m, settings.width_m);
        Self {
            reach_m: 0.5 * (length * length + width * width).sqrt() + SIDE_M,
            forward: [sin(heading), cos(heading)],
            bumps: Field::new(seed, Purpose::Bumps, 0.3 * length.min(width)),
            settings,
        }
    }

    /// Height of the object's surface above the ground at a place, metres; 0 beside it.
    pub fn height_m(&self, east_m: f64, north_m: f64) -> f64 {
        let object = &self.settings;
        let (east, north) = (east_m - object.east_m, north_m - object.north_m);
        if east * east + north * north > self.reach_m * self.reach_m {
            return 0.0;
        }
        let along = east * self.forward[0] + north * self.forward[1];
        let across = east * self.forward[1] - north * self.forward[0];
        // Distances from the centre in half lengths and half widths.
        let (u, v) = (2.0 * along / object.length_m, 2.0 * across / object.width_m);
        let share = match object.kind {
            ObjectKind::Rock => {
                let bumpy = 1.0 + 0.12 * self.bumps.at(east, north);
                bumpy * (1.0 - u * u - v * v).max(0.0).sqrt()
            }
            ObjectKind::Block => {
                let inside =
                    (0.5 * object.length_m - along.abs()).min(0.5 * object.width_m - across.abs());
                ((inside + SIDE_M) / SIDE_M).clamp(0.0, 1.0)
            }
            ObjectKind::Cylinder if u.abs() > 1.0 => 0.0,
            ObjectKind::Cylinder => round(v),
            ObjectKind::Tyre => {
                // The ring's middle lies at 0.7 of the outer radius, its half thickness is 0.3 of it.
                round(((u * u + v * v).sqrt() - 0.7) / 0.3)
            }
        };
        object.height_m * share
    }
}

/// Upper half of a round section that touches the ground from above: 1 at the middle, 1/2 at the widest, 0 beyond.
fn round(offset: f64) -> f64 {
    if offset.abs() >= 1.0 {
        return 0.0;
    }
    0.5 + 0.5 * (1.0 - offset * offset).sqrt()
}

/// All objects of the scene: those it names, then those scattered beside the lines.
pub fn place(scene: &Scene, path: &Path, seed: u64) -> Vec<Placed> {
    let mut random = Random::new(seed, Purpose::Objects, 0);
    let scattered = (0..scene.scattered_objects).map(|_| scatter(path, &mut random));
    let all: Vec<ObjectSettings> = scene.objects.iter().cloned().chain(scattered).collect();
    all.into_iter()
        .enumerate()
        .map(|(index, settings)| Placed::new(settings, seed.wrapping_add(index as u64)))
        .collect()
}

/// How far scattered objects lie off the way at most, metres. They may lie under the boat: nobody knows where they are
/// before the survey, and there the object is what is first heard.
const OFF_M: f64 = 7.0;

/// A random object beside or below a random point of the way.
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
        ObjectKind::Tyre => (0.7, 0.7, 0.22),
    };
    ObjectSettings {
        kind,
        east_m: pose.east_m + off * forward_north,
        north_m: pose.north_m - off * forward_east,
        length_m,
        width_m,
        height_m,
        heading_deg: (random.between(0.0, PI)).to_degrees(),
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
        };
        // Heading 90 degrees: along is east, across is south.
        Placed::new(settings, 1).height_m(10.0 + along, -4.0 - across)
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
