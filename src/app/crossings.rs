//! Compares logs where tracks meet. Height differences between logs, and soundings that other logs
//! show to be false, are found whenever several logs have results; the analyst can then level the
//! logs or leave the soundings out. Errors and latencies of positions are found over slopes at the
//! request of the analyst, and corrected if the analyst applies them.

use super::jobs::{JobKey, Kept};
use super::{Action, App, LogId, OpenLog, OpenLogs};
use bathyscope_bottom::bathymetry::height_offsets::{Datum, HeightDifference, LogOffset};
use bathyscope_bottom::bathymetry::position_offsets::Wanted;
use bathyscope_bottom::cloud::PingDepth;
use bathyscope_bottom::presentation::text;
use bathyscope_log::support::progress::Progress;
use bathyscope_products::pipeline::joint::{
    HeightComparison, LogPositions, compare_heights, contradictions, depths_scale, heights_differ,
    position_offsets,
};
use bathyscope_products::pipeline::{LogSettings, ProcessedLog, Same, Settings};
use std::sync::Arc;
use toml::Value;

/// Key of the setting with the height offset of a log.
const HEIGHT: &str = "height_offset_m";
/// Key of the setting with the shift of a log to the east.
const EAST: &str = "position_shift.east_m";
/// Key of the setting with the shift of a log to the north.
const NORTH: &str = "position_shift.north_m";
/// Key of the setting with the latency of a log's positions.
const LATENCY: &str = "mounting.latency_s";

/// The height offsets that were found for some logs.
#[derive(Clone, Debug)]
pub struct FoundHeights {
    ids: Vec<LogId>,
    compared: HeightComparison,
}

impl FoundHeights {
    /// Returns each log with its offset, in the order of the list at the time of the comparison.
    pub fn logs(&self) -> impl Iterator<Item = (LogId, &LogOffset)> {
        self.ids.iter().copied().zip(&self.compared.offsets.logs)
    }

    /// Returns true if other logs show soundings to be false.
    pub(super) fn is_contradicted(&self) -> bool {
        !self.compared.contradicted.is_empty()
    }

    /// Returns the number of groups of connected logs.
    pub fn groups(&self) -> usize {
        self.compared.offsets.groups()
    }
}

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

/// Inputs of a comparison: the depths of each log, and the log whose height is held.
type HeightsKey = (Vec<(LogId, Same<Vec<PingDepth>>)>, Option<LogId>);

/// State of the comparison of heights.
#[derive(Default)]
pub struct Heights {
    found: Kept<HeightsKey, FoundHeights>,
    /// The log whose height stays when offsets are applied; with `None` the mean height of all logs
    /// stays.
    pub(crate) held: Option<LogId>,
    /// Sentence of the latest notice that logs differ; `None` while they agree.
    last_notice: Option<String>,
    /// Sentence of the latest notice of soundings that other logs contradict.
    last_false_notice: Option<String>,
}

impl OpenLogs {
    fn names_of(&self, ids: &[LogId]) -> Vec<String> {
        let name = |id: &LogId| self.get(*id).map_or_else(String::new, OpenLog::name);
        ids.iter().map(name).collect()
    }
}

impl App {
    /// Returns the height offsets of the visible logs; `None` until they are found, and for
    /// fewer than two logs.
    pub fn height_offsets(&self) -> Option<&FoundHeights> {
        let found = self.findings.heights.found.result()?;
        // Results of logs that are closed or not visible any more are being replaced.
        let is_visible = |id: &LogId| self.logs.visible().any(|log| log.id == *id);
        found.ids.iter().all(is_visible).then_some(found)
    }

    /// Returns a warning for each pair of logs that no height offsets bring into agreement, and for
    /// each pair whose depths differ in proportion to the depth.
    pub(crate) fn height_contradictions(&self) -> Vec<String> {
        let Some(found) = self.height_offsets() else {
            return Vec::new();
        };
        let names = self.logs.names_of(&found.ids);
        let offsets = &found.compared.offsets;
        let scales = offsets.scales.iter().map(|scale| format!("{}.", depths_scale(scale, &names)));
        scales.chain(contradictions(&offsets.pairs, &names)).collect()
    }

    /// Returns a sentence about the two logs whose depths differ most with the offsets in force;
    /// `None` if no difference is larger than chance explains.
    pub(crate) fn unlevelled(&self) -> Option<String> {
        let found = self.height_offsets()?;
        let in_force_m = |id: &LogId| {
            let products = self.logs.get(*id).and_then(|log| log.products.as_ref());
            products.map_or(0.0, |products| products.correction.height_offset_m())
        };
        let in_force_m: Vec<f64> = found.ids.iter().map(in_force_m).collect();
        let difference: HeightDifference = found.compared.offsets.unlevelled(&in_force_m)?;
        Some(format!("{}.", heights_differ(&difference, &self.logs.names_of(&found.ids))))
    }

    /// Returns a sentence about each stretch of soundings that other logs show to be false.
    pub(crate) fn contradicted_soundings(&self) -> Vec<String> {
        let Some(found) = self.height_offsets() else {
            return Vec::new();
        };
        let names = self.logs.names_of(&found.ids);
        let stretches = found.compared.contradicted.iter();
        stretches.map(|stretch| format!("{}.", stretch.summary(&names))).collect()
    }

    /// Starts comparing the heights of the visible logs again if their depths or the held log
    /// changed, and notifies the analyst of differences.
    pub(super) fn follow_heights(&mut self) {
        let recordings = self.logs.visible().filter(|log| log.survey.is_some()).count();
        if recordings < 2 {
            return self.findings.heights.found.drop_all(&mut self.jobs, &JobKey::CompareHeights);
        }
        // Without this wait, the logs that have results first would be compared again and again.
        if self.jobs.is_running(&JobKey::OpenLog) || self.logs.visible().any(OpenLog::is_behind) {
            return;
        }
        let settled = |log: &OpenLog| Some((log.id, log.settled()?));
        let logs: Vec<(LogId, ProcessedLog)> = self.logs.visible().filter_map(settled).collect();
        let ids: Vec<LogId> = logs.iter().map(|(id, _)| *id).collect();
        let depths = |(id, log): &(LogId, ProcessedLog)| (*id, Same(log.products.depths.clone()));
        let place = |held: LogId| ids.iter().position(|id| *id == held);
        let held = self.findings.heights.held.and_then(place);
        let key = (logs.iter().map(depths).collect(), held.map(|place| ids[place]));
        let logs: Vec<ProcessedLog> = logs.into_iter().map(|(_, log)| log).collect();
        let work = move |progress: &Progress| {
            let datum = held.map_or(Datum::Mean, Datum::Log);
            let mut compared = compare_heights(&logs, datum, progress).ok()?;
            if let Some(held) = held {
                let in_force_m = logs[held].products.correction.height_offset_m();
                compared.offsets.raise(held, in_force_m);
            }
            Some(FoundHeights { ids, compared })
        };
        self.keep(JobKey::CompareHeights, key, work, |app| Some(&mut app.findings.heights.found));
        if !self.jobs.is_running(&JobKey::CompareHeights) {
            self.say_heights();
        }
    }

    /// Notifies the analyst once of false soundings and of height differences, with the commands
    /// that leave the soundings out and level the logs.
    fn say_heights(&mut self) {
        let contradicted = self.contradicted_soundings().into_iter().next();
        let unlevelled = self.unlevelled();
        let heights = &mut self.findings.heights;
        for (last, now, action) in [
            (&mut heights.last_false_notice, contradicted, Action::LeaveOutContradicted),
            (&mut heights.last_notice, unlevelled, Action::ApplyHeights),
        ] {
            if *last == now {
                continue;
            }
            self.notices.withdraw(action);
            if let Some(text) = &now {
                self.notices.offer(text.clone(), action);
            }
            *last = now;
        }
    }

    /// Excludes the soundings that other logs show to be false, as one undo step.
    pub(super) fn leave_out_contradicted(&mut self) {
        let Some(found) = self.height_offsets().filter(|found| found.is_contradicted()).cloned()
        else {
            let text = "no soundings are shown to be false by other logs: that takes two logs that contradict them";
            return self.notices.warn(text);
        };
        let before = self.step_now();
        let mut left_out = 0;
        for stretch in &found.compared.contradicted {
            let id = found.ids[stretch.log];
            let Some((log, survey)) = self.logs.log_and_survey(id) else {
                continue;
            };
            let mut settings = Settings::clone(&log.settings);
            settings.excluded = settings.excluded.excluding(survey, stretch.part());
            let (shared, own) = match log.own.change(&self.document.shared, &settings) {
                Ok(parts) => parts,
                Err(error) => return self.notices.warn(error),
            };
            self.document.shared = Arc::new(shared);
            self.set_own(id, Arc::new(own), false);
            left_out += stretch.count;
        }
        self.record_step(&before, "false soundings", false);
        self.notices.withdraw(Action::LeaveOutContradicted);
        let left_out = text::plural(left_out, "sounding was", "soundings were");
        self.notices.offer_undo(format!("{left_out} left out"));
        self.process();
    }

    /// Sets the height offsets of all logs for which the comparison determines one, as one undo
    /// step.
    pub(super) fn apply_heights(&mut self) {
        let Some(found) = self.height_offsets().cloned() else {
            let text =
                "heights are compared between logs: open two or more, and wait for their results";
            return self.notices.warn(text);
        };
        let mut levelled = 0;
        let before = self.step_now();
        for (id, offset) in found.logs().filter(|(_, offset)| offset.is_determined()) {
            if let Some(log) = self.logs.get(id) {
                let mut own = LogSettings::clone(&log.own);
                own.set(HEIGHT, Value::Float(offset.applied_m()));
                self.set_own(id, Arc::new(own), false);
                levelled += 1;
            }
        }
        if levelled == 0 {
            let text = "no height offset is determined: the tracks of these logs do not cross, or their depths contradict each other where they do";
            return self.notices.warn(text);
        }
        self.record_step(&before, "height offsets", false);
        self.notices.withdraw(Action::ApplyHeights);
        let held = self.findings.heights.held.and_then(|id| self.logs.get(id));
        let held = held.map_or("their mean".to_owned(), |log| format!("that of {}", log.name()));
        self.notices
            .offer_undo(format!("Heights of {levelled} logs were levelled; {held} was held"));
        self.process();
    }

    /// Starts to compare the positions of the visible logs: their shifts, if there are several
    /// logs, and their latencies.
    pub(super) fn match_positions(&mut self) {
        let shown = self.logs.with_results();
        if shown.is_empty() {
            let text =
                "positions are compared where tracks cross: open a log, and wait for its results";
            return self.notices.warn(text);
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
                    app.notices.notify(FoundPositions::NOTHING_TOLD);
                }
                app.findings.positions = found.or(app.findings.positions.take());
            },
        );
    }

    /// Applies the shifts and latencies that crossings determine, as one undo step.
    pub(super) fn apply_positions(&mut self) {
        let Some(found) = self.findings.positions.as_ref().cloned() else {
            return self.notices.warn("compare the positions of the logs first");
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
