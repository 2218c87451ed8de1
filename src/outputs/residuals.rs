//! `residuals.json`: side-scan points against the soundings of the same log, and the log against itself.

use super::depth::DepthWritten;
use super::record::{Coordinates, Made};
use crate::export::{self, Summary};
use crate::pipeline::{
    Agreement, Choice, Crossed, NamedComparison, Products, ResidualTables, Settings, choices,
    crossed,
};
use crate::progress::{Cancelled, Progress};
use crate::survey::Survey;
use serde::Serialize;
use std::io::Write as _;
use std::path::Path;

#[derive(Serialize)]
struct Record<'a> {
    program: String,
    sign: &'static str,
    statement: String,
    comparisons: &'a [NamedComparison],
    side_scan: Option<ResidualTables>,
    choices: Vec<Choice>,
    crossings: Option<Crossed>,
    settings: &'a Settings,
}

const SIGN: &str = "measured minus reference elevation, metres; positive is shallower";
const STATEMENT: &str = "Soundings and first returns of one log share transducer, position and sound speed: this is agreement \
     within one instrument, not accuracy against a reference.";

/// Writes the record: some comparisons; what side-scan's hang on, and what other choices of geometry and calibration make of them;
/// the crossings of the track. Nothing where there is neither a comparison nor a crossing.
pub(super) fn write(
    survey: &Survey,
    products: &Products,
    comparisons: &[NamedComparison],
    folder: &Path,
    progress: &Progress,
    written: &mut DepthWritten,
) -> Result<(), String> {
    let cancelled = |error: Cancelled| error.to_string();
    let crossings = crossed(survey, products, progress).map_err(cancelled)?;
    if comparisons.is_empty() && crossings.is_none() {
        let why = "no residuals: the log has no side-scan points near a sounding, and its track does not cross itself";
        written.warnings.push(why.to_owned());
        return Ok(());
    }
    let side_scan = Agreement::with_soundings(products, progress).map_err(cancelled)?;
    let record = Record {
        program: format!("bathyscope {}", env!("CARGO_PKG_VERSION")),
        sign: SIGN,
        statement: format!("{} {STATEMENT}", products.correction.statement()),
        comparisons,
        side_scan: side_scan.map(|found| found.tables),
        choices: choices(survey, products, progress).map_err(cancelled)?,
        crossings,
        settings: &products.settings,
    };
    let name = "residuals.json";
    export::write_aside(&folder.join(name), |mut file| {
        let text = serde_json::to_vec_pretty(&record)?;
        file.write_all(&text)?;
        file.write_all(b"\n")
    })
    .map_err(|error| error.to_string())?;
    written.made.push(Made {
        name,
        what: "Side-scan points against the soundings of the same log",
        coordinates: Coordinates::None,
        counted: "comparisons",
        measured: "",
        summary: Summary {
            count: record.comparisons.len(),
            ..Summary::default()
        },
        regardless_of: &["detector", "isobaths", "mosaic"],
    });
    Ok(())
}
