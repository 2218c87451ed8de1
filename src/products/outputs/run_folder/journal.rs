//! Stores the work that remains when all files of a run are written.

use crate::export::{ExportError, write_atomically};
use crate::file_in_use::patiently;
use serde::{Deserialize, Serialize};
use std::fs;
use std::io::{self, Write as _};
use std::path::{Component, Path};

/// Renames and removals that put a run in place. The work can be started again after an
/// interruption at any of them.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct Journal {
    /// Manifests of the earlier run, which are removed before anything else.
    #[serde(default)]
    pub first: Vec<String>,
    /// Files that move from the side folder into the folder.
    pub files: Vec<String>,
    /// Files of the earlier run that are removed and not replaced.
    pub remove: Vec<String>,
    /// The file that is moved last; `None` where no manifest changes.
    pub manifest: Option<String>,
}

impl Journal {
    /// Reads a journal; `None` where there is none, it is incomplete, or a name leads out of the
    /// folder.
    pub(super) fn read(path: &Path) -> Option<Self> {
        let journal: Self = serde_json::from_slice(&fs::read(path).ok()?).ok()?;
        let Self { first, files, remove, manifest } = &journal;
        let mut names = first.iter().chain(files).chain(remove).chain(manifest);
        names.all(|name| is_plain(name)).then_some(journal)
    }

    pub(super) fn write(&self, path: &Path) -> Result<(), ExportError> {
        write_atomically(path, |mut file| file.write_all(&serde_json::to_vec(self)?))
    }

    /// Does the remaining work, and removes the journal.
    pub(super) fn finish(&self, new: &Path, folder: &Path) -> io::Result<()> {
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
            Some(side) => remove(&side.join(super::JOURNAL)),
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
pub(super) fn is_plain(name: &str) -> bool {
    let mut parts = Path::new(name).components();
    let plain = parts.by_ref().take(3).all(|part| matches!(part, Component::Normal(_)));
    plain && !name.is_empty() && parts.next().is_none() && !name.contains('\\')
}
