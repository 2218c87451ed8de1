//! Changes of every kind, which tests apply in any order.

use crate::pipeline::Settings;
use crate::project::Project;
use crate::project::log::{LogKey, ProjectLog};
use crate::project::measurement::Measurement;
use bathyscope_bottom::first_return::BottomSettings;
use bathyscope_objects::review::{Edit, Review};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Change that can be undone.
#[derive(Clone, Debug, PartialEq)]
pub enum Change {
    /// Change of the settings of a log: settings that belong to one log change for it, all others
    /// for all logs.
    Settings {
        /// Log whose settings the analyst views; `None` for the shared settings.
        log: Option<LogKey>,
        /// Settings after the change, as composed.
        after: Box<Settings>,
    },
    /// Change of a setting to the log's own value, or back to the shared one.
    Own {
        /// Log with the setting.
        log: LogKey,
        /// Key of the setting, as in `--set`.
        key: String,
        /// True if the log gets its own value.
        own: bool,
    },
    /// Change of the bottom edits of a log.
    Bottom {
        /// Log of the edits.
        log: LogKey,
        /// All bottom edits of the log after the change.
        after: BottomSettings,
    },
    /// Decision about a box.
    Box {
        /// Log of the box.
        log: LogKey,
        /// Decision about the box.
        edit: Edit,
    },
    /// Boxes of a search, or a review that was opened.
    Review {
        /// Log of the review.
        log: LogKey,
        /// Review of all boxes of the log after the change.
        after: Arc<Review>,
    },
    /// Log that is added.
    Add(Box<ProjectLog>),
    /// Log that is removed; its file stays.
    Remove(LogKey),
    /// Move of a log in the list.
    Move {
        /// Log that is moved.
        log: LogKey,
        /// New place, from 0.
        to: usize,
    },
    /// New name of a log.
    Rename(LogKey, String),
    /// New colour of a log; `None` for one by its place in the list.
    Colour(LogKey, Option<[u8; 3]>),
    /// True if a log is shown.
    Show(LogKey, bool),
    /// Measurement by its number; `None` for a new one.
    Measure(Option<u32>, Measurement),
    /// Number of a measurement that is removed.
    Forget(u32),
    /// Another file of the survey, by its kind; `None` to remove it.
    File(String, Option<PathBuf>),
}

impl Project {
    /// Returns the project after a change; `None` if it changes nothing, or the changed object does
    /// not exist.
    pub fn apply(&self, change: &Change) -> Option<Self> {
        match change {
            Change::Settings { log, after } => self.with_settings(log.as_ref(), after),
            Change::Own { log, key, own } => self.change_log(log, |log| {
                log.settings = log.settings.owning(&self.settings, key, *own)?;
                Some(())
            }),
            Change::Bottom { log, after } => self.change_log(log, |log| {
                log.settings.bottom = after.clone();
                Some(())
            }),
            Change::Box { log, edit } => self.change_log(log, |log| {
                log.review = Arc::new(log.review.apply(edit)?);
                Some(())
            }),
            Change::Review { log, after } => self.change_log(log, |log| {
                let is_of_log = after.identity().is_same_log(&log.file.identity());
                log.review = is_of_log.then(|| after.clone())?;
                Some(())
            }),
            Change::Add(log) => self.with_log(log.as_ref().clone()),
            Change::Remove(log) => self.without_log(log),
            Change::Move { log, to } => self.with_log_at(log, *to),
            Change::Rename(log, name) => self.change_log(log, |log| {
                let name = name.trim();
                log.name = (!name.is_empty()).then(|| name.chars().take(200).collect())?;
                Some(())
            }),
            Change::Colour(log, colour) => self.change_log(log, |log| {
                log.colour = *colour;
                Some(())
            }),
            Change::Show(log, is_visible) => self.change_log(log, |log| {
                log.is_visible = *is_visible;
                Some(())
            }),
            Change::Measure(number, measurement) => self.with_measurement(*number, measurement),
            Change::Forget(number) => {
                let mut after = self.clone();
                after.measurements.remove(number).map(|_| after)
            }
            Change::File(what, path) => self.with_file(what, path.as_deref()),
        }
    }

    fn change_log(
        &self,
        key: &LogKey,
        change: impl FnOnce(&mut ProjectLog) -> Option<()>,
    ) -> Option<Self> {
        let mut log = self.log(key)?.as_ref().clone();
        change(&mut log)?;
        self.with_changed(log)
    }

    fn with_settings(&self, key: Option<&LogKey>, after: &Settings) -> Option<Self> {
        let mut changed = self.clone();
        match key {
            None => {
                changed.settings = after.clone();
                changed.settings.bottom = BottomSettings::default();
            }
            Some(key) => {
                let mut log = self.log(key)?.as_ref().clone();
                let (shared, own) = log.settings.change(&self.settings, after).ok()?;
                changed.settings = shared;
                log.settings = own;
                changed = changed.with_changed(log).unwrap_or(changed);
            }
        }
        (changed != *self).then_some(changed)
    }

    fn with_measurement(&self, number: Option<u32>, measurement: &Measurement) -> Option<Self> {
        let last = self.measurements.keys().next_back();
        let next = || last.map_or(Some(1), |last| last.checked_add(1));
        let number = number.map_or_else(next, Some)?;
        let mut after = self.clone();
        let replaced = after.measurements.insert(number, measurement.clone());
        (replaced.as_ref() != Some(measurement)).then_some(after)
    }

    fn with_file(&self, what: &str, path: Option<&Path>) -> Option<Self> {
        let mut after = self.clone();
        match path {
            Some(path) => after.files.insert(what.to_owned(), path.to_owned()),
            None => after.files.remove(what),
        };
        (after.files != self.files).then_some(after)
    }
}
