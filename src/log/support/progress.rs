//! Progress of a running stage, and its cancellation.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// A stage was cancelled; its partial result is dropped.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("cancelled")]
pub struct Cancelled;

/// Shared between the thread that works (sets, checks) and the one that shows and cancels. Clones
/// are the same progress.
#[derive(Clone, Debug, Default)]
pub struct Progress {
    shared: Arc<Shared>,
    cancellation: Arc<Cancellation>,
}

/// Cancellation of some work, apart from the data shown about it, so that a part does not keep the
/// whole, which keeps its parts.
#[derive(Debug, Default)]
struct Cancellation {
    is_asked_for: AtomicBool,
    /// Cancellation of the whole that this is a part of; it cancels the part as well.
    whole: Option<Arc<Cancellation>>,
}

impl Cancellation {
    fn is_in_force(&self) -> bool {
        let whole = || self.whole.as_ref().is_some_and(|whole| whole.is_in_force());
        self.is_asked_for.load(Ordering::Relaxed) || whole()
    }
}

#[derive(Debug, Default)]
struct Shared {
    done: AtomicU64,
    total: AtomicU64,
    /// Parts of the stage, where it has any, each with its weight.
    parts: Mutex<Vec<(f32, Progress)>>,
}

impl Shared {
    fn parts(&self) -> MutexGuard<'_, Vec<(f32, Progress)>> {
        self.parts.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Progress {
    /// A fresh progress: nothing done, not cancelled.
    pub fn new() -> Self {
        Self::default()
    }

    /// Starts a stage of `total` steps.
    pub fn start(&self, total: u64) {
        self.shared.parts().clear();
        self.shared.done.store(0, Ordering::Relaxed);
        self.shared.total.store(total, Ordering::Relaxed);
    }

    /// Counts `steps` more as done. Callable from many threads.
    pub fn advance(&self, steps: u64) {
        self.shared.done.fetch_add(steps, Ordering::Relaxed);
    }

    /// Starts a stage of parts that are done beside each other, one for each weight: the share of
    /// it that is done is the mean of theirs. To cancel the whole cancels them; each can be
    /// cancelled alone.
    pub fn start_parts(&self, weights: impl IntoIterator<Item = f32>) -> Vec<Self> {
        let part = |weight| {
            let cancellation =
                Cancellation { whole: Some(self.cancellation.clone()), ..Cancellation::default() };
            let part = Self { shared: Arc::default(), cancellation: Arc::new(cancellation) };
            (weight, part)
        };
        let parts: Vec<(f32, Self)> = weights.into_iter().map(part).collect();
        self.shared.parts().clone_from(&parts);
        parts.into_iter().map(|(_, part)| part).collect()
    }

    /// Counts all as done.
    pub fn finish(&self) {
        self.start(1);
        self.advance(1);
    }

    /// Done share, 0 to 1; 0 while the total is unknown.
    pub fn fraction(&self) -> f32 {
        let parts = self.shared.parts();
        let weight: f32 = parts.iter().map(|(weight, _)| weight).sum();
        if weight > 0.0 {
            let done = parts.iter().map(|(weight, part)| weight * part.fraction());
            return done.sum::<f32>() / weight;
        }
        let total = self.shared.total.load(Ordering::Relaxed);
        if total == 0 {
            return 0.0;
        }
        (self.shared.done.load(Ordering::Relaxed) as f32 / total as f32).min(1.0)
    }

    /// Asks the worker to stop at its next check.
    pub fn cancel(&self) {
        let asked = &self.cancellation.is_asked_for;
        asked.store(true, Ordering::Relaxed);
    }

    /// Returns true if [`Progress::cancel`] was called.
    pub fn is_cancelled(&self) -> bool {
        self.cancellation.is_in_force()
    }

    /// `Err` once cancelled, so that a loop can stop with `?`.
    ///
    /// # Errors
    /// When the work was cancelled.
    pub fn check(&self) -> Result<(), Cancelled> {
        if self.is_cancelled() { Err(Cancelled) } else { Ok(()) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stage_of_parts_is_done_as_far_as_they_are() {
        let progress = Progress::new();
        let parts = progress.start_parts([1.0, 3.0]);
        assert_eq!(progress.fraction(), 0.0);
        parts[0].finish();
        assert_eq!(progress.fraction(), 0.25);
        parts[1].start(4);
        parts[1].advance(2);
        assert_eq!(progress.fraction(), 0.625);
        // A part that starts its next stage, and the next stage of all.
        parts[1].start(2);
        assert_eq!(progress.fraction(), 0.25);
        progress.start(10);
        progress.advance(1);
        assert_eq!(progress.fraction(), 0.1);
        assert_eq!(progress.start_parts([]).len(), 0);
        assert_eq!(progress.fraction(), 0.1);
    }

    #[test]
    fn parts_are_cancelled_with_the_whole_or_alone() {
        let progress = Progress::new();
        let [one, other] = progress.start_parts([1.0; 2]).try_into().unwrap();
        one.cancel();
        assert!(one.is_cancelled() && !other.is_cancelled() && !progress.is_cancelled());
        progress.cancel();
        assert!(other.check().is_err());
        // A part outlives the whole without keeping it.
        let whole = Arc::downgrade(&progress.shared);
        drop(progress);
        assert!(whole.upgrade().is_none() && other.is_cancelled());
    }
}
