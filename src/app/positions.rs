//! Finds the errors and the latency of the positions of each log where tracks cross over a slope,
//! and corrects them if the analyst applies them.

use super::jobs::JobKey;
use super::{App, LogId};
use bathyscope_bottom::bathymetry::position_offsets::Wanted;
use bathyscope_products::pipeline::joint::{LogPositions, position_offsets};
use bathyscope_products::pipeline::{LogSettings, ProcessedLog};
use std::sync::Arc;
use toml::Value;

/// Keys of the settings that hold the corrections.
const EAST: &str = "position_shift.east_m";
const NORTH: &str = "position_shift.north_m";
const LATENCY: &str = "mounting.latency_s";

/// Position errors and latencies found for some logs.
#[derive(Clone, Debug)]
pub struct FoundPositions {
    /// Position errors of each log, in the order of the list when the comparison was requested.
    pub logs: Vec<(LogId, LogPositions)>,
}

impl FoundPositions {
    /// Notice if no correction is worth applying.
    pub(crate) const NOTHING_TOLD: &str = "No position error was found: the tracks agree, cross too rarely, or cross over a level bottom.";

    /// Returns true if a shift or a latency of any log differs significantly from the one in force.
    pub fn tells(&self) -> bool {
        let of_log =
            |log: &LogPositions| log.told_shift().is_some() || log.told_latency_s().is_some();
        self.logs.iter().any(|(_, log)| of_log(log))
    }
}

impl App {
    /// Starts to compare the positions of the visible logs: their shifts, if there are several
    /// logs, and their latencies.
    pub(super) fn match_positions(&mut self) {
        let shown = self.logs.with_results();
        if shown.is_empty() {
            let text =
                "positions are compared where tracks cross: open a log, and wait for its results";
            return self.notices.warn(text.to_owned());
        }
        let ids: Vec<LogId> = shown.iter().map(|log| log.id).collect();
        let logs: Vec<ProcessedLog> = shown.into_iter().map(|log| log.log).collect();
        let wanted = Wanted { shifts: logs.len() > 1, latencies: true };
        self.jobs.run(
            JobKey::ComparePositions,
            move |progress| {
                let found = position_offsets(&logs, wanted, progress).ok()??;
                let logs = ids.into_iter().zip(found).collect();
                Some(FoundPositions { logs })
            },
            |app, found| {
                if found.as_ref().is_some_and(|found| !found.tells()) {
                    app.notices.notify(FoundPositions::NOTHING_TOLD.to_owned());
                }
                app.findings.positions = found.or(app.findings.positions.take());
            },
        );
    }

    /// Applies the shifts and latencies that crossings determine, as one undo step.
    pub(super) fn apply_positions(&mut self) {
        let Some(found) = self.findings.positions.as_ref().cloned() else {
            let text = "compare the positions of the logs first";
            return self.notices.warn(text.to_owned());
        };
        let before = self.step_now();
        for (id, found) in &found.logs {
            let shift = found.told_shift();
            let shift = shift.map(|shift| [(EAST, shift.east_m), (NORTH, shift.north_m)]);
            let latency = found.told_latency_s().map(|latency_s| (LATENCY, latency_s));
            let corrections: Vec<(&str, f64)> =
                shift.into_iter().flatten().chain(latency).collect();
            if corrections.is_empty() {
                continue;
            }
            if let Some(log) = self.logs.get(*id) {
                let mut own = LogSettings::clone(&log.own);
                for (key, value) in corrections {
                    own.set(key, Value::Float(value));
                }
                self.set_own(*id, Arc::new(own), false);
            }
        }
        self.record_step(&before, "positions", false);
        self.process();
    }
}
