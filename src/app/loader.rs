//! Opening a log off the window's thread.

use super::Jobs;
use super::bottom::{self, ReadBottom};
use super::task::{Outcome, Task};
use crate::formats;
use crate::progress::Progress;
use crate::survey::Survey;
use std::path::PathBuf;

/// What is opened.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Origin {
    /// A file or folder.
    Path(PathBuf),
    /// The bundled demo survey.
    Demo,
}

impl Origin {
    /// What to call it.
    pub fn name(&self) -> String {
        match self {
            Origin::Path(path) => path.file_name().map_or_else(
                || path.display().to_string(),
                |name| name.to_string_lossy().into_owned(),
            ),
            Origin::Demo => "demo survey".to_owned(),
        }
    }

    /// Opens it.
    pub fn open(&self, progress: &Progress) -> Result<Survey, formats::OpenError> {
        match self {
            Origin::Path(path) => formats::open(path, progress),
            Origin::Demo => {
                formats::open_bytes("demo.sl2", crate::app::state::DEMO.to_vec(), progress)
            }
        }
    }
}

/// What is being opened, for the status line.
#[derive(Clone, Debug, PartialEq)]
pub struct LoadStatus {
    /// Its name.
    pub name: String,
    /// Done share, 0 to 1.
    pub fraction: f32,
}

/// A log, and what was drawn on it when it was last open.
type Opened = Result<(Survey, Option<ReadBottom>), String>;

/// A log being opened. Dropping it cancels it.
pub(super) struct Loading {
    pub origin: Origin,
    task: Task<Opened>,
}

impl Loading {
    /// Starts opening.
    pub fn start(origin: Origin, jobs: &Jobs) -> Self {
        let wanted = origin.clone();
        let task = Task::start(jobs, move |progress| {
            let mut survey = wanted.open(progress).map_err(|error| error.to_string())?;
            formats::hold(&mut survey, progress).map_err(|error| error.to_string())?;
            let log = survey.source.files.first();
            let drawn = match &wanted {
                Origin::Path(_) => log.and_then(|log| bottom::read(log, &survey)),
                Origin::Demo => None,
            };
            Ok((survey, drawn))
        });
        Self { origin, task }
    }

    /// The outcome, once.
    pub fn poll(&self) -> Option<Opened> {
        match self.task.poll() {
            Outcome::Done(opened) => Some(opened),
            Outcome::Pending => None,
            Outcome::Failed => Some(Err(format!(
                "opening failed unexpectedly: {}",
                self.origin.name()
            ))),
        }
    }

    pub fn status(&self) -> LoadStatus {
        LoadStatus {
            name: self.origin.name(),
            fraction: self.task.fraction(),
        }
    }
}
