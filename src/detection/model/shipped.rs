//! The model that comes with the program.

use super::{Model, ModelError};

/// The model that comes with the program; `None` in a build without one.
pub fn shipped() -> Option<Result<Model, ModelError>> {
    None
}
