//! Changes of every kind, which tests make in any order.

use crate::pipeline::Settings;
use crate::project::Project;
use crate::project::log::{LogKey, ProjectLog};
use crate::project::measurement::Measurement;
use bathyscope_bottom::first_return::BottomSettings;
use bathyscope_objects::review::{Edit, Review};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A change that can be taken back.
#[derive(Clone, Debug, PartialEq)]
pub enum Change {
    /// The settings of a log became these: what belongs to the log changes there, all else for all
    /// logs.
    Settings {
        /// The log whose settings the analyst looks at; `None` to change the shared ones alone.
        log: Option<LogKey>,
        /// Settings after the change, as composed.
        after: Box<Settings>,
        /// Name of the change: `threshold`.
        label: &'static str,
    },
    /// Makes a setting a log's own, with the value that it has, or leaves it to what all share.
    Own {
        /// The log.
        log: LogKey,
        /// The setting, as in `--set`.
        key: String,
        /// True if it is the log's own.
        own: bool,
    },
    /// The bottom of a log was drawn or forgotten.
    Bottom {
        /// The log.
        log: LogKey,
        /// All of its bottom edits.
        after: BottomSettings,
    },
    /// A decision about a box.
    Box {
        /// The log.
        log: LogKey,
        /// The decision.
        edit: Edit,
    },
    /// Boxes that were searched for, or a review that was opened.
    Review {
        /// The log.
        log: LogKey,
        /// All of its boxes.
        after: Arc<Review>,
        /// Name of the change: `search for objects`.
        label: &'static str,
    },
    /// A log more.
    Add(Box<ProjectLog>),
    /// A log less; its file stays.
    Remove(LogKey),
    /// A log stands elsewhere in the list.
    Move {
        /// The log.
        log: LogKey,
        /// Its new place, from 0.
        to: usize,
    },
    /// A log is called otherwise.
    Rename(LogKey, String),
    /// A log has another colour, or one by its place.
    Colour(LogKey, Option<[u8; 3]>),
    /// A log takes part, or does not.
    Show(LogKey, bool),
    /// Something was measured; `None` instead of a number for one more.
    Measure(Option<u32>, Measurement),
    /// A measurement is taken away.
    Forget(u32),
    /// Another file of the survey, by what it is, or none any more.
    File(String, Option<PathBuf>),
}

impl Project {
    /// The project after a change; `None` when it changes nothing, or is about something that is
    /// not there.
    pub fn apply(&self, change: &Change) -> Option<Self> {
        match change {
            Change::Settings { log, after, .. } => self.with_settings(log.as_ref(), after),
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
            Change::Review { log, after, .. } => self.change_log(log, |log| {
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
