//! Generates random numbers that depend only on the seed, the purpose and the ping, so that pings
//! can be simulated in any order, and random fields that are smooth over the ground, so that a
//! place has the same value from whichever line it is surveyed.

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

/// Stream of random numbers, SplitMix64 (Steele, Lea and Flood 2014): small, fast, and good enough
/// for pictures.
pub(super) struct Random(u64);

impl Random {
    /// Creates the stream of one purpose; `index` distinguishes pings (or other items of the
    /// purpose).
    pub(super) fn new(seed: u64, purpose: RandomPurpose, index: u64) -> Self {
        Self(mix(mix(seed ^ mix(purpose as u64)).wrapping_add(index)))
    }

    /// Returns 64 random bits.
    pub(super) fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        mix(self.0)
    }

    /// Returns a uniform number between 0 and 1, both excluded.
    pub(super) fn unit(&mut self) -> f64 {
        ((self.bits() >> 12) as f64 + 0.5) / (1u64 << 52) as f64
    }

    /// Returns a uniform number between two numbers.
    pub(super) fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// Returns true with a probability.
    pub(super) fn chance(&mut self, probability: f64) -> bool {
        self.unit() < probability
    }

    /// Returns two independent normal numbers of mean 0 and variance 1 (Box and Muller).
    pub(super) fn normal_pair(&mut self) -> [f64; 2] {
        let radius = (-2.0 * ln(self.unit())).sqrt();
        let angle = 2.0 * PI * self.unit();
        [radius * cos(angle), radius * sin(angle)]
    }

    /// Returns a normal number of mean 0 and variance 1.
    pub(super) fn normal(&mut self) -> f64 {
        self.normal_pair()[0]
    }

    /// Returns an exponential number of mean 1: the power of an echo with fully developed speckle.
    pub(super) fn exponential(&mut self) -> f64 {
        -ln(self.unit())
    }
}

/// Mixes bits by SplitMix64's output function: every bit of the input changes about half of the
/// bits of the output.
pub(super) fn mix(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// Value noise: random numbers on a square lattice, smoothly interpolated between its points.
pub(super) struct NoiseField {
    key: u64,
    per_metre: f64,
}

/// Standard deviation of the interpolated field for lattice values between -1 and 1: sqrt(1/3) at
/// the lattice points, less between them (the mean of the squared weights over a cell is 0.5515).
const SPREAD: f64 = 0.4288;

impl NoiseField {
    /// Creates a field with lattice points `spacing_m` apart.
    pub(super) fn new(seed: u64, purpose: RandomPurpose, spacing_m: f64) -> Self {
        Self { key: mix(seed ^ mix(purpose as u64)), per_metre: 1.0 / spacing_m }
    }

    /// Returns the value at a place: mean 0, standard deviation 1, magnitude at most 2.4.
    pub(super) fn at(&self, east_m: f64, north_m: f64) -> f64 {
        let (x, y) = (east_m * self.per_metre, north_m * self.per_metre);
        let (column, row) = (x.floor(), y.floor());
        let (u, v) = (smooth(x - column), smooth(y - row));
        let (column, row) = (column as i64, row as i64);
        let low = self.between(column, row, u);
        let high = self.between(column, row + 1, u);
        (low + (high - low) * v) / SPREAD
    }

    fn between(&self, column: i64, row: i64, u: f64) -> f64 {
        let left = self.lattice(column, row);
        left + (self.lattice(column + 1, row) - left) * u
    }

    fn lattice(&self, column: i64, row: i64) -> f64 {
        let place = (column as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15)
            ^ (row as u64).wrapping_mul(0xc2b2_ae3d_27d4_eb4f);
        (mix(self.key ^ place) >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }
}

/// Returns a smooth step: 0 up to 0, 1 from 1 on, and flat at both ends.
pub(super) fn smooth(t: f64) -> f64 {
    let t = t.clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
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

    #[test]
    fn field_has_unit_spread_and_is_continuous() {
        let field = NoiseField::new(3, RandomPurpose::Texture, 0.7);
        let places = 200;
        let (mut sum, mut squares, mut step) = (0.0, 0.0, 0.0_f64);
        for i in 0..places {
            for j in 0..places {
                let (east, north) = (f64::from(i) * 0.33 - 20.0, f64::from(j) * 0.37 - 30.0);
                let value = field.at(east, north);
                sum += value;
                squares += value * value;
                step = step.max((field.at(east + 1e-4, north) - value).abs());
            }
        }
        let count = f64::from(places * places);
        let spread = (squares / count - (sum / count).powi(2)).sqrt();
        assert!((sum / count).abs() < 0.05, "{}", sum / count);
        assert!((spread - 1.0).abs() < 0.05, "{spread}");
        assert!(step < 2e-3, "{step}");
    }
}
