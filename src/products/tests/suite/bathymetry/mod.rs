//! Surfaces and what is drawn from them, against what other programs make of the same numbers and
//! against simulated truth.

mod change;
mod height_offsets;
mod isobaths;
mod ponds;

/// Uniform numbers from a seed, and normal ones as sums of twelve of them.
struct Dice(u64);

impl Dice {
    /// Returns a random number from 0 to 1.
    fn uniform(&mut self) -> f64 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Returns a normally distributed random number with a mean of zero.
    fn normal(&mut self, sd: f64) -> f64 {
        sd * ((0..12).map(|_| self.uniform()).sum::<f64>() - 6.0)
    }
}
