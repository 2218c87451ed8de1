//! Work on several logs in the background, and what it found last.

use super::{Jobs, Task, TaskOutcome};
use bathyscope_log::support::progress::Progress;

/// The work and its result.
pub(super) struct LogsTask<T> {
    task: Option<Task<Option<T>>>,
    found: Option<T>,
}

/// State of the work.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Stands {
    /// There is none, or it goes on.
    Still,
    /// It found something now.
    Found,
    /// It ended unexpectedly.
    Failed,
}

impl<T> Default for LogsTask<T> {
    fn default() -> Self {
        Self { task: None, found: None }
    }
}

impl<T: Send + 'static> LogsTask<T> {
    /// Returns true if it is at work.
    pub(super) fn is_busy(&self) -> bool {
        self.task.is_some()
    }

    /// Returns the last result.
    pub(super) fn found(&self) -> Option<&T> {
        self.found.as_ref()
    }

    /// Begins to look; a search under way is given up.
    pub(super) fn start(
        &mut self,
        jobs: &Jobs,
        search: impl FnOnce(&Progress) -> Option<T> + Send + 'static,
    ) {
        self.task = Some(Task::start(jobs, search));
    }

    /// Takes over what was found.
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
