//! Requests for the files of a run, and the conditions under which each file is written.

use super::error::OutputError;
use super::product::Product;
use crate::pipeline::joint::RequestedCorrection;
use crate::pipeline::{Derived, ProcessedLog, Reference};
use bathyscope_bottom::bathymetry::compare::Matching;
use bathyscope_objects::Model;
use bathyscope_objects::objects::SurveyReview;
use std::sync::Arc;

/// Condition under which a run writes a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum When {
    /// Every run writes it.
    Always,
    /// It belongs to a group that is chosen.
    Chosen(Product),
    /// A run that compares with a reference writes it.
    Compared,
    /// A run that searches for objects writes it.
    Searched,
    /// A run that searches for objects, or has a review of them, writes it.
    Listed,
}

/// Request for the files of a run: logs, products, and an optional comparison and search.
pub struct Order<'a> {
    /// The logs that the files are of, with what the pipeline made of them: one, or all of a
    /// survey, in the frame of the first.
    pub logs: &'a [ProcessedLog],
    /// Results that are computed from all logs together, each once.
    pub derived: &'a Derived,
    /// Products to write in addition to the tables of pings and points, `report.json` and the
    /// manifest.
    pub requested: &'a [Product],
    /// Reference that the depths are compared with, and how a point finds its reference.
    pub reference: Option<(&'a Arc<Reference>, Matching)>,
    /// Model that searches for objects: these are written as `detections.*` and `chips`.
    pub search: Option<&'a Model>,
    /// Boxes of each log that were found before and decided about: the report shows them, before
    /// those of a search.
    pub review: &'a SurveyReview,
    /// Results of the requested corrections of positions and heights: the report lists them.
    pub corrections: &'a [RequestedCorrection],
}

impl Order<'_> {
    /// Returns true if files that are written at such a time are to be written.
    pub(super) fn asks_for(&self, when: When) -> bool {
        match when {
            When::Always => true,
            When::Chosen(product) => self.requested.contains(&product),
            When::Compared => self.reference.is_some(),
            // Without side-scan there is nothing to search.
            When::Searched => {
                let mut surveys = self.logs.iter().map(|log| &log.survey);
                self.search.is_some() && surveys.any(|survey| survey.has_side_scan())
            }
            When::Listed => self.review.has_boxes() || self.asks_for(When::Searched),
        }
    }
}

/// Checks that the logs still hold what files were made of: done when all files are made, before
/// they are put in place.
///
/// # Errors
/// Names a log that does not.
pub(super) fn check_logs(logs: &[ProcessedLog]) -> Result<(), OutputError> {
    let mut surveys = logs.iter().map(|log| &log.survey);
    Ok(surveys.try_for_each(|survey| survey.check_files())?)
}
