//! Draws what lies on the bottom and swims in a random survey: objects, and what is mistaken for
//! them.

use super::{log_between, up_to};
use crate::arithmetic::{cos, sin};
use crate::object_kind::ObjectKind;
use crate::random::Random;
use crate::scene::{ObjectSettings, Pit, Scene, Shoal, WeedClump};

/// Most objects of a survey.
const MOST_OBJECTS: u64 = 13;
/// Places that are tried for an object.
const TRIES: usize = 12;
/// Surveys without any object, to learn what is none.
const EMPTY_SHARE: f64 = 0.08;

/// The ground that both sides insonify.
pub(super) struct Strip {
    length_m: f64,
    bend_rad_per_m: f64,
    depth_m: f64,
    /// Nearest and farthest distance from the track worth placing something, metres.
    aside_m: [f64; 2],
}

impl Strip {
    /// The ground of a scene with a single line.
    pub(super) fn new(scene: &Scene) -> Self {
        let (depth_m, range_m) = (scene.bed.mean_depth_m, scene.recorder.range_m);
        let mut far_m = (range_m * range_m - depth_m * depth_m).max(1.0).sqrt();
        if let Some(bank) = &scene.bed.bank {
            far_m = far_m.min(0.5 * bank.width_m - 2.0);
        }
        Self {
            length_m: scene.track.length_m,
            bend_rad_per_m: scene.track.bend_deg_per_m.to_radians(),
            depth_m,
            aside_m: [0.5 * depth_m, (0.95 * far_m).max(0.5 * depth_m + 1.0)],
        }
    }

    /// A random place, metres east and north. The line runs east through the middle of the scene.
    fn place(&self, random: &mut Random) -> [f64; 2] {
        let along_m = random.unit() * self.length_m;
        let [near, far] = self.aside_m;
        let side = if random.chance(0.5) { 1.0 } else { -1.0 };
        let right_m = side * random.between(near, far);
        let turn = self.bend_rad_per_m * along_m;
        let start = -0.5 * self.length_m;
        let (ahead, aside) = if turn.abs() < 1e-6 {
            (along_m, 0.0)
        } else {
            let radius = 1.0 / self.bend_rad_per_m;
            (radius * sin(turn), radius * (1.0 - cos(turn)))
        };
        [start + ahead - right_m * sin(turn), -aside - right_m * cos(turn)]
    }
}

/// Objects that leave each other room; none in some surveys.
pub(super) fn objects(random: &mut Random, strip: &Strip) -> Vec<ObjectSettings> {
    let mut objects: Vec<ObjectSettings> = Vec::new();
    if random.chance(EMPTY_SHARE) {
        return objects;
    }
    for _ in 0..3 + up_to(random, MOST_OBJECTS - 3) {
        let object = object(random, strip.depth_m);
        let reach = |object: &ObjectSettings| 0.5 * object.length_m.max(object.width_m) + 0.3;
        let free = (0..TRIES).map(|_| strip.place(random)).find(|place| {
            objects.iter().all(|other| {
                let (east, north) = (place[0] - other.east_m, place[1] - other.north_m);
                let room = reach(&object) + reach(other);
                east * east + north * north > room * room
            })
        });
        if let Some([east_m, north_m]) = free {
            objects.push(ObjectSettings { east_m, north_m, ..object });
        }
    }
    objects
}

/// An object of random kind, size, pose, burial and material; its place is still open.
fn object(random: &mut Random, depth_m: f64) -> ObjectSettings {
    let kind = ObjectKind::ALL[(random.bits() % 7) as usize];
    let build = Build::random(random, kind);
    // Nothing reaches up through half of the water: its shadow would have no end.
    let height_m = build.height_m.min(0.4 * depth_m);
    let burial = if random.chance(0.35) { random.between(0.0, 0.45) } else { 0.0 };
    ObjectSettings {
        kind,
        east_m: 0.0,
        north_m: 0.0,
        length_m: build.length_m,
        width_m: build.width_m,
        height_m,
        heading_deg: random.between(0.0, 360.0),
        buried_m: burial * height_m,
        strength_db: Some(build.strength_db),
    }
}

/// Size and material of an object.
struct Build {
    length_m: f64,
    width_m: f64,
    height_m: f64,
    /// The strength of the material's echo over that of the ground, dB.
    strength_db: f64,
}

impl Build {
    /// Draws a build that is usual for the kind. The numbers are drawn in the order of the fields:
    /// another order makes another survey of a seed.
    fn random(random: &mut Random, kind: ObjectKind) -> Self {
        match kind {
            ObjectKind::Rock => {
                // Boulders of a glacial river reach four metres (the recorded river shows some).
                let size_m = log_between(random, 0.5, 4.0);
                Self {
                    length_m: size_m,
                    width_m: size_m * random.between(0.65, 1.0),
                    height_m: size_m * random.between(0.35, 0.7),
                    strength_db: random.between(-4.0, 5.0),
                }
            }
            ObjectKind::Block => {
                let size_m = log_between(random, 0.5, 1.6);
                Self {
                    length_m: size_m,
                    width_m: size_m * random.between(0.5, 1.0),
                    height_m: size_m * random.between(0.4, 0.9),
                    strength_db: random.between(-2.0, 8.0),
                }
            }
            ObjectKind::Cylinder => {
                let thick_m = log_between(random, 0.2, 0.7);
                Self {
                    length_m: (thick_m * random.between(3.0, 10.0)).clamp(1.0, 5.0),
                    width_m: thick_m,
                    height_m: thick_m,
                    strength_db: random.between(-3.0, 8.0),
                }
            }
            ObjectKind::Tyre => {
                let size_m = log_between(random, 0.55, 1.3);
                Self {
                    length_m: size_m,
                    width_m: size_m,
                    height_m: size_m * random.between(0.26, 0.34),
                    strength_db: random.between(-4.0, 6.0),
                }
            }
            ObjectKind::Boat => {
                let length_m = random.between(3.0, 5.2);
                Self {
                    length_m,
                    width_m: length_m * random.between(0.32, 0.42),
                    height_m: random.between(0.45, 0.9),
                    strength_db: random.between(-3.0, 7.0),
                }
            }
            ObjectKind::Log => {
                let length_m = random.between(2.2, 7.0);
                Self {
                    length_m,
                    width_m: length_m * random.between(0.25, 0.5),
                    height_m: random.between(0.2, 0.5),
                    strength_db: random.between(-4.0, 5.0),
                }
            }
            ObjectKind::Effigy => Self {
                length_m: random.between(1.55, 1.9),
                width_m: random.between(0.7, 1.3),
                height_m: random.between(0.22, 0.34),
                strength_db: random.between(-1.0, 10.0),
            },
        }
    }
}

/// A few pits, in some surveys.
pub(super) fn pits(random: &mut Random, strip: &Strip) -> Vec<Pit> {
    let count = if random.chance(0.25) { up_to(random, 5) } else { 0 };
    let pit = |_| {
        let [east_m, north_m] = strip.place(random);
        let radius_m = log_between(random, 0.4, 2.0);
        Pit { east_m, north_m, radius_m, depth_m: radius_m * random.between(0.1, 0.35) }
    };
    (0..count).map(pit).collect()
}

/// A few shoals, in some surveys: over the ground, or near the track in the water column.
pub(super) fn shoals(random: &mut Random, strip: &Strip) -> Vec<Shoal> {
    let count = if random.chance(0.3) { 1 + up_to(random, 2) } else { 0 };
    let shoal = |_| {
        let [east_m, north_m] = strip.place(random);
        // Half of them are near the track, in the water column.
        let nearer = if random.chance(0.5) { 0.3 } else { 1.0 };
        let north_m = nearer * north_m;
        Shoal {
            east_m,
            north_m,
            depth_m: strip.depth_m * random.between(0.3, 0.9),
            radius_m: random.between(0.3, 1.5),
            count: 1 + up_to(random, 39) as u32,
            strength_db: random.between(-14.0, 0.0),
        }
    };
    (0..count).map(shoal).collect()
}

/// A few clumps of weed, in some surveys.
pub(super) fn weed_clumps(random: &mut Random, strip: &Strip) -> Vec<WeedClump> {
    let count = if random.chance(0.3) { 1 + up_to(random, 5) } else { 0 };
    let clump = |_| {
        let [east_m, north_m] = strip.place(random);
        WeedClump { east_m, north_m, diameter_m: log_between(random, 0.6, 4.0) }
    };
    (0..count).map(clump).collect()
}
