//! Builds successive versions of a growing list without copying all of it each time. Each version
//! has the first entries of the version before, and new entries behind them.

use std::sync::Arc;

/// The last two versions of a growing list, kept so that the time for a new version depends on the
/// number of its new entries only.
///
/// A new version is written over the version before the last, which lacks only what the last two
/// steps added. Where that version is still in use, the known entries are copied instead.
#[derive(Debug)]
pub struct Versions<T> {
    /// The last version, and the number of its first entries that are the same in the version
    /// before.
    last: Option<(Arc<Vec<T>>, usize)>,
    before: Option<Arc<Vec<T>>>,
}

impl<T> Default for Versions<T> {
    fn default() -> Self {
        Self { last: None, before: None }
    }
}

impl<T: Copy> Versions<T> {
    /// Returns the next version: the first `kept` entries of `known`, and `added` behind them.
    pub fn next(&mut self, known: &Arc<Vec<T>>, kept: usize, added: &[T]) -> Arc<Vec<T>> {
        self.next_changed(known, kept, added, |all| all.len())
    }

    /// Returns the next version as [`Versions::next`] does, with entries changed by `change`, which
    /// returns the index of the first entry that it changed.
    pub fn next_changed(
        &mut self,
        known: &Arc<Vec<T>>,
        kept: usize,
        added: &[T],
        change: impl FnOnce(&mut [T]) -> usize,
    ) -> Arc<Vec<T>> {
        let kept = kept.min(known.len());
        let mut all = self.start(known, kept);
        all.extend_from_slice(&known[all.len()..kept]);
        all.extend_from_slice(added);
        let same = change(&mut all).min(kept);
        let all = Arc::new(all);
        self.before = Some(known.clone());
        self.last = Some((all.clone(), same));
        all
    }

    /// Returns the list to write the next version into, with the first entries of `known`, at most
    /// `kept`: the version before the last if it is not in use any more, otherwise an empty list.
    fn start(&mut self, known: &Arc<Vec<T>>, kept: usize) -> Vec<T> {
        let last = self.last.take();
        let same = last.and_then(|(last, same)| Arc::ptr_eq(&last, known).then_some(same));
        let unread = self.before.take().and_then(Arc::into_inner);
        match same.zip(unread) {
            Some((same, mut unread)) => {
                unread.truncate(same.min(kept));
                unread
            }
            None => Vec::with_capacity(kept),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn a_version_that_nobody_reads_is_written_over() {
        let mut versions = Versions::default();
        let first = Arc::new(vec![1, 2, 3]);
        let second = versions.next(&first, 2, &[4, 5, 6]);
        let third = versions.next(&second, 3, &[7]);
        assert_eq!(*third, [1, 2, 4, 7], "the first is read still");
        let place = second.as_ptr();
        drop(second);
        let fourth = versions.next(&third, 4, &[8]);
        assert_eq!(*fourth, [1, 2, 4, 7, 8]);
        assert_eq!(fourth.as_ptr(), place, "over the second");
        assert_eq!(*first, [1, 2, 3]);
    }

    #[test]
    fn another_list_is_not_taken_for_the_last_version() {
        let mut versions = Versions::default();
        let first = versions.next(&Arc::default(), 0, &[1, 2]);
        drop(versions.next(&first, 2, &[3]));
        drop(first);
        let other = Arc::new(vec![9, 8, 7]);
        assert_eq!(*versions.next(&other, 3, &[6]), [9, 8, 7, 6]);
    }

    proptest! {
        #[test]
        fn every_version_is_what_a_copy_would_be(
            steps in prop::collection::vec((0_usize..12, prop::collection::vec(0_u8..9, 0..6), 0_usize..12, any::<bool>()), 1..20),
        ) {
            let mut versions = Versions::default();
            let mut known: Arc<Vec<u8>> = Arc::new(vec![5; 8]);
            let mut read = Vec::new();
            for (kept, added, changed, is_read) in steps {
                let change = |all: &mut [u8]| {
                    let first = changed.min(all.len());
                    for value in &mut all[first..] {
                        *value += 10;
                    }
                    first
                };
                let mut expected = known[..kept.min(known.len())].to_vec();
                expected.extend_from_slice(&added);
                change(&mut expected);
                let next = versions.next_changed(&known, kept, &added, change);
                prop_assert_eq!(&*next, &expected);
                if is_read {
                    read.push((next.clone(), expected));
                }
                known = next;
            }
            for (list, expected) in read {
                prop_assert_eq!(&*list, &expected);
            }
        }
    }
}
