//! Defines the trait of the readers of formats, which recognise a recording by its content and read
//! it, and the two inputs of a reader: a source of files, disk or memory, and the part of the log
//! to read.

use super::{OpenError, Opened};
use crate::support::mapped_file::MappedFile;
use crate::support::progress::Progress;
use crate::survey::{Bytes, Seam, Survey};
use std::io;
use std::path::{Path, PathBuf};

/// Function that reads a recording after it was recognised.
pub(super) type ReadRecording =
    Box<dyn FnOnce(&Reading<'_>, &Progress) -> Result<Survey, OpenError>>;

/// Format of recorders' logs that can be read. The row in [`super::table::FORMATS`] has its name.
pub(super) trait LogFormat: Sync {
    /// Recognises a file by its content, never by its name alone. A format of several files
    /// searches for the other files in `files`. `None` where the file is of another format, whether
    /// damaged or not.
    fn recognise(&self, files: &FileSource, opened: &Opened) -> Option<ReadRecording>;

    /// Recognises the recording in a folder, or the first of several; only needed for formats of
    /// several files.
    fn recognise_folder(&self, _files: &FileSource, _folder: &Path) -> Option<ReadRecording> {
        None
    }

    /// Returns true if all files in a folder are parts of one recording, so that the folder is
    /// opened instead of its files.
    fn is_recording(&self, _files: &FileSource, _folder: &Path) -> bool {
        false
    }

    /// Returns true if a file is only read where the user names it, and not as part of a folder of
    /// logs: tables with other content look the same, or another file of the recording is opened
    /// instead.
    fn is_read_by_name_only(&self, _path: &Path) -> bool {
        false
    }
}

/// Part of a log to read: the whole log, or the records that were added to a known log. The default
/// is the whole of a finished log.
#[derive(Clone, Copy, Default)]
pub(super) struct Reading<'a> {
    /// True if the log is still being written: a truncated last record is then no damage.
    pub(super) is_growing: bool,
    /// The log as read before, and the offsets from which it is read now; `None` to read all of it.
    pub(super) tail: Option<(&'a Survey, &'a Seam)>,
}

impl<'a> Reading<'a> {
    /// Returns the log as read before; `None` where all of it is read.
    pub(super) fn known(&self) -> Option<&'a Survey> {
        self.tail.map(|(known, _)| known)
    }

    /// Returns the offset in a file from which it is read; `None` where the whole file is read.
    pub(super) fn from(&self, file: usize) -> Option<usize> {
        let (_, seam) = self.tail?;
        let from = seam.from.get(file).copied().unwrap_or(0);
        usize::try_from(from).ok().filter(|from| *from > 0)
    }

    /// Returns, for each file, the number of bytes whose records were already counted.
    pub(super) fn counted_to(&self) -> Vec<u64> {
        let bytes = self.tail.map(|(known, _)| known.bytes.iter());
        let lengths = bytes.into_iter().flatten().map(|file| file.len() as u64);
        lengths.collect()
    }
}

/// Source of a log and its sidecar files: reads files and lists folders. Files in memory are used
/// by tests and the demo survey.
pub(super) enum FileSource {
    /// The file system; files are memory-mapped.
    Disk,
    /// Files in memory, with their paths.
    Held(Vec<(PathBuf, Bytes)>),
}

impl FileSource {
    /// Returns the bytes of a file.
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

    /// Returns the bytes of a file for a short use, such as recognition.
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

    /// Returns the files and folders in a folder, sorted by name; none where it cannot be read.
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

/// Returns the folder, or `.` for the empty path, which is the parent of a bare file name and
/// cannot be listed.
fn folder_or_here(folder: &Path) -> &Path {
    if folder.as_os_str().is_empty() { Path::new(".") } else { folder }
}

/// Returns true if a file's name has this ending, in upper or lower case.
pub(super) fn has_ending(path: &Path, ending: &str) -> bool {
    path.extension().is_some_and(|own| own.eq_ignore_ascii_case(ending))
}
