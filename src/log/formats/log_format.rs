//! Trait of the readers of formats: each recognises a recording by content, and reads it. A reader
//! is given a source of files, the disk or memory, and the part of the log that is to be read.

use super::{OpenError, Opened};
use crate::support::mapped_file::MappedFile;
use crate::support::progress::Progress;
use crate::survey::{Bytes, Seam, Survey};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Reads the recording that was recognised.
pub(super) type ReadRecording =
    Box<dyn FnOnce(&Reading<'_>, &Progress) -> Result<Survey, OpenError>>;

/// A format of recorders' logs. Its row in [`super::table::FORMATS`] names it.
pub(super) trait LogFormat: Sync {
    /// Recognises a file by its content, never by its name alone. A format of several files looks
    /// for the others beside it in `files`. `None` when the file is of another format: this says
    /// nothing of damage.
    fn recognise(&self, files: &FileSource, opened: &Opened) -> Option<ReadRecording>;

    /// Recognises the recording in a folder, or the first of several; of use only to formats of
    /// several files.
    fn recognise_folder(&self, _files: &FileSource, _folder: &Path) -> Option<ReadRecording> {
        None
    }

    /// Returns true if all files in a folder are parts of one recording, so that the folder is
    /// opened in their place.
    fn is_recording(&self, _files: &FileSource, _folder: &Path) -> bool {
        false
    }

    /// Returns true if a file is only read where it is named, and not where it lies in a folder of
    /// logs: tables of other kinds look the same, or another file of the recording stands for it.
    fn is_read_by_name_only(&self, _path: &Path) -> bool {
        false
    }
}

/// Part of a log that is read: all of it, or the records added to a log that is known. The default
/// one is all of a log that is whole.
#[derive(Clone, Copy, Default)]
pub(super) struct Reading<'a> {
    /// More of it is being written: a record that is cut at its end comes later and is no damage.
    pub(super) is_growing: bool,
    /// The log as it was read before, and from where on it is read now.
    pub(super) tail: Option<(&'a Survey, &'a Seam)>,
}

impl<'a> Reading<'a> {
    /// The log as it was read before; `None` where all of it is read.
    pub(super) fn known(&self) -> Option<&'a Survey> {
        self.tail.map(|(known, _)| known)
    }

    /// Bytes of a file before which nothing is read; `None` where all of it is.
    pub(super) fn from(&self, file: usize) -> Option<usize> {
        let (_, seam) = self.tail?;
        let from = seam.from.get(file).copied().unwrap_or(0);
        usize::try_from(from).ok().filter(|from| *from > 0)
    }

    /// Returns for each file the number of bytes whose records were counted before.
    pub(super) fn counted_to(&self) -> Vec<u64> {
        let bytes = self.tail.map(|(known, _)| known.bytes.iter());
        let lengths = bytes.into_iter().flatten().map(|file| file.len() as u64);
        lengths.collect()
    }
}

/// Source of a log and its sidecar files: reads files and lists folders. Files in memory are those
/// of tests and of the demo survey.
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
