//! Finds the logs of a project: at their recorded place, or moved with the project or within its
//! folder; and makes the inputs for work without a window: the logs at their present places, each
//! with its settings.
//!
//! Finds the decisions about a log among untitled projects, too: those that the window writes into
//! a folder of its own until the analyst saves the survey under a name. A log may be in several
//! untitled projects, because it was open with other logs at other times. The project that was
//! changed last has the valid decisions about it.

use super::log::{LogFile, LogKey, ProjectLog};
use super::paths::{self, beside};
use super::store::{ENDING, JOURNAL, folder_of, read_with_changes};
use super::{Project, text};
use crate::Error;
use crate::pipeline::{Settings, sha256_of};
use bathyscope_log::formats::{self, FileRole};
use bathyscope_log::support::geo::LocalFrame;
use bathyscope_log::support::progress::{Cancelled, Progress};
use bathyscope_log::support::regular_file;
use bathyscope_log::survey::Survey;
use std::collections::VecDeque;
use std::ffi::OsString;
use std::fs;
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::SystemTime;

/// Greatest depth of the folders searched below the project's folder.
const DEEPEST: usize = 5;
/// Most files examined: a folder with more may be a whole disk.
const MOST_FILES: usize = 50_000;

/// Location of a log.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum LogLocation {
    /// The log is at its recorded place.
    Here,
    /// The log is at this path: [`super::ProjectLog::at`] returns the log with it.
    Moved(PathBuf),
    /// A file of the same length with other bytes is at the recorded place, and the log was not
    /// found elsewhere.
    Changed,
    /// Another recording is at the recorded place, and the log was not found elsewhere.
    Replaced,
    /// The log was not found: the analyst is asked for its place.
    Missing,
}

/// Searches for the logs of a project: at their recorded place; by name in the project's folder and
/// the folders below it; by their bytes under any name there. At a place other than the recorded
/// one, a file is taken for the log only if its hash is equal.
pub fn find(
    project: &Project,
    folder: &Path,
    progress: &Progress,
) -> Result<Vec<(LogKey, LogLocation)>, Cancelled> {
    let mut below: Option<Vec<PathBuf>> = None;
    let mut found = Vec::new();
    for log in project.logs() {
        progress.check()?;
        let place = match at_its_place(&log.file, progress)? {
            LogLocation::Here => LogLocation::Here,
            otherwise => {
                let files = below.get_or_insert_with(|| files_below(folder));
                let elsewhere = search(&log.file, files, progress)?;
                elsewhere.map_or(otherwise, LogLocation::Moved)
            }
        };
        found.push((log.key.clone(), place));
    }
    Ok(found)
}

fn search(
    log: &LogFile,
    files: &[PathBuf],
    progress: &Progress,
) -> Result<Option<PathBuf>, Cancelled> {
    let name = log.path.file_name().unwrap_or_default().to_string_lossy();
    // A path that another system wrote is one long file name on this one.
    let name = paths::name_from_text(&name);
    let (named, others): (Vec<_>, Vec<_>) =
        files.iter().partition(|path| path.file_name() == Some(name.as_os_str()));
    for path in named.into_iter().chain(others) {
        progress.check()?;
        if *path != log.path && is_log(log, path, progress)? {
            return Ok(Some(path.clone()));
        }
    }
    Ok(None)
}

/// Examines the file at the log's recorded place, which may have grown since.
fn at_its_place(log: &LogFile, progress: &Progress) -> Result<LogLocation, Cancelled> {
    let path = &log.path;
    if is_log(log, path, progress)? || has_grown(log, path, progress)? {
        return Ok(LogLocation::Here);
    }
    if length(path) == Some(log.byte_count) {
        return Ok(LogLocation::Changed);
    }
    let there = if starts_recording(log, path) { opened(path, progress)? } else { None };
    let there = there.filter(|survey| survey.is_or_was(&log.identity()));
    Ok(match there {
        Some(survey) if survey.source.byte_count > log.byte_count => LogLocation::Here,
        Some(_) => LogLocation::Changed,
        None if path.exists() => LogLocation::Replaced,
        None => LogLocation::Missing,
    })
}

/// Returns true if a file is the log, by its hash.
fn is_log(log: &LogFile, path: &Path, progress: &Progress) -> Result<bool, Cancelled> {
    if length(path) == Some(log.byte_count) {
        return has_hash(log, regular_file::open(path), progress);
    }
    let survey = if starts_recording(log, path) { opened(path, progress)? } else { None };
    survey.map_or(Ok(false), |survey| log.is_of(&survey, progress))
}

/// Returns true if a file is longer than the log and begins with the log's bytes: more was written
/// since.
fn has_grown(log: &LogFile, path: &Path, progress: &Progress) -> Result<bool, Cancelled> {
    if length(path).is_none_or(|length| length <= log.byte_count) {
        return Ok(false);
    }
    let beginning = regular_file::open(path).map(|file| file.take(log.byte_count));
    has_hash(log, beginning, progress)
}

/// Returns true if the bytes have the hash of the log; false if they cannot be read.
fn has_hash(
    log: &LogFile,
    from: io::Result<impl Read>,
    progress: &Progress,
) -> Result<bool, Cancelled> {
    let hash = from.and_then(|from| sha256_of(from, progress));
    progress.check()?;
    Ok(hash.is_ok_and(|(_, sha256)| sha256 == log.sha256))
}

/// Returns the length of a file; `None` if there is none at the path.
fn length(path: &Path) -> Option<u64> {
    fs::metadata(path).ok().filter(fs::Metadata::is_file).map(|there| there.len())
}

/// Returns true if a file may be the first file of the log's recording in several: it is shorter
/// than the whole, and has the ending of the log's file.
fn starts_recording(log: &LogFile, path: &Path) -> bool {
    let ending = |path: &Path| path.extension().map(|ending| ending.to_ascii_lowercase());
    let role = formats::role_by_name(&log.path);
    let is_several =
        matches!(role, Some(FileRole::Description | FileRole::Part | FileRole::Paired));
    is_several
        && ending(path) == ending(&log.path)
        && length(path).is_some_and(|length| length < log.byte_count)
}

/// Opens the log in a file; `None` if the file is not a log.
fn opened(path: &Path, progress: &Progress) -> Result<Option<Survey>, Cancelled> {
    match formats::open(path, progress) {
        Ok(survey) => Ok(Some(survey)),
        Err(formats::OpenError::Cancelled(cancelled)) => Err(cancelled),
        Err(_) => Ok(None),
    }
}

/// Returns the files in a folder and the folders below it, the nearest first. Links to folders are
/// not followed: they may form a loop.
fn files_below(folder: &Path) -> Vec<PathBuf> {
    let mut files = Vec::new();
    let mut folders = VecDeque::from([(folder.to_owned(), 0)]);
    while let Some((folder, depth)) = folders.pop_front() {
        let mut entries: Vec<_> = fs::read_dir(&folder).into_iter().flatten().flatten().collect();
        entries.sort_by_key(fs::DirEntry::file_name);
        for entry in entries {
            let Ok(kind) = entry.file_type() else {
                continue;
            };
            if files.len() >= MOST_FILES {
                return files;
            }
            if kind.is_dir() && depth < DEEPEST {
                folders.push_back((entry.path(), depth + 1));
            } else if !kind.is_dir() {
                files.push(entry.path());
            }
        }
    }
    files
}

/// Log of a project, to be opened and processed.
#[derive(Clone, Debug)]
pub struct ProjectInput {
    /// The log, with the present path of its file.
    pub log: Arc<ProjectLog>,
    /// Settings with which the log is processed; the water levels and the area that they name are
    /// loaded.
    pub settings: Settings,
    /// Confidence from which undecided proposals count.
    pub least_confidence: f32,
    /// Local coordinate frame of all logs of the project, as in the window; `None` if the project
    /// has no origin yet.
    pub frame: Option<LocalFrame>,
    /// Warning about the log's file; `None` if there is none.
    pub warning: Option<String>,
}

/// Returns the visible logs of a project, in their order, with the changes in the journal beside
/// it: those of a window that has it open, or was killed.
///
/// # Errors
/// When the project cannot be read, contains no visible log, or a log or a file that its settings
/// name is missing.
pub fn inputs(path: &Path, progress: &Progress) -> Result<Vec<ProjectInput>, Error> {
    let mut project = read_with_changes(path)?;
    // Loaded once for all logs.
    project.settings.load_area().map_err(|error| error.0)?;
    let folder = folder_of(path);
    let places = find(&project, &folder, progress)?;
    let mut inputs = Vec::new();
    for (log, (_, found)) in project.logs().iter().zip(places) {
        if !log.is_visible {
            continue;
        }
        let (name, file) = (&log.name, log.file.path.display());
        let warning = (found == LogLocation::Changed).then(|| log.is_changed());
        let log = match found {
            LogLocation::Here | LogLocation::Changed => log.clone(),
            LogLocation::Moved(path) => Arc::new(log.at(&path)),
            LogLocation::Replaced => {
                return Err(format!(
                    "another recording lies where the log `{name}` of the project was; put it back beside the project: {file}"
                )
                .into());
            }
            LogLocation::Missing => {
                return Err(format!(
                    "the log `{name}` of the project is not there; put it back, or anywhere below the project's folder: {file}"
                )
                .into());
            }
        };
        let mut settings = project.settings_of(&log).map_err(|error| error.0)?;
        settings.load_files().map_err(|error| error.0)?;
        let frame = project.origin.map(LocalFrame::new);
        inputs.push(ProjectInput {
            log,
            settings,
            least_confidence: project.least_confidence(),
            frame,
            warning,
        });
    }
    if inputs.is_empty() {
        return Err(format!("the project has no log that is shown: {}", path.display()).into());
    }
    Ok(inputs)
}

/// Key of the named project in the files of an untitled one that was saved under a name.
pub const NAMED: &str = "project";

/// Untitled project that has the last decisions about a log.
#[derive(Debug)]
pub struct UntitledProject {
    /// Path of the project's file.
    pub path: PathBuf,
    /// The project, with the changes that are in its journal.
    pub project: Project,
    /// The log in it, with its present path.
    pub log: Arc<ProjectLog>,
    /// Time of its last change.
    pub changed_at: SystemTime,
    /// True if the project has the last decisions about all requested logs, and no other logs.
    pub is_whole: bool,
}

impl UntitledProject {
    /// Returns the named project that has its decisions now; `None` if it was not saved under a
    /// name, or the named project does not exist any more.
    pub fn named(&self) -> Option<&PathBuf> {
        self.project.files.get(NAMED).filter(|named| named.is_file())
    }
}

/// Finds the untitled project in `folder` that has the last decisions about a log which is opened
/// together with the logs at the paths `others`; `None` if there is none. A project that cannot be
/// read is passed over.
///
/// # Errors
/// When the work was cancelled.
pub fn find_untitled(
    folder: &Path,
    survey: &Survey,
    others: &[PathBuf],
    progress: &Progress,
) -> Result<Option<UntitledProject>, Cancelled> {
    let Some(file) = survey.source.files.first() else {
        return Ok(None);
    };
    let requested = names_of([file].into_iter().chain(others).map(PathBuf::as_path));
    let starts: Vec<String> =
        requested.iter().map(|name| LogKey::start_of(name.as_ref())).collect();
    let mut in_newer: Vec<OsString> = Vec::new();
    for path in newest_first(folder) {
        progress.check()?;
        if !has_log_like(&path, &starts) {
            continue;
        }
        let Ok(project) = read_with_changes(&path) else {
            continue;
        };
        let names = names_of(project.logs().iter().map(|log| log.file.path.as_path()));
        for log in project.logs() {
            if log.file.is_or_was_of(survey, progress)? {
                // Logs of the same name cannot be told from each other before they are read.
                let is_unambiguous = names.windows(2).all(|pair| pair[0] != pair[1]);
                let is_last = !requested.iter().any(|name| in_newer.contains(name));
                let is_whole = names == requested && is_unambiguous && is_last;
                let (log, changed_at) = (Arc::new(log.at(file)), changed_at(&path));
                let found = UntitledProject { path, project, log, changed_at, is_whole };
                return Ok(Some(found));
            }
        }
        in_newer.extend(names);
    }
    Ok(None)
}

/// Returns a path in `folder` that no file has yet, for the untitled project of a log.
pub fn unused_path(folder: &Path, log: &LogFile) -> PathBuf {
    let key = LogKey::of(log);
    let path = |number: u32| match number {
        1 => folder.join(format!("{key}.{ENDING}")),
        number => folder.join(format!("{key}-{number}.{ENDING}")),
    };
    let is_unused = |path: &PathBuf| !path.exists() && !beside(path, JOURNAL).exists();
    (1..).map(path).find(is_unused).unwrap_or_else(|| path(1))
}

/// Returns true if the text of a project or of its journal names a log with a key that begins with
/// one of `starts`. In a folder of many projects, most need not be parsed then.
fn has_log_like(path: &Path, starts: &[String]) -> bool {
    [path.to_owned(), beside(path, JOURNAL)].iter().any(|path| {
        let text = regular_file::read(path, text::LONGEST).unwrap_or_default();
        let text = String::from_utf8_lossy(&text);
        starts.iter().any(|start| text.contains(&format!("log.{start}")))
    })
}

/// Returns the names of files, sorted.
fn names_of<'a>(paths: impl Iterator<Item = &'a Path>) -> Vec<OsString> {
    let mut names: Vec<OsString> =
        paths.map(|path| path.file_name().unwrap_or_default().to_owned()).collect();
    names.sort();
    names
}

/// Returns the projects in a folder, beginning with the one that was changed last.
fn newest_first(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    let mut found: Vec<(SystemTime, PathBuf)> = entries
        .map(|entry| entry.path())
        .filter(|path| path.extension().is_some_and(|ending| ending == ENDING))
        .map(|path| (changed_at(&path), path))
        .collect();
    found.sort_by(|one, other| other.cmp(one));
    found.into_iter().map(|(_, path)| path).collect()
}

/// Returns the time at which a project was changed last: that of its file, or of its journal.
fn changed_at(path: &Path) -> SystemTime {
    let at = |path: &Path| fs::metadata(path).and_then(|found| found.modified()).ok();
    at(path).max(at(&beside(path, JOURNAL))).unwrap_or(SystemTime::UNIX_EPOCH)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn survey(path: &Path) -> Survey {
        formats::open(path, &Progress::new()).expect("a log")
    }

    fn places(project: &Project, folder: &Path) -> Vec<LogLocation> {
        let found = find(project, folder, &Progress::new()).expect("places");
        found.into_iter().map(|(_, found)| found).collect()
    }

    #[test]
    fn a_log_is_found_where_it_was_moved_to_and_only_by_its_bytes() {
        let temporary = tempfile::tempdir().expect("a folder");
        let folder = fs::canonicalize(temporary.path()).expect("a folder");
        let demo = bathyscope_test_support::demo_log();
        let log = folder.join("pond.sl2");
        fs::copy(&demo, &log).expect("a log");
        let file = LogFile::of(&survey(&log), &Progress::new()).expect("a log");
        let bytes = fs::read(&log).expect("a log");
        let (length, hash) = sha256_of(&bytes[..], &Progress::new()).expect("a log");
        assert_eq!((file.byte_count, &file.sha256), (length, &hash));
        let project = Project::default().with_log(ProjectLog::new(file)).expect("a log");
        assert_eq!(places(&project, &folder), [LogLocation::Here]);

        // In another folder, another recording has the same name and size.
        let [day, other] = ["day 1", "day 2"].map(|name| folder.join(name));
        fs::create_dir_all(&day).expect("a folder");
        fs::create_dir_all(&other).expect("a folder");
        let mut spoilt = bytes.clone();
        spoilt[bytes.len() / 2] ^= 1;
        fs::write(day.join("pond.sl2"), &spoilt).expect("a log");
        fs::remove_file(&log).expect("a log");
        assert_eq!(places(&project, &folder), [LogLocation::Missing]);
        let moved = other.join("renamed.sl2");
        fs::write(&moved, &bytes).expect("a log");
        assert_eq!(places(&project, &folder), [LogLocation::Moved(moved.clone())]);
        let named = other.join("pond.sl2");
        fs::write(&named, &bytes).expect("a log");
        assert_eq!(places(&project, &folder), [LogLocation::Moved(named)]);

        // The file at the recorded place has other bytes, of the same length.
        fs::write(&log, &spoilt).expect("a log");
        assert!(matches!(places(&project, &folder)[0], LogLocation::Moved(_)));
        for moved in [&moved, &other.join("pond.sl2")] {
            fs::rename(moved, moved.with_extension("kept")).expect("a log");
        }
        fs::remove_dir_all(&day).expect("a folder");
        for kept in ["renamed.kept", "pond.kept"] {
            fs::write(other.join(kept), b"").expect("a file");
        }
        assert_eq!(places(&project, &folder), [LogLocation::Changed]);
        fs::create_dir(&day).expect("a folder");
        fs::write(&moved, &bytes).expect("a log");

        // Another recording is at the recorded place.
        fs::write(&log, &bytes[..bytes.len() - 1000]).expect("a log");
        assert!(matches!(places(&project, &folder)[0], LogLocation::Moved(_)));
        fs::remove_dir_all(&other).expect("a folder");
        assert_eq!(places(&project, &folder), [LogLocation::Replaced]);

        // The path as written on Windows.
        fs::remove_file(&log).expect("a log");
        fs::write(day.join("pond.sl2"), &bytes).expect("a log");
        let text = project
            .to_text(&folder)
            .replace("file = \"pond.sl2\"", "file = \"D:\\\\lake\\\\pond.sl2\"");
        let foreign = Project::from_text(&text, &folder).expect("a project");
        assert_eq!(places(&foreign, &folder), [LogLocation::Moved(day.join("pond.sl2"))]);
        assert!(find(&project, &folder, &Progress::new()).is_ok());
    }

    #[test]
    fn a_picture_is_found_with_its_table() {
        let temporary = tempfile::tempdir().expect("a folder");
        let folder = fs::canonicalize(temporary.path()).expect("a folder");
        let [picture, table] = ["pond.png", "pond.csv"].map(|name| folder.join(name));
        let pixels = image::GrayImage::from_fn(8, 2, |x, y| image::Luma([(x + y) as u8]));
        pixels.save(&picture).expect("a picture");
        fs::write(&table, "lon,lat,range_m\n11.5,48.1,20\n11.5,48.2,20\n").expect("a table");
        let file = LogFile::of(&survey(&table), &Progress::new()).expect("a log");
        assert_eq!(file.path, picture);
        let project = Project::default().with_log(ProjectLog::new(file));
        let project = project.expect("a log");
        assert_eq!(places(&project, &folder), [LogLocation::Here]);
        let day = folder.join("day");
        fs::create_dir(&day).expect("a folder");
        let moved = day.join("lake.png");
        fs::rename(&picture, &moved).expect("a picture");
        assert_eq!(places(&project, &folder), [LogLocation::Missing]);
        fs::rename(&table, day.join("lake.csv")).expect("a table");
        assert_eq!(places(&project, &folder), [LogLocation::Moved(moved)]);
    }

    #[test]
    fn a_search_of_folders_ends() {
        let temporary = tempfile::tempdir().expect("a folder");
        let mut deep = temporary.path().to_owned();
        for level in 0..DEEPEST + 3 {
            fs::write(deep.join(format!("{level}.txt")), b"x").expect("a file");
            deep.push("below");
            fs::create_dir(&deep).expect("a folder");
        }
        assert_eq!(files_below(temporary.path()).len(), DEEPEST + 1);
        #[cfg(unix)]
        {
            std::os::unix::fs::symlink(temporary.path(), temporary.path().join("circle"))
                .expect("a link");
            assert_eq!(files_below(temporary.path()).len(), DEEPEST + 2);
        }
    }
}
