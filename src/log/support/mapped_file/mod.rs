//! Maps files for reading that may be cut, overwritten, or removed with their card or network disk
//! while they are mapped. This module depends on `regular_file` alone.
//!
//! When a page of a map cannot be read any more, the system sends SIGBUS, which ends a program. On
//! Unix `registry` lists all maps, and `fault` replaces such a page by zeros: the program goes on,
//! and [`MappedFile::lost`] returns where the lost bytes begin. `state` checks whether the file is
//! still the one that was mapped.
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
#[cfg(unix)]
mod registry;
#[cfg(any(windows, test))]
mod removable;
mod state;
#[cfg(test)]
mod tests;

pub use state::FileFault;

use super::regular_file;
use state::FileState;
use std::fmt;
use std::fs::File;
use std::io;
use std::ops::Deref;
use std::path::Path;

/// The bytes of a mapped file, read from the disk when they are accessed.
pub struct MappedFile {
    /// Entry of the map in the registry. Declared before `map`, so that it is dropped first, while
    /// the addresses still belong to the map.
    #[cfg(unix)]
    registered: registry::Registered,
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
            registered: registry::Registered::new(map.as_ptr().addr(), length),
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
