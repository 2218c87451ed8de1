//! Writes the products of a survey into a folder.

use super::clouds::{write_clouds, write_tables};
use super::record::{Made, write_record};
use super::report::Report;
use super::track::write_track;
use super::{
    MosaicWritten, NamedComparison, Product, Products, Settings, write_depth, write_mosaic,
};
use crate::bathymetry::Surface;
use crate::export::{self, is_same_file};
use crate::geo::MapPlane;
use crate::progress::Progress;
use crate::survey::Survey;
use std::io::Write as _;
use std::path::{Path, PathBuf};

/// What was written.
#[derive(Clone, Debug)]
pub struct Written {
    /// File names, in the order of writing; beside each but the report lies its record, `NAME.json`.
    pub files: Vec<&'static str>,
    /// The report, as written to `report.json`.
    pub report: Report,
    /// The plane that maps are drawn in.
    pub map: MapPlane,
    /// The depth map in that plane, where something wanted shows it and there is one.
    pub surface: Option<Surface>,
    /// How side-scan agrees with the soundings, where that was wanted.
    pub comparisons: Vec<NamedComparison>,
}

/// Writes `first_returns.csv`, `cloud.csv`, the wanted products, the record of each, and `report.json` into `folder`, which is
/// made when it is missing. Each file is written aside and renamed, the report last: where it is, the others are whole.
///
/// `on_step` is told what comes next. The error is one sentence that names the file. A cancelled run leaves whole files only.
pub fn write_products(
    survey: &Survey,
    products: &Products,
    wanted: &[Product],
    folder: &Path,
    progress: &Progress,
    mut on_step: impl FnMut(&'static str),
) -> Result<Written, String> {
    on_step("writing");
    // Before the work: a system that does not fit should not cost a hash of all inputs first.
    let map = map_plane(survey, &products.settings)?;
    spare_inputs(survey, products, folder)?;
    let mut report = Report::new(survey, products, progress).map_err(|error| error.to_string())?;
    std::fs::create_dir_all(folder)
        .map_err(|error| format!("cannot make the folder: {error}: {}", folder.display()))?;
    let wants = |product| wanted.contains(&product);
    let mut made = write_tables(survey, products, folder, progress)?;
    if wants(Product::Cloud) {
        made.extend(write_clouds(survey, products, &map, folder, progress)?);
    }
    if wants(Product::Track) {
        on_step("track");
        let (track, warnings) = write_track(survey, products, &map, folder, progress)?;
        made.extend(track);
        report.warnings.extend(warnings);
    }
    on_step("depths");
    let depth = write_depth(survey, products, wanted, folder, progress)?;
    made.extend(depth.made);
    report.warnings.extend(depth.warnings);
    if survey.has_side_scan() && wants(Product::Mosaic) {
        on_step("mosaic");
        match write_mosaic(survey, products, folder, progress)? {
            MosaicWritten::File(mosaic) => made.push(*mosaic),
            MosaicWritten::None(why) => report.warnings.push(why),
        }
    }
    on_step("records");
    for one in &made {
        progress.check().map_err(|error| error.to_string())?;
        write_record(one, &report, folder)?;
    }
    write_report(&report, folder)?;
    let names = made.iter().map(|one: &Made| one.name);
    Ok(Written {
        files: names.chain(["report.json"]).collect(),
        report,
        map,
        surface: depth.surface,
        comparisons: depth.comparisons,
    })
}

/// Names of products without their endings.
const STEMS: [&str; 16] = [
    "cloud",
    "comparison",
    "depth",
    "depth_areas",
    "detections",
    "distance",
    "first_returns",
    "footprint",
    "isobaths",
    "merged",
    "mosaic",
    "report",
    "residuals",
    "storage",
    "track",
    "uncertainty",
];

fn spare_inputs(survey: &Survey, products: &Products, folder: &Path) -> Result<(), String> {
    let gauge = products.correction.gauge().map(|gauge| &gauge.path);
    let files = survey.source.files.iter().chain(gauge);
    spare_files(files.map(PathBuf::as_path), folder)
}

/// Refuses a folder in which a product would be written over a file that it is made from: `track.gpx` of another receiver, `depth.tif`
/// that the survey is held against. The error is one sentence.
pub fn spare_files<'a>(
    mut files: impl Iterator<Item = &'a Path>,
    folder: &Path,
) -> Result<(), String> {
    let at_risk = |input: &&Path| {
        let stem = input.file_stem().unwrap_or_default();
        STEMS.iter().any(|name| stem.eq_ignore_ascii_case(name))
            && (input.file_name()).is_some_and(|name| is_same_file(&folder.join(name), input))
    };
    match files.find(at_risk) {
        Some(input) => Err(format!(
            "a product might be written over this input; choose another folder, or rename it: {}",
            input.display()
        )),
        None => Ok(()),
    }
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

/// The plane of the system that `crs` names; the error is a sentence that says why there is none.
pub(super) fn map_plane(survey: &Survey, settings: &Settings) -> Result<MapPlane, String> {
    let origin = survey.track.frame.origin();
    let crs = settings.crs.at(origin).map_err(|error| error.to_string())?;
    Ok(MapPlane::new(crs, origin))
}
