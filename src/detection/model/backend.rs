//! The seam between a network and what runs it.

use super::Unusable;

/// What a compiled network gives for one picture.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Output {
    /// Name in the file.
    pub name: String,
    /// Sizes, the batch's first.
    pub shape: Vec<usize>,
    /// The numbers, the last size's the fastest.
    pub values: Vec<f32>,
}

/// A compiled network of fixed input size. It is run from several threads at once, one picture a run: for small networks
/// that is faster than batches and than threads within a run.
pub(crate) trait Inference: Send + Sync {
    /// Runs one picture through; `input` holds as many numbers as the input has.
    fn run(&self, input: Vec<f32>) -> Result<Vec<Output>, Unusable>;

    /// States how many pictures follow, so that what is worth its start for as many is started.
    fn prepare(&self, _pictures: usize) {}

    /// Keeps it from all but the processor, as a baseline; before [`Self::prepare`].
    #[cfg(feature = "bench")]
    fn keep_to_processor(&self) {}

    /// Which part of the computer runs it, as `run by ...`; `None` where there is no choice, or none was made yet.
    fn runs_on(&self) -> Option<String> {
        None
    }
}
