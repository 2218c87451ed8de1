//! Height differences between logs: found where their tracks meet, and taken off their depths when
//! the analyst asks for it.

use super::logs_task::{LogsTask, Stands};
use super::{App, LogId, OpenLog};
use bathyscope_bottom::bathymetry::height_offsets::{Datum, HeightOffsets, LogOffset};
use bathyscope_products::pipeline::joint::{contradictions, height_offsets};
use bathyscope_products::pipeline::{LogSettings, ProcessedLog};
use std::sync::Arc;
use toml::Value;

/// The setting that carries the offset of a log.
const KEY: &str = "height_offset_m";

/// The offsets of some logs.
#[derive(Clone, Debug)]
pub struct FoundHeights {
    ids: Vec<LogId>,
    offsets: HeightOffsets,
}

impl FoundHeights {
    /// Every log with its offset, in the order of the list when they were found.
    pub fn logs(&self) -> impl Iterator<Item = (LogId, &LogOffset)> {
        self.ids.iter().copied().zip(&self.offsets.logs)
    }

    /// How many groups of connected logs there are.
    pub fn groups(&self) -> usize {
        self.offsets.groups()
    }
}

/// Offsets, and the work on them.
pub(super) type Heights = LogsTask<FoundHeights>;

impl App {
    /// Whether heights are being compared.
    pub(crate) fn is_matching_heights(&self) -> bool {
        self.findings.heights.is_busy()
    }

    /// By how much the heights of the logs differ, once that was asked for.
    pub fn height_offsets(&self) -> Option<&FoundHeights> {
        self.findings.heights.found()
    }

    /// A warning for every two logs that no height offsets bring together.
    pub(crate) fn height_contradictions(&self) -> Vec<String> {
        let Some(found) = self.height_offsets() else {
            return Vec::new();
        };
        let name = |id: &LogId| self.open_log(*id).map_or_else(String::new, OpenLog::name);
        let names: Vec<String> = found.ids.iter().map(name).collect();
        contradictions(&found.offsets.pairs, &names).collect()
    }

    /// Starts to compare the heights of the visible logs.
    pub(super) fn match_heights(&mut self) {
        let shown = self.shown_logs();
        if shown.len() < 2 {
            let text =
                "heights are compared between logs: open two or more, and wait for their results";
            return self.notify(text.to_owned(), true);
        }
        let ids = shown.iter().map(|log| log.id).collect();
        let logs: Vec<ProcessedLog> = shown.into_iter().map(|log| log.log).collect();
        self.findings.heights.start(&self.jobs, move |progress| {
            let offsets = height_offsets(&logs, Datum::Mean, progress).ok()?;
            Some(FoundHeights { ids, offsets })
        });
    }

    /// Collects what was found.
    pub(super) fn poll_heights(&mut self) {
        match self.findings.heights.poll() {
            Stands::Still => {}
            Stands::Found => {
                let any = |is: fn(&LogOffset) -> bool| {
                    let found = self.height_offsets();
                    found.is_some_and(|found| found.logs().any(|(_, offset)| is(offset)))
                };
                if !any(|offset| offset.log_overlaps > 0) {
                    let text = "the tracks of these logs do not cross, so their heights cannot be compared";
                    self.notify(text.to_owned(), true);
                } else if !any(LogOffset::is_determined) {
                    let text = "where these logs cross, their depths contradict each other: no height offset is determined";
                    self.notify(text.to_owned(), true);
                }
            }
            Stands::Failed => {
                self.notify("comparing heights failed unexpectedly".to_owned(), true);
            }
        }
    }

    /// Adds the offsets to the elevations of their logs, as one undo step.
    pub(super) fn apply_heights(&mut self) {
        let Some(found) = self.height_offsets().cloned() else {
            let text = "compare the heights of the logs first";
            return self.notify(text.to_owned(), true);
        };
        let before = self.step_now();
        for (id, offset) in found.logs().filter(|(_, offset)| offset.is_determined()) {
            if let Some(log) = self.open_log(id) {
                let mut own = LogSettings::clone(&log.own);
                own.set(KEY, Value::Float(offset.applied_m()));
                self.set_own(id, Arc::new(own), false);
            }
        }
        let after = self.step_now();
        self.record_step(&before, &after, "height offsets", false);
        self.process();
    }
}
