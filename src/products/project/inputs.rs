//! A project as input for work without a window: its logs where they lie now, each with its
//! settings.

use super::find::{LogLocation, find};
use super::log::ProjectLog;
use super::store::{StoreError, read};
use crate::pipeline::{Settings, SettingsError};
use bathyscope_log::support::file_error::FileError;
use bathyscope_log::support::geo::LocalFrame;
use bathyscope_log::support::progress::{Cancelled, Progress};
use std::path::Path;
use std::sync::Arc;

/// A log of a project, to be opened and processed.
#[derive(Clone, Debug)]
pub struct ProjectInput {
    /// The log, its file where it lies now.
    pub log: Arc<ProjectLog>,
    /// The settings that it is processed with; the water levels and the area that they name are
    /// read.
    pub settings: Settings,
    /// The confidence from which undecided proposals count.
    pub least_confidence: f32,
    /// The frame that all logs of the project lie in, as the window has them; `None` where it is
    /// not kept.
    pub frame: Option<LocalFrame>,
    /// Warning about its file.
    pub warning: Option<String>,
}

/// Reason why a project gives no logs to process, in one sentence that ends with the file.
#[derive(Debug, thiserror::Error)]
pub enum ProjectInputError {
    /// The project cannot be read.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// A log has settings that cannot be used, or that name a file that cannot.
    #[error(transparent)]
    Settings(#[from] SettingsError),
    /// The work was cancelled.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    /// A log is not where it was, or none is shown.
    #[error(transparent)]
    Logs(#[from] FileError<LogsFault>),
}

/// Reason why the logs of a project cannot be processed, in a sentence without the file.
#[derive(Debug, thiserror::Error)]
pub enum LogsFault {
    /// Another recording is called as the log of this name was.
    #[error(
        "another recording lies where the log `{0}` of the project was; put it back beside the project"
    )]
    Replaced(String),
    /// The log of this name is nowhere.
    #[error(
        "the log `{0}` of the project is not there; put it back, or anywhere below the project's folder"
    )]
    Missing(String),
    /// No log is visible.
    #[error("the project has no log that is shown")]
    NoneShown,
}

/// The visible logs of a project, in their order.
///
/// # Errors
/// When the project cannot be read, holds no visible log, or a log or a file that its settings name
/// is not there.
pub fn inputs(path: &Path, progress: &Progress) -> Result<Vec<ProjectInput>, ProjectInputError> {
    let mut project = read(path)?;
    // Once for all logs.
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
