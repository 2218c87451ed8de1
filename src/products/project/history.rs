//! Undo and redo, also after the project is opened again.
//!
//! `History` holds complete states, each with the name of the change that followed it. States share
//! their unchanged parts, so that a step only needs memory for its changes.
//!
//! `Past` stores the changes that led to the present state of a project in a file beside it,
//! `NAME.bathyscope-history`: first the hash of the project's file to which they lead, then a line
//! for each change, the newest first, with the differences from the state after it to the state
//! before. The changes since the project was saved are in its journal. A file for another version
//! of the project is ignored.

use super::journal::Entry;
use super::paths::beside;
use super::row::Rows;
use super::text::{VERSION, migrate};
use super::{Project, ProjectLog, rows};
use crate::export;
use bathyscope_log::support::regular_file;
use std::borrow::Cow;
use std::collections::VecDeque;
use std::path::Path;
use std::sync::Arc;

/// Name of a change in menus and in the list of the history.
type ChangeLabel = Cow<'static, str>;

/// History of states, in which a drag is one step, however many states it passes.
#[derive(Clone, Debug)]
pub struct History<T> {
    undo: VecDeque<(T, ChangeLabel)>,
    redo: Vec<(T, ChangeLabel)>,
    /// State before the current drag, and the name of the drag; `None` outside a drag.
    open: Option<(T, ChangeLabel)>,
}

/// Step in the list of the history.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct HistoryStep<'a> {
    /// Name of the change.
    pub label: &'a str,
    /// True if the step was undone and can be redone.
    pub is_undone: bool,
}

/// Most steps that can be undone.
const DEPTH: usize = 200;

impl<T> Default for History<T> {
    fn default() -> Self {
        Self { undo: VecDeque::new(), redo: Vec::new(), open: None }
    }
}

impl<T: Clone + PartialEq> History<T> {
    /// Creates a history of changes that were made before: each state with the name of the change
    /// that followed it, the oldest first.
    pub fn of_past(past: impl IntoIterator<Item = (T, ChangeLabel)>) -> Self {
        Self { undo: past.into_iter().collect(), ..Self::default() }
    }

    /// Returns the changes that can be undone: each state with the name of the change that followed
    /// it, the oldest first.
    pub fn past(&self) -> impl DoubleEndedIterator<Item = (&T, &str)> {
        self.undo.iter().map(|(state, label)| (state, &**label))
    }

    /// Records a change from `before` to `after`. Changes with `live` are part of a drag: the next
    /// change of the same name without `live` ends it, and all are one step.
    pub fn record(&mut self, before: &T, after: &T, label: impl Into<ChangeLabel>, live: bool) {
        let label = label.into();
        if self.open.as_ref().is_some_and(|(_, open)| *open != label) {
            self.close(before);
        }
        let (start, label) = self.open.take().unwrap_or_else(|| (before.clone(), label));
        if live {
            self.open = Some((start, label));
        } else if start != *after {
            self.push(start, label);
        }
    }

    /// Returns the state at the start of the step that a change with this name from `before` would
    /// end: the state before its drag, if there is one, else `before`.
    pub fn start_of<'a>(&'a self, label: &str, before: &'a T) -> &'a T {
        let open = self.open.as_ref().filter(|(_, open)| open == label);
        open.map_or(before, |(start, _)| start)
    }

    /// Renames the last step: the drag `threshold` becomes `threshold 0.41`.
    pub fn name_last(&mut self, label: impl Into<ChangeLabel>) {
        if let Some((_, last)) = self.undo.back_mut() {
            *last = label.into();
        }
    }

    fn close(&mut self, now: &T) {
        if let Some((start, label)) = self.open.take()
            && start != *now
        {
            self.push(start, label);
        }
    }

    fn push(&mut self, state: T, label: ChangeLabel) {
        self.undo.push_back((state, label));
        self.redo.clear();
        if self.undo.len() > DEPTH {
            self.undo.pop_front();
        }
    }

    /// Undoes the last step and returns the state before it; `None` if there is none.
    pub fn undo(&mut self, now: &T) -> Option<T> {
        self.close(now);
        let (state, label) = self.undo.pop_back()?;
        self.redo.push((now.clone(), label));
        Some(state)
    }

    /// Redoes the last undone step and returns the state after it; `None` if there is none.
    pub fn redo(&mut self, now: &T) -> Option<T> {
        let (state, label) = self.redo.pop()?;
        self.undo.push_back((now.clone(), label));
        Some(state)
    }

    /// Returns the name of the step that [`History::undo`] would undo.
    pub fn undo_label(&self) -> Option<&str> {
        self.open.as_ref().or(self.undo.back()).map(|(_, label)| label.as_ref())
    }

    /// Returns the name of the step that [`History::redo`] would redo.
    pub fn redo_label(&self) -> Option<&str> {
        self.redo.last().map(|(_, label)| label.as_ref())
    }

    /// Returns all steps in their order, the undone ones after the others.
    pub fn steps(&self) -> impl Iterator<Item = HistoryStep<'_>> {
        let done = self
            .undo
            .iter()
            .chain(&self.open)
            .map(|(_, label)| HistoryStep { label, is_undone: false });
        done.chain(self.redo.iter().rev().map(|(_, label)| HistoryStep { label, is_undone: true }))
    }

    /// Goes to the state after the first `count` of [`History::steps`] and returns it; `None` if it
    /// is the present state, or there are fewer steps.
    pub fn go_to(&mut self, count: usize, now: &T) -> Option<T> {
        self.close(now);
        if count > self.undo.len() + self.redo.len() {
            return None;
        }
        let mut state = None;
        while self.undo.len() != count {
            let from = state.as_ref().unwrap_or(now).clone();
            state = if self.undo.len() > count { self.undo(&from) } else { self.redo(&from) };
        }
        state
    }
}

/// Name of undo and redo in the journal.
pub const UNDONE: &str = "undo or redo";
/// Most changes that are stored.
const KEPT: usize = 100;
/// Largest size of the file, bytes: this program does not write a longer one.
const LONGEST: u64 = 256 << 20;
/// Suffix of the file's name after the project's.
pub(super) const HISTORY: &str = "-history";

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
pub(super) struct Past(pub VecDeque<PastStep>);

impl Past {
    /// Creates the past from these changes, the oldest first; of more than [`KEPT`], the last ones
    /// are kept.
    pub(super) fn of_steps(steps: Vec<PastStep>) -> Self {
        let surplus = steps.len().saturating_sub(KEPT);
        Self(steps.into_iter().skip(surplus).collect())
    }

    /// Records a change of a project. An undo or redo to an earlier state removes the changes since
    /// then.
    pub(super) fn note(&mut self, label: &str, before: &Project, after: &Project) {
        if label == UNDONE
            && let Some(at) = self.0.iter().rposition(|step| step.before.decides_as(after))
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
        export::write_bytes(&beside(path, HISTORY), text).ok();
    }

    /// Reads the changes that led to the project, whose file has this hash and these rows; empty if
    /// they are unknown.
    pub(super) fn read(
        path: &Path,
        (saved, mut rows): (&Project, Rows),
        sha256: &str,
        folder: &Path,
    ) -> Self {
        let bytes = regular_file::read(&beside(path, HISTORY), LONGEST).unwrap_or_default();
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

#[cfg(test)]
mod tests {
    use super::History;

    #[test]
    fn a_drag_is_one_step() {
        let mut history = History::default();
        history.record(&0, &1, "threshold", true);
        history.record(&1, &2, "threshold", true);
        history.record(&2, &3, "threshold", false);
        history.record(&3, &9, "preset", false);
        assert_eq!(history.undo(&9), Some(3));
        assert_eq!(history.undo(&3), Some(0));
        assert_eq!(history.undo(&0), None);
        assert_eq!(history.redo(&0), Some(3));
        assert_eq!(history.redo(&3), Some(9));
    }

    #[test]
    fn a_step_is_named_by_where_its_drag_began() {
        let mut history = History::default();
        history.record(&0, &1, "threshold", true);
        assert_eq!(*history.start_of("threshold", &1), 0);
        assert_eq!(*history.start_of("preset", &1), 1);
        history.record(&1, &2, "threshold", false);
        history.name_last("threshold 2");
        assert_eq!(history.undo_label(), Some("threshold 2"));
        assert_eq!(*history.start_of("threshold", &2), 2);
    }

    #[test]
    fn an_unfinished_drag_is_kept_when_something_else_changes() {
        let mut history = History::default();
        history.record(&0, &1, "threshold", true);
        history.record(&1, &5, "preset", false);
        assert_eq!(history.undo(&5), Some(1));
        assert_eq!(history.undo(&1), Some(0));
    }

    #[test]
    fn the_history_can_be_read_and_any_step_of_it_be_gone_to() {
        let mut history = History::default();
        for (state, label) in ["one", "two", "three"].into_iter().enumerate() {
            history.record(&state, &(state + 1), label, false);
        }
        let read = |history: &History<usize>| -> Vec<String> {
            let steps = history.steps();
            let shown = |step: super::HistoryStep| {
                if step.is_undone { format!("({})", step.label) } else { step.label.to_owned() }
            };
            steps.map(shown).collect()
        };
        assert_eq!(history.go_to(1, &3), Some(1));
        assert_eq!(read(&history), ["one", "(two)", "(three)"]);
        assert_eq!(history.go_to(1, &1), None);
        assert_eq!(history.go_to(4, &1), None);
        assert_eq!(history.go_to(3, &1), Some(3));
        assert_eq!(read(&history), ["one", "two", "three"]);
        assert_eq!(history.go_to(0, &3), Some(0));
        history.record(&0, &7, format!("box {}", 7), false);
        assert_eq!(read(&history), ["box 7"]);
    }
}
