//! Known objects in a survey, and their comparison with a review's boxes.
//!
//! In: a file of known objects, and the boxes of a review. Out: which boxes are right, and the
//! mistakes.
//!
//! `file` reads it: the table of objects that `bathyscope simulate` writes, or a review of the same
//! log by somebody who knew. `raster_truth` puts it into the survey's raster and leaves out what
//! nobody could see; `compare` pairs it with boxes.

mod compare;
mod file;
mod raster_truth;
#[cfg(test)]
mod tests;

pub use compare::{Mistake, Standing, TruthComparison};
pub use file::{TruthError, TruthFileError};
pub use raster_truth::RasterTruth;

use super::dataset::KnownObject;

/// End of the name of the table of objects that `bathyscope simulate` writes next to a log, in
/// place of the log's own.
pub const SIDECAR: &str = "objects.csv";

/// Objects whose place in a survey is known.
#[derive(Clone, Debug, PartialEq)]
pub struct SurveyTruth {
    /// Class names that [`KnownObject::class`] means.
    pub classes: Vec<String>,
    /// The objects, one entry for each pass that insonified one.
    pub objects: Vec<KnownObject>,
    /// Somebody drew the boxes because they saw something there: all of them count. Otherwise they
    /// follow from geometry, and what does not stand out in the picture is neither to be found nor
    /// to be missed.
    pub was_seen: bool,
}

impl SurveyTruth {
    /// Name of a class; empty for an index that has none.
    pub fn class_name(&self, class: usize) -> &str {
        self.classes.get(class).map_or("", String::as_str)
    }
}
