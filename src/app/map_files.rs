//! Opens further files that the map is drawn with in background threads: the analyst's own picture
//! under the map, which stays from survey to survey, and the area at which isobaths end, which
//! becomes part of the settings only if its file holds an area.

use super::error::AppError;
use super::jobs::JobKey;
use super::{App, MapLayer};
use bathyscope_log::formats::base_map::{self, BaseMap};
use bathyscope_log::formats::read_area;
use bathyscope_log::survey::{Survey, WaterArea};
use std::path::PathBuf;
use std::sync::Arc;

impl App {
    /// Opens the base map that was open when the window was last closed; notifies the analyst if
    /// its file is missing.
    pub(crate) fn reopen_base_map(&mut self, path: PathBuf) {
        if path.is_file() {
            self.open_base_map(path, true);
        } else {
            let text = format!("The base map that was open last is missing: {}", path.display());
            self.notices.notify(text);
        }
    }

    /// Starts opening a base map, which the analyst asked for now or in the last session; the
    /// opening of an earlier one is dropped.
    pub(super) fn open_base_map(&mut self, path: PathBuf, is_of_last_time: bool) {
        // The file must be found again in whatever folder the next run starts.
        let path = std::path::absolute(&path).unwrap_or(path);
        self.jobs.run(
            JobKey::OpenBaseMap,
            move |progress| Ok(base_map::open(&path, progress)?),
            move |app, opened| app.take_base_map(opened, is_of_last_time),
        );
    }

    /// Removes the base map.
    pub(super) fn close_base_map(&mut self) {
        self.map.base_map = None;
        self.jobs.stop(&JobKey::OpenBaseMap);
    }

    /// Shows a base map that was opened, or notifies the analyst of the error.
    fn take_base_map(&mut self, opened: Result<BaseMap, AppError>, is_of_last_time: bool) {
        match opened {
            // A base map of the last session stays shown or hidden, without a notice.
            Ok(map) if is_of_last_time => self.map.base_map = Some(Arc::new(map)),
            Ok(map) => {
                self.notices.notify(words_about(&map, self.logs.shown.survey.as_deref()));
                self.view.options.map.layers.set_visible(MapLayer::BaseMap, true);
                self.map.base_map = Some(Arc::new(map));
            }
            Err(error) if is_of_last_time => self.notices.notify(error),
            Err(error) => self.notices.warn(error),
        }
    }

    /// Starts reading an area; the reading of an earlier one is dropped.
    pub(super) fn open_isobath_area(&mut self, path: PathBuf) {
        // The settings must hold a path that is valid in whatever folder the next run starts.
        let path = std::path::absolute(&path).unwrap_or(path);
        self.jobs.run(
            JobKey::ReadArea,
            move |_| read_area(&path),
            |app, read| match read {
                Ok(area) => app.set_isobath_area(Some(area)),
                Err(error) => app.notices.warn(error),
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

/// Returns the notice about an opened base map: its size, its coordinate system, its path, and
/// a remark if it does not reach the start of `survey`.
fn words_about(map: &BaseMap, survey: Option<&Survey>) -> String {
    let [columns, rows] = map.size;
    let pixel_m = map.pixel_m();
    let mut text = format!(
        "Opened the base map of {columns} by {rows} pixels of {pixel_m:.2} m, {}",
        map.place.crs
    );
    let start = survey.map(|survey| survey.track.frame.origin());
    if start.is_some_and(|start| !map.covers(start)) {
        text += ", which does not reach the start of this survey";
    }
    format!("{text}: {}", map.path.display())
}
