//! The tables of residuals: made when they come into view, for they triangulate all soundings.

use super::{App, Outcome, Task};
use crate::pipeline::{ResidualTables, residual_tables};
use std::sync::Arc;

/// Tables, and the work on them.
#[derive(Default)]
pub(super) struct Tabulating {
    /// The kept points that the tables are of, or will be.
    of: Option<Arc<Vec<bool>>>,
    task: Option<Task<Option<ResidualTables>>>,
    tables: Option<Arc<ResidualTables>>,
}

impl Tabulating {
    /// Whether tables are being made.
    pub fn is_busy(&self) -> bool {
        self.task.is_some()
    }
}

impl App {
    /// How side-scan differs from soundings; `None` until they were asked for, and where no point lies over them.
    pub fn residual_tables(&self) -> Option<&Arc<ResidualTables>> {
        self.tabulating.tables.as_ref()
    }

    /// Whether residuals are being tabulated.
    pub fn is_tabulating(&self) -> bool {
        self.tabulating.is_busy()
    }

    /// Starts the tables of the result in force, unless they are there or under way.
    pub(super) fn tabulate(&mut self) {
        let Some(products) = &self.products else {
            return;
        };
        let made = &mut self.tabulating;
        if (made.of.as_ref()).is_some_and(|of| Arc::ptr_eq(of, &products.kept)) {
            return;
        }
        made.of = Some(products.kept.clone());
        let products = products.clone();
        made.task = Some(Task::start(&self.jobs, move |progress| {
            residual_tables(&products, progress).ok().flatten()
        }));
    }

    /// Takes tables that are ready.
    pub(super) fn poll_tables(&mut self) {
        let made = &mut self.tabulating;
        match made.task.as_ref().map(Task::poll) {
            Some(Outcome::Done(tables)) => made.tables = tables.map(Arc::new),
            Some(Outcome::Failed) => made.tables = None,
            Some(Outcome::Pending) | None => return,
        }
        made.task = None;
    }
}
