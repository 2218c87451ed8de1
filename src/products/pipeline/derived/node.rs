//! Cache of results that are computed when they are first requested, and kept with their inputs.

use bathyscope_log::support::progress::{Cancelled, Progress};
use std::sync::{Mutex, MutexGuard, PoisonError, TryLockError};
use std::time::Duration;

/// Poll interval while another thread makes a result.
const WAIT: Duration = Duration::from_millis(5);

/// Last results of one kind, each with its key: equal keys give equal results, so none is computed
/// twice. Two threads that request the same result at once share one computation.
pub(super) struct DerivedNode<K, T> {
    kept: Mutex<Vec<(K, T)>>,
    /// Largest sum of the weights of all results.
    most: usize,
    weight: fn(&T) -> usize,
}

impl<K: PartialEq, T: Clone> DerivedNode<K, T> {
    /// Creates a cache of at most `most` results; the oldest are removed first.
    pub(super) fn keeping(most: usize) -> Self {
        Self::weighing(most, |_| 1)
    }

    /// Creates a cache of results whose weights sum to at most `most`; the oldest are removed
    /// first. The newest stays, whatever its weight.
    pub(super) fn weighing(most: usize, weight: fn(&T) -> usize) -> Self {
        Self { kept: Mutex::default(), most, weight }
    }

    /// Returns the result of a key; computes it with `make` if it is not kept.
    ///
    /// # Errors
    /// When the work, or the wait for another thread, was cancelled.
    pub(super) fn get(
        &self,
        key: K,
        progress: &Progress,
        make: impl FnOnce() -> Result<T, Cancelled>,
    ) -> Result<T, Cancelled> {
        let mut kept = self.lock(progress)?;
        if let Some((_, made)) = kept.iter().find(|(of, _)| *of == key) {
            return Ok(made.clone());
        }
        let made = make()?;
        kept.push((key, made.clone()));
        let mut all = kept.iter().map(|(_, value)| (self.weight)(value)).sum::<usize>();
        while all > self.most && kept.len() > 1 {
            all -= (self.weight)(&kept.remove(0).1);
        }
        Ok(made)
    }

    /// Waits until no other thread computes a result here; returns an error if this work is
    /// cancelled meanwhile.
    fn lock(&self, progress: &Progress) -> Result<MutexGuard<'_, Vec<(K, T)>>, Cancelled> {
        loop {
            match self.kept.try_lock() {
                Ok(kept) => return Ok(kept),
                // A computation that panicked has stored nothing.
                Err(TryLockError::Poisoned(kept)) => return Ok(PoisonError::into_inner(kept)),
                Err(TryLockError::WouldBlock) => progress.check()?,
            }
            std::thread::sleep(WAIT);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicUsize, Ordering};

    #[test]
    fn a_result_is_made_once_and_the_oldest_goes() {
        let (node, progress) = (DerivedNode::keeping(2), Progress::new());
        let made = AtomicUsize::new(0);
        let ask = |key: u8| {
            let make = || {
                made.fetch_add(1, Ordering::Relaxed);
                Ok(10 * key)
            };
            node.get(key, &progress, make).expect("nobody cancels")
        };
        assert_eq!([ask(1), ask(2), ask(1)], [10, 20, 10]);
        assert_eq!(made.load(Ordering::Relaxed), 2);
        assert_eq!([ask(3), ask(2), ask(1)], [30, 20, 10]);
        assert_eq!(made.load(Ordering::Relaxed), 4, "1 had gone for 3");
    }

    #[test]
    fn results_go_by_their_weight_and_the_last_one_stays() {
        let node = DerivedNode::weighing(10, |made: &usize| *made);
        let kept = |asked: usize| {
            let made = node.get(asked, &Progress::new(), || Ok(asked));
            assert_eq!(made, Ok(asked));
            let kept = node.kept.lock().expect("nobody panicked");
            kept.iter().map(|(key, _)| *key).collect::<Vec<_>>()
        };
        assert_eq!([kept(4), kept(6)], [vec![4], vec![4, 6]]);
        assert_eq!(kept(3), [6, 3]);
        assert_eq!(kept(50), [50]);
        assert_eq!(kept(2), [2]);
    }

    #[test]
    fn two_who_ask_at_once_get_the_work_of_one() {
        let (node, made) = (DerivedNode::keeping(1), AtomicUsize::new(0));
        std::thread::scope(|scope| {
            for _ in 0..4 {
                scope.spawn(|| {
                    let make = || {
                        std::thread::sleep(10 * WAIT);
                        Ok(made.fetch_add(1, Ordering::Relaxed))
                    };
                    assert_eq!(node.get((), &Progress::new(), make), Ok(0));
                });
            }
        });
    }

    #[test]
    fn who_gives_up_does_not_wait_and_leaves_nothing() {
        let node = DerivedNode::keeping(1);
        let given_up = Progress::new();
        given_up.cancel();
        let inner = || {
            let waits = node.get((), &given_up, || Ok(1));
            assert_eq!(waits, Err(Cancelled));
            Err(Cancelled)
        };
        assert_eq!(node.get((), &Progress::new(), inner), Err(Cancelled));
        assert_eq!(node.get((), &Progress::new(), || Ok(2)), Ok(2));
    }
}
