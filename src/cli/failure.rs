//! Why a command ends.

use std::fmt::Display;

/// Why a command ends. Errors and sentences become one with `?`. It is no `Display` itself: a
/// failure is never made of another.
#[derive(Debug)]
pub(super) struct Failure {
    /// What is printed.
    pub sentence: String,
}

impl<E: Display> From<E> for Failure {
    fn from(error: E) -> Self {
        Self { sentence: error.to_string() }
    }
}
