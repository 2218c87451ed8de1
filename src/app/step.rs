//! Defines the state that undo restores, and the figure in it that the analyst draws to measure.

use super::mounting::Mountings;
use super::planning::PlannedLines;
use super::{LogId, OpenLog};
use bathyscope_objects::review::Review;
use bathyscope_products::pipeline::{LogSettings, Settings};
use bathyscope_products::project::Measurement;
use std::sync::Arc;

/// State that undo restores: everything that an analyst changes.
#[derive(Clone, PartialEq)]
pub struct UndoStep {
    pub(super) shared: Arc<Settings>,
    /// The logs in the order of the list.
    pub(super) logs: Vec<LogStep>,
    /// Ids of the logs that are closed and can be opened again.
    pub(super) closed: Vec<LogId>,
    pub(super) figure: Option<Arc<Figure>>,
    pub(super) planned: Option<Arc<PlannedLines>>,
    pub(super) mountings: Arc<Mountings>,
}

/// A figure that the analyst draws to measure.
#[derive(Clone, Debug, PartialEq)]
pub struct Figure {
    /// Kind of the measurement, and its corners.
    pub measurement: Measurement,
    /// True if the figure is ended, so that the next corner begins another one.
    pub done: bool,
}

/// State of one log that undo restores.
#[derive(Clone)]
pub(super) struct LogStep {
    pub id: LogId,
    pub is_visible: bool,
    pub own: Arc<LogSettings>,
    pub review: Arc<Review>,
}

impl LogStep {
    /// Returns the present state of a log, as undo would restore it.
    pub(super) fn of(log: &OpenLog) -> Self {
        Self {
            id: log.id,
            is_visible: log.is_visible,
            own: log.own.clone(),
            review: log.reviewing.review.clone(),
        }
    }
}

/// Equality of reviews means the same version in memory, which undo restores as it was.
impl PartialEq for LogStep {
    fn eq(&self, other: &Self) -> bool {
        self.id == other.id
            && self.is_visible == other.is_visible
            && Arc::ptr_eq(&self.review, &other.review)
            && (Arc::ptr_eq(&self.own, &other.own) || self.own == other.own)
    }
}
