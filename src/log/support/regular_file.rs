//! Opens and reads files that a user names, only if they are regular files, and only up to a limit
//! of bytes. This module depends on no other module of the crate.

use std::fs::{self, File};
use std::io::{self, ErrorKind, Read as _};
use std::path::Path;

/// Opens a file for reading.
///
/// # Errors
/// The system's error when the file cannot be opened; a folder, a pipe and a device are refused
/// before they are opened, because a pipe may never begin and a device never end.
pub fn open(path: &Path) -> io::Result<File> {
    let found = fs::metadata(path)?;
    if found.is_dir() {
        return Err(io::Error::other("it is a folder, and a file is expected"));
    }
    if !found.is_file() {
        return Err(io::Error::other("it is a pipe or a device, not a file"));
    }
    File::open(path)
}

/// Reads all bytes of a file that has `most` bytes at most.
///
/// # Errors
/// The errors of [`open`], and of reading; [`ErrorKind::FileTooLarge`] where the file has more
/// bytes.
pub fn read(path: &Path, most: u64) -> io::Result<Vec<u8>> {
    if let Some(bytes) = held::get(path) {
        return Ok(bytes);
    }
    let file = open(path)?;
    let length = file.metadata()?.len();
    let mut bytes = Vec::new();
    // One byte more than allowed is read, so that a file that is too long is noticed even if it
    // grows meanwhile.
    if length <= most {
        bytes.try_reserve_exact(usize::try_from(length).map_err(io::Error::other)?)?;
        file.take(most.saturating_add(1)).read_to_end(&mut bytes)?;
    }
    if length > most || bytes.len() as u64 > most {
        let what = format!("it is longer than {}", in_words(most));
        return Err(io::Error::new(ErrorKind::FileTooLarge, what));
    }
    Ok(bytes)
}

/// Reads the text of a file that has `most` bytes at most.
///
/// # Errors
/// The errors of [`read`]; [`ErrorKind::InvalidData`] where the bytes are not UTF-8.
pub fn read_text(path: &Path, most: u64) -> io::Result<String> {
    String::from_utf8(read(path, most)?)
        .map_err(|_| io::Error::new(ErrorKind::InvalidData, "it is not text in UTF-8"))
}

/// Holds one file in memory that [`read`] returns instead of the file on disk, for the fuzzer,
/// which reads millions of files.
pub mod held {
    use std::cell::RefCell;
    use std::path::{Path, PathBuf};

    thread_local! {
        static HELD: RefCell<Option<(PathBuf, Vec<u8>)>> = const { RefCell::new(None) };
    }

    /// Returns the bytes that are held for a path; `None` where there are none.
    pub(super) fn get(path: &Path) -> Option<Vec<u8>> {
        HELD.with_borrow(|held| {
            let held = held.as_ref().filter(|(name, _)| name == path);
            held.map(|(_, bytes)| bytes.clone())
        })
    }

    /// Runs `work` on this thread, while [`read`](super::read) returns `bytes` for a path.
    pub fn with<T>(path: &Path, bytes: &[u8], work: impl FnOnce() -> T) -> T {
        HELD.replace(Some((path.to_owned(), bytes.to_vec())));
        let outcome = work();
        HELD.replace(None);
        outcome
    }
}

fn in_words(bytes: u64) -> String {
    match bytes >> 20 {
        0 => format!("{bytes} bytes"),
        mebibytes if mebibytes % 1024 == 0 => format!("{} GiB", mebibytes / 1024),
        mebibytes => format!("{mebibytes} MiB"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_that_just_fits_is_read_and_one_byte_more_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("levels.csv");
        fs::write(&path, b"12345").unwrap();
        assert_eq!(read(&path, 5).unwrap(), b"12345");
        assert_eq!(read_text(&path, u64::MAX).unwrap(), "12345");
        let error = read(&path, 4).unwrap_err();
        assert_eq!(error.kind(), ErrorKind::FileTooLarge);
        assert_eq!(error.to_string(), "it is longer than 4 bytes");
        assert_eq!([3 << 20, 2 << 30].map(in_words), ["3 MiB".to_owned(), "2 GiB".to_owned()]);
        fs::write(&path, b"\xff\xfe").unwrap();
        let error = read_text(&path, 5).unwrap_err();
        assert!(error.to_string().contains("UTF-8"), "{error}");
    }

    #[test]
    fn what_is_no_file_is_refused_before_it_is_opened() {
        let folder = tempfile::tempdir().unwrap();
        let error = open(folder.path()).unwrap_err();
        assert!(error.to_string().contains("a folder"), "{error}");
        assert_eq!(open(&folder.path().join("none")).unwrap_err().kind(), ErrorKind::NotFound);
        if cfg!(target_os = "linux") {
            let error = read(Path::new("/dev/zero"), 1).unwrap_err();
            assert!(error.to_string().contains("a device"), "{error}");
        }
    }
}
