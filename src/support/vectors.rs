//! Loops compiled for the widest vectors that a processor has.

/// A loop over numbers that is compiled for each kind of processor.
pub(crate) trait VectorLoop {
    /// What it gives.
    type Output;

    /// Runs it. Every implementation, and every function that it calls in its loops, is marked `#[inline(always)]`: what is not inlined, a
    /// closure too, stays as compiled for what all processors have.
    fn run(self) -> Self::Output;
}

/// Runs a loop as compiled for the widest vectors of this processor. Numbers come out the same to the bit.
pub(crate) fn vectorised<L: VectorLoop>(work: L) -> L::Output {
    pulp::Arch::new().dispatch(Work(work))
}

struct Work<L>(L);

impl<L: VectorLoop> pulp::WithSimd for Work<L> {
    type Output = L::Output;

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) -> L::Output {
        self.0.run()
    }
}
