//! Runs work in background threads: single tasks, and kinds of work for the screen, of which the
//! newest request replaces the current one and the last result stays.

use bathyscope_log::support::progress::Progress;
use std::sync::{Arc, mpsc};

/// Way in which background work is run.
#[derive(Clone)]
pub enum Jobs {
    /// Worker threads, which call this function when there is a result to show.
    Threads(Arc<dyn Fn() + Send + Sync>),
    /// The calling thread: the work is done before the call returns.
    Inline,
}

impl Jobs {
    /// Calls the function of [`Jobs::Threads`]: there is a result to show.
    pub fn wake(&self) {
        match self {
            Self::Threads(waker) => waker(),
            Self::Inline => {}
        }
    }
}

/// State of a task, with its result.
pub enum TaskOutcome<T> {
    /// The task still runs.
    Pending,
    /// The result, returned once.
    Done(T),
    /// The thread panicked, or the result was already returned.
    Failed,
}

/// Guard that wakes the window when it is dropped.
struct WakeAtEnd(Arc<dyn Fn() + Send + Sync>);

impl Drop for WakeAtEnd {
    fn drop(&mut self) {
        (self.0)();
    }
}

/// Task that runs in the background; dropping it cancels the work.
pub struct Task<T> {
    progress: Progress,
    result: mpsc::Receiver<T>,
}

impl<T: Send + 'static> Task<T> {
    /// Starts `work` on its own thread, or runs it in this call for [`Jobs::Inline`].
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
                    // Dropped in this order, the sender first, even if the work panics: when the
                    // window wakes, the outcome is known.
                    let (_at_end, sender) = (at_end, sender);
                    // Sending fails if the task was replaced meanwhile.
                    sender.send(work(&progress)).ok();
                });
            }
        }
        task
    }

    /// Returns the state of the task, with the result if it is ready.
    pub fn poll(&self) -> TaskOutcome<T> {
        match self.result.try_recv() {
            Ok(result) => TaskOutcome::Done(result),
            Err(mpsc::TryRecvError::Empty) => TaskOutcome::Pending,
            Err(mpsc::TryRecvError::Disconnected) => TaskOutcome::Failed,
        }
    }

    /// Waits for the result; `None` if the thread panicked, or the result was already returned.
    pub fn wait(&self) -> Option<T> {
        self.result.recv().ok()
    }

    /// Returns the share of the work that is done, 0 to 1.
    pub fn fraction(&self) -> f32 {
        self.progress.fraction()
    }
}

impl<T> Drop for Task<T> {
    fn drop(&mut self) {
        self.progress.cancel();
    }
}

/// One kind of work in the background. `K` is the key of the inputs of a result; a request with the
/// key of the last request starts no work.
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
    /// Starts the work for `key`, unless it is the key of the last request. `work` returns `None`
    /// if it was cancelled or there is no result; the earlier result then stays.
    pub fn ask(
        &mut self,
        key: K,
        jobs: &Jobs,
        work: impl FnOnce(&Progress) -> Option<T> + Send + 'static,
    ) {
        if self.key.as_ref() != Some(&key) {
            self.key = Some(key);
            // Replacing a task cancels the earlier one.
            self.running = Some(Task::start(jobs, work));
        }
        self.collect();
    }

    /// Returns the last result, which may be of an older key.
    pub fn result(&self) -> Option<&T> {
        self.result.as_ref()
    }

    /// Returns true if work is running.
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

/// Shared value as a key: equal if it is the same allocation, not if the contents are equal. The
/// key keeps the value alive, so that its address is not used again.
pub struct Same<T>(pub Arc<T>);

impl<T> Clone for Same<T> {
    fn clone(&self) -> Self {
        Self(self.0.clone())
    }
}

impl<T> PartialEq for Same<T> {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
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
