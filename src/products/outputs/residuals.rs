//! Writes `residuals.json`: the comparison of side-scan points and swath points with the soundings
//! of the survey, and of the tracks with themselves and each other.

use super::content::{FileContent, FileResult};
use super::results::Results;
use crate::export::write_json;
use crate::pipeline::{
    Agreement, Crosslines, GeometryChoice, NamedComparison, ProcessedLog, ResidualTables, Settings,
    choices, comparisons, crosslines,
};
use crate::{Error, PROGRAM};
use bathyscope_bottom::cloud::PointSource;
use bathyscope_log::support::progress::{Cancelled, Progress};
use serde::Serialize;
use std::path::Path;
use std::slice;

#[derive(Serialize)]
struct Record<'a> {
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
/// Meaning of the sign of differences.
pub(super) const SIGN: &str = "measured minus reference elevation, metres; positive is shallower";
const STATEMENT: &str = "Soundings and first returns of one log share transducer, position and sound speed: this is agreement \
     within one instrument, not accuracy against a reference.";
const STATEMENT_OF_LOGS: &str = "Points of all logs are compared with the soundings of all of them: what the heights of the logs differ by \
     is in it. Each log against its own soundings stands under `logs`.";

/// Writes `residuals.json`: the agreement of side-scan with soundings, the variables that the
/// differences depend on, the effect of other choices of geometry and calibration, and the
/// crossings of the tracks. With several logs, for all together and for each by itself.
pub(super) fn write(results: &Results<'_>, path: &Path) -> FileResult {
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
    let record = Record {
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
    write_json(path, &record)?;
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
