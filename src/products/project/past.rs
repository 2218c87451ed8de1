//! Stores the changes that led to the present state of a project, so that they can be undone after
//! the project is opened again.
//!
//! The changes are in a file beside the project, `NAME.bathyscope-history`: first the hash of the
//! project's file to which they lead, then a line for each change, the newest first, with the
//! differences from the state after it to the state before. The changes since the project was saved
//! are in its journal. A file for another version of the project is ignored.

use super::journal::Entry;
use super::row::Rows;
use super::text::{VERSION, migrate};
use super::{Project, ProjectLog, rows};
use crate::export;
use bathyscope_log::support::regular_file;
use std::collections::VecDeque;
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Name of undo and redo in the journal.
pub const UNDONE: &str = "undo or redo";
/// Most changes that are stored.
const KEPT: usize = 100;
/// Largest size of the file, bytes: this program does not write a longer one.
const LONGEST: u64 = 256 << 20;
/// Suffix of the file's name after the project's.
const HISTORY: &str = "-history";

/// Change that was made.
#[derive(Clone, Debug)]
pub struct PastStep {
    /// Name of the change.
    pub label: String,
    /// Project before the change.
    pub before: Project,
}

/// Changes in the order in which they were made.
#[derive(Clone, Debug, Default)]
pub(super) struct Past(VecDeque<PastStep>);

impl Past {
    /// Creates the past from these changes, the oldest first; of more than [`KEPT`], the last ones
    /// are kept.
    pub(super) fn of_steps(steps: Vec<PastStep>) -> Self {
        let surplus = steps.len().saturating_sub(KEPT);
        Self(steps.into_iter().skip(surplus).collect())
    }

    /// Returns the changes, the oldest first.
    pub(super) fn into_steps(self) -> impl Iterator<Item = PastStep> {
        self.0.into_iter()
    }

    /// Records a change of a project. An undo or redo to an earlier state removes the changes since
    /// then.
    pub(super) fn note(&mut self, label: &str, before: &Project, after: &Project) {
        if label == UNDONE
            && let Some(at) = self.0.iter().rposition(|step| decides_alike(&step.before, after))
        {
            return self.0.truncate(at);
        }
        self.0.push_back(PastStep { label: label.to_owned(), before: before.clone() });
        if self.0.len() > KEPT {
            self.0.pop_front();
        }
    }

    /// Records the changes in a journal since a project was saved; its rows have the journal's
    /// layout.
    pub(super) fn replay(
        &mut self,
        saved: &Project,
        (mut rows, version): (Rows, u32),
        entries: &[Entry],
        folder: &Path,
    ) {
        let mut project = saved.clone();
        for entry in entries {
            let Entry::Done { label, .. } = entry else {
                continue;
            };
            entry.replay(&mut rows);
            let after = rows::read(migrate(rows.clone(), version, VERSION), folder);
            let Ok(after) = after else {
                return;
            };
            let after = sharing(after, &project);
            self.note(label, &project, &after);
            project = after;
        }
    }

    /// Writes the file of the changes that led to a project, whose own file has this hash. Errors
    /// are ignored, since only undo needs the file.
    pub(super) fn write(&self, path: &Path, now: &Project, sha256: &str, folder: &Path) {
        let saved = Entry::Saved { sha256: sha256.to_owned(), version: VERSION };
        let mut text = saved.to_line();
        let mut after = now;
        for step in self.0.iter().rev() {
            let (set, gone) = rows::changes(after, &step.before, folder);
            text += &Entry::done(&step.label, &set, &gone).to_line();
            after = &step.before;
        }
        export::write_bytes(&history_of(path), text).ok();
    }

    /// Reads the changes that led to the project, whose file has this hash and these rows; empty if
    /// they are unknown.
    pub(super) fn read(
        path: &Path,
        (saved, mut rows): (&Project, Rows),
        sha256: &str,
        folder: &Path,
    ) -> Self {
        let bytes = regular_file::read(&history_of(path), LONGEST).unwrap_or_default();
        let text = String::from_utf8(bytes).unwrap_or_default();
        let mut entries = text.lines().map_while(Entry::from_line);
        let is_of = |entry| matches!(entry, Entry::Saved { sha256: of, version } if of == sha256 && version == VERSION);
        let mut past = VecDeque::new();
        if !entries.next().is_some_and(is_of) {
            return Self(past);
        }
        let mut after = saved.clone();
        for entry in entries.take(KEPT) {
            entry.replay(&mut rows);
            let (Entry::Done { label, .. }, Ok(before)) = (entry, rows::read(rows.clone(), folder))
            else {
                break;
            };
            let before = sharing(before, &after);
            after = before.clone();
            past.push_front(PastStep { label, before });
        }
        Self(past)
    }
}

/// Returns true if the decisions in two versions are equal; display settings are not compared.
fn decides_alike(one: &Project, other: &Project) -> bool {
    let is_same = |(one, other): (&Arc<_>, &Arc<_>)| Arc::ptr_eq(one, other) || one == other;
    one.settings == other.settings
        && one.measurements == other.measurements
        && one.logs.len() == other.logs.len()
        && one.logs.iter().zip(&other.logs).all(is_same)
}

/// Returns the project with the parts that equal those of another one shared with it in memory.
fn sharing(mut project: Project, with: &Project) -> Project {
    for log in &mut project.logs {
        let Some(same) = with.log(&log.key) else {
            continue;
        };
        if log == same {
            *log = same.clone();
        } else if log.review == same.review {
            let review = same.review.clone();
            *log = Arc::new(ProjectLog { review, ..ProjectLog::clone(log) });
        }
    }
    project
}

/// Returns the path of the file with the past of a project.
pub(super) fn history_of(path: &Path) -> PathBuf {
    let mut name = OsString::from(path.file_name().unwrap_or_default());
    name.push(HISTORY);
    path.with_file_name(name)
}
