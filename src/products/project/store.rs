//! Stores a project on disk.
//!
//! - Saving writes a temporary file, syncs it to the disk, and renames it: there is always one
//!   complete file.
//! - Every change is written into the journal beside the file ([`Store::record`]); opening applies
//!   the changes that were not saved. After a crash at most the last change is missing.
//! - Only one window has a project open at a time. If that cannot be ensured, a file that another
//!   program changed meanwhile is not replaced.

use super::history::{HISTORY, Past, PastStep};
use super::journal::{Entry, NoJournal, Owner, ProjectJournal, Read};
use super::paths::beside;
use super::row::Rows;
use super::text::{VERSION, migrate};
use super::{Project, ProjectError, paths, rows, text};
use crate::export::{self, is_same_file};
use crate::pipeline::in_hexadecimal;
use bathyscope_log::support::file_error::FileError;
use bathyscope_log::support::regular_file;
use sha2::{Digest as _, Sha256};
use std::fs::{self, File};
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};

/// Ending of a project's file name.
pub const ENDING: &str = "bathyscope";
/// Suffix of the journal's name after the project's.
pub(super) const JOURNAL: &str = "-journal";

/// Reason why a project cannot be opened or saved, in one sentence that ends with the file.
pub type StoreError = FileError<StoreFault>;

/// Reason why a project cannot be opened or saved, in a sentence without the file.
#[derive(Debug, thiserror::Error)]
pub enum StoreFault {
    /// The file cannot be read.
    #[error("cannot read the project: {0}")]
    Read(#[source] io::Error),
    /// The text of the file is not a valid project.
    #[error("cannot use the project: {0}")]
    Text(#[source] ProjectError),
    /// Another window of this program has the project open.
    #[error(
        "the project is open in another window ({0}); close it there, or save this one under another name"
    )]
    Taken(Owner),
    /// The project or a file beside it cannot be written; [`read`] can still read the project.
    #[error("the project cannot be written here: {0}; save it under another name")]
    NotWritable(#[source] io::Error),
    /// Another program has changed the file since it was read.
    #[error(
        "another program has changed the project since it was opened, so it is not written over; save this one under another name"
    )]
    Changed,
    /// The path is that of a log, or does not have the ending of a project.
    #[error("a project is kept in a file of its own, whose name ends in .bathyscope")]
    Name,
}

/// Project that was opened.
#[derive(Debug)]
pub struct OpenedProject {
    /// Store with which the project is saved from now on.
    pub store: Store,
    /// Project with the changes that were not saved.
    pub project: Project,
    /// Notes to the analyst, in sentences, on changes that were recovered, or could not be.
    pub notes: Vec<String>,
    /// Changes that led to the project, the oldest first, as far as they are known.
    pub past: Vec<PastStep>,
}

/// File and journal of an open project. When the store is dropped, the journal stays if it has
/// changes that are not saved.
#[derive(Debug)]
pub struct Store {
    path: PathBuf,
    /// Journal; `None` only while the store is being dropped.
    journal: Option<ProjectJournal>,
    /// Hash of the file as this window read or wrote it.
    sha256: String,
    /// Project that the file and the journal together contain.
    recorded: Project,
    /// Project that the file contains; `None` if the file lacks a part of the project that was
    /// opened.
    saved: Option<Project>,
    /// Changes that led to the recorded project.
    past: Past,
}

/// Reads the file of a project without opening it for changes. A journal beside it is ignored.
///
/// # Errors
/// A sentence, when the file cannot be read or is not a valid project.
pub fn read(path: &Path) -> Result<Project, StoreError> {
    let (text, _) = text_of(path)?;
    let read = Project::from_text(&text, &folder_of(path));
    read.map_err(|error| StoreError::new(StoreFault::Text(error), path))
}

/// Reads a project as [`read`] does, with the changes in the journal beside it.
///
/// # Errors
/// As [`read`], and when the changes are not valid.
pub(super) fn read_with_changes(path: &Path) -> Result<Project, StoreError> {
    let (text, sha256) = text_of(path)?;
    let journal = regular_file::read(&beside(path, JOURNAL), text::LONGEST).unwrap_or_default();
    let read = text::read_as_written(&text).and_then(|(written, version)| {
        project_with_changes(written, version, &sha256, &Read::of(&journal), &folder_of(path))
    });
    read.map_err(|error| StoreError::new(StoreFault::Text(error), path))
}

impl Store {
    /// Opens a project for this window alone, and applies the changes that were not saved when it
    /// was last open.
    ///
    /// # Errors
    /// When the file cannot be read, is not a valid project, is open in another window, or is in a
    /// folder that cannot be written into.
    pub fn open(path: &Path) -> Result<OpenedProject, StoreError> {
        // The path without links, since saving renames a file to it, and there is one journal for
        // it.
        let path = paths::canonical(path)
            .map_err(|error| StoreError::new(StoreFault::Read(error), path))?;
        // Checked before any file is written beside it: it may not be a project.
        let wrong = |error| StoreError::new(StoreFault::Text(error), &path);
        text::read_as_written(&text_of(&path)?.0).map_err(wrong)?;
        let (mut journal, mut read) = lock(&path)?;
        // Read again, since from here on no other window can save it.
        let (text, sha256) = text_of(&path)?;
        let (written, version) = text::read_as_written(&text).map_err(wrong)?;
        let folder = folder_of(&path);
        let rows = migrate(written.clone(), version, VERSION);
        let saved = rows::read(rows.clone(), &folder).map_err(wrong)?;
        let mut notes = Vec::new();
        let mut project = saved.clone();
        let mut past = Past::read(&path, (&saved, rows), &sha256, &folder);
        match unsaved(&read, &sha256) {
            Some((entries, entry_version)) if !entries.is_empty() => {
                match replayed(written.clone(), version, entries, entry_version, &folder) {
                    Ok(with_unsaved) => {
                        project = with_unsaved;
                        let rows = migrate(written, version, entry_version);
                        past.replay(&saved, (rows, entry_version), entries, &folder);
                        notes.extend(taken_in(entries, read.damaged));
                    }
                    Err(error) => {
                        notes.push(aside(&path, journal, &format!("cannot be used: {error}"))?);
                        (journal, read) = lock(&path)?;
                    }
                }
            }
            Some(_) => {}
            None => {
                let why =
                    "belong to another version of the file, which was changed by another program";
                notes.push(aside(&path, journal, why)?);
                (journal, read) = lock(&path)?;
            }
        }
        let is_saved = project == saved;
        let begun = if is_saved || read.entries.is_empty() {
            journal.restart(&sha256, VERSION)
        } else {
            journal.append(&Entry::Opened(Owner::now()))
        };
        begun.map_err(not_writable(&path))?;
        let store = Self {
            journal: Some(journal),
            sha256,
            recorded: project.clone(),
            saved: Some(saved),
            past: past.clone(),
            path,
        };
        Ok(OpenedProject { store, project, notes, past: past.0.into() })
    }

    /// Creates the file of a project and opens it for changes. An existing file is replaced:
    /// whoever chose the name has confirmed it. `past` are the changes that led to the project, the
    /// oldest first, so that they can be undone when it is opened again.
    ///
    /// # Errors
    /// When another window has the file open, when it is a log or its name is not of the form
    /// `NAME.bathyscope`, or when it cannot be written.
    pub fn create(path: &Path, project: &Project, past: Vec<PastStep>) -> Result<Self, StoreError> {
        let ends = path.extension().is_some_and(|ending| ending == ENDING);
        let is_log = || project.logs().iter().any(|log| is_same_file(&log.file.path, path));
        if !ends || is_log() {
            return Err(StoreError::new(StoreFault::Name, path));
        }
        let path = match paths::canonical(path) {
            Ok(path) => path,
            Err(_) => paths::placed(path),
        };
        let (mut journal, read) = lock(&path)?;
        if read.entries.iter().any(|entry| matches!(entry, Entry::Done { .. })) {
            // The journal has unsaved changes to the file that is replaced; it is kept under
            // another name.
            aside(&path, journal, "")?;
            (journal, _) = lock(&path)?;
        }
        let mut store = Self {
            journal: Some(journal),
            sha256: String::new(),
            recorded: project.clone(),
            saved: None,
            past: Past::of_steps(past),
            path,
        };
        let saving = store.saving(project, None)?;
        store.end_save(saving.write())?;
        Ok(store)
    }

    /// Returns the path of the project's file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Returns the folder to which paths in the file are relative.
    pub fn folder(&self) -> PathBuf {
        folder_of(&self.path)
    }

    /// Returns true if the file contains another version of the project than this one.
    pub fn is_unsaved(&self, project: &Project) -> bool {
        self.saved.as_ref() != Some(project)
    }

    /// Writes the changes since the last call into the journal, as one line; no line if there are
    /// none. From then on a crash of the program does not lose them. The time depends on the size
    /// of the changes: under a millisecond for a decision.
    ///
    /// # Errors
    /// When the journal cannot be written; the next call tries again with all missing changes.
    pub fn record(&mut self, project: &Project, label: &str) -> Result<(), StoreError> {
        let (set, gone) = rows::changes(&self.recorded, project, &self.folder());
        if !set.is_empty() || !gone.is_empty() {
            let entry = Entry::done(label, &set, &gone);
            let path = &self.path;
            let journal = self.journal.as_mut().ok_or_else(|| closed(path))?;
            journal.append(&entry).map_err(not_writable(path))?;
            self.past.note(label, &self.recorded, project);
        }
        self.recorded = project.clone();
        Ok(())
    }

    /// Writes the project into its file.
    ///
    /// # Errors
    /// When another program has changed the file, or the file cannot be written; the changes stay
    /// in the journal.
    pub fn save(&mut self, project: &Project) -> Result<(), StoreError> {
        let saving = self.begin_save(project)?;
        self.end_save(saving.write())
    }

    /// Begins to write the project into its file. [`Saving::write`] writes the file, on another
    /// thread if that may take long; [`Store::end_save`] ends it. Changes recorded in between
    /// follow it in the journal: whenever the program ends, the journal fits the file that is
    /// there.
    ///
    /// # Errors
    /// When the journal cannot be written.
    pub fn begin_save(&mut self, project: &Project) -> Result<Saving, StoreError> {
        self.record(project, "save")?;
        self.saving(project, Some(self.sha256.clone()))
    }

    /// Updates the store after the project was written, or not written.
    ///
    /// # Errors
    /// The reason why the project was not written.
    pub fn end_save(&mut self, written: SavingOutcome) -> Result<(), StoreError> {
        let SavingOutcome { result, sha256, project } = written;
        result?;
        self.sha256.clone_from(&sha256);
        let is_all = self.recorded == project;
        self.saved = Some(project);
        // Later changes stay in the journal, after the entry that the file contains all earlier
        // ones.
        if is_all {
            let path = &self.path;
            let journal = self.journal.as_mut().ok_or_else(|| closed(path))?;
            journal.restart(&sha256, VERSION).map_err(not_writable(path))?;
        }
        Ok(())
    }

    /// Prepares the writing of a project into the file, which must have this hash if one is given.
    fn saving(
        &mut self,
        project: &Project,
        expected: Option<String>,
    ) -> Result<Saving, StoreError> {
        let text = project.to_text(&self.folder());
        let sha256 = in_hexadecimal(&Sha256::digest(&text));
        let path = self.path.clone();
        let journal = self.journal.as_mut().ok_or_else(|| closed(&path))?;
        // If the program ends between the renaming and the new journal, the hash of the file shows
        // that it contains all earlier changes.
        let about = Entry::Saved { sha256: sha256.clone(), version: VERSION };
        journal.append(&about).map_err(not_writable(&path))?;
        Ok(Saving {
            journal: journal.handle().map_err(not_writable(&path))?,
            path,
            expected,
            text,
            sha256,
            project: project.clone(),
            past: self.past.clone(),
        })
    }

    /// Removes the project from the disk: its file, its journal and its past. Errors are ignored.
    pub fn remove(mut self) {
        if let Some(journal) = self.journal.take() {
            journal.remove();
        }
        for path in [&self.path, &beside(&self.path, HISTORY)] {
            fs::remove_file(path).ok();
        }
    }

    /// Closes the project. Changes since the last save stay in the journal for the next time if
    /// `keep`, or are lost.
    pub fn close(mut self, keep: bool) {
        if !keep && let Some(journal) = self.journal.take() {
            journal.remove();
        }
    }
}

/// Project to be written into its file.
#[derive(Debug)]
pub struct Saving {
    path: PathBuf,
    /// Hash of the file if no other program changed it; `None` if any file is replaced.
    expected: Option<String>,
    text: String,
    sha256: String,
    project: Project,
    past: Past,
    journal: File,
}

/// Result of a [`Saving`].
#[derive(Debug)]
pub struct SavingOutcome {
    result: Result<(), StoreError>,
    sha256: String,
    project: Project,
}

impl Saving {
    /// Writes the project to a temporary file, syncs it to the disk, and renames it.
    pub fn write(self) -> SavingOutcome {
        SavingOutcome { result: self.try_write(), sha256: self.sha256, project: self.project }
    }

    fn try_write(&self) -> Result<(), StoreError> {
        let path = &self.path;
        // A file that was removed is written again. A file that cannot be read is not compared:
        // writing it succeeds or returns the error.
        if let (Some(expected), Ok((_, sha256))) = (&self.expected, text_of(path))
            && sha256 != *expected
        {
            return Err(StoreError::new(StoreFault::Changed, path));
        }
        self.journal.sync_data().map_err(not_writable(path))?;
        let written = export::write_atomically(path, |mut file| {
            file.write_all(self.text.as_bytes())?;
            file.sync_all()
        });
        written.map_err(|error| not_writable(path)(error.source))?;
        sync_folder(&folder_of(path));
        (self.past).write(path, &self.project, &self.sha256, &folder_of(path));
        Ok(())
    }
}

fn not_writable(path: &Path) -> impl Fn(io::Error) -> StoreError + use<'_> {
    |error| StoreError::new(StoreFault::NotWritable(error), path)
}

impl Drop for Store {
    fn drop(&mut self) {
        let is_saved = self.saved.as_ref() == Some(&self.recorded);
        if is_saved && let Some(journal) = self.journal.take() {
            journal.remove();
        }
    }
}

fn closed(path: &Path) -> StoreError {
    not_writable(path)(io::Error::other("it was closed"))
}

/// Returns the changes of a journal that the file with this hash lacks, and the layout of their
/// rows; `None` if the journal has no entry for that file.
fn unsaved<'a>(read: &'a Read, sha256: &str) -> Option<(&'a [Entry], u32)> {
    let is_done = |entry: &Entry| matches!(entry, Entry::Done { .. });
    if !read.entries.iter().any(is_done) {
        return Some((&[], VERSION));
    }
    let version_at = |entry: &Entry| match entry {
        Entry::Saved { sha256: hash, version } if hash == sha256 => Some(*version),
        _ => None,
    };
    let at = read.entries.iter().rposition(|entry| version_at(entry).is_some())?;
    let after = &read.entries[at + 1..];
    let version = version_at(&read.entries[at])?;
    let rest = if after.iter().any(is_done) { after } else { &[] };
    Some((rest, version))
}

/// Reads a project as [`Store::open`] does with the journal beside it, but from memory, for the
/// fuzzer. `sha256` is the hash of the text.
///
/// # Errors
/// As [`Project::from_text`], and when the changes are not valid.
pub fn with_journal(
    text: &str,
    sha256: &str,
    journal: &[u8],
    folder: &Path,
) -> Result<Project, ProjectError> {
    let (written, version) = text::read_as_written(text)?;
    let read = Read::of(journal);
    if let Some((entries, entry_version)) = unsaved(&read, sha256) {
        let rows = migrate(written.clone(), version, VERSION);
        let saved = rows::read(rows.clone(), folder)?;
        Past::default().replay(&saved, (rows, entry_version), entries, folder);
        taken_in(entries, read.damaged);
    }
    project_with_changes(written, version, sha256, &read, folder)
}

/// Returns the project with these rows, and with the changes of its journal if the file has this
/// hash.
fn project_with_changes(
    written: Rows,
    version: u32,
    sha256: &str,
    journal: &Read,
    folder: &Path,
) -> Result<Project, ProjectError> {
    match unsaved(journal, sha256) {
        Some((entries, entry_version)) if !entries.is_empty() => {
            replayed(written, version, entries, entry_version, folder)
        }
        _ => rows::read(migrate(written, version, VERSION), folder),
    }
}

/// Returns the project with the changes applied again. The rows are converted to the layout of the
/// changes first.
fn replayed(
    written: Rows,
    version: u32,
    entries: &[Entry],
    entry_version: u32,
    folder: &Path,
) -> Result<Project, ProjectError> {
    if entry_version > VERSION {
        return Err(ProjectError::Newer { version: entry_version });
    }
    let mut rows = migrate(written, version, entry_version);
    for entry in entries {
        entry.replay(&mut rows);
    }
    rows::read(migrate(rows, entry_version, VERSION), folder)
}

/// Returns notes on the changes that were recovered from the journal.
fn taken_in(entries: &[Entry], damaged: usize) -> Vec<String> {
    let mut labels = entries.iter().filter_map(|entry| match entry {
        Entry::Done { label, .. } => Some(label.as_str()),
        _ => None,
    });
    let count = labels.clone().count();
    let last = labels.next_back().unwrap_or_default();
    let changes = if count == 1 { "change" } else { "changes" };
    let mut notes = vec![format!(
        "{count} {changes} that were not saved when the project was last open were taken in; the last was: {last}"
    )];
    if damaged > 0 {
        notes.push(format!("{damaged} more could not be read and are lost"));
    }
    notes
}

/// Renames a journal that cannot be used, and returns a sentence about it.
fn aside(path: &Path, journal: ProjectJournal, why: &str) -> Result<String, StoreError> {
    drop(journal);
    let kept = export::rename_older(&beside(path, JOURNAL))
        .map_err(|error| not_writable(path)(error.source))?;
    Ok(format!(
        "The changes that were not saved when the project was last open {why}; they are kept as {}",
        kept.display()
    ))
}

fn lock(path: &Path) -> Result<(ProjectJournal, Read), StoreError> {
    let what = |error| match error {
        NoJournal::Taken(owner) => StoreFault::Taken(owner),
        NoJournal::Io(error) => StoreFault::NotWritable(error),
    };
    let opened = ProjectJournal::open(&beside(path, JOURNAL));
    opened.map_err(|error| StoreError::new(what(error), path))
}

/// Returns the folder of a file, absolute.
pub(super) fn folder_of(path: &Path) -> PathBuf {
    // In the same form as the paths of logs, so that relative paths are short.
    let path = paths::placed(path);
    path.parent().map(Path::to_owned).unwrap_or_default()
}

/// Returns the text of a project's file and its hash.
fn text_of(path: &Path) -> Result<(String, String), StoreError> {
    let fail = StoreError::at(path);
    let bytes =
        regular_file::read(path, text::LONGEST).map_err(|error| fail(StoreFault::Read(error)))?;
    let sha256 = in_hexadecimal(&Sha256::digest(&bytes));
    let text = String::from_utf8(bytes).map_err(|error| {
        let good = &error.as_bytes()[..error.utf8_error().valid_up_to()];
        let line = good.iter().filter(|byte| **byte == b'\n').count() + 1;
        let what = ProjectError::line(line, "this is no text in UTF-8");
        fail(StoreFault::Text(what))
    })?;
    Ok((text, sha256))
}

/// Syncs the new name of a file to the disk.
fn sync_folder(folder: &Path) {
    // Not every system can open folders; the content of the file is synced in any case.
    if let Ok(folder) = File::open(folder) {
        folder.sync_all().ok();
    }
}
