//! Runs the stages of one log in the background of the window: one worker, a new request replaces
//! the current one, the last result stays on screen.

use super::{Jobs, Products, Settings, Stage, Task, TaskOutcome, run};
use bathyscope_log::survey::Survey;
use std::sync::{Arc, Mutex, PoisonError};

/// Activity of the engine.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum EngineStatus {
    /// No stage runs.
    #[default]
    Idle,
    /// A stage runs.
    Running {
        /// Current stage.
        stage: Stage,
        /// Share of the stage that is done, 0 to 1.
        fraction: f32,
    },
}

/// Error of a stage that ended in a panic.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("a processing step failed unexpectedly; the last result stays")]
pub struct StageFailed;

/// Runner of [`run`] in a background thread. A new request cancels the current one.
pub struct Engine {
    jobs: Jobs,
    running: Option<Running>,
}

struct Running {
    stage: Arc<Mutex<Stage>>,
    task: Task<Option<Products>>,
}

impl Engine {
    /// Creates an engine that starts its work by `jobs`.
    pub fn new(jobs: Jobs) -> Self {
        Self { jobs, running: None }
    }

    /// Starts a run with these inputs and cancels the current one; stages whose settings equal
    /// those of `previous` are not run again.
    pub fn request(&mut self, survey: Arc<Survey>, settings: Settings, previous: Option<Products>) {
        self.cancel();
        let stage = Arc::new(Mutex::new(Stage::Navigation));
        let (now, jobs) = (stage.clone(), self.jobs.clone());
        let task = Task::start(&self.jobs, move |progress| {
            let on_stage = |stage| {
                *now.lock().unwrap_or_else(PoisonError::into_inner) = stage;
                jobs.wake();
            };
            run(&survey, &settings, previous.as_ref(), progress, on_stage).ok()
        });
        self.running = Some(Running { stage, task });
    }

    /// Cancels the current run; its result is dropped.
    pub fn cancel(&mut self) {
        self.running = None;
    }

    /// Returns the result of the last request once, when the run has ended; `None` before and
    /// after. `Err` means that the worker panicked.
    pub fn poll(&mut self) -> Option<Result<Products, StageFailed>> {
        let outcome = match self.running.as_ref()?.task.poll() {
            TaskOutcome::Pending => return None,
            TaskOutcome::Done(products) => products.map(Ok),
            TaskOutcome::Failed => Some(Err(StageFailed)),
        };
        self.running = None;
        outcome
    }

    /// Returns the activity of the engine.
    pub fn status(&self) -> EngineStatus {
        let running = self.running.as_ref();
        running.map_or(EngineStatus::Idle, |Running { stage, task }| EngineStatus::Running {
            stage: *stage.lock().unwrap_or_else(PoisonError::into_inner),
            fraction: task.fraction(),
        })
    }
}
