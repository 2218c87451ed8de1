//! Random numbers for tests that harm bytes: the same in every run, so that a failure can be repeated. It depends on no other module; any may
//! use it.

/// A generator of numbers, xorshift; it begins with any number but 0.
pub(crate) struct Random(pub(crate) u64);

impl Random {
    /// The next number below `end`, which is not 0.
    pub(crate) fn below(&mut self, end: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 % end as u64) as usize
    }
}
