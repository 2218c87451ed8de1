//! One piece of work in a background thread.

use bathyscope_log::support::progress::Progress;
use std::sync::{Arc, mpsc};

/// Way in which background work is run.
#[derive(Clone)]
pub enum Jobs {
    /// Worker threads, which call this function when there is something to show.
    Threads(Arc<dyn Fn() + Send + Sync>),
    /// Inside the call.
    Inline,
}

impl Jobs {
    /// Says that there is something to show.
    pub(crate) fn wake(&self) {
        match self {
            Self::Threads(waker) => waker(),
            Self::Inline => {}
        }
    }
}

/// Result of a task.
pub enum TaskOutcome<T> {
    /// It still runs, or its result was taken.
    Pending,
    /// Its result, once.
    Done(T),
    /// Its thread died.
    Failed,
}

/// Wakes the window when it is dropped.
struct WakeAtEnd(Arc<dyn Fn() + Send + Sync>);

impl Drop for WakeAtEnd {
    fn drop(&mut self) {
        (self.0)();
    }
}

/// Work under way. Dropping it cancels it.
pub struct Task<T> {
    progress: Progress,
    result: mpsc::Receiver<T>,
}

impl<T: Send + 'static> Task<T> {
    /// Starts `work` on a thread of its own, or inside this call for [`Jobs::Inline`].
    pub fn start(jobs: &Jobs, work: impl FnOnce(&Progress) -> T + Send + 'static) -> Self {
        let (sender, result) = mpsc::channel();
        let progress = Progress::new();
        let task = Self { progress: progress.clone(), result };
        match jobs {
            Jobs::Inline => {
                sender.send(work(&progress)).ok();
            }
            Jobs::Threads(waker) => {
                let at_end = WakeAtEnd(waker.clone());
                std::thread::spawn(move || {
                    // Dropped in turn, the channel first, also where the work panics: who is woken
                    // finds out what became of it.
                    let (_at_end, sender) = (at_end, sender);
                    // Nobody listens any more when the task was replaced meanwhile.
                    sender.send(work(&progress)).ok();
                });
            }
        }
        task
    }

    /// The result, if it is there.
    pub fn poll(&self) -> TaskOutcome<T> {
        match self.result.try_recv() {
            Ok(result) => TaskOutcome::Done(result),
            Err(mpsc::TryRecvError::Empty) => TaskOutcome::Pending,
            Err(mpsc::TryRecvError::Disconnected) => TaskOutcome::Failed,
        }
    }

    /// Waits for the result; `None` when its thread died, or the result was taken.
    pub fn wait(&self) -> Option<T> {
        self.result.recv().ok()
    }

    /// Done share, 0 to 1.
    pub fn fraction(&self) -> f32 {
        self.progress.fraction()
    }
}

impl<T> Drop for Task<T> {
    fn drop(&mut self) {
        self.progress.cancel();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_window_is_woken_by_a_worker_that_dies() {
        let (sender, woken) = mpsc::channel();
        let jobs = Jobs::Threads(Arc::new(move || {
            sender.send(()).ok();
        }));
        let dies = || -> u8 { panic!("for the test") };
        let task = Task::start(&jobs, move |_| dies());
        woken.recv().expect("it is woken");
        assert!(matches!(task.poll(), TaskOutcome::Failed));
        let task = Task::start(&jobs, |_| 7);
        woken.recv().expect("it is woken");
        assert!(matches!(task.poll(), TaskOutcome::Done(7)));
    }
}
