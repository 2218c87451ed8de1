//! Keeps the numbers of objects, so that an object has the same number after each change.

use super::{LogBox, LogId};
use crate::review::BoxId;
use std::collections::{BTreeMap, HashMap, HashSet};
use std::sync::Arc;

/// Number of the object of each box of a log.
pub type LogNumbers = Arc<BTreeMap<BoxId, u32>>;

/// The last object number of every box, also while the box is hidden. Cheap to clone.
#[derive(Clone, Debug, Default)]
pub struct ObjectNumbers {
    logs: HashMap<LogId, LogNumbers>,
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
    /// had, unless another group has more boxes with this number; otherwise a new one.
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
