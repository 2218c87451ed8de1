//! Computes results over all logs of a survey together.
//!
//! In: the results of several logs. Out: their differences, height offsets and one report.
//!
//! Every log is processed by itself, with its own calibration and outliers; all of them are in the
//! local coordinate frame of the first ([`bathyscope_log::survey::Survey::in_frame`]), so joint
//! results can combine theirs. `crossline` compares the depths of one log or several where tracks
//! cross, and finds the height offsets of several and the soundings that others show to be false,
//! `corrections` describes the requested corrections, applied or refused, and `report` sums the logs
//! up, compares them with each other by their points, and lists them ([`LogsReport`]).

mod corrections;
mod crossline;
mod report;

pub use corrections::RequestedCorrection;
pub use crossline::{
    ContradictedSoundings, CrosslineAnalysis, Crosslines, HeightComparison, LogPositions,
    compare_heights, crossline_analysis, crosslines, latencies, position_offsets,
};
pub(crate) use crossline::{crossing_error, track_depths};
pub(crate) use report::joint_report;
pub use report::{contradictions, depths_scale, heights_differ};

use super::Fingerprint;
use super::log_report::{CalibrationReport, RunCounts};
use bathyscope_bottom::bathymetry::compare::Comparison;
use bathyscope_bottom::bathymetry::height_offsets::{DepthScale, LogOffset, PairDifference};
use bathyscope_bottom::cloud::{Residuals, TrackShare};
use bathyscope_bottom::presentation::text;
use bathyscope_log::survey::ExcludedStretch;
use serde::Serialize;
use std::collections::BTreeMap;

/// All logs of a survey, and their agreement.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LogsReport {
    /// Datum from which the offsets below count, in words.
    pub datum: &'static str,
    /// Report of each log.
    pub logs: Vec<LogReport>,
    /// Soundings that are kept although other logs show them to be false.
    pub contradicted: Vec<ContradictedSoundings>,
    /// Difference of every two logs that cross or overlap, before any offset is applied;
    /// `residual_m` is the part of it that remains after the offsets found.
    pub pairs: Vec<PairDifference>,
    /// Pairs of logs whose depths differ by a share of the depth, as with a different sound speed.
    pub scales: Vec<DepthScale>,
    /// Residuals of the crossings of all tracks, with the offsets in force; `None` if no track
    /// crosses another or itself.
    pub crosslines: Option<CrosslineAnalysis>,
}

/// Report of one log of several.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LogReport {
    /// Name of the log, which the tables use, too.
    pub log: String,
    /// Files that were read.
    pub inputs: Vec<Fingerprint>,
    /// Format in words.
    pub format: String,
    /// Unix seconds of the log's time zero; `None` if unknown.
    pub start_unix_s: Option<f64>,
    /// Settings of the log that differ from those of the first log, which are in the main report.
    pub own_settings: BTreeMap<String, Option<toml::Value>>,
    /// Offset in force that is added to the log's elevations (`height_offset_m`), metres.
    pub height_offset_in_force_m: f64,
    /// Offset that the overlaps with other logs show, in force or not.
    #[serde(flatten)]
    pub offset: LogOffset,
    /// Comparison of the log's points with the triangulated points of all other logs.
    pub against_the_others: Comparison,
    /// Counts of the log.
    pub counts: RunCounts,
    /// Excluded stretches.
    pub excluded: Vec<ExcludedStretch>,
    /// Scales of the log.
    pub calibration: CalibrationReport,
    /// Sources of the depths along the track.
    pub track: TrackShare,
    /// Residuals of side-scan against the recorded depth of the same ping; `None` without any.
    pub residuals: Option<Residuals>,
    /// Corrections of recorded positions, in sentences; empty if there are none.
    pub positions: String,
    /// Statement of what these depths are, and what was not corrected.
    pub statement: String,
}

impl LogsReport {
    /// Returns the table of offsets, a line for each log.
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
