//! The changes that led to the present state of a project: undo takes them back after the project
//! is opened again.
//!
//! They lie in a file beside the project, `NAME.bathyscope-history`: first the hash of the
//! project's file that they lead to, then a line a change, the newest first, with what leads back
//! from the state after it to the state before. What was done since the project was saved is in its
//! journal. A file of another version of the project counts for nothing.

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
/// Changes kept.
const KEPT: usize = 100;
/// A longer file was not written by this program.
const LONGEST: u64 = 256 << 20;
/// Suffix of the file's name after the project's.
const HISTORY: &str = "-history";

/// A change that was made.
#[derive(Clone, Debug)]
pub struct PastStep {
    /// Name.
    pub label: String,
    /// The project before it.
    pub before: Project,
}

/// The changes in the order in which they were made.
#[derive(Clone, Debug, Default)]
pub(super) struct Past(VecDeque<PastStep>);

impl Past {
    /// These changes, the oldest first; of very many the last ones.
    pub(super) fn of_steps(steps: Vec<PastStep>) -> Self {
        let surplus = steps.len().saturating_sub(KEPT);
        Self(steps.into_iter().skip(surplus).collect())
    }

    /// The changes, the oldest first.
    pub(super) fn into_steps(self) -> impl Iterator<Item = PastStep> {
        self.0.into_iter()
    }

    /// Notes that a project became another one. One that comes back to an earlier state takes the
    /// changes since then away.
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

    /// Notes what a journal says that was done since a project was saved, whose rows have the
    /// journal's layout.
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

    /// Writes the file of the changes that led to a project, whose own file has this hash. It is of
    /// use to undo alone: what fails is lost silently.
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

    /// Reads the changes that led to the project in a file with this hash, of which these are the
    /// rows; none where that is not known.
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

/// Returns true if an analyst decided the same in two versions; how they are shown is no decision.
fn decides_alike(one: &Project, other: &Project) -> bool {
    let is_same = |(one, other): (&Arc<_>, &Arc<_>)| Arc::ptr_eq(one, other) || one == other;
    one.settings == other.settings
        && one.measurements == other.measurements
        && one.logs.len() == other.logs.len()
        && one.logs.iter().zip(&other.logs).all(is_same)
}

/// The project with what it has in common with another one as the same in memory.
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

fn history_of(path: &Path) -> PathBuf {
    let mut name = OsString::from(path.file_name().unwrap_or_default());
    name.push(HISTORY);
    path.with_file_name(name)
}
