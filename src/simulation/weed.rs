//! Models a bed of water weed: a canopy whose echo comes before that of the ground.

use super::path::Path;
use super::random::{NoiseField, Random, RandomPurpose, smooth};

/// A round bed of weed.
pub(super) struct WeedBed {
    east_m: f64,
    north_m: f64,
    radius_m: f64,
    outline: NoiseField,
    height: NoiseField,
    stems: NoiseField,
}

/// Lowest and highest height of the canopy above the ground, metres.
const CANOPY_M: (f64, f64) = (0.25, 0.45);
/// Irregularity of the outline, as a share of the radius (standard deviation).
const RAGGED: f64 = 0.25;
/// Width of the rim over which the canopy slopes down to the ground, metres.
const RIM_M: f64 = 1.0;

impl WeedBed {
    /// Creates a bed of a diameter at a random place of the way, away from the ends of the way;
    /// `None` for a diameter of 0 or less.
    pub(super) fn new(diameter_m: f64, path: &Path, seed: u64) -> Option<Self> {
        if diameter_m <= 0.0 {
            return None;
        }
        let mut random = Random::new(seed, RandomPurpose::Weed, 0);
        let pose = path.at(random.between(0.1, 0.9) * path.length_m());
        Some(Self::at([pose.east_m, pose.north_m], diameter_m, seed))
    }

    /// Creates a bed of a diameter around a place (east and north, metres).
    pub(super) fn at([east_m, north_m]: [f64; 2], diameter_m: f64, seed: u64) -> Self {
        Self {
            east_m,
            north_m,
            radius_m: 0.5 * diameter_m,
            outline: NoiseField::new(seed, RandomPurpose::Outline, 0.2 * diameter_m),
            height: NoiseField::new(seed, RandomPurpose::Canopy, 0.8),
            stems: NoiseField::new(seed, RandomPurpose::Stems, 0.25),
        }
    }

    /// Returns true if the bed is within a distance of a place.
    pub(super) fn is_near(&self, east_m: f64, north_m: f64, distance_m: f64) -> bool {
        self.inside(east_m, north_m) > -distance_m
    }

    /// Returns the approximate distance of a place to the rim of the bed, metres; negative outside.
    fn inside(&self, east_m: f64, north_m: f64) -> f64 {
        let (east, north) = (east_m - self.east_m, north_m - self.north_m);
        // The irregular outline is never outside of the radius, so that it is not computed there.
        let beyond = self.radius_m - (east * east + north * north).sqrt();
        if beyond < 0.0 {
            return beyond;
        }
        let ragged = RAGGED * self.radius_m * self.outline.at(east, north);
        beyond - ragged.abs()
    }

    /// Returns the height of the canopy above the ground at a place, metres; 0 outside of the bed.
    pub(super) fn height_m(&self, east_m: f64, north_m: f64) -> f64 {
        let inside = self.inside(east_m, north_m);
        if inside <= 0.0 {
            return 0.0;
        }
        let (low, high) = CANOPY_M;
        let middle =
            0.5 * (low + high) + 0.5 * (high - low) * self.height.at(east_m, north_m) / 2.4;
        middle * smooth(inside / RIM_M)
    }

    /// Returns the density of the weed at a place: 0 (a gap) to about 3.
    pub(super) fn density(&self, east_m: f64, north_m: f64) -> f64 {
        let rim = smooth(self.inside(east_m, north_m) / RIM_M);
        rim * (1.0 + 0.9 * self.stems.at(east_m, north_m)).max(0.0)
    }
}
