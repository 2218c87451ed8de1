//! What is kept between runs: settings, display options, arrangement, recent logs, the base map's file. Never data.

use super::Shell;
use super::layout::Layout;
use crate::app::{Mountings, ViewOptions};
use crate::pipeline::Settings;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// Key in the store; a new number when old contents cannot be read any more.
const KEY: &str = "bathyscope window 1";

/// Everything that is kept.
#[derive(Serialize, Deserialize)]
struct Saved {
    /// Settings of another version may not be known here; the rest is taken all the same.
    settings: serde_json::Value,
    options: ViewOptions,
    layout: Layout,
    recent: Vec<PathBuf>,
    #[serde(default)]
    base_map: Option<PathBuf>,
    /// How recorders are mounted as a rule.
    #[serde(default)]
    mountings: Mountings,
}

#[derive(Serialize)]
struct Saving<'a> {
    settings: Settings,
    options: &'a ViewOptions,
    layout: &'a Layout,
    recent: &'a [PathBuf],
    base_map: Option<&'a Path>,
    mountings: &'a Mountings,
}

/// Writes the window's state into the store.
pub fn save(shell: &Shell, storage: &mut dyn eframe::Storage) {
    let settings = shell.app.log.settings.with_survey_of(&Settings::default());
    let saving = Saving {
        settings,
        options: &shell.app.options,
        layout: &shell.layout,
        recent: &shell.app.recent,
        base_map: shell.app.base_map.as_ref().map(|map| map.path.as_path()),
        mountings: shell.app.mountings(),
    };
    if let Ok(text) = serde_json::to_string(&saving) {
        storage.set_string(KEY, text);
    }
}

impl Shell {
    /// Takes over what an earlier run saved; anything unreadable is left as it is by default.
    pub fn restore(&mut self, storage: &dyn eframe::Storage) {
        let Some(text) = storage.get_string(KEY) else {
            return;
        };
        if let Ok(saved) = serde_json::from_str::<Saved>(&text) {
            let settings = serde_json::from_value::<Settings>(saved.settings).ok();
            if let Some(settings) = settings.filter(|settings| settings.check().is_ok()) {
                self.app.use_settings(&settings);
            }
            self.app.use_mountings(saved.mountings);
            self.app.options = saved.options;
            self.app.recent = saved.recent;
            self.layout = saved.layout;
            if let Some(path) = saved.base_map {
                self.app.reopen_base_map(path);
            }
        }
    }
}
