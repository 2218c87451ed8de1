//! Part of a report that lists the logs of a survey of several logs.

use super::{ContradictedSoundings, CrosslineAnalysis};
use crate::pipeline::Input;
use crate::pipeline::log_report::{CalibrationReport, RunCounts};
use bathyscope_bottom::bathymetry::compare::Comparison;
use bathyscope_bottom::bathymetry::height_offsets::{DepthScale, LogOffset, PairDifference};
use bathyscope_bottom::cloud::{Residuals, TrackShare};
use bathyscope_bottom::presentation::text;
use bathyscope_log::survey::ExcludedStretch;
use serde::Serialize;
use std::collections::BTreeMap;

/// All logs of a survey, and how they agree.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LogsReport {
    /// Datum that the offsets below count from, in words.
    pub datum: &'static str,
    /// Every log.
    pub logs: Vec<LogReport>,
    /// Soundings that count although other logs show them to be false.
    pub contradicted: Vec<ContradictedSoundings>,
    /// Difference of every two logs that cross or overlap, before any offset is applied;
    /// `residual_m` is what the offsets found leave of it.
    pub pairs: Vec<PairDifference>,
    /// Pairs of logs whose depths differ by a share of the depth, as by another sound speed.
    pub scales: Vec<DepthScale>,
    /// Crossings of all tracks, with the offsets in force; `None` where none crosses another or
    /// itself.
    pub crosslines: Option<CrosslineAnalysis>,
}

/// One log of several.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LogReport {
    /// Name, also in the tables.
    pub log: String,
    /// The files read.
    pub inputs: Vec<Input>,
    /// Format in words.
    pub format: String,
    /// Unix seconds of its time zero.
    pub start_unix_s: Option<f64>,
    /// Its settings that differ from those of the first log, which stand above.
    pub own_settings: BTreeMap<String, Option<toml::Value>>,
    /// Offset in force that is added to its elevations (`height_offset_m`), metres.
    pub height_offset_in_force_m: f64,
    /// The offset that its overlaps with other logs show, in force or not.
    #[serde(flatten)]
    pub offset: LogOffset,
    /// Comparison of its points with the triangulated points of all others.
    pub against_the_others: Comparison,
    /// Counts.
    pub counts: RunCounts,
    /// Stretches that count for nothing.
    pub excluded: Vec<ExcludedStretch>,
    /// Scales.
    pub calibration: CalibrationReport,
    /// Sources of the depths along the track.
    pub track: TrackShare,
    /// Side-scan against the recorded depth of the same ping.
    pub residuals: Option<Residuals>,
    /// Corrections of recorded positions, in sentences; empty where there are none.
    pub positions: String,
    /// Statement of what these depths are, and what was not corrected.
    pub statement: String,
}

impl LogsReport {
    /// The table of offsets, in lines for people.
    pub fn summary(&self) -> String {
        let line = |log: &LogReport| {
            let LogOffset { offset_m, standard_error_m, log_overlaps, .. } = log.offset;
            let overlaps = text::plural(log_overlaps, "overlap", "overlaps");
            match (log_overlaps, log.offset.is_determined()) {
                (0, _) => format!("{}: crosses no other log", log.log),
                (_, false) => format!(
                    "{}: height offset not determined by {overlaps}, where depths contradict each other; {:+.3} m in force",
                    log.log, log.height_offset_in_force_m
                ),
                _ => format!(
                    "{}: height offset {offset_m:+.3} +- {standard_error_m:.3} m by {overlaps}, {:+.3} m in force",
                    log.log, log.height_offset_in_force_m
                ),
            }
        };
        let mut lines: Vec<String> = self.logs.iter().map(line).collect();
        let corrected = self.logs.iter().filter(|log| !log.positions.is_empty());
        lines.extend(corrected.map(|log| format!("{}: {}", log.log, log.positions)));
        let between = self.crosslines.as_ref().and_then(|all| all.between_logs);
        if let Some(between) = between {
            lines.push(format!(
                "crossings of two logs: n {}, median {:+.3} m, sd {:.3} m, p95 {:.3} m",
                between.n, between.median_m, between.sd_m, between.p95_m
            ));
        }
        lines.join("\n")
    }
}
