//! The seam between a network and what runs it.

use super::Unusable;

/// What a compiled network gives for one picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Output {
    /// Name in the file.
    pub name: String,
    /// Sizes, the batch's first.
    pub shape: Vec<usize>,
    /// The numbers, the last size's the fastest.
    pub values: Vec<f32>,
}

/// A compiled network of fixed input size. It is run from several threads at once, one picture a
/// run: for small networks that is faster than batches and than threads within a run.
pub trait Inference: Send + Sync {
    /// Runs one picture through; `input` holds as many numbers as the input has.
    fn run(&self, input: Vec<f32>) -> Result<Vec<Output>, Unusable>;
}
