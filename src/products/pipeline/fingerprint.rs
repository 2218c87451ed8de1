//! Identifies one version of a file.

use super::Settings;
use bathyscope_log::support::file_error::FileError;
use bathyscope_log::support::mapped_file::FileFault;
use bathyscope_log::support::progress::{Cancelled, Progress};
use bathyscope_log::support::regular_file;
use bathyscope_log::survey::Survey;
use serde::{Deserialize, Serialize};
use sha2::{Digest as _, Sha256};
use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

/// Bytes hashed between two looks at whether the work was cancelled.
const CHUNK: usize = 1 << 20;

/// One file read.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Input {
    /// Its name, as it was given.
    pub file: String,
    /// Its size.
    pub bytes: usize,
    /// SHA-256, hexadecimal.
    pub sha256: String,
}

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
    /// The system's error; [`io::ErrorKind::Other`] when the work was cancelled.
    pub fn of(folder: &Path, file: &str, progress: &Progress) -> io::Result<Self> {
        let from = File::open(folder.join(file))?;
        let (bytes, sha256) = sha256_of(from, progress)?;
        Ok(Self { file: file.to_owned(), bytes, sha256 })
    }

    /// Returns true if there is a file of that name and size in `folder`, whatever it holds.
    pub(crate) fn is_as_long_in(&self, folder: &Path) -> bool {
        let there = folder.join(&self.file).symlink_metadata();
        there.is_ok_and(|there| there.is_file() && there.len() == self.bytes)
    }

    /// Returns true if the file of that name in `folder` is still this one.
    pub(crate) fn is_unchanged(&self, folder: &Path) -> bool {
        let again = || Self::of(folder, &self.file, &Progress::new());
        self.is_as_long_in(folder) && again().is_ok_and(|again| again == *self)
    }
}

/// The files of a log, read for their hashes.
pub(super) fn hash_inputs(survey: &Survey, progress: &Progress) -> Result<Vec<Input>, Cancelled> {
    progress.start(survey.bytes.iter().map(|bytes| bytes.len() as u64).sum());
    let files = survey.source.files.iter().zip(&survey.bytes);
    files
        .map(|(path, bytes)| {
            let sha256 = hash(&bytes[..], || progress.check(), |count| progress.advance(count));
            Ok(Input {
                file: path.display().to_string(),
                bytes: bytes.len(),
                // Memory can be read, unless somebody says to stop; `Survey::check_files` tells of
                // what reads as zero.
                sha256: sha256.map_err(|_| Cancelled)?.1,
            })
        })
        .collect()
}

/// A log by its bytes, and all files that its results depend on.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct LogFiles {
    /// SHA-256 of its file; of a log of several files, that of their hashes in a row. Names and
    /// folders do not matter.
    pub sha256: String,
    /// Its files, the track of another receiver and the readings of the water level, by their names
    /// without folders.
    pub files: Vec<Fingerprint>,
}

impl LogFiles {
    /// Hashes the files of a log that was opened with some settings.
    ///
    /// # Errors
    /// When the work was cancelled.
    pub(crate) fn of(
        survey: &Survey,
        settings: &Settings,
        progress: &Progress,
    ) -> Result<Self, Cancelled> {
        let track = usize::from(survey.track.external.is_some());
        let mut inputs = hash_inputs(survey, progress)?;
        let own = inputs.len().saturating_sub(track);
        let sha256 = match &inputs[..own] {
            [one] => one.sha256.clone(),
            several => {
                let hashes: String = several.iter().map(|one| one.sha256.as_str()).collect();
                in_hexadecimal(&Sha256::digest(hashes.as_bytes()))
            }
        };
        inputs.extend(settings.water_level.gauge.as_deref().map(|gauge| Input {
            file: gauge.path.display().to_string(),
            bytes: gauge.bytes,
            sha256: gauge.sha256.clone(),
        }));
        let files = inputs.into_iter().map(|input| Fingerprint {
            file: Path::new(&input.file)
                .file_name()
                .map_or_else(String::new, |name| name.to_string_lossy().into_owned()),
            bytes: input.bytes as u64,
            sha256: input.sha256,
        });
        Ok(Self { sha256, files: files.collect() })
    }
}

/// Reason why a file cannot be read for its hash, in one sentence.
#[derive(Debug, thiserror::Error)]
pub enum InputError {
    /// The work was cancelled.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    /// A log did not stay what it was.
    #[error(transparent)]
    Log(#[from] FileError<FileFault>),
    /// The system does not give it.
    #[error("cannot read the file: {source}: {}", path.display())]
    Unreadable {
        /// The system's error.
        source: io::Error,
        /// Path of the file.
        path: PathBuf,
    },
}

/// A file that is no log.
pub(super) fn hash_file(path: &Path, progress: &Progress) -> Result<Input, InputError> {
    let fail = |source: io::Error| match progress.check() {
        Err(cancelled) => InputError::from(cancelled),
        Ok(()) => InputError::Unreadable { source, path: path.to_owned() },
    };
    let from = regular_file::open(path).map_err(fail)?;
    progress.start(from.metadata().map_err(fail)?.len());
    let hashed = hash(from, || progress.check(), |count| progress.advance(count));
    let (bytes, sha256) = hashed.map_err(fail)?;
    Ok(Input { file: path.display().to_string(), bytes: bytes as usize, sha256 })
}

/// Length and SHA-256 of what is read.
///
/// # Errors
/// The system's error; [`io::ErrorKind::Other`] when the work was cancelled.
pub(crate) fn sha256_of(from: impl Read, progress: &Progress) -> io::Result<(u64, String)> {
    hash(from, || progress.check(), |_| ())
}

/// Length and SHA-256 of what is read; `check` may stop it.
fn hash(
    mut from: impl Read,
    check: impl Fn() -> Result<(), Cancelled>,
    on_read: impl Fn(u64),
) -> io::Result<(u64, String)> {
    let (mut hash, mut bytes) = (Sha256::new(), 0);
    let mut chunk = vec![0; CHUNK];
    loop {
        check().map_err(io::Error::other)?;
        let count = from.read(&mut chunk)?;
        if count == 0 {
            return Ok((bytes, in_hexadecimal(&hash.finalize())));
        }
        hash.update(&chunk[..count]);
        bytes += count as u64;
        on_read(count as u64);
    }
}

/// Bytes of a hash as text.
pub fn in_hexadecimal(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}
