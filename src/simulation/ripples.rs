//! Shapes that water makes of sand: ripples in patches, pits scoured out of it, and mounds and
//! hollows.

use super::arithmetic::{cos, exp, sin};
use super::noise::{NoiseField, smooth};
use super::random::RandomPurpose;
use super::scene::{Mound, Pit, RippleSettings};
use std::f64::consts::PI;

/// Size of the patches that the ripples lie in, and of the bends of their crests, metres.
const PATCH_M: (f64, f64) = (6.0, 2.5);
/// Bend of a crest, in wavelengths (standard deviation).
const BEND: f64 = 0.25;

/// Ripples over the ground.
pub(super) struct Ripples {
    amplitude_m: f64,
    /// Radians per metre east and north.
    wave: [f64; 2],
    patches: NoiseField,
    bends: NoiseField,
}

impl Ripples {
    /// Ripples whose patches and bends come from the seed.
    pub(super) fn new(settings: &RippleSettings, seed: u64) -> Self {
        let number = 2.0 * PI / settings.wavelength_m;
        let direction = settings.heading_deg.to_radians();
        Self {
            amplitude_m: 0.5 * settings.height_m,
            wave: [number * sin(direction), number * cos(direction)],
            patches: NoiseField::new(seed, RandomPurpose::Ripples, PATCH_M.0),
            bends: NoiseField::new(seed.wrapping_add(1), RandomPurpose::Ripples, PATCH_M.1),
        }
    }

    /// Height of the ripples at a place, metres; the mean is 0.
    pub(super) fn height_m(&self, east_m: f64, north_m: f64) -> f64 {
        let share = smooth(0.8 + 0.8 * self.patches.at(east_m, north_m));
        if share == 0.0 {
            return 0.0;
        }
        let bend = 2.0 * PI * BEND * self.bends.at(east_m, north_m);
        let phase = self.wave[0] * east_m + self.wave[1] * north_m + bend;
        let crest = sin(phase);
        // Narrow crests, wide troughs.
        share * self.amplitude_m * (crest + 0.4 * crest * crest - 0.2)
    }
}

/// Square of the distance, in radii, beyond which a mound is lower than the last digit of any
/// depth: e to the power of -50 of its height.
const FAR: f64 = 100.0;

impl Mound {
    /// Returns the height that is added to the ground at a place, metres.
    pub fn height_at_m(&self, east_m: f64, north_m: f64) -> f64 {
        let (east, north) = (east_m - self.east_m, north_m - self.north_m);
        let off = (east * east + north * north) / (self.radius_m * self.radius_m);
        if off > FAR { 0.0 } else { self.height_m * exp(-0.5 * off) }
    }
}

impl Pit {
    /// Returns the depth of the pit at a place, below the ground around it, metres; negative on the
    /// rim, where the scoured-out sand lies.
    pub(crate) fn depth_at_m(&self, east_m: f64, north_m: f64) -> f64 {
        let (east, north) = (east_m - self.east_m, north_m - self.north_m);
        let off = (east * east + north * north) / (self.radius_m * self.radius_m);
        if off < 1.0 {
            return self.depth_m * (1.0 - off) * (1.0 - off);
        }
        // The rim is highest midway of a ring half a radius wide.
        let rim = (off - 1.0) * (2.25 - off);
        if rim > 0.0 { -0.4 * self.depth_m * rim * rim } else { 0.0 }
    }
}
