//! Writes the products of a survey into a folder.

use super::Products;
use super::report::Report;
use crate::progress::Progress;
use crate::survey::Survey;
use std::path::Path;

/// What was written.
#[derive(Clone, Debug, PartialEq)]
pub struct Written {
    /// File names, in the order of writing.
    pub files: Vec<&'static str>,
    /// The report, as written to `report.json`.
    pub report: Report,
}

/// Writes `report.json` into `folder`.
pub fn write_products(
    survey: &Survey,
    products: &Products,
    folder: &Path,
    progress: &Progress,
) -> Result<Written, String> {
    let report = Report::new(survey, products, progress).map_err(|error| error.to_string())?;
    std::fs::create_dir_all(folder).map_err(|e| e.to_string())?;
    std::fs::write(
        folder.join("report.json"),
        serde_json::to_vec_pretty(&report).map_err(|e| e.to_string())?,
    )
    .map_err(|e| e.to_string())?;
    Ok(Written {
        files: vec!["report.json"],
        report,
    })
}
