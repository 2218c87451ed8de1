//! A survey as a project: its logs and all that was decided about them, as one text file that
//! lasts.
//!
//! In: decisions of the analyst, or the text of a project. Out: the project, its text, and steps of
//! undo.
//!
//! `log` is one log, `history` what undo goes back to, and `past` keeps that on disk. `rows` turns
//! a project into lines and back, `row` is one line, `text` the file of them, which takes in what
//! older versions wrote, `paths` how files are named in it. `store` keeps the file: saved aside and
//! renamed, every gesture in a `journal` beside it, guarded by a `lock`. `find` looks for logs that
//! were moved, `inputs` hands them to work without a window, `sidecar` takes in the files that
//! earlier versions kept beside a log. No log is ever written.
//!
//! # The file
//!
//! `NAME.bathyscope` is UTF-8 text, and TOML, of which every line stands for itself:
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
//! Lines stand in the order of their keys, numbers by their value, so that a decision changes its
//! own line and nothing else. Between two lines with a value there is a blank one, because git
//! merges two people's changes only where a line between them stayed: changes of different
//! decisions merge by themselves. Where two people added lines at the same place git asks; both
//! stay, unless they have the same number. What this version does not know, a line or a field of
//! one, is kept and written back. Comments are not.

mod find;
mod history;
mod inputs;
mod journal;
mod lock;
mod log;
mod measurement;
mod past;
mod paths;
mod row;
mod rows;
mod sidecar;
mod store;
mod text;

pub use find::{LogLocation, find};
pub use history::{History, HistoryStep};
pub use inputs::{ProjectInput, inputs};
pub use log::{LogFile, LogKey, ProjectLog};
pub use measurement::{Measurement, MeasurementKind, Pick};
pub use past::{PastStep, UNDONE};
pub use row::Key;
pub use sidecar::{BottomFileError, read_bottom};
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

/// A text that is no project of this program.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ProjectError {
    /// One line makes no sense.
    #[error("line {line}: {what}")]
    Line {
        /// Number of the line, from 1.
        line: usize,
        /// Description of the error, with the correct form.
        what: String,
    },
    /// A newer program wrote it.
    #[error(
        "this project has layout {version}, this program reads layouts up to {}; use a newer Bathyscope",
        text::VERSION
    )]
    Newer {
        /// The version that it says.
        version: u32,
    },
}

impl ProjectError {
    fn line(line: usize, what: impl Display) -> Self {
        Self::Line { line, what: what.to_string() }
    }
}

/// The view ([`Project::view`]) that says how boxes are reviewed: their order, and the confidence
/// from which undecided ones count.
pub const REVIEW_VIEW: &str = "review";

/// Content of the file that this version does not know; it is written back.
#[derive(Clone, Debug, Default, PartialEq)]
struct Unknown {
    rows: Rows,
    /// Fields of rows that it knows.
    fields: BTreeMap<Key, Table>,
}

/// Everything that an analyst decides about a survey. A value: a change makes another one
/// ([`Project::with_changed`]), which shares what stayed.
#[derive(Clone, Debug, Default)]
pub struct Project {
    /// The settings that all logs share; it holds no bottom edits.
    pub settings: Settings,
    /// Place at which the plane that all logs lie in touches the ellipsoid: places in metres count
    /// from there. `None` until a log has a place.
    pub origin: Option<LonLat>,
    /// Other files that belong to the survey, by what they are: `base_map`, `reference`. Absolute.
    pub files: BTreeMap<String, PathBuf>,
    /// Measurements, by number.
    pub measurements: BTreeMap<u32, Measurement>,
    /// Display settings, by a name that Bathyscope chooses: [`Project::view`].
    pub views: BTreeMap<String, Value>,
    logs: Vec<Arc<ProjectLog>>,
    unknown: Unknown,
}

/// Cheap where two versions share their logs, as those of a history do.
impl PartialEq for Project {
    fn eq(&self, other: &Self) -> bool {
        let Self { settings, origin, files, measurements, views, logs, unknown } = self;
        let is_same = |(one, other): (&Arc<_>, &Arc<_>)| Arc::ptr_eq(one, other) || one == other;
        *settings == other.settings
            && *origin == other.origin
            && *files == other.files
            && *measurements == other.measurements
            && *views == other.views
            && *unknown == other.unknown
            && logs.len() == other.logs.len()
            && logs.iter().zip(&other.logs).all(is_same)
    }
}

impl Project {
    /// The logs in their order.
    pub fn logs(&self) -> &[Arc<ProjectLog>] {
        &self.logs
    }

    /// A log by its key.
    pub fn log(&self, key: &LogKey) -> Option<&Arc<ProjectLog>> {
        self.logs.iter().find(|log| log.key == *key)
    }

    /// The log that has these bytes, under whatever name: a log is in a project once.
    pub fn log_like(&self, file: &LogFile) -> Option<&Arc<ProjectLog>> {
        let is_same = |log: &&Arc<ProjectLog>| {
            log.file.sha256 == file.sha256 && log.file.byte_count == file.byte_count
        };
        self.logs.iter().find(is_same)
    }

    /// The settings that a log is processed with;
    /// [`LogSettings::compose`](crate::pipeline::LogSettings::compose).
    ///
    /// # Errors
    /// When an own value cannot be used.
    pub fn settings_of(&self, log: &ProjectLog) -> Result<Settings, SettingsError> {
        log.settings.compose(&self.settings)
    }

    /// Returns the project with one more log, the last of the list. `None` when its bytes are there
    /// already.
    pub fn with_log(&self, mut log: ProjectLog) -> Option<Self> {
        if self.log_like(&log.file).is_some() || self.log(&log.key).is_some() {
            return None;
        }
        log.order = self.logs.last().map_or(1.0, |last| last.order.floor() + 1.0);
        let mut after = self.clone();
        after.logs.push(Arc::new(log));
        Some(after)
    }

    /// Returns the project with another version of a log in its place. `None` when it is the same,
    /// or no log of the project.
    pub fn with_changed(&self, log: ProjectLog) -> Option<Self> {
        let index = self.logs.iter().position(|one| one.key == log.key)?;
        let before = &self.logs[index];
        let is_same = **before == log && before.object_numbers == log.object_numbers;
        (!is_same).then(|| {
            let mut after = self.clone();
            after.logs[index] = Arc::new(log);
            after.put_in_order();
            after
        })
    }

    /// Stores display settings under a name that Bathyscope chooses. They are no part of the
    /// history.
    pub fn set_view(&mut self, name: &str, shown: &impl Serialize) {
        // Options are numbers, names and lists, which can be written.
        if let Ok(value) = Value::try_from(shown) {
            self.views.insert(name.to_owned(), value);
        }
    }

    /// The confidence from which undecided proposals count; 0 where the project does not say.
    pub fn least_confidence(&self) -> f32 {
        #[derive(serde::Deserialize)]
        struct Kept {
            threshold: f32,
        }
        let kept = self.view::<Kept>(REVIEW_VIEW);
        kept.map_or(0.0, |kept| kept.threshold)
    }

    /// Returns display settings by their name; `None` where nothing is stored, or nothing that this
    /// version can use.
    pub fn view<T: DeserializeOwned>(&self, name: &str) -> Option<T> {
        self.views.get(name)?.clone().try_into().ok()
    }

    /// The text of its file in a folder.
    pub fn to_text(&self, folder: &Path) -> String {
        text::write(&rows::of(self, folder))
    }

    /// Reads the text of a file in a folder.
    ///
    /// # Errors
    /// A sentence with the line that makes no sense, or that a newer program is needed.
    pub fn from_text(text: &str, folder: &Path) -> Result<Self, ProjectError> {
        rows::read(text::read(text)?, folder)
    }

    /// Puts the logs in the order that they say.
    fn put_in_order(&mut self) {
        let by_order = |one: &Arc<ProjectLog>, other: &Arc<ProjectLog>| {
            (one.order.total_cmp(&other.order)).then_with(|| one.key.cmp(&other.key))
        };
        self.logs.sort_by(by_order);
    }
}

impl Project {
    /// Returns the project without a log, whose file stays. `None` when it is no log of the
    /// project.
    pub fn without_log(&self, key: &LogKey) -> Option<Self> {
        self.log(key)?;
        let mut after = self.clone();
        after.logs.retain(|log| log.key != *key);
        Some(after)
    }

    /// Returns the project with a log moved to place `to` of the list, counted from 0. `None` when
    /// it is there already, or no log of the project.
    ///
    /// Its order becomes a number between those of its neighbours, so that the others stay as they
    /// are; where there is no number between, all are numbered.
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
