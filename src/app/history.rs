//! Undo and redo: whole states with the name of the change that led away from them.

/// A history of states; a drag is one step however many states it passes.
#[derive(Clone, Debug)]
pub struct History<T> {
    undo: Vec<(T, &'static str)>,
    redo: Vec<(T, &'static str)>,
    /// The state before the drag under way, and its name.
    open: Option<(T, &'static str)>,
}

/// Steps kept.
const DEPTH: usize = 200;

impl<T> Default for History<T> {
    fn default() -> Self {
        Self {
            undo: Vec::new(),
            redo: Vec::new(),
            open: None,
        }
    }
}

impl<T: Clone + PartialEq> History<T> {
    /// Notes that `before` became `after`. `live` changes belong to the step that the next change of the same name ends.
    pub fn record(&mut self, before: &T, after: &T, label: &'static str, live: bool) {
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

    fn close(&mut self, now: &T) {
        if let Some((start, label)) = self.open.take()
            && start != *now
        {
            self.push(start, label);
        }
    }

    fn push(&mut self, state: T, label: &'static str) {
        self.undo.push((state, label));
        self.redo.clear();
        if self.undo.len() > DEPTH {
            self.undo.remove(0);
        }
    }

    /// The state to go back to.
    pub fn undo(&mut self, now: &T) -> Option<T> {
        self.close(now);
        let (state, label) = self.undo.pop()?;
        self.redo.push((now.clone(), label));
        Some(state)
    }

    /// The state to go forward to.
    pub fn redo(&mut self, now: &T) -> Option<T> {
        let (state, label) = self.redo.pop()?;
        self.undo.push((now.clone(), label));
        Some(state)
    }

    /// Name of what [`History::undo`] would take back.
    pub fn undo_label(&self) -> Option<&'static str> {
        self.open
            .as_ref()
            .or(self.undo.last())
            .map(|(_, label)| *label)
    }

    /// Name of what [`History::redo`] would do again.
    pub fn redo_label(&self) -> Option<&'static str> {
        self.redo.last().map(|(_, label)| *label)
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
    fn an_unfinished_drag_is_kept_when_something_else_changes() {
        let mut history = History::default();
        history.record(&0, &1, "threshold", true);
        history.record(&1, &5, "preset", false);
        assert_eq!(history.undo(&5), Some(1));
        assert_eq!(history.undo(&1), Some(0));
    }
}
