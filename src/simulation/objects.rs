//! Places objects on the ground, as heights above it, so that highlight and shadow follow from the
//! geometry alone.

use super::arithmetic::{cos, from_db, sin};
use super::path::Path;
use super::random::{Random, RandomPurpose};
use super::scene::{ObjectKind, ObjectSettings, Scene};
use super::shape::{SIDE_M, Shape};
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
