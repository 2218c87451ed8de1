//! A project as input for work without a window: its logs where they lie now, each with its settings.

use super::find::{Found, find};
use super::log::ProjectLog;
use super::store::read;
use crate::pipeline::Settings;
use crate::support::geo::LocalFrame;
use crate::support::progress::Progress;
use std::path::Path;
use std::sync::Arc;

/// A log of a project, to be opened and processed.
#[derive(Clone, Debug)]
pub struct Input {
    /// The log, its file where it lies now.
    pub log: Arc<ProjectLog>,
    /// The settings that it is processed with; the water levels and the area that they name are read.
    pub settings: Settings,
    /// The frame that all logs of the project lie in, as the window has them; `None` where it is not kept.
    pub frame: Option<LocalFrame>,
    /// What to say of its file.
    pub warning: Option<String>,
}

/// The visible logs of a project, in their order.
///
/// # Errors
/// A sentence when the project cannot be read, holds no visible log, or a log or a file that its settings name is not there.
pub fn inputs(path: &Path, progress: &Progress) -> Result<Vec<Input>, String> {
    let mut project = read(path).map_err(|error| error.to_string())?;
    // Once for all logs.
    project
        .settings
        .load_area()
        .map_err(|error| error.to_string())?;
    let folder = super::store::folder_of(path);
    let places = find(&project, &folder, progress).map_err(|error| error.to_string())?;
    let mut inputs = Vec::new();
    for (log, (_, found)) in project.logs().iter().zip(places) {
        if !log.is_visible {
            continue;
        }
        let file = log.file.path.display();
        let warning = (found == Found::Changed).then(|| log.is_changed());
        let log = match found {
            Found::Here | Found::Changed => log.clone(),
            Found::Moved(path) => Arc::new(log.at(&path)),
            Found::Replaced => {
                return Err(format!(
                    "another recording lies where the log `{}` of the project was; put it back beside the project: {file}",
                    log.name
                ));
            }
            Found::Missing => {
                return Err(format!(
                    "the log `{}` of the project is not there; put it back, or anywhere below the project's folder: {file}",
                    log.name
                ));
            }
        };
        let mut settings = (project.settings_of(&log)).map_err(|error| error.to_string())?;
        settings.load_files().map_err(|error| error.to_string())?;
        let frame = project.origin.map(LocalFrame::new);
        inputs.push(Input {
            log,
            settings,
            frame,
            warning,
        });
    }
    if inputs.is_empty() {
        return Err(format!(
            "the project has no log that is shown: {}",
            path.display()
        ));
    }
    Ok(inputs)
}
