//! Project of a survey: its logs and all decisions about them, stored as one text file.
//!
//! In: decisions of the analyst, or the text of a project. Out: the project, its text, and steps of
//! undo.
//!
//! `log` is one log, `history` holds the states for undo and stores them on disk. `rows` converts a
//! project to lines and back, `row` is one line, `text` reads and writes all lines and converts
//! those of older versions, `paths` converts the paths of files. `store` writes the file under a
//! temporary name and renames it, with every change in a `journal` beside it, which one window at a
//! time has. `find` searches for logs that were moved, makes the inputs for work without a window,
//! and finds the decisions about logs that are in no named project. Logs are never written.
//!
//! # The file
//!
//! `NAME.bathyscope` is UTF-8 text in TOML, in which every value is on one line:
//!
//! ```toml
//! bathyscope = 1                           # the version of the layout; a newer one is refused, an older one is taken in
//!
//! [settings]                               # shared by all logs: every setting, under its key of `--set`
//!
//! first_return.threshold = 0.3
//!
//! [file]                                   # other files that belong to the survey: base_map, reference
//!
//! base_map = "maps/aerial.tif"
//!
//! [log.chart_1-3f9a2c41]                   # a log: its first file name and the start of its SHA-256
//!
//! bytes = 1048576                          # of all its files
//!
//! classes = ["object"]                     # that its boxes can have
//!
//! file = "day1/Chart_1.sl2"                # from the project's folder
//!
//! name = "Chart_1"                         # also: colour = "#d95f02", visible = false
//!
//! order = 1.0                              # its place in the list
//!
//! pings = 4500
//!
//! sha256 = "3f9a2c41..."                   # of its files one after the other
//!
//! [log.chart_1-3f9a2c41.settings]          # where this log differs from the shared settings
//!
//! draft_m = 0.3
//!
//! [log.chart_1-3f9a2c41.bottom]            # a stretch of the bottom: side and first ping, last ping, corners [ping, slant range]
//!
//! port.1200 = { corners = [[1200.0, 4.2], [1260.0, 4.4]], last = 1260 }
//!
//! port.1300 = { accepted = true, last = 1340 }      # first returns that are bottom where they were found
//!
//! [log.chart_1-3f9a2c41.excluded]          # a stretch that counts for nothing, or is kept: pings or time_s, first and last
//!
//! pings.2000 = { last = 2150, reason = "turn" }
//!
//! [log.chart_1-3f9a2c41.searched]          # what a model has searched: first ping, its name, end
//!
//! 0 = { end = 4500, model = "demo" }
//!
//! [log.chart_1-3f9a2c41.box]               # a box by its number, pings with the last excluded
//!
//! 17 = { class = "object", edited = false, far_m = 6.8, near_m = 4.21, object = 4, pings = [1200, 1230], side = "port", state = "added" }
//!
//! [measure]                                # what was measured on the map: distance, area or profile, corners [lon, lat]
//!
//! 1 = { corners = [[-111.5, 36.8], [-111.4, 36.9]], kind = "distance" }
//!
//! [view]                                   # how things are shown, as the program that wrote it means it
//! ```
//!
//! Lines are in the order of their keys, numbers by their value, so that a decision changes only
//! its own line. Between two lines with a value there is a blank line, because git merges the
//! changes of two people only if there is an unchanged line between them: changes of different
//! decisions merge automatically. If two people added lines at the same place, git reports a
//! conflict; both lines can stay, unless they have the same number. Lines and fields that this
//! version does not know are kept and written back; comments are not.

mod find;
mod history;
mod journal;
mod log;
mod measurement;
mod paths;
mod row;
mod rows;
mod store;
mod text;

pub use find::{
    LogLocation, NAMED, ProjectInput, UntitledProject, find, find_untitled, inputs, unused_path,
};
pub use history::{History, HistoryStep, PastStep, UNDONE};
pub use log::{LogFile, LogKey, ProjectLog, read_bottom};
pub use measurement::{Measurement, MeasurementKind, Pick};
pub use row::Key;
pub use store::{ENDING, OpenedProject, SavingOutcome, Store, StoreError, read, with_journal};

use crate::pipeline::{Settings, SettingsError};
use bathyscope_log::support::geo::LonLat;
use row::Rows;
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::collections::BTreeMap;
use std::fmt::Display;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use toml::{Table, Value};

/// Error of a text that is not a project this program can read.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ProjectError {
    /// A line is not valid.
    #[error("line {line}: {what}")]
    Line {
        /// Number of the line, from 1.
        line: usize,
        /// Description of the error, with the correct form.
        what: String,
    },
    /// The file was written by a newer program.
    #[error(
        "this project has layout {version}, this program reads layouts up to {}; use a newer Bathyscope",
        text::VERSION
    )]
    Newer {
        /// Version in the file.
        version: u32,
    },
}

impl ProjectError {
    fn line(line: usize, what: impl Display) -> Self {
        Self::Line { line, what: what.to_string() }
    }
}

/// Name of the view ([`Project::view`]) with the display settings of the review: the order of
/// boxes, and the confidence from which undecided ones count.
pub const REVIEW_VIEW: &str = "review";

/// Content of the file that this version does not know, which is written back.
#[derive(Clone, Debug, Default, PartialEq)]
struct Unknown {
    rows: Rows,
    /// Unknown fields of known rows.
    fields: BTreeMap<Key, Table>,
}

/// All decisions of an analyst about a survey. An immutable value: a change makes a new project
/// ([`Project::with_changed`]), which shares the unchanged parts.
#[derive(Clone, Debug, Default)]
pub struct Project {
    /// Settings that all logs share, without bottom edits.
    pub settings: Settings,
    /// Position at which the plane of all logs touches the ellipsoid, and from which places in
    /// metres count; `None` until a log has a position.
    pub origin: Option<LonLat>,
    /// Absolute paths of other files of the survey, by their kind: `base_map`, `reference`.
    pub files: BTreeMap<String, PathBuf>,
    /// Measurements, by number.
    pub measurements: BTreeMap<u32, Measurement>,
    /// Display settings, by a name that Bathyscope chooses: [`Project::view`].
    pub views: BTreeMap<String, Value>,
    logs: Vec<Arc<ProjectLog>>,
    unknown: Unknown,
}

/// Cheap if two versions share their logs, as those of a history do.
impl PartialEq for Project {
    fn eq(&self, other: &Self) -> bool {
        let Self { settings: _, origin, files, measurements: _, views, logs: _, unknown } = self;
        self.decides_as(other)
            && *origin == other.origin
            && *files == other.files
            && *views == other.views
            && *unknown == other.unknown
    }
}

impl Project {
    /// Returns true if the decisions in two versions are equal; display settings are not compared.
    fn decides_as(&self, other: &Self) -> bool {
        let is_same = |(one, other): (&Arc<_>, &Arc<_>)| Arc::ptr_eq(one, other) || one == other;
        self.settings == other.settings
            && self.measurements == other.measurements
            && self.logs.len() == other.logs.len()
            && self.logs.iter().zip(&other.logs).all(is_same)
    }

    /// Returns the logs in their order.
    pub fn logs(&self) -> &[Arc<ProjectLog>] {
        &self.logs
    }

    /// Returns a log by its key.
    pub fn log(&self, key: &LogKey) -> Option<&Arc<ProjectLog>> {
        self.logs.iter().find(|log| log.key == *key)
    }

    /// Returns the log with the same bytes as a file, under any name: a project has each log once.
    pub fn log_like(&self, file: &LogFile) -> Option<&Arc<ProjectLog>> {
        let is_same = |log: &&Arc<ProjectLog>| {
            log.file.sha256 == file.sha256 && log.file.byte_count == file.byte_count
        };
        self.logs.iter().find(is_same)
    }

    /// Returns the settings with which a log is processed; see
    /// [`LogSettings::compose`](crate::pipeline::LogSettings::compose).
    ///
    /// # Errors
    /// When one of the log's own values cannot be used.
    pub fn settings_of(&self, log: &ProjectLog) -> Result<Settings, SettingsError> {
        log.settings.compose(&self.settings)
    }

    /// Returns the project with one more log, at the end of the list; `None` if the project has a
    /// log with the same bytes or key.
    pub fn with_log(&self, mut log: ProjectLog) -> Option<Self> {
        if self.log_like(&log.file).is_some() || self.log(&log.key).is_some() {
            return None;
        }
        log.order = self.logs.last().map_or(1.0, |last| last.order.floor() + 1.0);
        let mut after = self.clone();
        after.logs.push(Arc::new(log));
        Some(after)
    }

    /// Returns the project with a log replaced by another version; `None` if it is equal, or the
    /// project has no log with its key.
    pub fn with_changed(&self, log: ProjectLog) -> Option<Self> {
        let index = self.logs.iter().position(|known| known.key == log.key)?;
        let before = &self.logs[index];
        let is_same = **before == log && before.object_numbers == log.object_numbers;
        (!is_same).then(|| {
            let mut after = self.clone();
            after.logs[index] = Arc::new(log);
            after.put_in_order();
            after
        })
    }

    /// Stores display settings under a name that Bathyscope chooses. They are not part of the
    /// history.
    pub fn set_view(&mut self, name: &str, shown: &impl Serialize) {
        // Options are numbers, names and lists, whose serialization cannot fail.
        if let Ok(value) = Value::try_from(shown) {
            self.views.insert(name.to_owned(), value);
        }
    }

    /// Returns the confidence from which undecided proposals count; 0 if none is stored.
    pub fn least_confidence(&self) -> f32 {
        #[derive(serde::Deserialize)]
        struct Kept {
            threshold: f32,
        }
        let kept = self.view::<Kept>(REVIEW_VIEW);
        kept.map_or(0.0, |kept| kept.threshold)
    }

    /// Returns display settings by their name; `None` if none are stored, or this version cannot
    /// read them.
    pub fn view<T: DeserializeOwned>(&self, name: &str) -> Option<T> {
        self.views.get(name)?.clone().try_into().ok()
    }

    /// Returns the text of the project's file in a folder.
    pub fn to_text(&self, folder: &Path) -> String {
        text::write(&rows::of(self, folder))
    }

    /// Parses the text of a project's file in a folder.
    ///
    /// # Errors
    /// A sentence that names the line that is not valid, or that a newer program is needed.
    pub fn from_text(text: &str, folder: &Path) -> Result<Self, ProjectError> {
        let (written, version) = text::read_as_written(text)?;
        rows::read(text::migrate(written, version, text::VERSION), folder)
    }

    /// Sorts the logs by their `order`, then by their key.
    fn put_in_order(&mut self) {
        let by_order = |one: &Arc<ProjectLog>, other: &Arc<ProjectLog>| {
            (one.order.total_cmp(&other.order)).then_with(|| one.key.cmp(&other.key))
        };
        self.logs.sort_by(by_order);
    }

    /// Returns the project with each log at the path that has the name of its file, if there is
    /// one among `paths`.
    pub fn with_logs_at(&self, paths: &[PathBuf]) -> Self {
        let mut after = self.clone();
        for log in &mut after.logs {
            if let Some(path) =
                paths.iter().find(|path| path.file_name() == log.file.path.file_name())
            {
                *log = Arc::new(log.at(path));
            }
        }
        after
    }

    /// Returns the project with a single log of it; measurements stay if it has no other log.
    pub fn with_only(&self, key: &LogKey) -> Self {
        let mut after = self.clone();
        after.logs.retain(|log| log.key == *key);
        if after.logs.len() < self.logs.len() {
            after.measurements.clear();
        }
        after
    }

    /// Returns the project without a log; the log's file is not removed. `None` if the project has
    /// no such log.
    pub fn without_log(&self, key: &LogKey) -> Option<Self> {
        self.log(key)?;
        let mut after = self.clone();
        after.logs.retain(|log| log.key != *key);
        Some(after)
    }

    /// Returns the project with a log moved to place `to` of the list, counted from 0; `None` if it
    /// is there already, or the project has no such log.
    ///
    /// The order of the log becomes a number between those of its neighbours, so that the others do
    /// not change; if there is no such number, all logs are numbered again.
    pub fn with_log_at(&self, key: &LogKey, to: usize) -> Option<Self> {
        let from = self.logs.iter().position(|log| log.key == *key)?;
        let mut after = self.clone();
        let log = after.logs.remove(from);
        let to = to.min(after.logs.len());
        if from == to {
            return None;
        }
        let before = to.checked_sub(1).map(|index| after.logs[index].order);
        let next = after.logs.get(to).map(|log| log.order);
        let order = match (before, next) {
            (Some(before), Some(next)) => 0.5 * (before + next),
            (Some(before), None) => before.floor() + 1.0,
            (None, Some(next)) => next.ceil() - 1.0,
            (None, None) => return None,
        };
        let fits =
            before.is_none_or(|before| before < order) && next.is_none_or(|next| order < next);
        let renumbered =
            |log: &ProjectLog, order: f64| Arc::new(ProjectLog { order, ..log.clone() });
        after.logs.insert(to, renumbered(&log, order));
        if !fits {
            let logs = after.logs.iter().enumerate();
            after.logs = logs.map(|(index, log)| renumbered(log, index as f64 + 1.0)).collect();
        }
        Some(after)
    }
}

#[cfg(test)]
mod tests;
