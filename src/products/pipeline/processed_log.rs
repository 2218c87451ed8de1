//! A log with what the pipeline made of it.

use super::Products;
use bathyscope_log::survey::Survey;
use bathyscope_objects::targets::PassLog;
use std::sync::Arc;

/// A log of a survey and its results. Cheap to clone: every part is shared.
#[derive(Clone, Debug)]
pub struct ProcessedLog {
    /// The recording. All logs of one survey lie in the frame of the first ([`Survey::in_frame`]).
    pub survey: Arc<Survey>,
    /// Results of the recording, by its own settings and calibration.
    pub products: Products,
}

impl ProcessedLog {
    /// A log with its results. The survey is the judged one where they have one
    /// ([`Products::judged`]).
    pub fn new(survey: Arc<Survey>, products: Products) -> Self {
        Self { survey: products.judged.clone().unwrap_or(survey), products }
    }

    /// Returns the survey and navigation by which the passes of the boat are counted.
    pub fn pass_log(&self) -> PassLog<'_> {
        (&self.survey, &self.products.navigation)
    }

    /// The kept points, in the order of the cloud.
    pub fn kept_points(&self) -> impl Iterator<Item = &bathyscope_bottom::cloud::CloudPoint> {
        self.products.kept_points()
    }
}
