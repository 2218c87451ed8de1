//! Writes all files of a run, or only those of a search for objects, into a folder that may hold
//! the files of a run: several groups of files in parallel, and none over an input of the run.

use super::content::{FileContent, Missing};
use super::object_files::Proposed;
use super::order::{Order, Product, When, check_logs};
use super::registry::{FileWriter, OUTPUT_FILES, OutputFile, WriteFile, row_of, row_of_beside};
use super::report_page::{self, OutputRun};
use super::results::Results;
use super::run_folder::{Replaced, RunFolder, has_foreign_manifest, is_stem_of_output};
use super::{MANIFEST, manifest};
use crate::Error;
use crate::export::{self, is_same_file, make_folder, write_json};
use crate::pipeline::joint::joint_report;
use crate::pipeline::{Derived, ProcessedLog, Reference, Report};
use bathyscope_bottom::bathymetry::Surface;
use bathyscope_bottom::presentation::text::bytes;
use bathyscope_log::support::progress::{Cancelled, Progress};
use bathyscope_log::survey::Survey;
use bathyscope_objects::objects::SurveyReview;
use bathyscope_objects::{DetectorSettings, Model, Picture, Scored, find_in_picture};
use std::panic::resume_unwind;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;

/// Largest number of groups that are written in parallel: few of them keep several cores busy, and
/// each needs memory.
const MOST_AT_ONCE: usize = 4;

/// Refuses a folder in which a file of a run would be written over an input, such as `track.gpx` of
/// another receiver, or `depth.tif` that the survey is compared with.
///
/// # Errors
/// When an input would be written over; the sentence names the input.
fn refuse_overwrite(order: &Order<'_>, folder: &Path) -> Result<(), Error> {
    let reference = order.reference.map(|(reference, _)| reference.path());
    let gauges = order.logs.iter().filter_map(|log| log.products.correction.gauge());
    let gauges = gauges.map(|gauge| gauge.path.as_path());
    let areas = order.logs.iter().filter_map(|log| {
        let area = log.products.settings.isobaths.area.as_deref();
        area.map(|area| area.path.as_path())
    });
    let surveys = order.logs.iter().map(|log| &*log.survey);
    let inputs = files_of(surveys).chain(gauges).chain(areas);
    refuse(inputs.chain(reference), folder)
}

fn files_of<'a>(surveys: impl IntoIterator<Item = &'a Survey>) -> impl Iterator<Item = &'a Path> {
    let files = surveys.into_iter().flat_map(|survey| &survey.source.files);
    files.map(PathBuf::as_path)
}

/// Prepares a folder for the files of a survey of one or several logs. This is done before the long
/// computation, so that it is not wasted on a folder that cannot be written into, or in which a
/// file would be written over the survey or its reference.
///
/// # Errors
/// When the folder cannot be used or an input would be written over; the sentence names the folder
/// or the input.
pub fn begin<'a>(
    folder: &Path,
    surveys: impl IntoIterator<Item = &'a Survey>,
    reference: Option<&'a Reference>,
) -> Result<RunFolder, Error> {
    let reference = reference.map(Reference::path);
    refuse(files_of(surveys).chain(reference), folder)?;
    if has_foreign_manifest(folder) {
        return Err(format!(
            "the folder holds a {MANIFEST} of something else; choose another folder: {}",
            folder.display()
        )
        .into());
    }
    RunFolder::begin(folder)
}

fn refuse<'a>(mut inputs: impl Iterator<Item = &'a Path>, folder: &Path) -> Result<(), Error> {
    let at_risk = |input: &&Path| {
        let stem = input.file_stem().unwrap_or_default().to_string_lossy();
        // The ending of `cloud.copc.laz` has two parts.
        let stem = stem.strip_suffix(".copc").unwrap_or(&stem);
        // Files without a subfolder are those of an old version, which a run removes.
        let name = input.file_name().unwrap_or_default();
        let is_name = |row: &OutputFile| row.name.eq_ignore_ascii_case(&name.to_string_lossy());
        let is_on_top = is_stem_of_output(stem) || OUTPUT_FILES.iter().any(is_name);
        // Subfolders in which a run may write a file with this name, apart from the ending.
        let rows = OUTPUT_FILES.iter().filter(|row| row.stem().eq_ignore_ascii_case(stem));
        let below = rows.map(OutputFile::folder).filter(|folder| !folder.is_empty());
        let folders = below.chain(is_on_top.then_some(""));
        let mut there = folders.map(|of| folder.join(of).join(name));
        there.any(|there| is_same_file(&there, input))
    };
    match inputs.find(at_risk) {
        Some(input) => Err(format!(
            "a product might be written over this input; choose another folder, or rename it: {}",
            input.display()
        )
        .into()),
        None => Ok(()),
    }
}

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
    let mut report = report(&results)?;
    let asked = |when| order.asks_for(when);
    let made = write_rows(&results, &path, asked, &mut on_step)?;
    report.warnings.extend(made.warnings);
    report.depths_between_lines = results.made_surface().and_then(Surface::between_lines);
    on_step("hashes");
    let hashed = folder.files(&[], progress)?;
    report.name_run(&hashed)?;
    if asked(When::Chosen(Product::Report)) {
        on_step("report");
    }
    let run = OutputRun { results, report, made: made.files, hashed, folder: &folder };
    let mut files: Vec<&OutputFile> = run.made.iter().map(|(row, _)| *row).collect();
    for row in OUTPUT_FILES.iter().filter(|row| asked(row.when)) {
        let path = || place(&path, row);
        match row.writer {
            FileWriter::Results(_) => continue,
            FileWriter::Page => report_page::write(&run, &path()?)?,
            FileWriter::Record => write_json(&path()?, &run.report)?,
            FileWriter::Manifest => manifest::write(&run, &path()?)?,
        }
        files.push(row);
    }
    let found = asked(When::Searched).then(|| Proposed::of(&run.results)).transpose()?;
    let (report, hashed) = (run.report, run.hashed);
    drop(run.results);
    check_logs(order.logs)?;
    Ok(Written {
        file_count: hashed.len(),
        byte_count: hashed.iter().map(|file| file.bytes).sum(),
        files,
        replaced: folder.commit(MANIFEST)?,
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

/// A requested file: its content, or the missing input without which it cannot be made.
type RowFile = (&'static OutputFile, Result<FileContent, Missing>);

/// Files that are written one after the other, because one may contain another that was written
/// before.
type Group = Vec<(&'static OutputFile, WriteFile)>;

/// Writes the requested files, several groups in parallel, and returns them in the order of their
/// rows. Most writers use a single thread. The threads do not belong to rayon, because they may
/// wait for each other ([`Results`]).
///
/// # Errors
/// When a file cannot be made or written (the error of the file that failed first), or the work was
/// cancelled.
fn write_groups(
    results: &Results<'_>,
    folder: &Path,
    asked: impl Fn(When) -> bool,
) -> Result<Vec<RowFile>, Error> {
    let groups = groups(asked);
    let parts = (results.progress).start_parts(groups.iter().map(|group| share_of_time(group)));
    let next = AtomicUsize::new(0);
    let first_failed = OnceLock::new();
    let work = || {
        let mut written = Vec::new();
        loop {
            let index = next.fetch_add(1, Ordering::Relaxed);
            let (Some(group), Some(part)) = (groups.get(index), parts.get(index)) else {
                return written;
            };
            let files = write_group(results, folder, group, part);
            if files.is_err() {
                first_failed.get_or_init(|| index);
                // All other files would be discarded.
                parts.iter().for_each(Progress::cancel);
            }
            written.push((index, files));
        }
    };
    let threads = rayon::current_num_threads().min(MOST_AT_ONCE);
    let mut written: Vec<(usize, Result<Vec<RowFile>, Error>)> = thread::scope(|scope| {
        let others: Vec<_> = (1..threads).map(|_| scope.spawn(work)).collect();
        let own = work();
        let others = others.into_iter().map(|other| other.join());
        let others = others.flat_map(|files| files.unwrap_or_else(|fault| resume_unwind(fault)));
        others.chain(own).collect()
    });
    results.progress.check()?;
    // The group that failed first has cancelled the others, so its error is returned.
    written.sort_unstable_by_key(|(index, _)| (Some(index) != first_failed.get(), *index));
    let groups: Vec<Vec<RowFile>> =
        (written.into_iter()).map(|(_, files)| files).collect::<Result<_, _>>()?;
    Ok(groups.into_iter().flatten().collect())
}

/// Returns all requested files, group by group.
fn groups(asked: impl Fn(When) -> bool) -> Vec<Group> {
    let rows = OUTPUT_FILES.iter().filter(|row| asked(row.when));
    let rows = rows.filter_map(|row| match row.writer {
        FileWriter::Results(write) => Some((row, write)),
        FileWriter::Page | FileWriter::Record | FileWriter::Manifest => None,
    });
    let rows: Group = rows.collect();
    let groups = rows.chunk_by(|(one, _), (other, _)| one.when == other.when);
    groups.map(<[_]>::to_vec).collect()
}

/// Returns the approximate time that a group takes relative to the others.
fn share_of_time(group: &Group) -> f32 {
    match group.first().map(|(row, _)| row.when) {
        Some(When::Chosen(Product::Mosaic)) => 8.0,
        Some(When::Chosen(Product::Track | Product::Xyz | Product::Targets)) => 1.0,
        _ => 3.0,
    }
}

fn write_group(
    results: &Results<'_>,
    folder: &Path,
    group: &Group,
    part: &Progress,
) -> Result<Vec<RowFile>, Error> {
    let parts = part.start_parts(group.iter().map(|_| 1.0));
    let files = group.iter().zip(&parts).map(|(&(row, write), part)| {
        let results = results.with_progress(part);
        part.check()?;
        let missing = row.needs.iter().find_map(|need| results.missing(*need).transpose());
        let file = match missing {
            Some(missing) => Err(missing?),
            None => Ok(write(&results, &place(folder, row)?)?),
        };
        part.finish();
        Ok((row, file))
    });
    files.collect()
}

/// Returns the path of a file, after making its subfolder.
fn place(folder: &Path, row: &OutputFile) -> Result<PathBuf, Error> {
    let path = folder.join(row.name);
    let parent = path.parent().unwrap_or(folder);
    make_folder(parent)?;
    Ok(path)
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
    export::picture_chips(&folder, picture, model.names(), &found)?;
    let table = folder.join("detections.csv");
    export::picture_boxes_csv(&table, name, model.names(), &found)?;
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
