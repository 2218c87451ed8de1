//! Work in background threads: one piece of it, or one kind of it for what is on the screen, where
//! the newest request wins and the last result stays.

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

/// One kind of work in the background. `K` is the key of the inputs of a result; the same key is
/// not worked on twice.
pub struct Background<K, T> {
    key: Option<K>,
    running: Option<Task<Option<T>>>,
    result: Option<T>,
}

impl<K, T> Default for Background<K, T> {
    fn default() -> Self {
        Self { key: None, running: None, result: None }
    }
}

impl<K: PartialEq, T: Send + 'static> Background<K, T> {
    /// Makes sure that the result of `key` is there or under way. `work` returns `None` when it was
    /// cancelled or when there is nothing to show; what was shown before stays then.
    pub fn ask(
        &mut self,
        key: K,
        jobs: &Jobs,
        work: impl FnOnce(&Progress) -> Option<T> + Send + 'static,
    ) {
        if self.key.as_ref() != Some(&key) {
            self.key = Some(key);
            // Replacing a task cancels the one before.
            self.running = Some(Task::start(jobs, work));
        }
        self.collect();
    }

    /// The last result, perhaps of an older key.
    pub fn result(&self) -> Option<&T> {
        self.result.as_ref()
    }

    /// Returns true if work is under way.
    pub fn is_running(&self) -> bool {
        self.running.is_some()
    }

    fn collect(&mut self) {
        let Some(task) = &self.running else {
            return;
        };
        match task.poll() {
            TaskOutcome::Pending => return,
            TaskOutcome::Done(Some(result)) => self.result = Some(result),
            TaskOutcome::Done(None) | TaskOutcome::Failed => {}
        }
        self.running = None;
    }
}

/// A shared result as a key: the same allocation, not equal contents. Holding it keeps its address
/// from being used again.
pub struct Same<T>(pub std::sync::Arc<T>);

impl<T> Clone for Same<T> {
    fn clone(&self) -> Self {
        Self(self.0.clone())
    }
}

impl<T> PartialEq for Same<T> {
    fn eq(&self, other: &Self) -> bool {
        std::sync::Arc::ptr_eq(&self.0, &other.0)
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
