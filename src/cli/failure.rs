//! Failure of a command.

use std::fmt::Display;

/// Failure that ends a command. Errors and sentences are converted to it by `?`. It does not
/// implement `Display`: a failure is never made of another.
#[derive(Debug)]
pub(super) struct Failure {
    /// Message that is printed.
    pub sentence: String,
}

impl<E: Display> From<E> for Failure {
    fn from(error: E) -> Self {
        Self { sentence: error.to_string() }
    }
}
