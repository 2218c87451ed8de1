//! Draws random small surveys to train a detector, with all settings varied as recorders, waters
//! and bottoms vary.

use super::arithmetic::{atan, cos, exp, ln, sin};
use super::artefacts::absorption;
use super::listener::{Beam, backscatter};
use super::random::{Random, RandomPurpose, mix};
use super::scene::{
    Artefacts, Bank, BedKind, BedSettings, Curve, ObjectKind, ObjectSettings, Pit,
    RecorderSettings, RippleSettings, Scene, Shoal, TrackSettings, WeedClump,
};
use bathyscope_log::survey::Side;

/// A random survey, and the places at which pictures are cut out of it.
#[derive(Clone, Debug, PartialEq)]
pub struct TrainingScene {
    /// The survey.
    pub scene: Scene,
    /// Places of the pictures.
    pub looks: Vec<TrainingPlace>,
}

/// Place of a picture on one side of a survey, independent of its size in pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrainingPlace {
    /// Side of the boat.
    pub side: Side,
    /// Start of the picture along the track, as a share of all places where it can start: 0 to 1.
    pub along: f64,
    /// Start of the picture outward, as a share of all places where it can start: 0 to 1.
    pub outward: f64,
}

/// Metres of track in addition to those of the pictures, so that the starts of the pictures vary.
const SPARE_M: f64 = 4.0;
/// Largest number of objects of a survey.
const MOST_OBJECTS: u64 = 13;
/// Number of random places that are tried for an object.
const TRIES: usize = 12;
/// Share of surveys without objects, for a detector to learn ground without objects.
const EMPTY_SHARE: f64 = 0.08;

/// Returns the seed of scene `index` of a part (training, validation, test) of a dataset. The parts
/// share no scenes, and the first scenes of a part are the same however many follow.
pub fn training_seed(dataset_seed: u64, part: u64, index: u64) -> u64 {
    mix(mix(mix(dataset_seed).wrapping_add(part)).wrapping_add(index))
}

/// Draws a random survey along one line, straight or gently turning, with room for `looks` pictures
/// of `look_m` metres along the track: depth 1.2 to 6 m, range 8 to 30 m, any bed, up to thirteen
/// objects of all kinds, and things that are mistaken for objects. The same seed gives the same
/// scene.
pub fn training_scene(seed: u64, looks: usize, look_m: f64) -> TrainingScene {
    let mut random = Random::new(seed, RandomPurpose::Training, 0);
    let rows = looks.div_ceil(2).max(1);
    let length_m = rows as f64 * look_m + SPARE_M;
    let depth_m = log_between(&mut random, 1.2, 6.0);
    let range_m = log_between(&mut random, (3.0 * depth_m).max(8.0), (11.0 * depth_m).min(30.0));
    let mut scene = Scene {
        bed: bed(&mut random, depth_m, range_m),
        track: track(&mut random, length_m),
        recorder: recorder(&mut random, range_m, depth_m),
        artefacts: artefacts(&mut random),
        scattered_objects: 0,
        ..Scene::default()
    };
    let strip = Strip::new(&scene);
    scene.objects = objects(&mut random, &strip);
    scene.bed.pits = pits(&mut random, &strip);
    scene.shoals = shoals(&mut random, &strip);
    scene.weed_clumps = weed_clumps(&mut random, &strip);
    let first = usize::from(random.chance(0.5));
    let looks = (0..looks).map(|index| TrainingPlace {
        side: Side::BOTH[(first + index) % 2],
        along: ((index / 2) as f64 + random.unit()) / rows as f64,
        outward: if random.chance(0.5) { 0.0 } else { random.unit() },
    });
    TrainingScene { looks: looks.collect(), scene }
}

/// Draws a number between two numbers, uniform in the logarithm.
fn log_between(random: &mut Random, low: f64, high: f64) -> f64 {
    exp(random.between(ln(low), ln(high)))
}

/// Draws a whole number from 0 to `most`.
fn up_to(random: &mut Random, most: u64) -> u64 {
    random.bits() % (most + 1)
}

/// Draws a ground of a mean depth.
fn bed(random: &mut Random, depth_m: f64, range_m: f64) -> BedSettings {
    let kind = match random.bits() % 10 {
        0..=5 => BedKind::Gentle,
        6..=7 if depth_m > 2.5 => BedKind::Steep,
        _ => BedKind::Rough,
    };
    let ripples = random.chance(0.25).then(|| {
        let wavelength_m = log_between(random, 0.25, 1.2);
        RippleSettings {
            wavelength_m,
            height_m: wavelength_m * random.between(0.04, 0.12),
            heading_deg: random.between(0.0, 180.0),
        }
    });
    let bank = random.chance(0.12).then(|| Bank {
        length_m: 1000.0,
        width_m: 2.0 * range_m * random.between(0.6, 1.0),
        slope_deg: random.between(12.0, 35.0),
    });
    BedSettings {
        kind,
        mean_depth_m: depth_m,
        terrace: None,
        bank,
        ripples,
        ..BedSettings::default()
    }
}

/// Draws a line of a length, straight or gently turning.
fn track(random: &mut Random, length_m: f64) -> TrackSettings {
    let speed_mps = random.between(0.8, 3.2);
    let spacing_m = log_between(random, 0.05, 0.2);
    let bend_deg_per_m = if random.chance(0.3) { random.between(-1.5, 1.5) } else { 0.0 };
    TrackSettings {
        lines: 1,
        cross_lines: 0,
        length_m,
        speed_mps,
        ping_rate_hz: (speed_mps / spacing_m).min(60.0),
        bend_deg_per_m,
        ..TrackSettings::default()
    }
}

/// Draws a recorder of a range, over ground at a mean depth.
fn recorder(random: &mut Random, range_m: f64, depth_m: f64) -> RecorderSettings {
    let amplitude = random.chance(0.35);
    // Some recorders have so much gain that the ground is clipped.
    let loud = random.chance(0.12);
    let recorder = RecorderSettings {
        range_m,
        samples_per_side: 600 + 100 * up_to(random, 9) as u32,
        beam_axis_deg: random.between(25.0, 45.0),
        beam_width_deg: random.between(45.0, 70.0),
        beam_azimuth_deg: random.between(0.5, 1.2),
        pulse_m: log_between(random, 0.008, 0.03),
        tvg_limit_m: range_m * random.between(0.5, 1.1),
        tvg_power: random.between(3.4, 5.0),
        bottom_byte: if loud { random.between(150.0, 250.0) } else { random.between(80.0, 170.0) },
        bytes_per_db: random.between(1.8, 3.6),
        curve: if amplitude { Curve::Amplitude } else { Curve::Decibel },
        echo_ceiling: if loud || random.chance(0.3) { 127 } else { 255 },
        sonar_samples: 16,
        sonar_every: 20,
        ..RecorderSettings::default()
    };
    // The noise is as strong as the ground at some range, most often beyond the recorded range. The
    // noise fills the shadows: in the real effigy tiles the shadows are half as bright as the
    // ground beside them (0.22 to 0.75).
    let faint_m = range_m * random.between(0.75, 1.6);
    let electronic_noise = faint_echo(&recorder, faint_m, depth_m);
    RecorderSettings {
        electronic_noise,
        volume_noise: electronic_noise * faint_m * faint_m * random.between(0.05, 1.0),
        ..recorder
    }
}

/// Returns the power of one sample of level ground at a long range.
fn faint_echo(recorder: &RecorderSettings, range_m: f64, depth_m: f64) -> f64 {
    let beam = Beam::new(recorder, 1.0);
    let sine = depth_m / range_m;
    let across_m = (range_m * range_m - depth_m * depth_m).max(0.01).sqrt();
    let gain = beam.two_way_gain(atan(across_m / depth_m));
    let sample_m = recorder.range_m / f64::from(recorder.samples_per_side);
    let spread = beam.azimuth_rad * sample_m / (range_m * range_m * range_m);
    backscatter(sine * sine, 2.0)
        * gain
        * spread
        * absorption(recorder.absorption_db_per_km, range_m)
}

/// Draws the faults and disturbances, each in some of the surveys.
fn artefacts(random: &mut Random) -> Artefacts {
    let sometimes = |random: &mut Random, share: f64, low: f64, high: f64| {
        let value = random.between(low, high);
        if random.chance(share) { value } else { 0.0 }
    };
    Artefacts {
        gain_wander_db: random.between(0.0, 1.5),
        fish: sometimes(random, 0.5, 0.005, 0.06),
        interference: sometimes(random, 0.3, 0.005, 0.06),
        weed_m: sometimes(random, 0.15, 3.0, 9.0),
        gain_drop: 1.0 - sometimes(random, 0.1, 0.3, 0.85),
        second_echo_db: sometimes(random, 0.6, 12.0, 26.0),
        roll_deg: random.between(0.0, 4.0),
        dropouts: sometimes(random, 0.4, 0.002, 0.03),
        range_change: 1.0,
        surface_m: sometimes(random, 0.15, 0.4, 1.5),
        glints: sometimes(random, 0.3, 0.001, 0.02),
        ..Artefacts::default()
    }
}

/// The strip of ground that both sides insonify.
struct Strip {
    length_m: f64,
    bend_rad_per_m: f64,
    depth_m: f64,
    /// Nearest and farthest distance from the track at which things are placed, metres.
    aside_m: [f64; 2],
}

impl Strip {
    /// Creates the strip of a scene with a single line.
    fn new(scene: &Scene) -> Self {
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

    /// Draws a place, metres east and north. The line runs east through the middle of the scene.
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

/// Draws objects that do not overlap; none in some surveys.
fn objects(random: &mut Random, strip: &Strip) -> Vec<ObjectSettings> {
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

/// Draws an object of random kind, size, heading, burial and material, at the centre of the scene;
/// the caller sets its place. Another order of the numbers would change the survey of a seed.
fn object(random: &mut Random, depth_m: f64) -> ObjectSettings {
    let kind = ObjectKind::ALL[(random.bits() % 7) as usize];
    let [length_m, width_m, height_m] = usual_size_m(random, kind);
    let [weakest_db, strongest_db] = match kind {
        ObjectKind::Rock | ObjectKind::Log => [-4.0, 5.0],
        ObjectKind::Block => [-2.0, 8.0],
        ObjectKind::Cylinder => [-3.0, 8.0],
        ObjectKind::Tyre => [-4.0, 6.0],
        ObjectKind::Boat => [-3.0, 7.0],
        ObjectKind::Effigy => [-1.0, 10.0],
    };
    let strength_db = random.between(weakest_db, strongest_db);
    // No object is higher than 0.4 of the depth: the shadow of a higher one would have no end.
    let height_m = height_m.min(0.4 * depth_m);
    let burial = if random.chance(0.35) { random.between(0.0, 0.45) } else { 0.0 };
    ObjectSettings {
        kind,
        east_m: 0.0,
        north_m: 0.0,
        length_m,
        width_m,
        height_m,
        heading_deg: random.between(0.0, 360.0),
        buried_m: burial * height_m,
        strength_db: Some(strength_db),
    }
}

/// Draws a length, a width and a height that are usual for a kind, metres.
fn usual_size_m(random: &mut Random, kind: ObjectKind) -> [f64; 3] {
    match kind {
        ObjectKind::Rock => {
            // Boulders of a glacial river reach four metres (the recorded river shows some).
            let size_m = log_between(random, 0.5, 4.0);
            [size_m, size_m * random.between(0.65, 1.0), size_m * random.between(0.35, 0.7)]
        }
        ObjectKind::Block => {
            let size_m = log_between(random, 0.5, 1.6);
            [size_m, size_m * random.between(0.5, 1.0), size_m * random.between(0.4, 0.9)]
        }
        ObjectKind::Cylinder => {
            let thick_m = log_between(random, 0.2, 0.7);
            [(thick_m * random.between(3.0, 10.0)).clamp(1.0, 5.0), thick_m, thick_m]
        }
        ObjectKind::Tyre => {
            let size_m = log_between(random, 0.55, 1.3);
            [size_m, size_m, size_m * random.between(0.26, 0.34)]
        }
        ObjectKind::Boat => {
            let length_m = random.between(3.0, 5.2);
            [length_m, length_m * random.between(0.32, 0.42), random.between(0.45, 0.9)]
        }
        ObjectKind::Log => {
            let length_m = random.between(2.2, 7.0);
            [length_m, length_m * random.between(0.25, 0.5), random.between(0.2, 0.5)]
        }
        ObjectKind::Effigy => {
            [(1.55, 1.9), (0.7, 1.3), (0.22, 0.34)].map(|(low, high)| random.between(low, high))
        }
    }
}

/// Draws a few pits; none in most surveys.
fn pits(random: &mut Random, strip: &Strip) -> Vec<Pit> {
    let count = if random.chance(0.25) { up_to(random, 5) } else { 0 };
    let pit = |_| {
        let [east_m, north_m] = strip.place(random);
        let radius_m = log_between(random, 0.4, 2.0);
        Pit { east_m, north_m, radius_m, depth_m: radius_m * random.between(0.1, 0.35) }
    };
    (0..count).map(pit).collect()
}

/// Draws a few shoals, over the ground or near the track in the water column; none in most surveys.
fn shoals(random: &mut Random, strip: &Strip) -> Vec<Shoal> {
    let count = if random.chance(0.3) { 1 + up_to(random, 2) } else { 0 };
    let shoal = |_| {
        let [east_m, north_m] = strip.place(random);
        // Half of the shoals are near the track, in the water column.
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

/// Draws a few clumps of weed; none in most surveys.
fn weed_clumps(random: &mut Random, strip: &Strip) -> Vec<WeedClump> {
    let count = if random.chance(0.3) { 1 + up_to(random, 5) } else { 0 };
    let clump = |_| {
        let [east_m, north_m] = strip.place(random);
        WeedClump { east_m, north_m, diameter_m: log_between(random, 0.6, 4.0) }
    };
    (0..count).map(clump).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_random_scene_can_be_simulated_and_all_kinds_occur() {
        let mut kinds = std::collections::BTreeSet::new();
        for seed in 0..300 {
            let training = training_scene(seed, 6, 16.0);
            assert_eq!(training, training_scene(seed, 6, 16.0));
            let scene = training.scene;
            assert_eq!(scene.check(), Ok(()), "{seed}");
            kinds.extend(scene.objects.iter().map(|object| object.kind));
        }
        assert_eq!(kinds.len(), ObjectKind::ALL.len());
    }
}
