//! Writes the products of a survey into a folder.

use super::Products;
use super::report::Report;
use crate::export;
use crate::progress::Progress;
use crate::survey::Survey;
use std::io::Write as _;
use std::path::Path;

/// What was written.
#[derive(Clone, Debug, PartialEq)]
pub struct Written {
    /// File names, in the order of writing.
    pub files: Vec<&'static str>,
    /// The report, as written to `report.json`.
    pub report: Report,
}

/// Writes one product to a path.
type Write<'a> = dyn Fn(&Path) -> Result<(), export::ExportError> + 'a;

/// Writes `first_returns.csv`, `cloud.csv`, `cloud.laz`, `cloud.ply` and `report.json` into `folder`, which is made when it
/// is missing. Each file is written aside and renamed, the report last: where it is, the others are whole.
///
/// The error is one sentence that names the file. A cancelled run leaves whole files only.
pub fn write_products(
    survey: &Survey,
    products: &Products,
    folder: &Path,
    progress: &Progress,
) -> Result<Written, String> {
    let report = Report::new(survey, products, progress).map_err(|error| error.to_string())?;
    std::fs::create_dir_all(folder)
        .map_err(|error| format!("cannot make the folder: {error}: {}", folder.display()))?;
    let Products {
        navigation,
        returns,
        calibration,
        cloud,
        kept,
        ..
    } = products;
    let writers: [(&'static str, &Write<'_>); 4] = [
        ("first_returns.csv", &|path| {
            export::first_returns_csv(path, survey, navigation, returns, calibration)
        }),
        ("cloud.csv", &|path| {
            export::cloud_csv(path, survey, navigation, cloud, kept)
        }),
        ("cloud.laz", &|path| {
            export::cloud_laz(path, survey, navigation, cloud, kept)
        }),
        ("cloud.ply", &|path| export::cloud_ply(path, cloud, kept)),
    ];
    progress.start(writers.len() as u64 + 1);
    for (name, write) in &writers {
        progress.check().map_err(|error| error.to_string())?;
        write(&folder.join(name)).map_err(|error| error.to_string())?;
        progress.advance(1);
    }
    progress.check().map_err(|error| error.to_string())?;
    write_report(&report, folder)?;
    progress.advance(1);
    let names = writers.iter().map(|(name, _)| *name);
    Ok(Written {
        files: names.chain(["report.json"]).collect(),
        report,
    })
}

/// Writes `report.json`; again once more products, and warnings about them, have come.
pub fn write_report(report: &Report, folder: &Path) -> Result<(), String> {
    export::write_aside(&folder.join("report.json"), |mut file| {
        let text = serde_json::to_vec_pretty(report)?;
        file.write_all(&text)?;
        file.write_all(b"\n")
    })
    .map_err(|error| error.to_string())
}
