//! Opens the area at which isobaths end: its file is read in a background thread, and becomes part
//! of the settings only if it holds an area.

use super::App;
use super::jobs::JobKey;
use bathyscope_log::formats::read_area;
use bathyscope_log::survey::WaterArea;
use std::path::PathBuf;
use std::sync::Arc;

impl App {
    /// Starts reading an area; the reading of an earlier one is dropped.
    pub(super) fn open_isobath_area(&mut self, path: PathBuf) {
        // The settings must hold a path that is valid in whatever folder the next run starts.
        let path = std::path::absolute(&path).unwrap_or(path);
        self.jobs.run(
            JobKey::ReadArea,
            move |_| read_area(&path),
            |app, read| match read {
                Ok(area) => app.set_isobath_area(Some(area)),
                Err(error) => app.notices.warn(error.to_string()),
            },
        );
    }

    /// Removes the area, so that isobaths are shown wherever there are depths.
    pub(super) fn remove_isobath_area(&mut self) {
        self.jobs.stop(&JobKey::ReadArea);
        self.set_isobath_area(None);
    }

    fn set_isobath_area(&mut self, area: Option<WaterArea>) {
        self.edit_settings("isobath area", |settings| {
            settings.isobaths.clip = area.as_ref().map(|area| area.path.clone());
            settings.isobaths.area = area.map(Arc::new);
        });
    }
}
