//! Opens the area at which isobaths end: its file is read in a background thread, and becomes part
//! of the settings only if it holds an area.

use super::error::AppError;
use super::{App, Task, TaskOutcome};
use bathyscope_log::formats::read_area;
use bathyscope_log::survey::WaterArea;
use bathyscope_products::pipeline::Settings;
use std::path::PathBuf;
use std::sync::Arc;

/// Name of undo steps that change the area.
const LABEL: &str = "isobath area";

/// The reading of an area, if one is running.
#[derive(Default)]
pub(super) struct ReadingArea(Option<Task<Result<WaterArea, AppError>>>);

impl ReadingArea {
    /// Returns true if an area is being read.
    pub(super) fn is_busy(&self) -> bool {
        self.0.is_some()
    }

    /// Stops reading an area.
    pub(super) fn stop(&mut self) {
        self.0 = None;
    }
}

impl App {
    /// Starts reading an area; the reading of an earlier one is dropped.
    pub(super) fn open_isobath_area(&mut self, path: PathBuf) {
        // The settings must hold a path that is valid in whatever folder the next run starts.
        let path = std::path::absolute(&path).unwrap_or(path);
        let work = move |_: &_| Ok(read_area(&path)?);
        self.files.reading_area.0 = Some(Task::start(&self.jobs, work));
    }

    /// Collects an area when reading has ended, and adds it to the settings.
    pub(super) fn poll_isobath_area(&mut self) {
        let read = match self.files.reading_area.0.as_ref().map(Task::poll) {
            None | Some(TaskOutcome::Pending) => return,
            Some(TaskOutcome::Done(read)) => read,
            Some(TaskOutcome::Failed) => Err(AppError::Failed("reading the area")),
        };
        self.files.reading_area.stop();
        match read {
            Ok(area) => self.set_isobath_area(Some(area)),
            Err(error) => self.warn(error.to_string()),
        }
    }

    /// Removes the area, so that isobaths are shown wherever there are depths.
    pub(super) fn remove_isobath_area(&mut self) {
        self.files.reading_area.stop();
        self.set_isobath_area(None);
    }

    fn set_isobath_area(&mut self, area: Option<WaterArea>) {
        let mut settings = Settings::clone(&self.log.settings);
        settings.isobaths.clip = area.as_ref().map(|area| area.path.clone());
        settings.isobaths.area = area.map(Arc::new);
        self.change(settings, LABEL, false);
    }
}
