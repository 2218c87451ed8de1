//! Source of a log and its sidecar files: the disk, or memory (tests, the demo survey).

use crate::support::mapped_file::MappedFile;
use crate::survey::Bytes;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Reads files and lists folders.
pub(super) enum FileSource {
    /// The file system; files are mapped.
    Disk,
    /// Files in memory, under the paths given.
    Held(Vec<(PathBuf, Bytes)>),
}

impl FileSource {
    /// Files in memory.
    pub(super) fn held(files: Vec<(PathBuf, Vec<u8>)>) -> Self {
        let hold = |(path, bytes): (PathBuf, Vec<u8>)| (path, Bytes::Held(Arc::from(bytes)));
        Self::Held(files.into_iter().map(hold).collect())
    }

    /// Files whose bytes are at hand.
    pub(super) fn at_hand(files: Vec<(PathBuf, Bytes)>) -> Self {
        Self::Held(files)
    }

    /// The bytes of a file.
    pub(super) fn read(&self, path: &Path) -> io::Result<Bytes> {
        match self {
            FileSource::Disk => MappedFile::open(path).map(Bytes::from),
            FileSource::Held(files) => files
                .iter()
                .find(|(name, _)| name == path)
                .map(|(_, bytes)| bytes.clone())
                .ok_or_else(|| io::Error::from(io::ErrorKind::NotFound)),
        }
    }

    /// The bytes of a file, to recognise it and put them away.
    pub(super) fn look_at(&self, path: &Path) -> io::Result<Bytes> {
        match self {
            FileSource::Disk => MappedFile::open_briefly(path).map(Bytes::from),
            FileSource::Held(_) => self.read(path),
        }
    }

    /// Returns true if the path is a folder.
    pub(super) fn is_folder(&self, path: &Path) -> bool {
        match self {
            FileSource::Disk => path.is_dir(),
            FileSource::Held(files) => {
                files.iter().any(|(name, _)| name != path && name.starts_with(path))
            }
        }
    }

    /// The files and folders in a folder, by name; none when it cannot be read.
    pub(super) fn children(&self, folder: &Path) -> Vec<PathBuf> {
        let mut children: Vec<PathBuf> = match self {
            FileSource::Disk => std::fs::read_dir(folder_or_here(folder))
                .map(|entries| entries.flatten().map(|entry| entry.path()).collect())
                .unwrap_or_default(),
            FileSource::Held(files) => files
                .iter()
                .filter_map(|(name, _)| {
                    let below = name.strip_prefix(folder).ok()?;
                    Some(folder.join(below.components().next()?))
                })
                .collect(),
        };
        children.sort();
        children.dedup();
        children
    }
}

/// The parent of a bare file name is the empty path, which no system lists.
fn folder_or_here(folder: &Path) -> &Path {
    if folder.as_os_str().is_empty() { Path::new(".") } else { folder }
}
