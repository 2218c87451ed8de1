//! `residuals.json`: side-scan points against the soundings of the same log, and the log against itself.

use super::record::{Coordinates, FileContent, write_json};
use super::results::Results;
use crate::export::Summary;
use crate::pipeline::{
    Agreement, Choice, NamedComparison, OwnCrosslines, ResidualTables, Settings, choices,
};
use crate::progress::Cancelled;
use serde::Serialize;
use std::path::Path;

#[derive(Serialize)]
struct Record<'a> {
    program: String,
    sign: &'static str,
    statement: String,
    comparisons: &'a [NamedComparison],
    side_scan: Option<ResidualTables>,
    choices: Vec<Choice>,
    crossline_analysis: Option<&'a OwnCrosslines>,
    settings: &'a Settings,
}

const SIGN: &str = "measured minus reference elevation, metres; positive is shallower";
const STATEMENT: &str = "Soundings and first returns of one log share transducer, position and sound speed: this is agreement \
     within one instrument, not accuracy against a reference.";

/// Writes `residuals.json`: how side-scan agrees with soundings, what that hangs on, and what other choices of geometry and calibration
/// make of it; the crossings of the track.
pub fn write(results: &Results<'_>, path: &Path) -> Result<FileContent, String> {
    let (products, progress) = (results.products, results.progress);
    let cancelled = |error: Cancelled| error.to_string();
    let side_scan = Agreement::with_soundings(products, progress).map_err(cancelled)?;
    let comparisons = results.comparisons()?;
    let record = Record {
        program: format!("bathyscope {}", env!("CARGO_PKG_VERSION")),
        sign: SIGN,
        statement: format!("{} {STATEMENT}", products.correction.statement()),
        comparisons,
        side_scan: side_scan.map(|found| found.tables),
        choices: choices(results.survey, products, progress).map_err(cancelled)?,
        crossline_analysis: results.crossings()?,
        settings: &products.settings,
    };
    write_json(path, &record)?;
    let summary = Summary {
        count: comparisons.len(),
        ..Summary::default()
    };
    Ok(FileContent::new(Coordinates::None, summary))
}
