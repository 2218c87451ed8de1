//! Maps files for reading that may be cut, overwritten, or removed with their card or network disk
//! while they are mapped. This module depends on `regular_file` alone.
//!
//! When a page of a map cannot be read any more, the system sends SIGBUS, which ends a program. On
//! Unix `fault` lists all maps and replaces such a page by zeros: the program goes on, and
//! [`MappedFile::lost`] returns where the lost bytes begin. [`MappedFile::fault`] checks whether
//! the file is still the one that was mapped.
//!
//! - A file that was deleted, or replaced by another by renaming, stays mapped as it was: the bytes
//!   are right.
//! - A file that was cut reads as zeros from the cut on; a file that was overwritten in place reads
//!   as its new bytes.
//! - On Windows no program can cut a file that is mapped. A page that is gone with its disk ends a
//!   program there, because Windows has no call that replaces the page: `removable` copies files on
//!   removable drives first.

#[cfg(unix)]
mod fault;
#[cfg(any(windows, test))]
mod removable;
#[cfg(test)]
mod tests;

use super::regular_file;
use std::fmt;
use std::fs::{self, File, Metadata};
use std::hash::{DefaultHasher, Hasher as _};
use std::io;
use std::ops::Deref;
use std::path::Path;
use std::sync::OnceLock;
use std::time::SystemTime;

/// Number of bytes before the end of the map that are compared when the file has become longer.
const COMPARED: usize = 4096;

/// The bytes of a mapped file, read from the disk when they are accessed.
pub struct MappedFile {
    /// Entry of the map in the registry. Declared before `map`, so that it is dropped first, while
    /// the addresses still belong to the map.
    #[cfg(unix)]
    registered: fault::Registered,
    map: memmap2::Mmap,
    /// State of the file when it was mapped; `None` for a file that no other program can reach.
    state: Option<FileState>,
}

impl MappedFile {
    /// Maps a whole file. On Windows a file on a removable or network drive is copied first, and
    /// the copy is mapped.
    ///
    /// # Errors
    /// The errors of [`regular_file::open`], and the system's error when the file cannot be mapped
    /// or copied.
    pub fn open(path: &Path) -> io::Result<Self> {
        #[cfg(windows)]
        if removable::may_be_taken_away(path) {
            let file = regular_file::open(path)?;
            let length = file.metadata()?.len();
            return Self::beginning(&removable::copied(&file, length)?, length);
        }
        Self::open_briefly(path)
    }

    /// Maps a whole file for a short look: no copy is made, on Windows either.
    ///
    /// # Errors
    /// The errors of [`Self::open`], without that of copying.
    pub(crate) fn open_briefly(path: &Path) -> io::Result<Self> {
        let file = regular_file::open(path)?;
        let found = file.metadata()?;
        Ok(Self { state: Some(FileState::of(&found)), ..Self::beginning(&file, found.len())? })
    }

    /// Maps the first `length` bytes of a file that belongs to this program and that others cannot
    /// change: the file may only grow behind these bytes.
    ///
    /// # Errors
    /// The system's error when the bytes cannot be mapped.
    pub(crate) fn beginning(file: &File, length: u64) -> io::Result<Self> {
        let length = usize::try_from(length).map_err(io::Error::other)?;
        #[cfg(unix)]
        fault::install();
        // SAFETY: the map is never written through, and no reference outlives it. Another program
        // may change the bytes, and `fault` may exchange them for zeros, while they are read; they
        // are only ever read as plain integers, floats and byte slices, for which every bit pattern
        // is valid, and each reader checks the values.
        #[allow(unsafe_code)]
        let map = unsafe { memmap2::MmapOptions::new().len(length).map(file)? };
        Ok(Self {
            #[cfg(unix)]
            registered: fault::Registered::new(map.as_ptr().addr(), length),
            map,
            state: None,
        })
    }

    /// Returns true if other programs can reach the file.
    pub fn is_shared(&self) -> bool {
        self.state.is_some()
    }

    /// Returns the fault of bytes that could not be read, with the offset of the first of them:
    /// from there on the bytes are zero. `None` while all could be read; always on Windows.
    pub fn lost(&self) -> Option<FileFault> {
        #[cfg(unix)]
        let from = self.registered.lost_from();
        #[cfg(not(unix))]
        let from: Option<u64> = None;
        from.map(|from| FileFault::Unreadable { from })
    }

    /// Returns the fault that makes the bytes, or the data that was read from them before, wrong;
    /// `None` while they are right. `path` names the file as it was opened. Reads the file's size
    /// and times from the disk, so the call may block on a disk that does not answer.
    pub fn fault(&self, path: &Path) -> Option<FileFault> {
        let state = self.state.as_ref();
        let changed = state.and_then(|state| state.fault(path, &self.map));
        changed.or_else(|| self.lost())
    }
}

impl Deref for MappedFile {
    type Target = [u8];

    fn deref(&self) -> &[u8] {
        &self.map
    }
}

impl fmt::Debug for MappedFile {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "MappedFile({} bytes)", self.map.len())
    }
}

/// Change of a mapped file that makes its bytes wrong, and advice on what to do.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum FileFault {
    /// The file became shorter.
    #[error(
        "the file became shorter while it was open, from {from} to {to} bytes, so results of it are wrong; open a whole copy of it"
    )]
    Shorter {
        /// Bytes of the file when it was opened.
        from: u64,
        /// Bytes of the file now.
        to: u64,
    },
    /// The file was overwritten in place.
    #[error(
        "the file was changed while it was open, so results may mix its old and new bytes; open it again when nothing writes into it"
    )]
    Changed,
    /// The disk could not read all of the file.
    #[error(
        "the file cannot be read any more at byte {from}, so results of it are wrong; put its card or disk back, or take another copy, and open it again"
    )]
    Unreadable {
        /// Offset of the first byte that was missing.
        from: u64,
    },
}

/// State of a file when it was mapped.
struct FileState {
    length: u64,
    modified: Option<SystemTime>,
    #[cfg(unix)]
    place: [u64; 2],
    /// Hash of the last mapped bytes, computed at the first comparison: computing it when the file
    /// is mapped would read the end of each file of which only the format is recognised.
    tail: OnceLock<u64>,
}

impl FileState {
    fn of(found: &Metadata) -> Self {
        Self {
            length: found.len(),
            modified: found.modified().ok(),
            #[cfg(unix)]
            place: place(found),
            tail: OnceLock::new(),
        }
    }

    /// Returns the change of the file at `path` that makes its mapped `bytes` wrong; `None` without
    /// such a change. A file that grows behind these bytes has no fault. Where the file was
    /// deleted, or another was renamed into its place, the map keeps the old file; where its disk
    /// does not answer, [`MappedFile::lost`] reports the lost bytes.
    fn fault(&self, path: &Path, bytes: &[u8]) -> Option<FileFault> {
        let now = fs::metadata(path).ok()?;
        #[cfg(unix)]
        if place(&now) != self.place {
            return None;
        }
        if now.len() < self.length {
            return Some(FileFault::Shorter { from: self.length, to: now.len() });
        }
        let known = *self.tail.get_or_init(|| hash_of_end(bytes));
        let is_changed = if now.len() == self.length {
            now.modified().ok() != self.modified
        } else {
            // A longer file may have been written over the mapped one.
            hash_of_end(bytes) != known
        };
        is_changed.then_some(FileFault::Changed)
    }
}

/// Returns the device and the inode number of a file: another file at the same path has others.
#[cfg(unix)]
fn place(found: &Metadata) -> [u64; 2] {
    use std::os::unix::fs::MetadataExt as _;
    [found.dev(), found.ino()]
}

fn hash_of_end(bytes: &[u8]) -> u64 {
    let mut hash = DefaultHasher::new();
    hash.write(&bytes[bytes.len().saturating_sub(COMPARED)..]);
    hash.finish()
}
