//! Random numbers that depend only on the seed, the purpose and the ping: pings can be simulated in
//! any order.

use super::arithmetic::{cos, ln, sin};
use std::f64::consts::PI;

/// Purpose of a stream of random numbers; part of its seed, so that no two purposes share numbers.
#[derive(Clone, Copy)]
pub(super) enum RandomPurpose {
    Bumps = 1,
    Canopy,
    Dropouts,
    Echogram,
    Fish,
    Fix,
    Interference,
    Objects,
    Outline,
    Patches,
    Plan,
    Roll,
    Roughness,
    Sounding,
    Speckle,
    Stems,
    Stones,
    Swells,
    Texture,
    Wander,
    Weed,
    Shape,
    Ripples,
    Shoal,
    Training,
    Position,
}

/// SplitMix64 (Steele, Lea and Flood 2014): small, fast, and good enough for pictures.
pub(super) struct Random(u64);

impl Random {
    /// The stream of one purpose; `index` distinguishes pings (or whatever else there are many of).
    pub(super) fn new(seed: u64, purpose: RandomPurpose, index: u64) -> Self {
        Self(mix(mix(seed ^ mix(purpose as u64)).wrapping_add(index)))
    }

    /// 64 random bits.
    pub(super) fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        mix(self.0)
    }

    /// Uniform between 0 and 1, neither included.
    pub(super) fn unit(&mut self) -> f64 {
        ((self.bits() >> 12) as f64 + 0.5) / (1u64 << 52) as f64
    }

    /// Uniform between two numbers.
    pub(super) fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// True with a probability.
    pub(super) fn chance(&mut self, probability: f64) -> bool {
        self.unit() < probability
    }

    /// Two independent normal numbers of mean 0 and variance 1 (Box and Muller).
    pub(super) fn normal_pair(&mut self) -> [f64; 2] {
        let radius = (-2.0 * ln(self.unit())).sqrt();
        let angle = 2.0 * PI * self.unit();
        [radius * cos(angle), radius * sin(angle)]
    }

    /// A normal number of mean 0 and variance 1.
    pub(super) fn normal(&mut self) -> f64 {
        self.normal_pair()[0]
    }

    /// An exponential number of mean 1: the power of a fully developed echo.
    pub(super) fn exponential(&mut self) -> f64 {
        -ln(self.unit())
    }
}

/// SplitMix64's output function: every bit of the input changes about half of the output's.
pub(super) fn mix(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn splitmix_gives_its_published_numbers() {
        // First outputs of the reference implementation for the state 1234567 (Vigna's
        // splitmix64.c).
        let mut random = Random(1_234_567);
        assert_eq!(random.bits(), 6_457_827_717_110_365_317);
        assert_eq!(random.bits(), 3_203_168_211_198_807_973);
    }

    #[test]
    fn moments_are_those_of_the_distributions() {
        let mut random = Random::new(7, RandomPurpose::Speckle, 3);
        let n = 100_000;
        let normal: Vec<f64> = (0..n).flat_map(|_| random.normal_pair()).collect();
        let mean = normal.iter().sum::<f64>() / normal.len() as f64;
        let variance = normal.iter().map(|x| x * x).sum::<f64>() / normal.len() as f64;
        let exponential = (0..n).map(|_| random.exponential()).sum::<f64>() / f64::from(n);
        assert!(mean.abs() < 0.01, "{mean}");
        assert!((variance - 1.0).abs() < 0.02, "{variance}");
        assert!((exponential - 1.0).abs() < 0.02, "{exponential}");
    }

    #[test]
    fn streams_differ_by_purpose_and_index() {
        let first = |purpose, index| Random::new(1, purpose, index).bits();
        assert_ne!(first(RandomPurpose::Speckle, 0), first(RandomPurpose::Speckle, 1));
        assert_ne!(first(RandomPurpose::Speckle, 0), first(RandomPurpose::Fish, 0));
    }
}
