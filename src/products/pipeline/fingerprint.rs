//! Identifies a version of a file by its name, size and hash.

use super::Settings;
use crate::Error;
use bathyscope_log::support::progress::{Cancelled, Progress};
use bathyscope_log::support::regular_file;
use bathyscope_log::survey::Survey;
use serde::{Deserialize, Serialize};
use sha2::{Digest as _, Sha256};
use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

/// Bytes hashed between two checks for cancellation.
const CHUNK: usize = 1 << 20;

/// Fingerprint of a file, by name and content.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Fingerprint {
    /// Name of the file: of a file that was read, as it was given; of a file in a folder, its name
    /// there, after the name of a subfolder and `/` if it is in one.
    pub file: String,
    /// Size of the file, bytes.
    pub bytes: u64,
    /// SHA-256 of the file, hexadecimal.
    pub sha256: String,
}

impl Fingerprint {
    /// Computes the fingerprint of a file in `folder`.
    ///
    /// # Errors
    /// The system's error; [`io::ErrorKind::Other`] when the work was cancelled.
    pub fn of(folder: &Path, file: &str, progress: &Progress) -> io::Result<Self> {
        let from = File::open(folder.join(file))?;
        let (bytes, sha256) = sha256_of(from, progress)?;
        Ok(Self { file: file.to_owned(), bytes, sha256 })
    }

    /// Returns the fingerprint of a file that was read and hashed before.
    pub(super) fn of_read(path: &Path, bytes: usize, sha256: &str) -> Self {
        let file = path.display().to_string();
        Self { file, bytes: bytes as u64, sha256: sha256.to_owned() }
    }

    /// Returns true if there is a file of that name and size in `folder`, whatever its content.
    pub(crate) fn is_as_long_in(&self, folder: &Path) -> bool {
        let there = folder.join(&self.file).symlink_metadata();
        there.is_ok_and(|there| there.is_file() && there.len() == self.bytes)
    }

    /// Returns true if the file of that name in `folder` still has this fingerprint.
    pub(crate) fn is_unchanged(&self, folder: &Path) -> bool {
        let again = || Self::of(folder, &self.file, &Progress::new());
        self.is_as_long_in(folder) && again().is_ok_and(|again| again == *self)
    }
}

/// Hashes the files of a log.
pub(super) fn hash_inputs(
    survey: &Survey,
    progress: &Progress,
) -> Result<Vec<Fingerprint>, Cancelled> {
    progress.start(survey.bytes.iter().map(|bytes| bytes.len() as u64).sum());
    let files = survey.source.files.iter().zip(&survey.bytes);
    files
        .map(|(path, bytes)| {
            let hashed = hash(&bytes[..], progress, |count| progress.advance(count));
            // Reading memory cannot fail; the only error is a cancellation. `Survey::check_files`
            // detects bytes that read as zero because the file changed.
            let (bytes, sha256) = hashed.map_err(|_| Cancelled)?;
            Ok(Fingerprint { file: path.display().to_string(), bytes, sha256 })
        })
        .collect()
}

/// Hash of a log, and fingerprints of all files on which its results depend.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct LogFiles {
    /// SHA-256 of the log's file; for a log of several files, SHA-256 of their concatenated hashes.
    /// Names and folders have no influence.
    pub sha256: String,
    /// Files of the log, the track of another receiver and the readings of the water level, by
    /// their names without folders.
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
            [input] => input.sha256.clone(),
            several => {
                let hashes: String = several.iter().map(|input| input.sha256.as_str()).collect();
                in_hexadecimal(&Sha256::digest(hashes.as_bytes()))
            }
        };
        let gauge = settings.water_level.gauge.as_deref();
        inputs.extend(
            gauge.map(|gauge| Fingerprint::of_read(&gauge.path, gauge.bytes, &gauge.sha256)),
        );
        let files = inputs.into_iter().map(|input| Fingerprint {
            file: Path::new(&input.file)
                .file_name()
                .map_or_else(String::new, |name| name.to_string_lossy().into_owned()),
            ..input
        });
        Ok(Self { sha256, files: files.collect() })
    }
}

/// Hashes a file that is not a log.
pub(super) fn hash_file(path: &Path, progress: &Progress) -> Result<Fingerprint, Error> {
    let fail = |source: io::Error| match progress.check() {
        Err(cancelled) => Error::from(cancelled),
        Ok(()) => format!("cannot read the file: {source}: {}", path.display()).into(),
    };
    let from = regular_file::open(path).map_err(fail)?;
    progress.start(from.metadata().map_err(fail)?.len());
    let hashed = hash(from, progress, |count| progress.advance(count));
    let (bytes, sha256) = hashed.map_err(fail)?;
    Ok(Fingerprint { file: path.display().to_string(), bytes, sha256 })
}

/// Computes the length and SHA-256 of the bytes read.
///
/// # Errors
/// The system's error; [`io::ErrorKind::Other`] when the work was cancelled.
pub(crate) fn sha256_of(from: impl Read, progress: &Progress) -> io::Result<(u64, String)> {
    hash(from, progress, |_| ())
}

/// Computes the length and SHA-256 of the bytes read; a cancellation stops the reading.
fn hash(
    mut from: impl Read,
    progress: &Progress,
    on_read: impl Fn(u64),
) -> io::Result<(u64, String)> {
    let (mut hash, mut bytes) = (Sha256::new(), 0);
    let mut chunk = vec![0; CHUNK];
    loop {
        progress.check().map_err(io::Error::other)?;
        let count = from.read(&mut chunk)?;
        if count == 0 {
            return Ok((bytes, in_hexadecimal(&hash.finalize())));
        }
        hash.update(&chunk[..count]);
        bytes += count as u64;
        on_read(count as u64);
    }
}

/// Returns the bytes of a hash as hexadecimal text.
pub fn in_hexadecimal(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}
