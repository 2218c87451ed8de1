//! Computes results over all logs of a survey together.
//!
//! In: the results of several logs. Out: their differences, height offsets and one report.
//!
//! Every log is processed by itself, with its own calibration and outliers; all of them are in the
//! local coordinate frame of the first ([`bathyscope_log::survey::Survey::in_frame`]), so joint
//! results can combine theirs. `crossline` compares the depths of one log or several where tracks
//! cross, and finds the height offsets of several and the soundings that others show to be false,
//! and `report` sums the logs up, compares them with each other by their points, and lists them
//! ([`LogsReport`]). [`RequestedCorrection`] describes a correction that was requested, applied or
//! refused.

mod crossline;
mod report;

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
use bathyscope_bottom::bathymetry::position_offsets::{Shift, Wanted};
use bathyscope_bottom::calibration::SoundingLag;
use bathyscope_bottom::cloud::{Residuals, TrackShare};
use bathyscope_bottom::presentation::text;
use bathyscope_log::survey::ExcludedStretch;
use serde::Serialize;
use std::collections::BTreeMap;
use std::fmt::{self, Display, Formatter};

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

/// Requested correction of a log.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RequestedCorrection {
    /// Name of the log.
    pub log: String,
    /// Value of the correction.
    #[serde(flatten)]
    pub found: FoundCorrection,
    /// Reason why the correction is not in force; `None` if it is.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub refused: Option<&'static str>,
}

/// Correction derived from crossings.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "setting")]
pub enum FoundCorrection {
    /// Shift of all positions.
    #[serde(rename = "position_shift")]
    Shift {
        /// Shift to the east, metres, to be added to positions.
        east_m: f64,
        /// Shift to the north, metres, to be added to positions.
        north_m: f64,
        /// Larger of the standard errors of both, metres.
        standard_error_m: f64,
    },
    /// Latency of positions.
    #[serde(rename = "mounting.latency_s")]
    Latency {
        /// Latency, seconds.
        latency_s: f64,
        /// Standard error of the latency, seconds.
        standard_error_s: f64,
    },
    /// Lag of soundings.
    #[serde(rename = "mounting.sounding_lag_s")]
    SoundingLag {
        /// Lag, seconds.
        sounding_lag_s: f64,
        /// Standard error of the lag, seconds.
        standard_error_s: f64,
    },
    /// Soundings that other logs show to be false, which are left out.
    #[serde(rename = "excluded.stretches")]
    FalseSoundings(ContradictedSoundings),
    /// No value was found for a setting.
    #[serde(untagged)]
    Nothing {
        /// Key of the setting.
        setting: &'static str,
    },
}

/// Standard error of a shift below which crossings are taken to determine it, metres: a larger one
/// is no better than the error assumed of any receiver.
const TOLD_M: f64 = 1.0;

const NO_SLOPE: &str = "no tracks cross over a slope in a way that shows it";
const IN_FORCE: &str = "it differs from what is in force by less than two standard errors";
const ONE_LOG: &str = "one log alone has no other to agree with";
const NO_SOLUTION: &str = "the crossings of the tracks give no solution";

impl RequestedCorrection {
    /// Returns the requested corrections of the positions of a log, applied or refused; `found` is
    /// `None` if the equations have no solution.
    pub fn of_positions(log: &str, wanted: Wanted, found: Option<&LogPositions>) -> Vec<Self> {
        let nothing = |setting| Self::nothing(log, setting, NO_SOLUTION);
        let shift =
            || found.map_or_else(|| nothing("position_shift"), |found| of_shift(log, found));
        let latency =
            || found.map_or_else(|| nothing("mounting.latency_s"), |found| of_latency(log, found));
        let shift = wanted.shifts.then(shift);
        shift.into_iter().chain(wanted.latencies.then(latency)).collect()
    }

    /// Returns the correction of soundings that are late.
    pub fn of_sounding_lag(log: &str, lag: &SoundingLag) -> Self {
        let found = FoundCorrection::SoundingLag {
            sounding_lag_s: lag.lag_s,
            standard_error_s: lag.standard_error_s,
        };
        Self::new(log, found, None)
    }

    /// Returns the exclusion of soundings that other logs contradict.
    pub fn of_false_soundings(log: &str, found: &ContradictedSoundings) -> Self {
        Self::new(log, FoundCorrection::FalseSoundings(found.clone()), None)
    }

    /// Returns the corrections that were requested for a single log and cannot be found without
    /// other logs, as refused.
    pub fn of_one_log(log: &str, wanted: Wanted) -> Vec<Self> {
        let shift = wanted.shifts.then_some("position_shift");
        let settings = ["height_offset_m"].into_iter().chain(shift);
        settings.map(|setting| Self::nothing(log, setting, ONE_LOG)).collect()
    }

    fn nothing(log: &str, setting: &'static str, why: &'static str) -> Self {
        Self::new(log, FoundCorrection::Nothing { setting }, Some(why))
    }

    fn new(log: &str, found: FoundCorrection, refused: Option<&'static str>) -> Self {
        Self { log: log.to_owned(), found, refused }
    }
}

fn of_shift(log: &str, positions: &LogPositions) -> RequestedCorrection {
    let Shift { east_m, north_m, .. } = positions.found.shift;
    let standard_error_m = positions.found.shift_error_m;
    let refused = match positions.told_shift() {
        Some(_) => None,
        None if standard_error_m < TOLD_M => Some(IN_FORCE),
        None => Some(NO_SLOPE),
    };
    let found = FoundCorrection::Shift { east_m, north_m, standard_error_m };
    RequestedCorrection::new(log, found, refused)
}

fn of_latency(log: &str, positions: &LogPositions) -> RequestedCorrection {
    let refused = match positions.told_latency_s() {
        Some(_) => None,
        None if positions.is_latency_known() => Some(IN_FORCE),
        None => Some(NO_SLOPE),
    };
    let found = FoundCorrection::Latency {
        latency_s: positions.found.shift.latency_s,
        standard_error_s: positions.found.latency_error_s,
    };
    RequestedCorrection::new(log, found, refused)
}

/// Formats the correction as `lake-1: position_shift of +1.25 m east, -0.50 m north, standard error
/// 0.21 m, applied`.
impl Display for RequestedCorrection {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        write!(f, "{}: ", self.log)?;
        match &self.found {
            FoundCorrection::Shift { east_m, north_m, standard_error_m } => write!(
                f,
                "position_shift of {east_m:+.2} m east, {north_m:+.2} m north, standard error {standard_error_m:.2} m"
            ),
            FoundCorrection::Latency { latency_s, standard_error_s } => write!(
                f,
                "mounting.latency_s of {latency_s:+.2} s, standard error {standard_error_s:.2} s"
            ),
            FoundCorrection::SoundingLag { sounding_lag_s, standard_error_s } => write!(
                f,
                "mounting.sounding_lag_s of {sounding_lag_s:+.2} s, standard error {standard_error_s:.2} s"
            ),
            FoundCorrection::FalseSoundings(found) => {
                write!(f, "excluded.stretches of {}, false by other logs", found.which())
            }
            FoundCorrection::Nothing { setting } => write!(f, "{setting}"),
        }?;
        match self.refused {
            None => write!(f, ", applied"),
            Some(why) => write!(f, ", not applied: {why}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bathyscope_bottom::bathymetry::position_offsets::FoundShift;

    fn positions(east_m: f64, error: f64) -> LogPositions {
        LogPositions {
            found: FoundShift {
                shift: Shift { east_m, north_m: -0.5, latency_s: 0.3 },
                shift_error_m: error,
                latency_error_s: error,
            },
            in_force: Shift::default(),
        }
    }

    #[test]
    fn what_was_found_is_said_with_what_became_of_it() {
        let wanted = Wanted { shifts: true, latencies: true };
        let said = |positions: Option<&LogPositions>| {
            let all = RequestedCorrection::of_positions("a", wanted, positions);
            all.iter().map(ToString::to_string).collect::<Vec<_>>()
        };
        assert_eq!(
            said(Some(&positions(1.25, 0.21))),
            [
                "a: position_shift of +1.25 m east, -0.50 m north, standard error 0.21 m, applied",
                "a: mounting.latency_s of +0.30 s, standard error 0.21 s, not applied: it differs from what is in force by less than two standard errors",
            ]
        );
        let unknown = said(Some(&positions(1.25, 1.9)));
        assert!(unknown.iter().all(|line| line.ends_with(NO_SLOPE)), "{unknown:?}");
        assert!(said(None)[0].ends_with(NO_SOLUTION));
        let alone = RequestedCorrection::of_one_log("a", wanted);
        assert_eq!(alone.len(), 2, "height offset and shift");
        let text = serde_json::to_string(&alone[0]).expect("JSON");
        assert!(text.contains("\"setting\":\"height_offset_m\""), "{text}");
    }
}
