//! Saves the analyst's preferences between runs (display options, arrangement, mountings), with
//! recent logs and the path of the base map. Data of surveys are
//! never saved, and no setting of one survey is used for the next.

use super::Shell;
use super::layout::Layout;
use crate::app::{Mountings, ViewOptions};
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// Key in the store; its number grows when old contents cannot be read any more.
const KEY: &str = "bathyscope window 1";

/// The saved preferences, as they are read.
#[derive(Serialize, Deserialize)]
struct Saved {
    options: ViewOptions,
    layout: Layout,
    recent: Vec<PathBuf>,
    #[serde(default)]
    base_map: Option<PathBuf>,
    /// Default mountings of the recorders.
    #[serde(default)]
    mountings: Mountings,
}

#[derive(Serialize)]
struct SavedWindow<'a> {
    options: &'a ViewOptions,
    layout: &'a Layout,
    recent: &'a [PathBuf],
    base_map: Option<&'a Path>,
    mountings: &'a Mountings,
}

/// Writes the preferences into the store.
pub(super) fn save(shell: &Shell, storage: &mut dyn eframe::Storage) {
    let base_map = shell.app.map.base_map.as_ref();
    let saving = SavedWindow {
        options: &shell.app.view.options,
        layout: &shell.layout,
        recent: &shell.app.recent,
        base_map: base_map.map(|map| map.path.as_path()),
        mountings: &shell.app.document.mountings,
    };
    if let Ok(text) = serde_json::to_string(&saving) {
        storage.set_string(KEY, text);
    }
}

impl Shell {
    /// Restores the preferences of an earlier run; those that cannot be read keep their defaults.
    pub fn restore(&mut self, storage: &dyn eframe::Storage) {
        let Some(text) = storage.get_string(KEY) else {
            return;
        };
        if let Ok(saved) = serde_json::from_str::<Saved>(&text) {
            self.app.use_mountings(saved.mountings);
            self.app.view.options = saved.options.for_new_survey();
            self.app.recent = saved.recent;
            self.layout = saved.layout;
            if let Some(path) = saved.base_map {
                self.app.reopen_base_map(path);
            }
        }
    }
}
