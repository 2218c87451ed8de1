//! Reports the progress of a running stage, and cancels it.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Number of steps of a walk between two checks for cancellation.
const STEPS_A_CHECK: usize = 1024;

/// Error of a stage that was cancelled; its partial result is dropped.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("cancelled")]
pub struct Cancelled;

/// Progress of a stage, shared between the thread that works (sets, checks) and the thread that
/// shows the progress and cancels. Clones share the same progress.
#[derive(Clone, Debug, Default)]
pub struct Progress {
    shared: Arc<Shared>,
    cancellation: Arc<Cancellation>,
}

/// Cancellation of some work. It is separate from [`Shared`], so that a part of a stage does not
/// keep the data of the whole stage alive, which holds its parts.
#[derive(Debug, Default)]
struct Cancellation {
    is_asked_for: AtomicBool,
    /// Cancellation of the whole stage, if this is a part of one; it cancels the part as well.
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
    /// Parts of the stage, each with its weight; empty where it has none.
    parts: Mutex<Vec<(f32, Progress)>>,
}

impl Shared {
    fn parts(&self) -> MutexGuard<'_, Vec<(f32, Progress)>> {
        self.parts.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Progress {
    /// Creates a progress with nothing done, not cancelled.
    pub fn new() -> Self {
        Self::default()
    }

    /// Starts a stage of `total` steps.
    pub fn start(&self, total: u64) {
        self.shared.parts().clear();
        self.shared.done.store(0, Ordering::Relaxed);
        self.shared.total.store(total, Ordering::Relaxed);
    }

    /// Counts `steps` more steps as done. Can be called from many threads.
    pub fn advance(&self, steps: u64) {
        self.shared.done.fetch_add(steps, Ordering::Relaxed);
    }

    /// Calls `step` with the offset `start`, and then with each offset that it returns, up to
    /// `end`; counts the bytes between as done.
    ///
    /// # Errors
    /// When the work was cancelled.
    pub(crate) fn walk(
        &self,
        start: usize,
        end: usize,
        mut step: impl FnMut(usize) -> Result<usize, Cancelled>,
    ) -> Result<(), Cancelled> {
        let (mut at, mut reported, mut steps) = (start, start, 0_usize);
        while at < end {
            if steps.is_multiple_of(STEPS_A_CHECK) {
                self.check()?;
                self.advance((at - reported) as u64);
                reported = at;
            }
            steps += 1;
            at = step(at)?;
        }
        self.advance(end.saturating_sub(reported) as u64);
        Ok(())
    }

    /// Starts a stage of parts that run at the same time, one for each weight: the done share of
    /// the stage is the weighted mean of those of the parts. Cancelling the stage cancels all
    /// parts; each part can also be cancelled alone.
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

    /// Counts the whole stage as done.
    pub fn finish(&self) {
        self.start(1);
        self.advance(1);
    }

    /// Returns the done share, 0 to 1; 0 while the total is unknown.
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

    /// Cancels the work: it stops at its next check.
    pub fn cancel(&self) {
        let asked = &self.cancellation.is_asked_for;
        asked.store(true, Ordering::Relaxed);
    }

    /// Returns true if [`Progress::cancel`] was called on this progress, or on the stage that it is
    /// a part of.
    pub fn is_cancelled(&self) -> bool {
        self.cancellation.is_in_force()
    }

    /// Returns an error once the work was cancelled, so that a loop can stop with `?`.
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
        // First a part starts its next stage, then the whole does.
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
        // A part can outlive the whole without keeping the data of the whole alive.
        let whole = Arc::downgrade(&progress.shared);
        drop(progress);
        assert!(whole.upgrade().is_none() && other.is_cancelled());
    }
}
