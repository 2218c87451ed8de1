//! The pipeline behind the window: one worker, the newest request wins, the last result stays on screen.

use super::{Products, Settings, Stage, run};
use crate::progress::Progress;
use crate::survey::Survey;
use std::sync::{Arc, Mutex, mpsc};

/// What the engine is doing.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum EngineStatus {
    /// Nothing to do.
    #[default]
    Idle,
    /// A stage runs.
    Running {
        /// Which.
        stage: Stage,
        /// Its done share, 0 to 1.
        fraction: f32,
    },
}

type Waker = Arc<dyn Fn() + Send + Sync>;

/// Runs [`run`] on a worker thread. A new request cancels the one under way.
pub struct Engine {
    waker: Waker,
    inline: bool,
    job: Option<Job>,
}

struct Job {
    progress: Progress,
    stage: Arc<Mutex<Stage>>,
    result: mpsc::Receiver<Option<Products>>,
}

impl Engine {
    /// `waker` is called from the worker whenever there is something new to show.
    pub fn new(waker: Waker) -> Self {
        Self {
            waker,
            inline: false,
            job: None,
        }
    }

    /// An engine that works inside [`Engine::request`], for tests and headless pictures.
    pub fn inline() -> Self {
        Self {
            waker: Arc::new(|| ()),
            inline: true,
            job: None,
        }
    }

    /// Starts over with these inputs; stages whose settings equal those of `previous` are not run again.
    pub fn request(&mut self, survey: Arc<Survey>, settings: Settings, previous: Option<Products>) {
        self.cancel();
        let progress = Progress::new();
        let stage = Arc::new(Mutex::new(Stage::Navigation));
        let (sender, result) = mpsc::channel();
        self.job = Some(Job {
            progress: progress.clone(),
            stage: stage.clone(),
            result,
        });
        let waker = self.waker.clone();
        let work = move || {
            let products = run(&survey, &settings, previous.as_ref(), &progress, |now| {
                *stage
                    .lock()
                    .unwrap_or_else(std::sync::PoisonError::into_inner) = now;
                waker();
            });
            // A dropped receiver means that the request was replaced: nobody waits for this result.
            sender.send(products.ok()).ok();
            waker();
        };
        if self.inline {
            work();
        } else {
            std::thread::spawn(work);
        }
    }

    /// Stops the job under way; its result is dropped.
    pub fn cancel(&mut self) {
        if let Some(job) = self.job.take() {
            job.progress.cancel();
        }
    }

    /// The result of the last request, once, when it is there. `Err` when its worker died.
    pub fn poll(&mut self) -> Option<Result<Products, String>> {
        let outcome = match self.job.as_ref()?.result.try_recv() {
            Err(mpsc::TryRecvError::Empty) => return None,
            Ok(Some(products)) => Some(Ok(products)),
            Ok(None) => None,
            Err(mpsc::TryRecvError::Disconnected) => Some(Err(
                "a processing step failed unexpectedly; the last result stays".to_owned(),
            )),
        };
        self.job = None;
        outcome
    }

    /// What is going on.
    pub fn status(&self) -> EngineStatus {
        self.job
            .as_ref()
            .map_or(EngineStatus::Idle, |job| EngineStatus::Running {
                stage: *job
                    .stage
                    .lock()
                    .unwrap_or_else(std::sync::PoisonError::into_inner),
                fraction: job.progress.fraction(),
            })
    }
}
