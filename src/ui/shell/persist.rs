//! What is kept between runs: settings, display options, arrangement, recent logs. Never data.

use super::Shell;
use super::layout::Layout;
use crate::app::ViewOptions;
use crate::pipeline::Settings;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// Key in the store; a new number when old contents cannot be read any more.
const KEY: &str = "bathyscope window 1";

/// Everything that is kept.
#[derive(Serialize, Deserialize)]
struct Saved {
    settings: Settings,
    options: ViewOptions,
    layout: Layout,
    recent: Vec<PathBuf>,
}

#[derive(Serialize)]
struct Saving<'a> {
    settings: Settings,
    options: &'a ViewOptions,
    layout: &'a Layout,
    recent: &'a [PathBuf],
}

/// Writes the window's state into the store.
pub fn save(shell: &Shell, storage: &mut dyn eframe::Storage) {
    let settings = shell.app.settings.with_survey_of(&Settings::default());
    let saving = Saving {
        settings,
        options: &shell.app.options,
        layout: &shell.layout,
        recent: &shell.app.recent,
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
        if let Ok(saved) = serde_json::from_str::<Saved>(&text)
            && saved.settings.check().is_ok()
        {
            self.app.settings = saved.settings;
            self.app.options = saved.options;
            self.app.recent = saved.recent;
            self.layout = saved.layout;
        }
    }
}
