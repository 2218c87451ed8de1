//! Order and selection of the boxes to review.

use super::{BoxId, Review, Reviewed, State};
use crate::Mark;
use bathyscope_log::named;
use serde::{Deserialize, Serialize};
use std::cmp::Ordering;
use std::ops::RangeInclusive;

/// Order of the queue.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Sort {
    /// The surest first.
    #[default]
    Score,
    /// Along the track.
    Position,
    /// Class by class, the surest first.
    Class,
}

named! {
    /// All sorts in the order of the menu.
    pub Sort {
        Score: "score",
        Position: "position",
        Class: "class",
    }
}

/// Conditions for a box to be in the queue.
#[derive(Clone, Debug, PartialEq)]
pub struct Filter {
    /// Only the class of this name: every log may have a list of classes of its own.
    pub class: Option<String>,
    /// Only this state.
    pub state: Option<State>,
    /// Confidence; boxes without one pass.
    pub score: RangeInclusive<f32>,
    /// Longer side of the box, metres.
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
    /// Order.
    pub sort: Sort,
    /// Conditions for the boxes.
    pub filter: Filter,
    /// Undecided proposals of a lower score than this are out of sight; what was decided stays in
    /// sight.
    pub threshold: f32,
}

impl Default for Queue {
    fn default() -> Self {
        Self { sort: Sort::default(), filter: Filter::default(), threshold: 0.25 }
    }
}

impl Queue {
    /// Returns true for a box that the least score leaves in sight.
    pub fn shows(&self, one: &Reviewed) -> bool {
        one.is_shown_from(self.threshold)
    }

    /// Returns true if a box of a review is in the queue. `size_m` is the longer side of a mark,
    /// metres.
    pub fn takes(&self, review: &Review, one: &Reviewed, size_m: impl Fn(&Mark) -> f64) -> bool {
        let filter = &self.filter;
        let of_class = |class: &String| class == review.class_name(one.class);
        self.shows(one)
            && filter.class.as_ref().is_none_or(of_class)
            && filter.state.is_none_or(|state| state == one.state)
            && one.score.is_none_or(|score| filter.score.contains(&score))
            && (filter.size_m == Filter::default().size_m
                || filter.size_m.contains(&size_m(&one.mark)))
    }

    /// The boxes to look at, in order.
    pub fn sort_and_filter(&self, review: &Review, size_m: impl Fn(&Mark) -> f64) -> Vec<BoxId> {
        let mut line: Vec<&Reviewed> =
            review.boxes().filter(|one| self.takes(review, one, &size_m)).collect();
        line.sort_by(|a, b| match self.sort {
            Sort::Score => by_score(a, b),
            Sort::Position => by_position(a, b),
            Sort::Class => a.class.cmp(&b.class).then_with(|| by_score(a, b)),
        });
        line.into_iter().map(|one| one.id).collect()
    }
}

/// The surest first, those without a score last.
fn by_score(a: &Reviewed, b: &Reviewed) -> Ordering {
    let score = |one: &Reviewed| one.score.unwrap_or(-1.0);
    score(b).total_cmp(&score(a)).then_with(|| by_position(a, b))
}

fn by_position(a: &Reviewed, b: &Reviewed) -> Ordering {
    let place = |one: &Reviewed| (one.mark.pings.start, one.mark.side, one.id);
    place(a).cmp(&place(b))
}

/// Counts of decisions about the boxes that the least score leaves in sight.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct DecisionCounts {
    /// Undecided.
    pub proposed: usize,
    /// Objects that a model found.
    pub accepted: usize,
    /// False alarms.
    pub rejected: usize,
    /// Objects that were missed and drawn by hand.
    pub added: usize,
    /// Undecided proposals out of sight.
    pub hidden: usize,
}

impl DecisionCounts {
    /// Counts.
    pub fn of(review: &Review, queue: &Queue) -> Self {
        let mut counts = Self::default();
        for one in review.boxes() {
            let count = match one.state {
                _ if !queue.shows(one) => &mut counts.hidden,
                State::Proposed => &mut counts.proposed,
                State::Accepted => &mut counts.accepted,
                State::Rejected => &mut counts.rejected,
                State::Added => &mut counts.added,
            };
            *count += 1;
        }
        counts
    }

    /// The counts of two logs together.
    pub fn plus(self, other: Self) -> Self {
        Self {
            proposed: self.proposed + other.proposed,
            accepted: self.accepted + other.accepted,
            rejected: self.rejected + other.rejected,
            added: self.added + other.added,
            hidden: self.hidden + other.hidden,
        }
    }

    /// Boxes that are decided.
    pub fn decided(&self) -> usize {
        self.accepted + self.rejected + self.added
    }

    /// Boxes in sight.
    pub fn total(&self) -> usize {
        self.decided() + self.proposed
    }
}
