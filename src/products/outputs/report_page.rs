//! Writes `report.html`, the results of a run on one page, while the files of the run are written.

use super::content::FileContent;
use super::object_files::{target_boxes, targets};
use super::order::When;
use super::registry::{FileWriter, OUTPUT_FILES, OutputFile};
use super::results::Results;
use super::run_folder::RunFolder;
use crate::Error;
use crate::export::write_bytes;
use crate::html_report::{self, FileLine, ReportData, ReportObjects};
use crate::pipeline::{Fingerprint, ProcessedLog, Report};
use bathyscope_objects::Raster;
use bathyscope_objects::objects::Object;
use bathyscope_objects::review::{PIXEL_M, Review, State};
use bathyscope_objects::targets::PassLog;
use std::path::Path;

/// A run whose files are being written.
pub(super) struct OutputRun<'a> {
    pub results: Results<'a>,
    pub report: Report,
    /// Files that have been made from the results so far.
    pub made: Vec<(&'static OutputFile, FileContent)>,
    /// Fingerprints of the files that were made from the results.
    pub hashed: Vec<Fingerprint>,
    pub folder: &'a RunFolder,
}

impl OutputRun<'_> {
    /// Returns the files, besides the page, that are in the folder at the end, in the order of the
    /// page: folders last.
    fn listed(&self) -> impl Iterator<Item = &'static OutputFile> {
        let of_run = |row: &&OutputFile| {
            row.when == When::Always && !matches!(row.writer, FileWriter::Results(_))
        };
        let (folders, files): (Vec<_>, Vec<_>) =
            (self.made.iter().map(|(row, _)| *row)).partition(|row| !row.file_name().contains('.'));
        let of_run = OUTPUT_FILES.iter().filter(of_run);
        files.into_iter().chain(of_run).chain(folders)
    }
}

/// Writes the page to a file.
pub(super) fn write(run: &OutputRun<'_>, path: &Path) -> Result<(), Error> {
    let results = &run.results;
    let order = results.order;
    let mut comparisons = results.comparisons()?.to_vec();
    if let Some(agreement) = results.agreement()? {
        comparisons.extend(agreement.by_source(order.logs));
    }
    // Too many levels were reported as a warning when the isobaths were written.
    let isobaths = results.isobaths()?.unwrap_or_default();
    let mosaic = results.mosaic()?;
    let files: Vec<FileLine> = run.listed().map(|row| (row.name, row.brief)).collect();
    let from = ReportData {
        logs: order.logs,
        names: &results.names,
        title: results.name(),
        survey: results.survey,
        products: results.products,
        report: &run.report,
        map: &results.map,
        depth_map: results.depth_map()?.map(AsRef::as_ref),
        isobaths: &isobaths,
        mosaic: mosaic.as_deref(),
        comparisons: &comparisons,
        latencies: results.crossings()?.map_or(&[], |found| found.latencies.as_slice()),
        objects: objects(results)?,
        files: &files,
    };
    Ok(write_bytes(path, html_report::page(&from, results.progress)?)?)
}

/// Returns the objects with the data that the page shows about them; `None` without a search or a
/// review.
fn objects<'a>(results: &'a Results<'_>) -> Result<Option<ReportObjects<'a>>, Error> {
    let order = results.order;
    let model = order.search.filter(|_| order.asks_for(When::Searched));
    if !order.asks_for(When::Listed) {
        return Ok(None);
    }
    let (list, _) = results.shaped_objects()?;
    let mut rasters = Vec::with_capacity(order.logs.len());
    let mut reviews: Vec<(&str, &Review)> = Vec::new();
    for (index, log) in order.logs.iter().enumerate() {
        let raster = |pixel_m| Raster::new(&log.survey, &log.products.navigation, pixel_m);
        rasters.push(match (order.review.log(index), model) {
            (Some(review), _) => {
                reviews.push((&results.names[index], review));
                Some(raster(PIXEL_M))
            }
            (None, Some(model)) => Some(raster(model.pixel_m)),
            (None, None) => None,
        });
    }
    let pass_logs: Vec<PassLog<'_>> = order.logs.iter().map(ProcessedLog::pass_log).collect();
    let passes = |object: &Object| (object.number, object.passes(&pass_logs));
    Ok(Some(ReportObjects {
        list,
        boxes: target_boxes(list),
        listed: targets(results)?,
        rasters,
        passes: list.targets().map(passes).collect(),
        origin: origin(&reviews, order.logs.len(), model.is_some()),
    }))
}

/// Describes the origin of the boxes:
/// `Boxes of the review: 12 accepted, 1 added, 3 rejected, 4 undecided`.
fn origin(reviews: &[(&str, &Review)], logs: usize, is_searched: bool) -> String {
    let boxes = || reviews.iter().flat_map(|(_, review)| review.boxes());
    let count = |state: State| boxes().filter(|review_box| review_box.state == state).count();
    let mut parts = String::new();
    for (name, review) in reviews {
        if let Some(part) = review.coverage() {
            let of_log = match logs {
                1 => String::new(),
                _ => format!(" of {name}"),
            };
            parts += &format!(". The search{of_log} was stopped: it covers {part}");
        }
    }
    if count(State::Proposed) == boxes().count() {
        return format!("Proposed by the detector, not reviewed{parts}");
    }
    let rest = match logs - reviews.len() {
        0 => String::new(),
        1 if is_searched => ". The boxes of one log are not reviewed".to_owned(),
        rest if is_searched => format!(". The boxes of {rest} logs are not reviewed"),
        1 => ". One log has no boxes".to_owned(),
        rest => format!(". {rest} logs have no boxes"),
    };
    format!(
        "Boxes of the review: {} accepted, {} added, {} rejected, {} undecided{rest}{parts}",
        count(State::Accepted),
        count(State::Added),
        count(State::Rejected),
        count(State::Proposed)
    )
}
