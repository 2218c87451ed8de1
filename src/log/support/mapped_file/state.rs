//! Checks that a file is still the one that was mapped.

use std::fs::{self, Metadata};
use std::hash::{DefaultHasher, Hasher as _};
use std::path::Path;
use std::sync::OnceLock;
use std::time::SystemTime;

/// Bytes before the end of what is mapped that have to be the same when the file is longer.
const COMPARED: usize = 4096;

/// Change of a mapped file that makes its bytes wrong, and advice on what to do.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum FileFault {
    /// There is less of it.
    #[error(
        "the file became shorter while it was open, from {from} to {to} bytes, so results of it are wrong; open a whole copy of it"
    )]
    Shorter {
        /// Its bytes when it was opened.
        from: u64,
        /// Its bytes now.
        to: u64,
    },
    /// Other bytes were written in its place.
    #[error(
        "the file was changed while it was open, so results may mix its old and new bytes; open it again when nothing writes into it"
    )]
    Changed,
    /// The disk did not give all of it.
    #[error(
        "the file cannot be read any more at byte {from}, so results of it are wrong; put its card or disk back, or take another copy, and open it again"
    )]
    Unreadable {
        /// Offset of the first byte that was missing.
        from: u64,
    },
}

/// A file as it was when it was mapped.
pub(super) struct FileState {
    length: u64,
    modified: Option<SystemTime>,
    #[cfg(unix)]
    place: [u64; 2],
    /// Hash of its last bytes when they were first asked for: at the mapping this would read the
    /// end of each file that is only recognised.
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

    /// Returns the change of the file at `path` that makes its mapped `bytes` wrong. It is no fault
    /// that the file grows behind them. Where it was deleted or another was renamed into its place,
    /// the map keeps the old one; where its disk does not answer, the map reports the bytes that it
    /// lost.
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
            // A longer one that was written over it.
            hash_of_end(bytes) != known
        };
        is_changed.then_some(FileFault::Changed)
    }
}

/// Device and number of a file: another in its place has others.
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
