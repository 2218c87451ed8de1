//! Selects and orders the boxes to review.

use super::{BoxId, Review, Reviewed, State};
use crate::Mark;
use bathyscope_log::named;
use serde::{Deserialize, Serialize};
use std::cmp::Ordering;
use std::ops::RangeInclusive;

/// Order of the boxes in the queue.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Sort {
    /// Falling score.
    #[default]
    Score,
    /// Place along the track.
    Position,
    /// Class, then falling score.
    Class,
}

named! {
    /// All orders, as in the menu.
    pub Sort {
        Score: "score",
        Position: "position",
        Class: "class",
    }
}

/// Conditions for a box to be in the queue.
#[derive(Clone, Debug, PartialEq)]
pub struct Filter {
    /// Name of the only class; `None` for all. A name, since every log may have its own list of
    /// classes.
    pub class: Option<String>,
    /// The only state; `None` for all.
    pub state: Option<State>,
    /// Range of scores; boxes without a score are in the queue too.
    pub score: RangeInclusive<f32>,
    /// Range of the longer side of the box, metres.
    pub size_m: RangeInclusive<f64>,
}

impl Default for Filter {
    fn default() -> Self {
        Self { class: None, state: None, score: 0.0..=1.0, size_m: 0.0..=f64::INFINITY }
    }
}

/// Order and selection of the boxes to review.
#[derive(Clone, Debug, PartialEq)]
pub struct Queue {
    /// Order of the boxes.
    pub sort: Sort,
    /// Conditions for the boxes.
    pub filter: Filter,
    /// Least score of a shown undecided proposal; boxes with a decision are always shown.
    pub threshold: f32,
}

impl Default for Queue {
    fn default() -> Self {
        Self { sort: Sort::default(), filter: Filter::default(), threshold: 0.25 }
    }
}

impl Queue {
    /// Returns true if the least score does not hide a box.
    pub fn shows(&self, review_box: &Reviewed) -> bool {
        review_box.is_shown_from(self.threshold)
    }

    /// Returns true if a box of a review is in the queue. `size_m` returns the longer side of a
    /// mark, metres.
    pub fn takes(
        &self,
        review: &Review,
        review_box: &Reviewed,
        size_m: impl Fn(&Mark) -> f64,
    ) -> bool {
        let filter = &self.filter;
        let of_class = |class: &String| class == review.class_name(review_box.class);
        self.shows(review_box)
            && filter.class.as_ref().is_none_or(of_class)
            && filter.state.is_none_or(|state| state == review_box.state)
            && review_box.score.is_none_or(|score| filter.score.contains(&score))
            && (filter.size_m == Filter::default().size_m
                || filter.size_m.contains(&size_m(&review_box.mark)))
    }

    /// Returns the numbers of the boxes in the queue, in its order.
    pub fn sort_and_filter(&self, review: &Review, size_m: impl Fn(&Mark) -> f64) -> Vec<BoxId> {
        let mut line: Vec<&Reviewed> =
            review.boxes().filter(|review_box| self.takes(review, review_box, &size_m)).collect();
        line.sort_by(|a, b| match self.sort {
            Sort::Score => by_score(a, b),
            Sort::Position => by_position(a, b),
            Sort::Class => a.class.cmp(&b.class).then_with(|| by_score(a, b)),
        });
        line.into_iter().map(|review_box| review_box.id).collect()
    }
}

/// Compares two boxes: the higher score comes first, boxes without a score last.
fn by_score(a: &Reviewed, b: &Reviewed) -> Ordering {
    let score = |review_box: &Reviewed| review_box.score.unwrap_or(-1.0);
    score(b).total_cmp(&score(a)).then_with(|| by_position(a, b))
}

fn by_position(a: &Reviewed, b: &Reviewed) -> Ordering {
    let place =
        |review_box: &Reviewed| (review_box.mark.pings.start, review_box.mark.side, review_box.id);
    place(a).cmp(&place(b))
}

/// Counts of the decisions about the boxes that the least score does not hide.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct DecisionCounts {
    /// Undecided proposals that are shown.
    pub proposed: usize,
    /// Accepted boxes: objects that a model found.
    pub accepted: usize,
    /// Rejected boxes: false alarms.
    pub rejected: usize,
    /// Added boxes: objects that were missed and drawn by hand.
    pub added: usize,
    /// Undecided proposals that are hidden.
    pub hidden: usize,
}

impl DecisionCounts {
    /// Counts the decisions about the boxes of a review.
    pub fn of(review: &Review, queue: &Queue) -> Self {
        let mut counts = Self::default();
        for review_box in review.boxes() {
            let count = match review_box.state {
                _ if !queue.shows(review_box) => &mut counts.hidden,
                State::Proposed => &mut counts.proposed,
                State::Accepted => &mut counts.accepted,
                State::Rejected => &mut counts.rejected,
                State::Added => &mut counts.added,
            };
            *count += 1;
        }
        counts
    }

    /// Adds the counts of two logs.
    pub fn plus(self, other: Self) -> Self {
        Self {
            proposed: self.proposed + other.proposed,
            accepted: self.accepted + other.accepted,
            rejected: self.rejected + other.rejected,
            added: self.added + other.added,
            hidden: self.hidden + other.hidden,
        }
    }

    /// Returns the number of shown boxes with a decision.
    pub fn decided(&self) -> usize {
        self.accepted + self.rejected + self.added
    }

    /// Returns the number of shown boxes.
    pub fn total(&self) -> usize {
        self.decided() + self.proposed
    }
}
