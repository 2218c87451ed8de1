//! Numbers that look random and are the same in every run, so that a failure can be repeated.

/// A generator of numbers, xorshift; it begins with any number but 0.
pub struct Random(pub u64);

impl Random {
    /// The next number below `end`, which is not 0.
    pub fn below(&mut self, end: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 % end as u64) as usize
    }
}

/// Numbers that look random and are the same in every run.
pub struct Moments(pub u64);

impl Moments {
    /// The next one, 0 to 1.
    pub fn share(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        (self.0 >> 33) as f64 / (1_u64 << 31) as f64
    }
}
