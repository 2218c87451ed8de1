//! Random small surveys for a detector to learn from: every setting varied, as recorders, waters
//! and bottoms vary.

mod settings;
mod strewn;

use super::arithmetic::{exp, ln};
use super::random::{Random, RandomPurpose, mix};
use super::scene::Scene;
use bathyscope_log::survey::Side;
use settings::{artefacts, bed, recorder, track};
use strewn::{Strip, objects, pits, shoals, weed_clumps};

/// A random survey, and where to cut pictures out of it.
#[derive(Clone, Debug, PartialEq)]
pub struct TrainingScene {
    /// The survey.
    pub scene: Scene,
    /// The pictures.
    pub looks: Vec<TrainingPlace>,
}

/// A place on one side of a survey, whatever its size in pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrainingPlace {
    /// The side.
    pub side: Side,
    /// Start of the picture along the track, as a share of all places where it can start: 0 to 1.
    pub along: f64,
    /// Start of the picture outward, as a share of all places where it can start: 0 to 1.
    pub outward: f64,
}

/// Metres of track beyond what the pictures need, so that they do not all start alike.
const SPARE_M: f64 = 4.0;

/// The seed of a scene: the `index`th of a part of a dataset (training, validation, test). No scene
/// of one part is one of another, and a part's first scenes are the same however many follow.
pub fn training_seed(dataset_seed: u64, part: u64, index: u64) -> u64 {
    mix(mix(mix(dataset_seed).wrapping_add(part)).wrapping_add(index))
}

/// A random survey along one line, straight or gently turning, that holds `looks` pictures of
/// `look_m` metres along the track: depth 1.2 to 6 m, range 8 to 30 m, any bed, up to thirteen
/// objects of all kinds and what is mistaken for them. The same seed gives the same scene.
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

/// Uniform in the logarithm.
fn log_between(random: &mut Random, low: f64, high: f64) -> f64 {
    exp(random.between(ln(low), ln(high)))
}

/// A whole number from 0 to `most`.
fn up_to(random: &mut Random, most: u64) -> u64 {
    random.bits() % (most + 1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ObjectKind;

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
