//! One piece of work off the window's thread.

use super::Jobs;
use crate::progress::Progress;
use std::sync::mpsc;

/// What became of a task.
pub enum Outcome<T> {
    /// It still runs, or its result was taken.
    Pending,
    /// Its result, once.
    Done(T),
    /// Its thread died.
    Failed,
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
        let task = Self {
            progress: progress.clone(),
            result,
        };
        match jobs {
            Jobs::Inline => {
                sender.send(work(&progress)).ok();
            }
            Jobs::Threads(waker) => {
                let waker = waker.clone();
                std::thread::spawn(move || {
                    // Nobody listens any more when the task was replaced meanwhile.
                    sender.send(work(&progress)).ok();
                    waker();
                });
            }
        }
        task
    }

    /// The result, if it is there.
    pub fn poll(&self) -> Outcome<T> {
        match self.result.try_recv() {
            Ok(result) => Outcome::Done(result),
            Err(mpsc::TryRecvError::Empty) => Outcome::Pending,
            Err(mpsc::TryRecvError::Disconnected) => Outcome::Failed,
        }
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
