//! Finds the decisions about a log among untitled projects: those that the window writes into a
//! folder of its own until the analyst saves the survey under a name.
//!
//! A log may be in several untitled projects, because it was open with other logs at other times.
//! The project that was changed last has the valid decisions about it.

use super::log::{LogFile, LogKey, ProjectLog};
use super::paths::beside;
use super::store::{ENDING, JOURNAL, read_with_changes};
use super::{Project, text::LONGEST};
use bathyscope_log::support::progress::{Cancelled, Progress};
use bathyscope_log::support::regular_file;
use bathyscope_log::survey::Survey;
use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::SystemTime;

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
        let text = regular_file::read(path, LONGEST).unwrap_or_default();
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
