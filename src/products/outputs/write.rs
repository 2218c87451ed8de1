//! Writes all files of a run, or only those of a search for objects, into a folder that may hold
//! the files of a run.

use super::content::{FileContent, Missing, Need};
use super::groups::{first_missing, place, write_groups};
use super::manifest::write_manifest;
use super::object_files::Proposed;
use super::order::{Order, Product, When, check_logs};
use super::overwrite::refuse_overwrite;
use super::registry::{FileWriter, OUTPUT_FILES, OutputFile, RunFile, row_of, row_of_beside};
use super::report_page;
use super::report_page::OutputRun;
use super::results::Results;
use super::run_folder::{Replaced, RunFolder};
use crate::Error;
use crate::export;
use crate::export::write_json;
use crate::pipeline::joint::joint_report;
use crate::pipeline::{Derived, ProcessedLog, Report};
use bathyscope_bottom::bathymetry::Surface;
use bathyscope_bottom::presentation::text::bytes;
use bathyscope_log::support::progress::{Cancelled, Progress};
use bathyscope_objects::objects::SurveyReview;
use bathyscope_objects::{DetectorSettings, Model, Picture, Scored, find_in_picture};
use std::path::Path;

/// Result of a run.
#[derive(Clone, Debug)]
pub struct Written {
    /// The files, in the order of writing.
    pub files: Vec<&'static OutputFile>,
    /// Number of files that were made from the results, with their companions and the pictures.
    pub file_count: usize,
    /// Total size of these files, bytes.
    pub byte_count: u64,
    /// Files of an earlier run that were removed or kept.
    pub replaced: Replaced,
    /// The report, as written to `report.json`.
    pub report: Report,
    /// Boxes and objects that were found; `None` without a search.
    pub found: Option<Proposed>,
}

impl Written {
    /// Describes the written and removed files in a sentence or two.
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

/// Writes every requested file of the registry, `report.html`, `report.json` and the manifest of
/// all files, and puts them in the place of the files of an earlier run.
///
/// `on_step` receives the name of the next step.
///
/// # Errors
/// When a file cannot be made or written, a log was cut or changed meanwhile, or the work was
/// cancelled; the sentence names the file. The folder is then unchanged.
pub fn write(
    order: &Order<'_>,
    folder: RunFolder,
    progress: &Progress,
    mut on_step: impl FnMut(&'static str),
) -> Result<Written, Error> {
    // This is checked first: an unsuitable coordinate system should be reported before all inputs
    // are hashed.
    let results = Results::new(order, progress)?;
    refuse_overwrite(order, folder.destination())?;
    let path = folder.path();
    let mut run = OutputRun {
        report: report(&results)?,
        results,
        made: Vec::new(),
        hashed: Vec::new(),
        folder: &folder,
    };
    let asked = |when| order.asks_for(when);
    let made = write_rows(&run.results, &path, asked, &mut on_step)?;
    run.report.warnings.extend(made.warnings);
    run.made = made.files;
    run.report.depths_between_lines = run.results.made_surface().and_then(Surface::between_lines);
    on_step("hashes");
    run.hashed = folder.files(&[], progress)?;
    run.report.name_run(&run.hashed)?;
    if asked(When::Chosen(Product::Report)) {
        on_step("report");
    }
    let mut files: Vec<&OutputFile> = run.made.iter().map(|(row, _)| *row).collect();
    for row in OUTPUT_FILES.iter().filter(|row| asked(row.when)) {
        if let FileWriter::Run(file) = row.writer
            && first_missing(row, &run.results)?.is_none()
        {
            let path = place(&path, row)?;
            match file {
                RunFile::Page => report_page::write(&run, &path)?,
                RunFile::Record => write_json(&path, &run.report)?,
                RunFile::Manifest => manifest(&run, &path)?,
            }
            files.push(row);
        }
    }
    let found = if asked(When::Searched) { Proposed::of(&run.results)? } else { None };
    let (report, hashed) = (run.report, run.hashed);
    drop(run.results);
    check_logs(order.logs)?;
    Ok(Written {
        file_count: hashed.len(),
        byte_count: hashed.iter().map(|file| file.bytes).sum(),
        files,
        replaced: folder.commit(super::MANIFEST)?,
        report,
        found,
    })
}

/// Returns the report of the log, or of all logs.
fn report(results: &Results<'_>) -> Result<Report, Cancelled> {
    let several = match results.order.logs {
        [_] => None,
        logs => joint_report(logs, &results.names, results.progress)?,
    };
    let report = match several {
        Some(all) => all,
        None => Report::new(results.survey, results.products, results.progress)?,
    };
    Ok(Report { corrections: results.order.corrections.to_vec(), ..report })
}

/// Files that were made from results, and the reasons why others were not.
struct MadeFiles {
    files: Vec<(&'static OutputFile, FileContent)>,
    warnings: Vec<String>,
}

/// Writes the files that are made from the results alone, if they are requested and possible; the
/// search for objects is done first.
fn write_rows(
    results: &Results<'_>,
    folder: &Path,
    asked: impl Fn(When) -> bool,
    on_step: &mut impl FnMut(&'static str),
) -> Result<MadeFiles, Error> {
    if asked(When::Searched) {
        on_step("objects");
        results.shaped_found()?;
    }
    on_step("writing");
    let mut made = MadeFiles { files: Vec::new(), warnings: Vec::new() };
    for (row, file) in write_groups(results, folder, &asked)? {
        match file {
            Ok(content) => made.files.push((row, content)),
            Err(Missing(why)) => {
                let new = why.filter(|why| !made.warnings.contains(why));
                made.warnings.extend(new);
            }
        }
    }
    if asked(When::Compared) {
        let notes = results.order.reference.iter();
        made.warnings.extend(notes.flat_map(|(reference, _)| reference.notes.iter().cloned()));
    }
    Ok(made)
}

/// Writes `manifest.json`, which lists every other file of the run.
fn manifest(run: &OutputRun<'_>, path: &Path) -> Result<(), Error> {
    let files = (run.folder).files(&run.hashed, run.results.progress)?;
    let compared = run.made.iter().any(|(row, _)| row.needs.contains(&Need::Reference));
    let more_inputs = if compared { run.results.reference_inputs()? } else { &[] };
    write_manifest(path, &run.report, &run.made, &files, more_inputs)
}

/// Searches a survey and writes the found objects in the place of those of an earlier search.
/// Returns the found boxes, and the earlier files that were removed or kept.
///
/// # Errors
/// When a file cannot be made or written, or the work was cancelled; the sentence names the file.
/// The folder is then unchanged.
pub fn write_detected(
    log: &ProcessedLog,
    model: &Model,
    run: RunFolder,
    progress: &Progress,
) -> Result<(Proposed, Replaced), Error> {
    let order = Order {
        logs: std::slice::from_ref(log),
        derived: &Derived::default(),
        requested: &[],
        reference: None,
        search: Some(model),
        review: &SurveyReview::default(),
        corrections: &[],
    };
    let results = Results::new(&order, progress)?;
    write_rows(&results, &run.path(), is_asked, &mut |_| ())?;
    let found = Proposed::of(&results)?;
    let found = found.ok_or("nothing searched for objects")?;
    check_logs(order.logs)?;
    Ok((found, run.commit_group(is_of_search)?))
}

/// Searches a picture of another program and writes the found boxes like [`write_detected`]; `name`
/// is the name of the picture in the table.
///
/// # Errors
/// As [`write_detected`].
pub fn write_detected_in_picture(
    name: &str,
    picture: &Picture,
    model: &Model,
    settings: &DetectorSettings,
    run: RunFolder,
    progress: &Progress,
) -> Result<(Vec<Scored>, Replaced), Error> {
    let found = find_in_picture(picture, model, settings, progress)?;
    let folder = run.path().join("objects");
    // The chips are written first, because this makes the folder.
    export::picture_chips(&folder, picture, model.names(), &found).and_then(|_| {
        let table = folder.join("detections.csv");
        export::picture_boxes_csv(&table, name, model.names(), &found)
    })?;
    Ok((found, run.commit_group(is_of_search)?))
}

/// Returns true if a file belongs to a search, in the layout of any version.
fn is_of_search(name: &str) -> bool {
    let row = row_of(name).or_else(|| row_of_beside(name));
    row.is_some_and(|row| is_asked(row.when))
}

/// Returns true for files that a search for objects writes.
fn is_asked(when: When) -> bool {
    matches!(when, When::Searched | When::Listed)
}
