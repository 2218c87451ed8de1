//! Runs work on several logs in a background thread, and keeps its last result.

use super::{Jobs, Task, TaskOutcome};
use bathyscope_log::support::progress::Progress;

/// Work on several logs, and its last result.
pub(super) struct LogsTask<T> {
    task: Option<Task<Option<T>>>,
    found: Option<T>,
}

/// State of the work when it was polled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Stands {
    /// There is no work, it goes on, or it ended without a result.
    Still,
    /// The work has just ended with a result.
    Found,
    /// The work ended in a panic.
    Failed,
}

impl<T> Default for LogsTask<T> {
    fn default() -> Self {
        Self { task: None, found: None }
    }
}

impl<T: Send + 'static> LogsTask<T> {
    /// Returns true while the work is running.
    pub(super) fn is_busy(&self) -> bool {
        self.task.is_some()
    }

    /// Returns the last result.
    pub(super) fn found(&self) -> Option<&T> {
        self.found.as_ref()
    }

    /// Starts the work; a running one is cancelled.
    pub(super) fn start(
        &mut self,
        jobs: &Jobs,
        search: impl FnOnce(&Progress) -> Option<T> + Send + 'static,
    ) {
        self.task = Some(Task::start(jobs, search));
    }

    /// Collects the result of the work if it has ended.
    pub(super) fn poll(&mut self) -> Stands {
        let stands = match self.task.as_ref().map(Task::poll) {
            None | Some(TaskOutcome::Pending) => return Stands::Still,
            Some(TaskOutcome::Done(Some(found))) => {
                self.found = Some(found);
                Stands::Found
            }
            Some(TaskOutcome::Done(None)) => Stands::Still,
            Some(TaskOutcome::Failed) => Stands::Failed,
        };
        self.task = None;
        stands
    }
}
