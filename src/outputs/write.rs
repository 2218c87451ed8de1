//! All files of a run.

use super::detections::Proposed;
use super::overwrite::refuse_overwrite;
use super::product::Product;
use super::record::{FileContent, write_json, write_record};
use super::registry::{OUTPUT_FILES, OutputFile, When, Writer};
use super::results::{Missing, Need, Results};
use super::run_folder::RunFolder;
use crate::bathymetry::compare::Matching;
use crate::detection::Model;
use crate::detection::review::Review;
use crate::outputs::OutputError;
use crate::pipeline::joint::joint_report;
use crate::pipeline::{Derived, ProcessedLog, Reference, Report};
use crate::progress::{Cancelled, Progress};
use std::path::Path;
use std::sync::Arc;

/// What is to be written.
pub struct Order<'a> {
    /// The logs that the files are of, with what the pipeline made of them: one, or all of a survey, in the frame of the first.
    pub logs: &'a [ProcessedLog],
    /// What is made of all logs together, each once.
    pub derived: &'a Derived,
    /// What is written beside `first_returns.csv`, `cloud.csv` and `report.json`.
    pub requested: &'a [Product],
    /// What the depths are compared with besides, and how a point finds its reference.
    pub reference: Option<(&'a Arc<Reference>, Matching)>,
    /// What searches for objects: they are written as `detections.*` and `chips`.
    pub search: Option<&'a Model>,
    /// Boxes of each log that were found before and decided about, or nothing: the report shows them, before those of a search.
    pub reviews: &'a [Option<Arc<Review>>],
}

impl Order<'_> {
    /// What was decided about the boxes of a log.
    pub(super) fn review(&self, log: usize) -> Option<&Review> {
        self.reviews.get(log)?.as_deref()
    }

    /// Whether files that are written at such a time are to be written.
    pub(super) fn asks_for(&self, when: When) -> bool {
        match when {
            When::Always => true,
            When::Chosen(product) => self.requested.contains(&product),
            When::Compared => self.reference.is_some(),
            // Without side-scan there is nothing to search.
            When::Searched => {
                let mut surveys = self.logs.iter().map(|log| &log.survey);
                self.search.is_some() && surveys.any(|survey| survey.has_side_scan())
            }
        }
    }
}

/// What was written.
#[derive(Clone, Debug)]
pub struct Written {
    /// File names, in the order of writing; beside each but the reports lies its record, `NAME.json`.
    pub files: Vec<&'static str>,
    /// Files of an earlier run that were removed, since this one wrote none in their place.
    pub removed: Vec<String>,
    /// The report, as written to `report.json`.
    pub report: Report,
    /// What was found, where a model searched.
    pub found: Option<Proposed>,
}

impl Written {
    /// What was written and removed, in a sentence or two.
    pub fn summary(&self, folder: &Path) -> String {
        let files = self.files.join(", ");
        // Where comes first: the list of files is long, and the window shows a few lines of it.
        let wrote = format!(
            "wrote into {}: {files}, each with its record (.json)",
            folder.display()
        );
        match self.removed.as_slice() {
            [] => wrote,
            removed => format!("{wrote}; removed of an earlier run: {}", removed.join(", ")),
        }
    }
}

/// A run whose files are being written.
pub(super) struct Run<'a> {
    pub results: Results<'a>,
    pub report: Report,
    /// Made of the results so far.
    written: Vec<&'static OutputFile>,
    folder: &'a RunFolder,
}

impl Run<'_> {
    /// What is in the folder in the end, as the page lists it: folders last.
    pub fn listed(&self) -> impl Iterator<Item = &'static OutputFile> {
        let manifest = OUTPUT_FILES
            .iter()
            .filter(|row| row.name == super::MANIFEST);
        let (folders, files): (Vec<_>, Vec<_>) =
            (self.written.iter().copied()).partition(|row| !row.name.contains('.'));
        files.into_iter().chain(manifest).chain(folders)
    }
}

/// Writes every file of the registry that is asked for, a record of each, `report.html` and `report.json`, and puts them in the place of
/// an earlier run's files.
///
/// `on_step` receives the next step.
///
/// # Errors
/// A sentence that names the file, or says that the work was cancelled; the folder is then as it was.
pub fn write(
    order: &Order<'_>,
    folder: RunFolder,
    progress: &Progress,
    mut on_step: impl FnMut(&'static str),
) -> Result<Written, OutputError> {
    // Before the work: a system that does not fit should not cost a hash of all inputs first.
    let results = Results::new(order, progress)?;
    refuse_overwrite(order, folder.destination())?;
    let path = folder.path();
    let mut run = Run {
        report: report(&results)?,
        results,
        written: Vec::new(),
        folder: &folder,
    };
    let asked = |when| order.asks_for(when);
    let made = write_rows(&mut run.results, &path, asked, &mut on_step)?;
    run.report.warnings.extend(made.warnings);
    on_step("records");
    run.report.name_run(folder.files(progress)?)?;
    for (row, content) in &made.files {
        progress.check()?;
        let of_reference = row.needs.contains(&Need::Reference);
        let more = match of_reference {
            true => run.results.reference_inputs()?,
            false => &[],
        };
        write_record(row, content, &run.report, more, &path)?;
    }
    run.written = made.files.iter().map(|(row, _)| *row).collect();
    if asked(When::Chosen(Product::Report)) {
        on_step("report");
    }
    let mut files: Vec<&'static str> = run.written.iter().map(|row| row.name).collect();
    for row in OUTPUT_FILES.iter().filter(|row| asked(row.when)) {
        if let Writer::Run(write) = row.writer
            && first_missing(row, &run.results)?.is_none()
        {
            write(&mut run, &path.join(row.name))?;
            files.push(row.name);
        }
    }
    let found = match asked(When::Searched) {
        true => Proposed::of(&run.results)?,
        false => None,
    };
    let report = run.report;
    drop(run.results);
    Ok(Written {
        files,
        removed: folder.commit(super::MANIFEST)?,
        report,
        found,
    })
}

/// The report of the log, or of all logs.
fn report(results: &Results<'_>) -> Result<Report, Cancelled> {
    let several = match results.order.logs {
        [_] => None,
        logs => joint_report(logs, &results.names, results.progress)?,
    };
    match several {
        Some(all) => Ok(all),
        None => Report::new(results.survey, results.products, results.progress),
    }
}

/// Files that were made of results, and why others were not.
pub(super) struct MadeFiles {
    pub files: Vec<(&'static OutputFile, FileContent)>,
    pub warnings: Vec<String>,
}

/// Writes the files that are made of the results alone, as far as they are asked for and possible.
pub(super) fn write_rows(
    results: &mut Results<'_>,
    folder: &Path,
    asked: impl Fn(When) -> bool,
    on_step: &mut impl FnMut(&'static str),
) -> Result<MadeFiles, OutputError> {
    let mut made = MadeFiles {
        files: Vec::new(),
        warnings: Vec::new(),
    };
    let mut group = None;
    for row in OUTPUT_FILES.iter().filter(|row| asked(row.when)) {
        let Writer::Results(write) = row.writer else {
            continue;
        };
        results.progress.check()?;
        let before = group.replace(row.when);
        if before.is_some() && before != group {
            results.end_group();
        }
        if before.map(step) != group.map(step) {
            on_step(step(row.when));
        }
        match first_missing(row, results)? {
            None => made
                .files
                .push((row, write(results, &folder.join(row.name))?)),
            Some(Missing(why)) => {
                let new = why.filter(|why| !made.warnings.contains(why));
                made.warnings.extend(new);
            }
        }
    }
    results.end_group();
    if asked(When::Compared) {
        let notes = results.order.reference.iter();
        made.warnings
            .extend(notes.flat_map(|(reference, _)| reference.notes.iter().cloned()));
    }
    Ok(made)
}

/// The first thing that a file cannot be made without.
fn first_missing(row: &OutputFile, results: &Results<'_>) -> Result<Option<Missing>, OutputError> {
    for &need in row.needs {
        if let Some(missing) = results.missing(need)? {
            return Ok(Some(missing));
        }
    }
    Ok(None)
}

/// What is done while the files of a group are written.
fn step(when: When) -> &'static str {
    match when {
        When::Always | When::Chosen(Product::Cloud) => "writing",
        When::Chosen(Product::Track) => "track",
        When::Chosen(Product::Mosaic) => "mosaic",
        When::Chosen(Product::Report) => "report",
        When::Chosen(Product::Depth | Product::Xyz | Product::Isobaths | Product::Residuals) => {
            "depths"
        }
        When::Compared => "comparing",
        When::Searched => "objects",
    }
}

/// Writes `report.json`, which names every other file of the run.
pub(super) fn manifest(run: &mut Run<'_>, path: &Path) -> Result<(), OutputError> {
    run.report.files = run.folder.files(run.results.progress)?;
    write_json(path, &run.report)
}
