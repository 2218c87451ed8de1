//! What tells one version of a file from another.

use crate::progress::Progress;
use serde::{Deserialize, Serialize};
use sha2::{Digest as _, Sha256};
use std::fs::File;
use std::io::{self, Read as _};
use std::path::Path;

/// Bytes hashed between two looks at whether the work was cancelled.
const CHUNK: usize = 1 << 20;

/// A file of a folder, by name and content.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Fingerprint {
    /// Its name in the folder; with `/` before it the subfolder's.
    pub file: String,
    /// Its size.
    pub bytes: u64,
    /// SHA-256, hexadecimal.
    pub sha256: String,
}

impl Fingerprint {
    /// Reads a file of `folder`.
    ///
    /// # Errors
    /// What the system said; [`io::ErrorKind::Other`] when the work was cancelled.
    pub fn of(folder: &Path, file: &str, progress: &Progress) -> io::Result<Self> {
        let mut from = File::open(folder.join(file))?;
        let (mut hash, mut bytes) = (Sha256::new(), 0);
        let mut chunk = vec![0; CHUNK];
        loop {
            progress.check().map_err(io::Error::other)?;
            let count = from.read(&mut chunk)?;
            if count == 0 {
                break;
            }
            hash.update(&chunk[..count]);
            bytes += count as u64;
        }
        Ok(Self {
            file: file.to_owned(),
            bytes,
            sha256: in_hexadecimal(&hash.finalize()),
        })
    }

    /// Whether the file of that name in `folder` is still this one.
    pub fn is_unchanged(&self, folder: &Path) -> bool {
        let path = folder.join(&self.file);
        let as_long = path
            .symlink_metadata()
            .is_ok_and(|there| there.is_file() && there.len() == self.bytes);
        let again = || Self::of(folder, &self.file, &Progress::new());
        as_long && again().is_ok_and(|again| again == *self)
    }
}

/// Bytes of a hash as text.
pub fn in_hexadecimal(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}
