//! All files of a run.

use super::detections::Proposed;
use super::manifest::{FileContent, write_json, write_manifest};
use super::overwrite::refuse_overwrite;
use super::product::Product;
use super::registry::{OUTPUT_FILES, OutputFile, When, Writer};
use super::results::{Missing, Need, Results};
use super::run_folder::{Replaced, RunFolder};
use crate::bottom::bathymetry::compare::Matching;
use crate::detection::Model;
use crate::detection::objects::SurveyReview;
use crate::pipeline::joint::{RequestedCorrection, joint_report};
use crate::pipeline::{Derived, Fingerprint, ProcessedLog, Reference, Report};
use crate::products::outputs::OutputError;
use crate::support::presentation::text::bytes;
use crate::support::progress::{Cancelled, Progress};
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// What is to be written.
pub struct Order<'a> {
    /// The logs that the files are of, with what the pipeline made of them: one, or all of a survey, in the frame of the first.
    pub logs: &'a [ProcessedLog],
    /// What is made of all logs together, each once.
    pub derived: &'a Derived,
    /// What is written beside the tables of pings and points, `report.json` and the manifest.
    pub requested: &'a [Product],
    /// What the depths are compared with besides, and how a point finds its reference.
    pub reference: Option<(&'a Arc<Reference>, Matching)>,
    /// What searches for objects: they are written as `detections.*` and `chips`.
    pub search: Option<&'a Model>,
    /// Boxes of each log that were found before and decided about: the report shows them, before those of a search.
    pub review: &'a SurveyReview,
    /// What became of corrections of positions and heights that were asked for: the report says it.
    pub corrections: &'a [RequestedCorrection],
}

impl Order<'_> {
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
    /// The files, in the order of writing.
    pub files: Vec<&'static OutputFile>,
    /// How many files were made of the results, with those that belong to them and the pictures.
    pub file_count: usize,
    /// Bytes of all of them.
    pub byte_count: u64,
    /// What became of files of an earlier run.
    pub replaced: Replaced,
    /// The report, as written to `report.json`.
    pub report: Report,
    /// What was found, where a model searched.
    pub found: Option<Proposed>,
}

impl Written {
    /// What was written and removed, in a sentence or two.
    pub fn summary(&self, folder: &Path) -> String {
        format!(
            "Wrote {} files, {}, into {}{}",
            self.file_count,
            bytes(self.byte_count),
            folder.display(),
            self.replaced.in_words()
        )
    }
}

/// A run whose files are being written.
pub(super) struct Run<'a> {
    pub results: Results<'a>,
    pub report: Report,
    /// Made of the results so far.
    made: Vec<(&'static OutputFile, FileContent)>,
    /// What was made of the results, by its hashes.
    hashed: Vec<Fingerprint>,
    folder: &'a RunFolder,
}

impl Run<'_> {
    /// What is in the folder in the end beside the page, as the page lists it: folders last.
    pub fn listed(&self) -> impl Iterator<Item = &'static OutputFile> {
        let of_run =
            |row: &&OutputFile| row.when == When::Always && matches!(row.writer, Writer::Run(_));
        let (folders, files): (Vec<_>, Vec<_>) =
            (self.made.iter().map(|(row, _)| *row)).partition(|row| !row.file_name().contains('.'));
        let of_run = OUTPUT_FILES.iter().filter(of_run);
        files.into_iter().chain(of_run).chain(folders)
    }
}

/// Writes every file of the registry that is asked for, `report.html`, `report.json` and the manifest of them all, and puts them in the
/// place of an earlier run's files.
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
        made: Vec::new(),
        hashed: Vec::new(),
        folder: &folder,
    };
    let asked = |when| order.asks_for(when);
    let made = write_rows(&mut run.results, &path, asked, &mut on_step)?;
    run.report.warnings.extend(made.warnings);
    run.made = made.files;
    run.report.depths_between_lines = run
        .results
        .made_levels()
        .and_then(|levels| levels.sentence());
    on_step("hashes");
    run.hashed = folder.files(&[], progress)?;
    run.report.name_run(&run.hashed)?;
    if asked(When::Chosen(Product::Report)) {
        on_step("report");
    }
    let mut files: Vec<&OutputFile> = run.made.iter().map(|(row, _)| *row).collect();
    for row in OUTPUT_FILES.iter().filter(|row| asked(row.when)) {
        if let Writer::Run(write) = row.writer
            && first_missing(row, &run.results)?.is_none()
        {
            write(&mut run, &place(&path, row)?)?;
            files.push(row);
        }
    }
    let found = match asked(When::Searched) {
        true => Proposed::of(&run.results)?,
        false => None,
    };
    let (report, hashed) = (run.report, run.hashed);
    drop(run.results);
    Ok(Written {
        file_count: hashed.len(),
        byte_count: hashed.iter().map(|file| file.bytes).sum(),
        files,
        replaced: folder.commit(super::MANIFEST)?,
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
    let report = match several {
        Some(all) => all,
        None => Report::new(results.survey, results.products, results.progress)?,
    };
    Ok(Report {
        corrections: results.order.corrections.to_vec(),
        ..report
    })
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
                .push((row, write(results, &place(folder, row)?)?)),
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
        When::Chosen(Product::Track | Product::Geopackage) => "track",
        When::Chosen(Product::MapTiles) => "map tiles",
        When::Chosen(Product::Mosaic) => "mosaic",
        When::Chosen(Product::Report) => "report",
        When::Chosen(
            Product::Depth
            | Product::Xyz
            | Product::Bottom
            | Product::Isobaths
            | Product::Residuals,
        ) => "depths",
        When::Compared => "comparing",
        When::Searched | When::Chosen(Product::Targets) => "objects",
    }
}

/// Where a file is written, its subfolder made.
fn place(folder: &Path, row: &OutputFile) -> Result<PathBuf, OutputError> {
    let path = folder.join(row.name);
    let parent = path.parent().unwrap_or(folder);
    fs::create_dir_all(parent)
        .map_err(|error| format!("cannot make the folder: {error}: {}", parent.display()))?;
    Ok(path)
}

/// Writes `report.json`.
pub(super) fn report_json(run: &mut Run<'_>, path: &Path) -> Result<(), OutputError> {
    write_json(path, &run.report)
}

/// Writes `manifest.json`, which names every other file of the run.
pub(super) fn manifest(run: &mut Run<'_>, path: &Path) -> Result<(), OutputError> {
    let files = (run.folder).files(&run.hashed, run.results.progress)?;
    let compared = run
        .made
        .iter()
        .any(|(row, _)| row.needs.contains(&Need::Reference));
    let more_inputs = match compared {
        true => run.results.reference_inputs()?,
        false => &[],
    };
    write_manifest(path, &run.report, &run.made, &files, more_inputs)
}
