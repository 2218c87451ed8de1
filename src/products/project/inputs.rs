//! Makes the inputs of a project for work without a window: its logs at their present places, each
//! with its settings.

use super::find::{LogLocation, find};
use super::log::ProjectLog;
use super::store::{StoreError, read};
use crate::pipeline::{Settings, SettingsError};
use bathyscope_log::support::file_error::FileError;
use bathyscope_log::support::geo::LocalFrame;
use bathyscope_log::support::progress::{Cancelled, Progress};
use std::path::Path;
use std::sync::Arc;

/// Log of a project, to be opened and processed.
#[derive(Clone, Debug)]
pub struct ProjectInput {
    /// The log, with the present path of its file.
    pub log: Arc<ProjectLog>,
    /// Settings with which the log is processed; the water levels and the area that they name are
    /// loaded.
    pub settings: Settings,
    /// Confidence from which undecided proposals count.
    pub least_confidence: f32,
    /// Local coordinate frame of all logs of the project, as in the window; `None` if the project
    /// has no origin yet.
    pub frame: Option<LocalFrame>,
    /// Warning about the log's file; `None` if there is none.
    pub warning: Option<String>,
}

/// Reason why a project gives no logs to process, in one sentence that ends with the file.
#[derive(Debug, thiserror::Error)]
pub enum ProjectInputError {
    /// The project cannot be read.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// Settings of a log cannot be used, or name a file that cannot be read.
    #[error(transparent)]
    Settings(#[from] SettingsError),
    /// The work was cancelled.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    /// A log is not at its place, or no log is visible.
    #[error(transparent)]
    Logs(#[from] FileError<LogsFault>),
}

/// Reason why the logs of a project cannot be processed, in a sentence without the file.
#[derive(Debug, thiserror::Error)]
pub enum LogsFault {
    /// Another recording is at the place of the log of this name.
    #[error(
        "another recording lies where the log `{0}` of the project was; put it back beside the project"
    )]
    Replaced(String),
    /// The log of this name was not found.
    #[error(
        "the log `{0}` of the project is not there; put it back, or anywhere below the project's folder"
    )]
    Missing(String),
    /// No log of the project is visible.
    #[error("the project has no log that is shown")]
    NoneShown,
}

/// Returns the visible logs of a project, in their order.
///
/// # Errors
/// When the project cannot be read, contains no visible log, or a log or a file that its settings
/// name is missing.
pub fn inputs(path: &Path, progress: &Progress) -> Result<Vec<ProjectInput>, ProjectInputError> {
    let mut project = read(path)?;
    // Loaded once for all logs.
    project.settings.load_area()?;
    let folder = super::store::folder_of(path);
    let places = find(&project, &folder, progress)?;
    let mut inputs = Vec::new();
    for (log, (_, found)) in project.logs().iter().zip(places) {
        if !log.is_visible {
            continue;
        }
        let fail = FileError::at(&log.file.path);
        let warning = (found == LogLocation::Changed).then(|| log.is_changed());
        let log = match found {
            LogLocation::Here | LogLocation::Changed => log.clone(),
            LogLocation::Moved(path) => Arc::new(log.at(&path)),
            LogLocation::Replaced => return Err(fail(LogsFault::Replaced(log.name.clone())).into()),
            LogLocation::Missing => return Err(fail(LogsFault::Missing(log.name.clone())).into()),
        };
        let mut settings = project.settings_of(&log)?;
        settings.load_files()?;
        let frame = project.origin.map(LocalFrame::new);
        inputs.push(ProjectInput {
            log,
            settings,
            least_confidence: project.least_confidence(),
            frame,
            warning,
        });
    }
    if inputs.is_empty() {
        return Err(FileError::new(LogsFault::NoneShown, path).into());
    }
    Ok(inputs)
}
