//! Writes the agreement of the depths: `comparison.json` and `comparison.csv`, the comparison of a
//! survey with a reference, in figures and point by point, and `residuals.json`, the comparison of
//! side-scan points and swath points with the soundings of the survey, and of the tracks with
//! themselves and each other.

use super::content::{FileContent, FileResult};
use super::order::{log_names, log_points};
use super::results::Results;
use crate::export::{self, Summary};
use crate::pipeline::{
    Agreement, Crosslines, Fingerprint, GeometryChoice, NamedComparison, ProcessedLog,
    ResidualTables, Settings, choices, comparisons, crosslines,
};
use crate::{Error, PROGRAM};
use bathyscope_bottom::bathymetry::compare::{Comparison, Match};
use bathyscope_bottom::cloud::PointSource;
use bathyscope_log::support::progress::{Cancelled, Progress};
use serde::Serialize;
use std::path::Path;
use std::slice;

/// Meaning of the sign of differences.
const SIGN: &str = "measured minus reference elevation, metres; positive is shallower";

/// Comparison of a survey with a reference in the form that is written and printed.
#[derive(Debug, Serialize)]
pub struct ComparisonRecord<'a> {
    program: &'static str,
    sign: &'static str,
    statement: String,
    /// The first file of each log, separated by commas.
    measured_file: String,
    reference_file: String,
    reference: ReferenceRecord<'a>,
    by: String,
    #[serde(flatten)]
    comparison: &'a Comparison,
    /// The comparison for each source of points.
    sources: Vec<NamedComparison>,
    /// The comparison for each of several logs; empty for a single log.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    logs: Vec<LogComparison>,
    #[serde(flatten)]
    tables: &'a ResidualTables,
    settings: &'a Settings,
}

/// Comparison of one of several logs with the reference.
#[derive(Debug, Serialize)]
struct LogComparison {
    log: String,
    statement: String,
    #[serde(flatten)]
    comparison: Comparison,
}

#[derive(Debug, Serialize)]
struct ReferenceRecord<'a> {
    /// `mission` or `points`.
    kind: &'static str,
    inputs: &'a [Fingerprint],
    notes: &'a [String],
}

const NO_REFERENCE: &str = "the survey was not compared with a reference";
const MISSION: &str = "The reference is another mission, processed with the same settings.";
const MISSION_OF_LOGS: &str =
    "The reference is another mission, processed with the settings of the first log.";
const PROJECT: &str =
    "The reference is another survey, each of its logs processed with its own settings.";
const POINTS: &str = "The reference is taken as it stands in its file.";

impl<'a> ComparisonRecord<'a> {
    /// Creates the record from the agreement of logs with a reference, and the files that the
    /// reference was read from.
    ///
    /// # Errors
    /// When there is no log or no reference.
    pub fn new(
        logs: &'a [ProcessedLog],
        agreement: &'a Agreement,
        inputs: &'a [Fingerprint],
    ) -> Result<Self, Error> {
        let (Some(first), Some(reference)) = (logs.first(), &agreement.reference) else {
            return Err(NO_REFERENCE.into());
        };
        let (kind, how) = match (reference.is_mission(), logs.len()) {
            (true, _) if reference.has_own_settings() => ("mission", PROJECT),
            (true, 1) => ("mission", MISSION),
            (true, _) => ("mission", MISSION_OF_LOGS),
            (false, _) => ("points", POINTS),
        };
        let statement = match logs {
            [log] => format!("{} {how}", log.products.correction.statement()),
            _ => how.to_owned(),
        };
        let files = logs.iter().filter_map(|log| log.survey.source.files.first());
        let files: Vec<String> = files.map(|file| file.display().to_string()).collect();
        Ok(Self {
            program: PROGRAM,
            sign: SIGN,
            statement,
            measured_file: files.join(", "),
            reference_file: reference.path().display().to_string(),
            reference: ReferenceRecord { kind, inputs, notes: &reference.notes },
            by: agreement.matching.in_words(),
            comparison: &agreement.comparison,
            sources: agreement.by_source(logs),
            logs: match logs {
                [_] => Vec::new(),
                logs => each(logs, agreement),
            },
            tables: &agreement.tables,
            settings: &first.products.settings,
        })
    }

    /// Describes the rule by which a point is matched with the reference.
    pub fn by(&self) -> &str {
        &self.by
    }

    /// Returns a line for each of several logs; `None` for a single log.
    pub fn summary_of_logs(&self) -> Option<String> {
        let line = |log: &LogComparison| match &log.comparison.residuals {
            None => format!("{}: no point has a reference", log.log),
            Some(found) => format!(
                "{}: n {}, median {:+.3} m, sd {:.3} m, p95 {:.3} m",
                log.log, found.n, found.median_m, found.sd_m, found.p95_m
            ),
        };
        let lines: Vec<String> = self.logs.iter().map(line).collect();
        (!lines.is_empty()).then(|| lines.join("\n"))
    }
}

/// Returns the comparison of each log by itself.
fn each(logs: &[ProcessedLog], agreement: &Agreement) -> Vec<LogComparison> {
    let found = agreement.comparison_of_each(logs).into_iter();
    let each = found.zip(logs).zip(log_names(logs));
    each.map(|((comparison, log), name)| LogComparison {
        log: name,
        statement: log.products.correction.statement(),
        comparison,
    })
    .collect()
}

/// Writes the points of the logs that were compared with a reference and their differences, as CSV.
///
/// # Errors
/// When the file cannot be written; the sentence names the file.
pub fn write_differences(
    path: &Path,
    logs: &[ProcessedLog],
    agreement: &Agreement,
) -> Result<Summary, Error> {
    let names = log_names(logs);
    let points = log_points(logs, &names);
    let found = agreement.logs.iter().map(|log| log.differences.as_slice());
    let found: Vec<&[Match]> = found.collect();
    Ok(export::differences_csv(path, &points, &found)?)
}

/// Writes `comparison.json`.
pub(super) fn json(results: &Results<'_>, path: &Path) -> FileResult {
    let agreement = results.agreement()?.ok_or(NO_REFERENCE)?;
    let inputs = results.reference_inputs()?;
    let record = ComparisonRecord::new(results.order.logs, agreement, inputs)?;
    export::write_json(path, &record)?;
    Ok(FileContent::count(agreement.differences().count()))
}

/// Writes `comparison.csv`.
pub(super) fn csv(results: &Results<'_>, path: &Path) -> FileResult {
    let agreement = results.agreement()?.ok_or(NO_REFERENCE)?;
    let points = write_differences(path, results.order.logs, agreement)?;
    Ok(FileContent::in_degrees(points))
}

#[derive(Serialize)]
struct ResidualsRecord<'a> {
    program: &'static str,
    sign: &'static str,
    statement: String,
    comparisons: &'a [NamedComparison],
    side_scan: Option<ResidualTables>,
    #[serde(skip_serializing_if = "Option::is_none")]
    swath: Option<ResidualTables>,
    /// Choices of geometry; only for a survey of one log.
    #[serde(skip_serializing_if = "Option::is_none")]
    choices: Option<Vec<GeometryChoice>>,
    crossline_analysis: Option<&'a Crosslines>,
    /// Residuals of each of several logs by itself; empty for a single log.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    logs: Vec<LogResiduals>,
    settings: &'a Settings,
}

/// Comparison of a log with its own soundings and its own track.
#[derive(Serialize)]
struct LogResiduals {
    log: String,
    statement: String,
    comparisons: Vec<NamedComparison>,
    side_scan: Option<ResidualTables>,
    #[serde(skip_serializing_if = "Option::is_none")]
    swath: Option<ResidualTables>,
    choices: Vec<GeometryChoice>,
    crossline_analysis: Option<Crosslines>,
}

/// Sources of first returns: both sides.
const SIDE_SCAN: [PointSource; 2] = [PointSource::Port, PointSource::Starboard];
const STATEMENT: &str = "Soundings and first returns of one log share transducer, position and sound speed: this is agreement \
     within one instrument, not accuracy against a reference.";
const STATEMENT_OF_LOGS: &str = "Points of all logs are compared with the soundings of all of them: what the heights of the logs differ by \
     is in it. Each log against its own soundings stands under `logs`.";

/// Writes `residuals.json`: the agreement of side-scan with soundings, the variables that the
/// differences depend on, the effect of other choices of geometry and calibration, and the
/// crossings of the tracks. With several logs, for all together and for each by itself.
pub(super) fn residuals(results: &Results<'_>, path: &Path) -> FileResult {
    let (logs, products, progress) = (results.order.logs, results.products, results.progress);
    let comparisons = results.comparisons()?;
    let (statement, choices, each) = match logs {
        [log] => {
            let statement = format!("{} {STATEMENT}", products.correction.statement());
            let choices = choices(&log.survey, products, progress)?;
            (statement, Some(choices), Vec::new())
        }
        logs => {
            let each = logs.iter().zip(&results.names);
            let each = each.map(|(log, name)| log_record(results, log, name));
            let statement = format!("{STATEMENT} {STATEMENT_OF_LOGS}");
            (statement, None, each.collect::<Result<_, Error>>()?)
        }
    };
    let record = ResidualsRecord {
        program: PROGRAM,
        sign: SIGN,
        statement,
        comparisons,
        side_scan: tables(logs, &SIDE_SCAN, progress)?,
        swath: tables(logs, &[PointSource::Swath], progress)?,
        choices,
        crossline_analysis: results.crossings()?,
        logs: each,
        settings: &products.settings,
    };
    export::write_json(path, &record)?;
    Ok(FileContent::count(comparisons.len()))
}

/// Returns tables of the differences of some sources from the soundings, by the variables that the
/// differences depend on; `None` without any difference.
fn tables(
    logs: &[ProcessedLog],
    sources: &[PointSource],
    progress: &Progress,
) -> Result<Option<ResidualTables>, Cancelled> {
    let found = Agreement::with_soundings(logs, sources, progress)?;
    Ok(found.map(|found| found.tables))
}

fn log_record(
    results: &Results<'_>,
    log: &ProcessedLog,
    name: &str,
) -> Result<LogResiduals, Error> {
    let (alone, map, progress) = (slice::from_ref(log), &results.map, results.progress);
    Ok(LogResiduals {
        log: name.to_owned(),
        statement: log.products.correction.statement(),
        comparisons: comparisons(alone, map, progress)?,
        side_scan: tables(alone, &SIDE_SCAN, progress)?,
        swath: tables(alone, &[PointSource::Swath], progress)?,
        choices: choices(&log.survey, &log.products, progress)?,
        crossline_analysis: crosslines(alone, &[], progress)?,
    })
}
