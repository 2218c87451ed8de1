//! Makes the inputs of a project for work without a window: its logs at their present places, each
//! with its settings.

use super::find::{LogLocation, find};
use super::log::ProjectLog;
use super::store::read_with_changes;
use crate::Error;
use crate::pipeline::Settings;
use bathyscope_log::support::geo::LocalFrame;
use bathyscope_log::support::progress::Progress;
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

/// Returns the visible logs of a project, in their order, with the changes in the journal beside
/// it: those of a window that has it open, or was killed.
///
/// # Errors
/// When the project cannot be read, contains no visible log, or a log or a file that its settings
/// name is missing.
pub fn inputs(path: &Path, progress: &Progress) -> Result<Vec<ProjectInput>, Error> {
    let mut project = read_with_changes(path)?;
    // Loaded once for all logs.
    project.settings.load_area().map_err(|error| error.0)?;
    let folder = super::store::folder_of(path);
    let places = find(&project, &folder, progress)?;
    let mut inputs = Vec::new();
    for (log, (_, found)) in project.logs().iter().zip(places) {
        if !log.is_visible {
            continue;
        }
        let (name, file) = (&log.name, log.file.path.display());
        let warning = (found == LogLocation::Changed).then(|| log.is_changed());
        let log = match found {
            LogLocation::Here | LogLocation::Changed => log.clone(),
            LogLocation::Moved(path) => Arc::new(log.at(&path)),
            LogLocation::Replaced => {
                return Err(format!(
                    "another recording lies where the log `{name}` of the project was; put it back beside the project: {file}"
                )
                .into());
            }
            LogLocation::Missing => {
                return Err(format!(
                    "the log `{name}` of the project is not there; put it back, or anywhere below the project's folder: {file}"
                )
                .into());
            }
        };
        let mut settings = project.settings_of(&log).map_err(|error| error.0)?;
        settings.load_files().map_err(|error| error.0)?;
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
        return Err(format!("the project has no log that is shown: {}", path.display()).into());
    }
    Ok(inputs)
}
