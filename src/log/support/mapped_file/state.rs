//! Checks that a file is still the one that was mapped.

use std::fs::{self, Metadata};
use std::hash::{DefaultHasher, Hasher as _};
use std::path::Path;
use std::sync::OnceLock;
use std::time::SystemTime;

/// Number of bytes before the end of the map that are compared when the file has become longer.
const COMPARED: usize = 4096;

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
pub(super) struct FileState {
    length: u64,
    modified: Option<SystemTime>,
    #[cfg(unix)]
    place: [u64; 2],
    /// Hash of the last mapped bytes, computed at the first comparison: computing it when the file
    /// is mapped would read the end of each file of which only the format is recognised.
    tail: OnceLock<u64>,
}

impl FileState {
    pub(super) fn of(found: &Metadata) -> Self {
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
    /// does not answer, [`super::MappedFile::lost`] reports the lost bytes.
    pub(super) fn fault(&self, path: &Path, bytes: &[u8]) -> Option<FileFault> {
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
