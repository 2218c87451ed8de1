//! Writes `comparison.json` and `comparison.csv`: the comparison of a survey with a reference, in
//! figures and point by point.

use super::content::{FileContent, FileResult};
use super::order::{log_names, log_points};
use super::residuals::SIGN;
use super::results::Results;
use crate::export::{self, Summary};
use crate::pipeline::{
    Agreement, Fingerprint, NamedComparison, ProcessedLog, ResidualTables, Settings,
};
use crate::{Error, PROGRAM};
use bathyscope_bottom::bathymetry::compare::{Comparison, Match};
use serde::Serialize;
use std::path::Path;

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
