//! The files of a run appear in their folder together.
//!
//! A run writes into a side folder within its folder, so that a run that fails, is cancelled or is
//! killed leaves the files of the run before as they were. When all are written, a journal that
//! names them is put beside them; from then on the run is decided, and what is left are renames:
//! the old manifest goes first, the new one comes last, so that a folder with a manifest is whole.
//! A run that is killed among these renames is finished by the next one into the same folder.
//!
//! What an earlier run wrote and this one does not is removed, as long as nobody has changed it
//! since: a folder holds the files of one run. Files that no manifest names are the user's own and
//! stay.

mod earlier;
mod journal;

use crate::export::{earlier_chips, make_folder, remove_passing_chips};
use crate::file_in_use::{for_one_writer, is_held, is_in_use};
use crate::outputs::OutputError;
use crate::pipeline::Fingerprint;
use bathyscope_log::support::progress::Progress;
use earlier::EarlierFiles;
pub(super) use earlier::{has_foreign_manifest, is_stem_of_output};
use journal::Journal;
use std::fs::{self, File, TryLockError};
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};

/// The side folder. One name for all runs: whoever comes next finds what the one before left.
const SIDE: &str = ".bathyscope-run";
/// Subfolder of [`SIDE`] with the unfinished files.
const NEW: &str = "new";
/// File in [`SIDE`] that the active run keeps locked.
const LOCK: &str = "lock";
/// File in [`SIDE`] that lists the renames and removals to do. Where it exists, the run is decided.
const JOURNAL: &str = "commit.json";
/// Files that named what belongs to a run before there was a manifest beside the report. At most
/// one of them is in a folder.
pub(super) const EARLIER_MANIFESTS: [&str; 2] = ["report.json", "merged.json"];
/// The folder of what a search for objects proposes.
const OBJECTS: &str = "objects/";

/// Files of an earlier run that the new run did not write again.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Replaced {
    /// Files that were removed.
    pub removed: Vec<String>,
    /// Files that are still there: somebody has changed them, or no manifest names them.
    pub kept: Vec<String>,
}

impl Replaced {
    /// Lists these files, to be added to a sentence about the written files; empty where there are
    /// none.
    pub fn in_words(&self) -> String {
        let parts = [
            ("removed of an earlier run", &self.removed),
            ("left from before, not of this run", &self.kept),
        ];
        let there = parts.iter().filter(|(_, names)| !names.is_empty());
        let part = |(what, names): &(&str, &Vec<String>)| format!("; {what}: {}", names.join(", "));
        there.map(part).collect()
    }
}

/// A folder that a run writes into. Dropped before [`RunFolder::commit`], it leaves the folder as
/// it was.
#[derive(Debug)]
pub struct RunFolder {
    folder: PathBuf,
    /// True if the folder was made for this run.
    is_ours: bool,
    lock: Option<File>,
}

impl RunFolder {
    /// Makes the folder when it is missing, finishes or clears away what a killed run left in it,
    /// and keeps other runs out.
    ///
    /// # Errors
    /// A sentence when the folder cannot be written into, or another run writes into it at this
    /// moment.
    pub fn begin(folder: &Path) -> Result<Self, OutputError> {
        let is_ours = !folder.exists();
        let fail = |error: io::Error| {
            format!("cannot write into the folder: {error}: {}", folder.display())
        };
        make_folder(folder)?;
        let lock = take_lock(folder).map_err(fail)?.ok_or_else(|| {
            format!(
                "another run of bathyscope is writing into this folder; wait for it, or choose another folder: {}",
                folder.display()
            )
        })?;
        let run = Self { folder: folder.to_path_buf(), is_ours, lock: Some(lock) };
        let side = folder.join(SIDE);
        if let Some(journal) = Journal::read(&side.join(JOURNAL)) {
            journal.finish(&side.join(NEW), folder).map_err(fail)?;
        }
        // A journal that is not for this folder is not followed.
        empty(&side).map_err(fail)?;
        earlier::remove_parts(folder);
        remove_passing_chips(folder);
        fs::create_dir(run.path()).map_err(fail)?;
        Ok(run)
    }

    /// Returns the folder into which the run writes its files.
    pub fn path(&self) -> PathBuf {
        self.folder.join(SIDE).join(NEW)
    }

    /// Returns the folder to which the files move in the end.
    pub(crate) fn destination(&self) -> &Path {
        &self.folder
    }

    /// Returns the final path of a file of the run, with the separators of the system: names have
    /// `/` on every system.
    fn destination_of(&self, name: &Path) -> PathBuf {
        self.folder.join(name).components().collect()
    }

    /// The files written so far, by name; those that are `known` are not read again.
    ///
    /// # Errors
    /// A sentence when one cannot be read, or the work was cancelled.
    pub fn files(
        &self,
        known: &[Fingerprint],
        progress: &Progress,
    ) -> Result<Vec<Fingerprint>, OutputError> {
        let new = self.path();
        let read = |file: String| match known.iter().find(|one| one.file == file) {
            Some(known) => Ok(known.clone()),
            None => Fingerprint::of(&new, &file, progress)
                .map_err(|error| OutputError::from(format!("{error}: {file}"))),
        };
        let names = names_in(&new)?;
        names.into_iter().map(read).collect()
    }

    /// Puts the files of a whole run in the place of those of the run before, `manifest` among
    /// them, and gives back what became of files of the earlier run that have no successor.
    ///
    /// # Errors
    /// A sentence when something is in the way; then the folder is as it was, or the next run
    /// finishes the job.
    pub(crate) fn commit(self, manifest: &str) -> Result<Replaced, OutputError> {
        self.swap(Some(manifest), |_| true)
    }

    /// Puts files in place that belong to no run, in a folder that may hold a run: the manifest
    /// there no longer names them. `group` tells which files they are and those that they take the
    /// place of.
    ///
    /// # Errors
    /// As [`RunFolder::commit`].
    pub(crate) fn commit_group(
        self,
        group: impl Fn(&str) -> bool,
    ) -> Result<Replaced, OutputError> {
        let manifest = earlier::without_group(&self.folder, &self.path(), &group)?;
        self.swap(manifest, group)
    }

    fn swap(
        mut self,
        manifest: Option<&str>,
        is_of_ours: impl Fn(&str) -> bool,
    ) -> Result<Replaced, OutputError> {
        let new = self.path();
        let fail = |error: io::Error| {
            format!("cannot put the files in place: {error}: {}", self.folder.display())
        };
        let mut files = names_in(&new).map_err(fail)?;
        let goes = |name: &str| is_of_ours(name) && !files.iter().any(|file| file == name);
        let EarlierFiles { unchanged: mut remove, changed: kept } =
            earlier::files(&self.folder, goes);
        // Of a version without subfolders, pictures lie on top.
        for (of, replaced) in [(OBJECTS, Some(new.join(OBJECTS))), ("", None)] {
            let chips = earlier_chips(&self.folder, of, replaced.as_deref(), &remove);
            remove.extend(chips);
        }
        remove.retain(|name| !files.contains(name));
        remove.sort_unstable();
        remove.dedup();
        self.refuse_in_the_way(&files)?;
        self.refuse_held(files.iter().chain(&remove))?;
        files.retain(|name| Some(name.as_str()) != manifest);
        let journal = Journal {
            first: match manifest {
                Some(_) => earlier::manifest_names(&self.folder),
                None => Vec::new(),
            },
            files,
            remove,
            manifest: manifest.map(str::to_owned),
        };
        let side = self.folder.join(SIDE);
        journal.write(&side.join(JOURNAL))?;
        journal.finish(&new, &self.folder).map_err(fail)?;
        self.is_ours = false;
        self.clear();
        let mut removed = journal.remove;
        let all: Vec<String> = removed.iter().chain(&kept).cloned().collect();
        // What belongs to a file goes with it unsaid: its record in versions that had such, and the
        // pictures of a folder.
        let is_record = |name: &str| {
            name.strip_suffix(".json").is_some_and(|of| all.iter().any(|one| one == of))
        };
        removed.retain(|name| !is_record(name) && !name.contains("chips/"));
        Ok(Replaced { removed, kept })
    }

    /// Refuses to write where a folder has the name of a file, or a file that of a folder.
    fn refuse_in_the_way(&self, files: &[String]) -> Result<(), OutputError> {
        let named = |what: &str, name: &Path| {
            let path = self.destination_of(name);
            let sentence = format!("{what} that is to be written; rename it: {}", path.display());
            Err(OutputError::from(sentence))
        };
        for name in files {
            let name = Path::new(name);
            if self.folder.join(name).is_dir() {
                return named("a folder has the name of a file", name);
            }
            let mut folders =
                name.ancestors().skip(1).filter(|inner| !inner.as_os_str().is_empty());
            if let Some(inner) = folders.find(|inner| {
                let there = self.folder.join(inner);
                there.symlink_metadata().is_ok() && !there.is_dir()
            }) {
                return named("a file has the name of a folder", inner);
            }
        }
        Ok(())
    }

    /// Refuses to replace or remove a file that another program holds open on Windows, while the
    /// folder is as it was.
    fn refuse_held<'a>(&self, names: impl Iterator<Item = &'a String>) -> Result<(), OutputError> {
        let mut paths = names.map(|name| self.destination_of(Path::new(name)));
        match paths.find(|path| is_held(path)) {
            Some(path) => Err(format!(
                "another program has a file open that is to be replaced, so nothing was; close it there, or choose another folder: {}",
                path.display()
            )
            .into()),
            None => Ok(()),
        }
    }

    /// Removes the side folder; best effort, for the next run does so too.
    fn clear(&mut self) {
        let Some(lock) = self.lock.take() else {
            return;
        };
        let side = self.folder.join(SIDE);
        if side.join(JOURNAL).exists() {
            // Decided, but not done: the next run needs what is here.
            return;
        }
        empty(&side).ok();
        // While it is held, so that nobody else can be working in there; on Windows only what
        // nobody has open can be removed.
        let lock = (!cfg!(windows)).then_some(lock);
        fs::remove_file(side.join(LOCK)).ok();
        fs::remove_dir(&side).ok();
        drop(lock);
        if self.is_ours {
            fs::remove_dir(&self.folder).ok();
        }
    }
}

impl Drop for RunFolder {
    fn drop(&mut self) {
        self.clear();
    }
}

/// Locks the side folder, which is made when it is missing; `None` when another run holds it.
fn take_lock(folder: &Path) -> io::Result<Option<File>> {
    let side = folder.join(SIDE);
    let path = side.join(LOCK);
    for attempt in 0..8 {
        match fs::create_dir(&side) {
            Err(error) if error.kind() != io::ErrorKind::AlreadyExists => return Err(error),
            _ => {}
        }
        // Whoever may write here could lead us elsewhere by a link.
        if !fs::symlink_metadata(&side)?.is_dir() {
            return Err(io::Error::other(format!("`{SIDE}` in it is no folder")));
        }
        let mut options = File::options();
        options.read(true).write(true).create(true).truncate(false);
        for_one_writer(&mut options);
        let mut lock = match options.open(&path) {
            Ok(lock) => lock,
            Err(error) if is_in_use(&error) => return Ok(None),
            // The run before has just removed the side folder.
            Err(error) if error.kind() == io::ErrorKind::NotFound => continue,
            Err(error) => return Err(error),
        };
        // Some network drives know no locks: better to write without than not at all.
        if !cfg!(windows) && matches!(lock.try_lock(), Err(TryLockError::WouldBlock)) {
            return Ok(None);
        }
        // Locked may be a file that the run before has removed meanwhile: then the one at the path
        // is another.
        let token = format!("{} {attempt}\n", std::process::id());
        lock.set_len(0)?;
        lock.write_all(token.as_bytes())?;
        if fs::read_to_string(&path).is_ok_and(|read| read == token) {
            return Ok(Some(lock));
        }
    }
    Ok(None)
}

/// Removes all that is in a side folder but the lock.
fn empty(side: &Path) -> io::Result<()> {
    for entry in fs::read_dir(side)? {
        let entry = entry?;
        if entry.file_type()?.is_dir() {
            fs::remove_dir_all(entry.path())?;
        } else if entry.file_name() != LOCK {
            fs::remove_file(entry.path())?;
        }
    }
    Ok(())
}

/// The files of a folder and of the folders in it, by name.
fn names_in(folder: &Path) -> io::Result<Vec<String>> {
    let mut names = Vec::new();
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        let name = entry.file_name().to_string_lossy().into_owned();
        if entry.file_type()?.is_dir() {
            let inner = names_in(&entry.path())?.into_iter();
            names.extend(inner.map(|file| format!("{name}/{file}")));
        } else {
            names.push(name)
        }
    }
    names.sort_unstable();
    Ok(names)
}

#[cfg(test)]
mod tests;
