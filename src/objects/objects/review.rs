//! Holds the decisions about the boxes of a survey, and the numbers of the objects, so that an
//! object has the same number after each change.

use super::{LogBox, LogId, ObjectBox};
use crate::review::{BoxId, Review, Reviewed};
use crate::targets::Target;
use bathyscope_log::survey::Exclusions;
use std::collections::{BTreeMap, HashMap, HashSet};
use std::sync::Arc;

/// The boxes of a log, and the score from which its undecided proposals are shown.
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
    /// Adds the next log, with its boxes if it has any.
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

/// Number of the object of each box of a log.
pub type LogNumbers = Arc<BTreeMap<BoxId, u32>>;

/// The object number that each box got most recently; it stays while the box is hidden. Cheap to
/// clone.
#[derive(Clone, Debug, Default)]
pub struct ObjectNumbers {
    logs: HashMap<LogId, LogNumbers>,
    /// Greatest number that was given.
    last: u32,
}

impl ObjectNumbers {
    /// Adds the object numbers of the boxes of a log.
    pub fn add_log(&mut self, log: LogId, numbers: LogNumbers) {
        self.last = numbers.values().fold(self.last, |last, number| last.max(*number));
        self.logs.insert(log, numbers);
    }

    /// Returns the object numbers of the boxes of a log.
    pub fn of_log(&self, log: LogId) -> LogNumbers {
        self.logs.get(&log).cloned().unwrap_or_default()
    }

    fn get(&self, key: &LogBox) -> Option<u32> {
        self.logs.get(&key.log)?.get(&key.id).copied()
    }

    /// Stores a number; the map of a log is copied only if a number in it changes.
    fn set(&mut self, key: &LogBox, number: u32) {
        if self.get(key) != Some(number) {
            let of_log = self.logs.entry(key.log).or_default();
            Arc::make_mut(of_log).insert(key.id, number);
        }
    }

    /// Returns a number for each group of boxes, and stores it: the number that most of its boxes
    /// had, of those that no group with more such boxes has, or an earlier group with as many; a
    /// new number if none is left.
    pub(super) fn give(&mut self, groups: &[Vec<LogBox>]) -> Vec<u32> {
        let mut claims: Vec<(usize, u32, usize)> = Vec::new();
        for (index, group) in groups.iter().enumerate() {
            let mut votes: HashMap<u32, usize> = HashMap::new();
            for number in group.iter().filter_map(|key| self.get(key)) {
                *votes.entry(number).or_default() += 1;
            }
            claims.extend(votes.into_iter().map(|(number, votes)| (votes, number, index)));
        }
        claims.sort_by_key(|(votes, number, index)| (std::cmp::Reverse(*votes), *number, *index));
        let mut given: Vec<Option<u32>> = vec![None; groups.len()];
        let mut used_numbers = HashSet::new();
        for (_, number, index) in claims {
            if given[index].is_none() && used_numbers.insert(number) {
                given[index] = Some(number);
            }
        }
        let numbers: Vec<u32> = given
            .into_iter()
            .map(|number| {
                number.unwrap_or_else(|| {
                    self.last = self.last.saturating_add(1);
                    self.last
                })
            })
            .collect();
        for (group, number) in groups.iter().zip(&numbers) {
            for key in group {
                self.set(key, *number);
            }
        }
        numbers
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn boxes(ids: &[(u64, u32)]) -> Vec<LogBox> {
        let id = |(log, id): &(u64, u32)| LogBox { log: LogId(*log), id: BoxId(*id) };
        ids.iter().map(id).collect()
    }

    fn give(numbers: &mut ObjectNumbers, groups: &[&[(u64, u32)]]) -> Vec<u32> {
        let groups: Vec<Vec<LogBox>> = groups.iter().map(|group| boxes(group)).collect();
        numbers.give(&groups)
    }

    #[test]
    fn an_object_keeps_its_number_whatever_becomes_of_its_boxes() {
        let mut numbers = ObjectNumbers::default();
        let first = give(&mut numbers, &[&[(0, 1), (1, 1)], &[(0, 2)], &[(0, 3), (1, 2)]]);
        assert_eq!(first, [1, 2, 3]);
        // The first group loses a box, which is then alone; the second is hidden; a new one is
        // added.
        let next =
            give(&mut numbers, &[&[(0, 1)], &[(1, 9)], &[(0, 3), (1, 2), (2, 1)], &[(1, 1)]]);
        assert_eq!(next, [1, 4, 3, 5]);
        // The second object is shown again, with one more box.
        let again = give(&mut numbers, &[&[(0, 2), (2, 7)], &[(0, 1), (1, 1)]]);
        assert_eq!(again, [2, 1]);
        // A map without changes stays the same allocation, so that a project need not compare it.
        let before = numbers.clone();
        give(&mut numbers, &[&[(0, 2), (2, 7)], &[(0, 1), (1, 1)]]);
        for log in [0, 1, 2].map(LogId) {
            assert!(Arc::ptr_eq(&before.of_log(log), &numbers.of_log(log)));
        }
        // Two objects become one, with the number of the one with more boxes.
        let joined = give(&mut numbers, &[&[(0, 2), (0, 3), (1, 2), (2, 1)]]);
        assert_eq!(joined, [3]);
    }
}
