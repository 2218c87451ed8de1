//! Work in a background thread for what is on the screen: the newest request wins, the last result
//! stays.

use super::{Jobs, Task, TaskOutcome};
use bathyscope_log::support::progress::Progress;

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
