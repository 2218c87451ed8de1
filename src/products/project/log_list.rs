//! The list of the logs of a project.

use super::Project;
use super::log::{LogKey, ProjectLog};
use std::sync::Arc;

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
