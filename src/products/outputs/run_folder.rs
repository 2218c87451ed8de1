//! Puts the files of a run into their folder together.
//!
//! A run writes into a side folder within its folder, so that a run that fails, is cancelled or is
//! killed leaves the files of the earlier run unchanged. When all files are written, a journal with
//! their names is put beside them. From then on the run is complete except for renames: the old
//! manifest is removed first, the new one is put in place last, so that a folder with a manifest is
//! consistent. If a run is killed among these renames, the next run into the same folder or the
//! next reader of its files finishes them.
//!
//! Files that an earlier run wrote and the new one did not are removed, unless a person has changed
//! them since: a folder holds the files of one run. Files that no manifest lists belong to the user
//! and stay.

mod earlier;

use crate::Error;
use crate::export::{
    ExportError, earlier_chips, make_folder, remove_passing_chips, write_atomically,
};
use crate::file_in_use::{for_one_writer, is_held, is_in_use, patiently};
use crate::pipeline::Fingerprint;
use bathyscope_log::support::progress::Progress;
use earlier::EarlierFiles;
pub(super) use earlier::{has_foreign_manifest, is_stem_of_output, read_manifest};
use serde::{Deserialize, Serialize};
use std::fs::{self, File, TryLockError};
use std::io::{self, Write as _};
use std::path::{Component, Path, PathBuf};

/// Name of the side folder. It is the same for all runs, so that the next run finds the remains of
/// a killed one.
const SIDE: &str = ".bathyscope-run";
/// Subfolder of [`SIDE`] with the unfinished files.
const NEW: &str = "new";
/// File in [`SIDE`] that the active run keeps locked.
const LOCK: &str = "lock";
/// File in [`SIDE`] that lists the renames and removals to do. If it exists, the files of the run
/// are complete.
const JOURNAL: &str = "commit.json";
/// Files that listed the files of a run in versions without a separate manifest. A folder has at
/// most one of them.
pub(super) const EARLIER_MANIFESTS: [&str; 2] = ["report.json", "merged.json"];
/// Folder of the objects that a search proposes.
const OBJECTS: &str = "objects/";

/// Files of an earlier run that the new run did not write again.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Replaced {
    /// Files that were removed.
    pub removed: Vec<String>,
    /// Files that are still there, because a person has changed them or no manifest lists them.
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

/// A folder that a run writes into. If it is dropped before [`RunFolder::commit`], the files in the
/// folder stay unchanged.
#[derive(Debug)]
pub struct RunFolder {
    folder: PathBuf,
    /// True if the folder was made for this run.
    is_ours: bool,
    lock: Option<File>,
}

impl RunFolder {
    /// Makes the folder if it is missing, finishes or removes the remains of a killed run in it,
    /// and locks it against other runs.
    ///
    /// # Errors
    /// When the folder cannot be written into, or another run is writing into it.
    pub fn begin(folder: &Path) -> Result<Self, Error> {
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
        // A journal that is not valid is ignored and removed.
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

    /// Returns the folder into which the files are moved in the end.
    pub(crate) fn destination(&self) -> &Path {
        &self.folder
    }

    /// Returns the final path of a file of the run, with the separators of the system: names have
    /// `/` on every system.
    fn destination_of(&self, name: &Path) -> PathBuf {
        self.folder.join(name).components().collect()
    }

    /// Returns the files written so far, by name; the fingerprints of `known` files are not
    /// computed again.
    ///
    /// # Errors
    /// When a file cannot be read, or the work was cancelled.
    pub fn files(
        &self,
        known: &[Fingerprint],
        progress: &Progress,
    ) -> Result<Vec<Fingerprint>, Error> {
        let new = self.path();
        let read = |file: String| match known.iter().find(|fingerprint| fingerprint.file == file) {
            Some(known) => Ok(known.clone()),
            None => Fingerprint::of(&new, &file, progress)
                .map_err(|error| Error::from(format!("{error}: {file}"))),
        };
        let names = names_in(&new)?;
        names.into_iter().map(read).collect()
    }

    /// Puts the files of a whole run, `manifest` among them, in the place of those of the earlier
    /// run. Returns the files of the earlier run that have no successor, removed or kept.
    ///
    /// # Errors
    /// When something is in the way. The folder is then unchanged, or the next run finishes the
    /// renames.
    pub(crate) fn commit(self, manifest: &str) -> Result<Replaced, Error> {
        self.swap(Some(manifest), |_| true)
    }

    /// Puts files that belong to no run into a folder that may hold a run. The manifest there no
    /// longer lists them. `group` returns true for these files and for those that they replace.
    ///
    /// # Errors
    /// As [`RunFolder::commit`].
    pub(crate) fn commit_group(self, group: impl Fn(&str) -> bool) -> Result<Replaced, Error> {
        let manifest = earlier::without_group(&self.folder, &self.path(), &group)?;
        self.swap(manifest, group)
    }

    fn swap(
        mut self,
        manifest: Option<&str>,
        is_of_ours: impl Fn(&str) -> bool,
    ) -> Result<Replaced, Error> {
        let new = self.path();
        let fail = |error: io::Error| {
            format!("cannot put the files in place: {error}: {}", self.folder.display())
        };
        let mut files = names_in(&new).map_err(fail)?;
        let goes = |name: &str| is_of_ours(name) && !files.iter().any(|file| file == name);
        let EarlierFiles { unchanged: mut remove, changed: kept } =
            earlier::files(&self.folder, goes);
        // In versions without subfolders, the pictures are in the folder itself.
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
        // Files that belong to another file are not reported: the record of a file in versions with
        // such records, and the pictures of a folder.
        let is_record = |name: &str| {
            name.strip_suffix(".json").is_some_and(|of| all.iter().any(|other| other == of))
        };
        removed.retain(|name| !is_record(name) && !name.contains("chips/"));
        Ok(Replaced { removed, kept })
    }

    /// Refuses to write where a folder has the name of a file to be written, or a file has the name
    /// of a folder.
    fn refuse_in_the_way(&self, files: &[String]) -> Result<(), Error> {
        let named = |what: &str, name: &Path| {
            let path = self.destination_of(name);
            let sentence = format!("{what} that is to be written; rename it: {}", path.display());
            Err(Error::from(sentence))
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

    /// Refuses to replace or remove a file that another program holds open on Windows, as long as
    /// the folder is unchanged.
    fn refuse_held<'a>(&self, names: impl Iterator<Item = &'a String>) -> Result<(), Error> {
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

    /// Removes the side folder; best effort, because the next run does so too.
    fn clear(&mut self) {
        let Some(lock) = self.lock.take() else {
            return;
        };
        let side = self.folder.join(SIDE);
        if side.join(JOURNAL).exists() {
            // The renames are not finished: the next run needs the files here.
            return;
        }
        empty(&side).ok();
        // The lock is held meanwhile, so that no other run can work in the folder; on Windows only
        // closed files can be removed.
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

/// Renames and removals that put a run in place. The work can be started again after an
/// interruption at any of them.
#[derive(Debug, Serialize, Deserialize)]
struct Journal {
    /// Manifests of the earlier run, which are removed before anything else.
    #[serde(default)]
    first: Vec<String>,
    /// Files that move from the side folder into the folder.
    files: Vec<String>,
    /// Files of the earlier run that are removed and not replaced.
    remove: Vec<String>,
    /// The file that is moved last; `None` where no manifest changes.
    manifest: Option<String>,
}

impl Journal {
    /// Reads a journal; `None` where there is none, it is incomplete, or a name leads out of the
    /// folder.
    fn read(path: &Path) -> Option<Self> {
        let journal: Self = serde_json::from_slice(&fs::read(path).ok()?).ok()?;
        let Self { first, files, remove, manifest } = &journal;
        let mut names = first.iter().chain(files).chain(remove).chain(manifest);
        names.all(|name| is_plain(name)).then_some(journal)
    }

    fn write(&self, path: &Path) -> Result<(), ExportError> {
        write_atomically(path, |mut file| file.write_all(&serde_json::to_vec(self)?))
    }

    /// Does the remaining work, and removes the journal.
    fn finish(&self, new: &Path, folder: &Path) -> io::Result<()> {
        let whole = (self.manifest.as_ref()).is_some_and(|name| !new.join(name).exists());
        // If the manifest is in place, everything else is too.
        if !whole {
            for name in &self.first {
                // A file of the new run may have the name of an earlier version's manifest.
                let is_in_place = self.files.contains(name) && !new.join(name).exists();
                if !is_in_place {
                    remove(&folder.join(name))?;
                }
            }
            for name in &self.files {
                move_into_place(new, folder, name)?;
            }
            for name in &self.remove {
                remove(&folder.join(name))?;
                for inner in Path::new(name).ancestors().skip(1) {
                    if !inner.as_os_str().is_empty() {
                        // A folder that holds anything else stays.
                        fs::remove_dir(folder.join(inner)).ok();
                    }
                }
            }
            if let Some(name) = &self.manifest {
                move_into_place(new, folder, name)?;
            }
        }
        match new.parent() {
            Some(side) => remove(&side.join(JOURNAL)),
            None => Ok(()),
        }
    }
}

fn move_into_place(new: &Path, folder: &Path, name: &str) -> io::Result<()> {
    let to = folder.join(name);
    if let (true, Some(parent)) = (name.contains('/'), to.parent()) {
        fs::create_dir_all(parent)?;
    }
    if new.join(name).exists() {
        // The old file is removed first: some file systems write a file to the disk before it
        // replaces another one, which makes the renames ten times as long.
        remove(&to)?;
    }
    match patiently(|| fs::rename(new.join(name), &to)) {
        // The file was moved before the run was killed.
        Err(error) if error.kind() == io::ErrorKind::NotFound && to.exists() => Ok(()),
        moved => moved,
    }
}

fn remove(path: &Path) -> io::Result<()> {
    match patiently(|| fs::remove_file(path)) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => Err(error),
        _ => Ok(()),
    }
}

/// Returns true if a name from a file stays within the folder: a file, or a file in a subfolder, at
/// most two folders deep.
fn is_plain(name: &str) -> bool {
    let mut parts = Path::new(name).components();
    let plain = parts.by_ref().take(3).all(|part| matches!(part, Component::Normal(_)));
    plain && !name.is_empty() && parts.next().is_none() && !name.contains('\\')
}

/// Finishes the renames of a run that was killed among them, in the folder `path` or in the folder
/// of a run that holds the file `path`: its files are then all of one run. Does nothing where no
/// run was killed, or while another run is writing.
///
/// # Errors
/// When a file cannot be renamed or removed; the sentence names the folder.
pub fn finish_killed_run(path: &Path) -> Result<(), Error> {
    // A file of a run is at most in a subfolder.
    for folder in path.ancestors().take(3) {
        let side = folder.join(SIDE);
        let Some(journal) = Journal::read(&side.join(JOURNAL)) else {
            continue;
        };
        let fail = |error: io::Error| {
            let text =
                "a run was killed while it replaced these files, and they cannot be completed";
            format!("{text}: {error}: {}", folder.display())
        };
        let Some(lock) = take_lock(folder).map_err(fail)? else {
            return Ok(());
        };
        journal.finish(&side.join(NEW), folder).map_err(fail)?;
        drop(RunFolder { folder: folder.to_path_buf(), is_ours: false, lock: Some(lock) });
    }
    Ok(())
}

/// Locks the side folder, which is made if it is missing; `None` if another run holds the lock.
fn take_lock(folder: &Path) -> io::Result<Option<File>> {
    let side = folder.join(SIDE);
    let path = side.join(LOCK);
    for attempt in 0..8 {
        match fs::create_dir(&side) {
            Err(error) if error.kind() != io::ErrorKind::AlreadyExists => return Err(error),
            _ => {}
        }
        // A link in the place of the folder could lead to another folder.
        if !fs::symlink_metadata(&side)?.is_dir() {
            return Err(io::Error::other(format!("`{SIDE}` in it is no folder")));
        }
        let mut options = File::options();
        options.read(true).write(true).create(true).truncate(false);
        for_one_writer(&mut options);
        let mut lock = match options.open(&path) {
            Ok(lock) => lock,
            Err(error) if is_in_use(&error) => return Ok(None),
            // The earlier run has just removed the side folder.
            Err(error) if error.kind() == io::ErrorKind::NotFound => continue,
            Err(error) => return Err(error),
        };
        // Some network drives have no locks: writing without a lock is better than not at all.
        if !cfg!(windows) && matches!(lock.try_lock(), Err(TryLockError::WouldBlock)) {
            return Ok(None);
        }
        // The locked file may have been removed by the earlier run meanwhile; the file at the path
        // is then another one.
        let token = format!("{} {attempt}\n", std::process::id());
        lock.set_len(0)?;
        lock.write_all(token.as_bytes())?;
        if fs::read_to_string(&path).is_ok_and(|read| read == token) {
            return Ok(Some(lock));
        }
    }
    Ok(None)
}

/// Removes everything in a side folder except the lock.
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

/// Returns the names of the files in a folder and in its subfolders.
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
