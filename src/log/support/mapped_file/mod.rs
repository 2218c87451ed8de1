//! A file mapped for reading that may be cut, overwritten, or taken away with its card or its
//! network disk while it is mapped. It depends on `regular_file` alone; any module may use it.
//!
//! A page of a map that the system cannot give any more makes it send SIGBUS, which ends a program.
//! On Unix `registry` knows all maps, and `fault` puts zeros in the place of such a page: the
//! program goes on, and the map says from where on bytes were lost. `state` tells whether the file
//! is still the one that was mapped.
//!
//! - A file that was deleted, or exchanged for another by renaming, stays mapped as it was: the
//!   bytes are right.
//! - A file that was cut reads as zeros from there on; one that was overwritten in its place reads
//!   as what it is now.
//! - On Windows nobody can cut a file that is mapped. A page that is gone with its disk ends a
//!   program there, for Windows has no call that puts another page in its place: `removable` makes
//!   a copy of what may be taken away.

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

/// The bytes of a file, read from the disk where they are touched.
pub struct MappedFile {
    /// Stands before the map, so that it is dropped first: the map's addresses are still its own
    /// then.
    #[cfg(unix)]
    registered: registry::Registered,
    map: memmap2::Mmap,
    /// The file as it was mapped; `None` for one that no other program can reach.
    state: Option<FileState>,
}

impl MappedFile {
    /// Maps a whole file; on Windows a copy of it where it lies on what may be taken away, which
    /// nothing can happen to then.
    ///
    /// # Errors
    /// Those of [`regular_file::open`], and what the system says of mapping or copying it.
    pub fn open(path: &Path) -> io::Result<Self> {
        #[cfg(windows)]
        if removable::may_be_taken_away(path) {
            let file = regular_file::open(path)?;
            let length = file.metadata()?.len();
            return Self::beginning(&removable::copied(&file, length)?, length);
        }
        Self::open_briefly(path)
    }

    /// Maps a whole file to look at it and close it again: no copy is made.
    ///
    /// # Errors
    /// As [`Self::open`].
    pub(crate) fn open_briefly(path: &Path) -> io::Result<Self> {
        let file = regular_file::open(path)?;
        let found = file.metadata()?;
        Ok(Self { state: Some(FileState::of(&found)), ..Self::beginning(&file, found.len())? })
    }

    /// Maps the first bytes of a file of this program's own, which others cannot change: it may
    /// only grow behind them.
    ///
    /// # Errors
    /// What the system says.
    pub(crate) fn beginning(file: &File, length: u64) -> io::Result<Self> {
        let length = usize::try_from(length).map_err(io::Error::other)?;
        #[cfg(unix)]
        fault::install();
        // SAFETY: the map is never written through, and no reference outlives it. Another program
        // may change the bytes, and `fault` may exchange them for zeros, while they are read; they
        // are only ever read as plain integers, floats and byte slices, for which every bit pattern
        // is valid, and each reader checks what it takes from them.
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

    /// Returns the fault of bytes that could not be read, with the first such byte: from there on
    /// they are zero. `None` while all could be read.
    pub fn lost(&self) -> Option<FileFault> {
        #[cfg(unix)]
        let from = self.registered.lost_from();
        #[cfg(not(unix))]
        let from: Option<u64> = None;
        from.map(|from| FileFault::Unreadable { from })
    }

    /// Returns the fault that makes the bytes, or the data that was read from them before, wrong;
    /// `None` while they are right. `path` names the file as it was opened. Asks the disk for the
    /// file's size and times, so it may wait for a disk that does not answer.
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
