//! Undo and redo: whole states with the name of the change that led away from them. States share
//! what stayed between them, so a step costs what it changed.

use std::borrow::Cow;
use std::collections::VecDeque;

/// Name of a change in menus and in the list of the history.
type ChangeLabel = Cow<'static, str>;

/// A history of states; a drag is one step however many states it passes.
#[derive(Clone, Debug)]
pub struct History<T> {
    undo: VecDeque<(T, ChangeLabel)>,
    redo: Vec<(T, ChangeLabel)>,
    /// The state before the drag under way, and its name.
    open: Option<(T, ChangeLabel)>,
}

/// A step in the list of the history.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct HistoryStep<'a> {
    /// Name of the change.
    pub label: &'a str,
    /// True if it was undone, and can be done again.
    pub is_undone: bool,
}

/// Steps kept.
const DEPTH: usize = 200;

impl<T> Default for History<T> {
    fn default() -> Self {
        Self { undo: VecDeque::new(), redo: Vec::new(), open: None }
    }
}

impl<T: Clone + PartialEq> History<T> {
    /// The history of changes that were made before: each state with the name of the change that
    /// led away from it, the oldest first.
    pub fn of_past(past: impl IntoIterator<Item = (T, ChangeLabel)>) -> Self {
        Self { undo: past.into_iter().collect(), ..Self::default() }
    }

    /// The changes that undo takes back: each state with the name of the change that led away from
    /// it, the oldest first.
    pub fn past(&self) -> impl DoubleEndedIterator<Item = (&T, &str)> {
        self.undo.iter().map(|(state, label)| (state, &**label))
    }

    /// Notes that `before` became `after`. `live` changes belong to the step that the next change
    /// of the same name ends.
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

    /// Returns the state at which the step began that a change of this name from `before` ends: the
    /// state before its drag, if one is under way.
    pub fn start_of<'a>(&'a self, label: &str, before: &'a T) -> &'a T {
        let open = self.open.as_ref().filter(|(_, open)| open == label);
        open.map_or(before, |(start, _)| start)
    }

    /// Gives the last step its full name: `threshold 0.41`, where its drag was a `threshold`.
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

    /// The state to go back to.
    pub fn undo(&mut self, now: &T) -> Option<T> {
        self.close(now);
        let (state, label) = self.undo.pop_back()?;
        self.redo.push((now.clone(), label));
        Some(state)
    }

    /// The state to go forward to.
    pub fn redo(&mut self, now: &T) -> Option<T> {
        let (state, label) = self.redo.pop()?;
        self.undo.push_back((now.clone(), label));
        Some(state)
    }

    /// Name of what [`History::undo`] would take back.
    pub fn undo_label(&self) -> Option<&str> {
        self.open.as_ref().or(self.undo.back()).map(|(_, label)| label.as_ref())
    }

    /// Name of what [`History::redo`] would do again.
    pub fn redo_label(&self) -> Option<&str> {
        self.redo.last().map(|(_, label)| label.as_ref())
    }

    /// All steps in the order in which they were done, and after them those that were taken back.
    pub fn steps(&self) -> impl Iterator<Item = HistoryStep<'_>> {
        let done = self
            .undo
            .iter()
            .chain(&self.open)
            .map(|(_, label)| HistoryStep { label, is_undone: false });
        done.chain(self.redo.iter().rev().map(|(_, label)| HistoryStep { label, is_undone: true }))
    }

    /// The state after the first `count` of [`History::steps`]; `None` when that is the present
    /// one, or there are fewer.
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
