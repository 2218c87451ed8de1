//! Follows a log that is being written. The bytes are copied as they are added, because the file
//! itself may change at any time.
//!
//! A memory map of a file loses its bytes when another program shortens the file ([`MappedFile`]).
//! A log that is being recorded may be shortened, replaced, or removed with its card at any time.
//! Bathyscope therefore reads a private copy in the folder for temporary files, which nothing
//! shortens. The log itself is only ever read.

use super::table::{FileRole, role_by_name};
use crate::support::mapped_file::MappedFile;
use crate::support::progress::{Cancelled, Progress};
use crate::support::regular_file;
use crate::survey::{Bytes, Survey};
use std::fs::File;
use std::io::{self, Read, Seek as _, SeekFrom, Write as _};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::SystemTime;

/// Bytes before the end of the known part that must be unchanged when the file is longer.
const COMPARED: u64 = 4096;
/// Bytes that are copied between two checks for cancellation.
const CHUNK: u64 = 1 << 20;
/// Most bytes of the description of a recording of several files; recorders rewrite this file as a
/// whole.
const LONGEST_DESCRIPTION: u64 = 1 << 17;

/// Reason why a log cannot be followed any further. The part that was read before remains usable.
#[derive(Debug, thiserror::Error)]
pub enum GrowingError {
    /// The file with this path is shorter than before.
    #[error("it became shorter: {0}")]
    Shorter(PathBuf),
    /// The file with this path does not begin with the bytes that were read before.
    #[error("another recording lies in its place: {0}")]
    Replaced(PathBuf),
    /// The file cannot be read any more.
    #[error("it cannot be read any more: {source}: {path}")]
    Gone {
        /// Path of the file.
        path: PathBuf,
        /// Error of the operating system.
        source: io::Error,
    },
    /// The copy cannot be written or read, for example because the disk is full.
    #[error("there is no room for a copy of it in the folder for temporary files: {0}")]
    NoRoom(#[source] io::Error),
    /// The log is no file, as the demo survey or a log in memory.
    #[error("only a log that is a file can be followed")]
    NoFile,
    /// The samples are packed in a picture, which can only be read as a whole.
    #[error("a log in a picture is read as a whole; open it again when the picture is longer")]
    Packed,
    /// The user cancelled the work.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

/// A log that is being written, and the copy of the part that was read.
pub struct GrowingLog {
    files: Vec<GrowingFile>,
}

struct GrowingFile {
    path: PathBuf,
    copied: Copied,
    /// Length of the file and time of its last change at the last look; `None` before the first.
    seen: Option<(u64, Option<SystemTime>)>,
}

enum Copied {
    /// Bytes of a file that grows at its end, copied into a file without a name.
    Log { copy: File, length: u64 },
    /// Bytes of a description, which is read as a whole.
    Whole(Arc<Vec<u8>>),
}

impl GrowingLog {
    /// Copies the files of a log as they are now; the part that was read for `survey` must be their
    /// beginning.
    ///
    /// # Errors
    /// When the log is packed in a picture or is no file, has changed other than by growing, or
    /// cannot be read or copied; or when the work was cancelled.
    pub fn start(survey: &Survey, progress: &Progress) -> Result<Self, GrowingError> {
        if survey.bytes.iter().any(Bytes::is_packed) {
            return Err(GrowingError::Packed);
        }
        let own = survey.source.files.iter().zip(&survey.bytes);
        let own = own.filter(|(path, _)| {
            let external = survey.track.external.as_ref();
            external.is_none_or(|track| track.path != **path)
        });
        let mut files = Vec::new();
        for (path, known) in own {
            if !path.is_file() {
                return Err(GrowingError::NoFile);
            }
            let mut file = GrowingFile::new(path)?;
            file.look(progress)?;
            file.must_begin_with(known)?;
            files.push(file);
        }
        if files.is_empty() { Err(GrowingError::NoFile) } else { Ok(Self { files }) }
    }

    /// Copies the bytes that were added since the last look; returns their number.
    ///
    /// # Errors
    /// When the log has changed other than by growing, or cannot be read or copied, or the work was
    /// cancelled; the bytes copied before remain.
    pub fn look(&mut self, progress: &Progress) -> Result<u64, GrowingError> {
        let mut added = 0;
        for file in &mut self.files {
            added += file.look(progress)?;
        }
        Ok(added)
    }

    /// Copies a log again from its beginning; `known` are its files as read before. This is needed
    /// because a recorder may rewrite its header at the end. Files that were added to the recording
    /// since then are copied too.
    ///
    /// # Errors
    /// When a file is shorter than before or cannot be read or copied, or the work was cancelled.
    pub fn again(known: &[(PathBuf, Bytes)], progress: &Progress) -> Result<Self, GrowingError> {
        let mut paths: Vec<PathBuf> = known.iter().map(|(path, _)| path.clone()).collect();
        // The recording may have other files beside such a file.
        let is_part = |path: &Path| role_by_name(path) == Some(FileRole::Part);
        for (path, _) in known.iter().filter(|(path, _)| is_part(path)) {
            let siblings = std::fs::read_dir(path.parent().unwrap_or(Path::new(".")));
            let siblings = siblings.into_iter().flatten().flatten();
            let siblings = siblings.map(|entry| entry.path());
            let new = siblings.filter(|new| has_ending_of(new, path) && !paths.contains(new));
            let mut new: Vec<PathBuf> = new.collect();
            new.sort();
            paths.extend(new);
        }
        let mut files = Vec::new();
        for path in paths {
            let mut file = GrowingFile::new(&path)?;
            file.look(progress)?;
            let before = known.iter().find(|(known, _)| *known == path);
            if before.is_some_and(|(_, bytes)| file.length() < bytes.len() as u64) {
                return Err(GrowingError::Shorter(path));
            }
            files.push(file);
        }
        Ok(Self { files })
    }

    /// Returns the number of bytes of all files.
    pub fn byte_count(&self) -> u64 {
        self.files.iter().map(GrowingFile::length).sum()
    }

    /// Returns the first bytes of each file from the copy, as many as `lengths` gives: the part
    /// that was read before. No memory map of the log itself is used.
    ///
    /// # Errors
    /// When the copy cannot be read.
    pub fn beginning(&self, lengths: &[usize]) -> Result<Vec<Bytes>, GrowingError> {
        let each = self.files.iter().zip(lengths);
        each.map(|(file, known)| file.bytes(*known as u64)).collect()
    }

    /// Returns the files with their copied bytes; the first is the file to open. The bytes remain
    /// unchanged, whatever happens to the log.
    ///
    /// # Errors
    /// When the copy cannot be read.
    pub fn bytes(&self) -> Result<Vec<(PathBuf, Bytes)>, GrowingError> {
        let each = self.files.iter();
        each.map(|file| Ok((file.path.clone(), file.bytes(u64::MAX)?))).collect()
    }
}

impl GrowingFile {
    fn new(path: &Path) -> Result<Self, GrowingError> {
        let copied = if role_by_name(path) == Some(FileRole::Description) {
            Copied::Whole(Arc::default())
        } else {
            Copied::Log { copy: tempfile::tempfile().map_err(GrowingError::NoRoom)?, length: 0 }
        };
        Ok(Self { path: path.to_owned(), copied, seen: None })
    }

    /// Returns the first `most` bytes of the copy, or fewer if it is shorter; a description is
    /// returned as a whole.
    fn bytes(&self, most: u64) -> Result<Bytes, GrowingError> {
        match &self.copied {
            Copied::Log { copy, length } => MappedFile::beginning(copy, most.min(*length))
                .map(Bytes::from)
                .map_err(GrowingError::NoRoom),
            Copied::Whole(bytes) => Ok(Bytes::Held(bytes.clone())),
        }
    }

    fn length(&self) -> u64 {
        match &self.copied {
            Copied::Log { length, .. } => *length,
            Copied::Whole(bytes) => bytes.len() as u64,
        }
    }

    fn look(&mut self, progress: &Progress) -> Result<u64, GrowingError> {
        progress.check()?;
        let path = self.path.clone();
        let gone = |source| GrowingError::Gone { path: path.clone(), source };
        let mut file = regular_file::open(&path).map_err(gone)?;
        let found = file.metadata().map_err(gone)?;
        let seen = Some((found.len(), found.modified().ok()));
        if self.seen == seen {
            return Ok(0);
        }
        if let Copied::Whole(bytes) = &mut self.copied {
            let now = regular_file::read(&self.path, LONGEST_DESCRIPTION);
            let now = now.map_err(gone)?;
            if **bytes != now {
                *bytes = Arc::new(now);
            }
            self.seen = seen;
            return Ok(0);
        }
        if found.len() < self.length() {
            return Err(GrowingError::Shorter(path));
        }
        if !self.goes_on(&mut file).map_err(gone)? {
            return Err(GrowingError::Replaced(path));
        }
        let added = self.take(file, progress)?;
        self.seen = seen;
        Ok(added)
    }

    /// Returns true if the file still has the bytes that were copied last, at the same offset.
    fn goes_on(&self, file: &mut File) -> io::Result<bool> {
        let Copied::Log { copy, length } = &self.copied else {
            return Ok(true);
        };
        let from = length.saturating_sub(COMPARED);
        let mut copy = copy;
        let now = part(file, from, length - from)?;
        Ok(now == part(&mut copy, from, length - from)?)
    }

    fn must_begin_with(&self, known: &[u8]) -> Result<(), GrowingError> {
        let Copied::Log { copy, length } = &self.copied else {
            return Ok(());
        };
        let path = self.path.clone();
        if known.len() as u64 > *length {
            return Err(GrowingError::Shorter(path));
        }
        let from = known.len().saturating_sub(COMPARED as usize);
        let mut copy = copy;
        let copied = part(&mut copy, from as u64, (known.len() - from) as u64);
        let copied = copied.map_err(GrowingError::NoRoom)?;
        if copied == known[from..] { Ok(()) } else { Err(GrowingError::Replaced(path)) }
    }

    /// Copies the bytes after the known ones; returns their number.
    fn take(&mut self, mut file: File, progress: &Progress) -> Result<u64, GrowingError> {
        let path = self.path.clone();
        let gone = |source| GrowingError::Gone { path: path.clone(), source };
        let Copied::Log { copy, length } = &mut self.copied else {
            return Ok(0);
        };
        let before = *length;
        file.seek(SeekFrom::Start(before)).map_err(gone)?;
        copy.seek(SeekFrom::Start(before)).map_err(GrowingError::NoRoom)?;
        let mut chunk = Vec::new();
        loop {
            progress.check()?;
            chunk.clear();
            (&mut file).take(CHUNK).read_to_end(&mut chunk).map_err(gone)?;
            if chunk.is_empty() {
                break;
            }
            copy.write_all(&chunk).map_err(GrowingError::NoRoom)?;
            *length += chunk.len() as u64;
        }
        copy.flush().map_err(GrowingError::NoRoom)?;
        Ok(*length - before)
    }
}

fn part(file: &mut (impl Read + io::Seek), from: u64, length: u64) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    file.seek(SeekFrom::Start(from))?;
    file.take(length).read_to_end(&mut bytes)?;
    Ok(bytes)
}

fn has_ending_of(path: &Path, other: &Path) -> bool {
    let endings = path.extension().zip(other.extension());
    endings.is_some_and(|(one, other)| one.eq_ignore_ascii_case(other))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    fn survey_of(path: &Path, bytes: &[u8]) -> Survey {
        let mut survey = Survey::default();
        survey.source.files = vec![path.to_owned()];
        survey.bytes = vec![Bytes::Held(Arc::new(bytes.to_vec()))];
        survey
    }

    fn add(path: &Path, bytes: &[u8]) {
        let mut file = fs::OpenOptions::new().append(true).open(path).expect("a log");
        file.write_all(bytes).expect("a log");
    }

    #[test]
    fn what_is_added_is_taken_in_and_stays_when_the_log_is_cut_short() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("log.sl2");
        let all: Vec<u8> = (0..10_000_u32).map(|at| (at * 7 % 251) as u8).collect();
        fs::write(&path, &all[..100]).expect("a log");
        let progress = Progress::new();
        let mut log = GrowingLog::start(&survey_of(&path, &all[..50]), &progress).expect("a log");
        let first = log.bytes().expect("bytes");
        assert_eq!(&first[0].1[..], &all[..100]);
        assert_eq!(log.look(&progress).expect("a log"), 0);
        add(&path, &all[100..9_000]);
        assert_eq!(log.look(&progress).expect("a log"), 8_900);
        add(&path, &all[9_000..]);
        assert_eq!(log.look(&progress).expect("a log"), 1_000);
        let last = log.bytes().expect("bytes");
        assert_eq!(&last[0].1[..], &all[..]);
        fs::write(&path, &all[..200]).expect("a log");
        let error = log.look(&progress).expect_err("it is shorter");
        assert!(matches!(error, GrowingError::Shorter(_)), "{error}");
        // A memory map of the log itself would have lost its bytes here.
        assert_eq!(&last[0].1[..], &all[..]);
        assert_eq!(&first[0].1[..], &all[..100]);
    }

    #[test]
    fn a_log_that_was_replaced_or_is_gone_is_told_from_one_that_grew() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("log.xtf");
        let progress = Progress::new();
        fs::write(&path, [1; 5_000]).expect("a log");
        let mut log = GrowingLog::start(&survey_of(&path, &[1; 5_000]), &progress).expect("a log");
        // A program that synchronises folders replaces the file by a longer one with the same
        // beginning.
        let other = folder.path().join("other");
        fs::write(&other, [[1; 5_000], [2; 5_000]].concat()).expect("a log");
        fs::rename(&other, &path).expect("a log");
        assert_eq!(log.look(&progress).expect("it grew"), 5_000);
        fs::write(&path, [3; 20_000]).expect("a log");
        let error = log.look(&progress).expect_err("it is another one");
        assert!(matches!(error, GrowingError::Replaced(_)), "{error}");
        fs::remove_file(&path).expect("a log");
        let error = log.look(&progress).expect_err("it is gone");
        assert!(matches!(error, GrowingError::Gone { .. }), "{error}");
        assert_eq!(log.byte_count(), 10_000);
        let none = GrowingLog::start(&Survey::default(), &progress);
        assert!(matches!(none, Err(GrowingError::NoFile)));
    }
}
