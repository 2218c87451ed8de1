//! Holds the decisions about the boxes of a survey.

use super::{LogBox, LogId, LogNumbers, ObjectBox, ObjectNumbers};
use crate::review::{Review, Reviewed};
use crate::targets::Target;
use bathyscope_log::survey::Exclusions;
use std::sync::Arc;

/// The boxes of a log, and the score from which they are shown.
#[derive(Clone, Debug)]
pub struct LogReview {
    /// The log.
    pub log: LogId,
    /// Boxes with the decisions about them.
    pub review: Arc<Review>,
    /// Least score of a shown undecided proposal.
    pub threshold: f32,
}

impl LogReview {
    /// Returns the boxes that count: those whose middle is not in an excluded stretch. Hidden boxes
    /// count too, so that no filter changes what is measured.
    pub fn boxes<'a>(
        &'a self,
        exclusions: &'a Exclusions,
    ) -> impl Iterator<Item = &'a Arc<Reviewed>> {
        let counts =
            |review_box: &&Arc<Reviewed>| !exclusions.is_middle_excluded(&review_box.mark.pings);
        self.review.shared().iter().filter(counts)
    }

    /// Creates the entry of a box for the list of objects; `log` is the index of the log in the
    /// survey, `target` the position and size of the box.
    pub fn object_box(
        &self,
        log: usize,
        review_box: &Arc<Reviewed>,
        target: Option<Target>,
    ) -> ObjectBox {
        ObjectBox {
            log,
            key: LogBox { log: self.log, id: review_box.id },
            class: self.review.class_name(review_box.class).to_owned(),
            one: review_box.clone(),
            target,
            object: None,
            is_hidden: !review_box.is_shown_from(self.threshold),
        }
    }
}

/// The boxes of a log as they are stored in a project or a file.
#[derive(Clone, Debug)]
pub struct KeptReview {
    /// Boxes with the decisions about them.
    pub review: Arc<Review>,
    /// Numbers of the objects that the boxes show.
    pub object_numbers: LogNumbers,
    /// Least score of a shown undecided proposal.
    pub threshold: f32,
}

/// Converts a review from a file of its own, which holds no object numbers and no least score: all
/// its boxes are shown.
impl From<Review> for KeptReview {
    fn from(review: Review) -> Self {
        Self { review: Arc::new(review), object_numbers: LogNumbers::default(), threshold: 0.0 }
    }
}

/// Boxes of all logs of a survey with the decisions about them, and the numbers of the objects.
#[derive(Clone, Debug, Default)]
pub struct SurveyReview {
    /// Boxes of each log; `None` for a log without boxes.
    pub logs: Vec<Option<LogReview>>,
    /// Numbers of the objects.
    pub numbers: ObjectNumbers,
}

impl SurveyReview {
    /// Adds the boxes of the next log, if it has any.
    pub fn add(&mut self, kept: Option<KeptReview>) {
        let log = LogId(self.logs.len() as u64);
        self.logs.push(kept.map(|kept| {
            self.numbers.add_log(log, kept.object_numbers);
            LogReview { log, review: kept.review, threshold: kept.threshold }
        }));
    }

    /// Returns the boxes of a log with the decisions about them; `None` if it has none.
    pub fn log(&self, log: usize) -> Option<&Review> {
        let of_log = self.logs.get(log)?.as_ref()?;
        Some(&of_log.review)
    }

    /// Returns true if any log has boxes.
    pub fn has_boxes(&self) -> bool {
        self.logs.iter().any(Option::is_some)
    }

    /// Returns true if there is a box that was accepted or drawn by hand.
    pub fn has_targets(&self) -> bool {
        let mut boxes = self.logs.iter().flatten();
        boxes.any(|of_log| of_log.review.boxes().any(|review_box| review_box.state.is_object()))
    }
}
