//! Copies files on removable or network drives into a temporary file, which is mapped instead, on
//! Windows, where a page that cannot be read would end the program. This costs the time and the
//! disk space of one copy, which is deleted when the file is closed.

use std::fs::File;
use std::io::{self, Read as _};

/// Returns true if a file's drive is a card, a stick, a disc or a network share, or is unknown. An
/// external hard disk counts as built in: Windows does not distinguish it.
// The call of the system function below is unsafe.
#[allow(unsafe_code)]
#[cfg(windows)]
pub(super) fn may_be_taken_away(path: &std::path::Path) -> bool {
    use std::path::{Component, Prefix};
    /// `DRIVE_FIXED` and `DRIVE_RAMDISK` of `fileapi.h`.
    const BUILT_IN: [u32; 2] = [3, 6];
    // SAFETY: the signature is that of `fileapi.h`.
    #[link(name = "kernel32")]
    unsafe extern "system" {
        fn GetDriveTypeW(root: *const u16) -> u32;
    }
    let whole = std::fs::canonicalize(path);
    let whole = whole.as_deref().unwrap_or(path);
    let letter = match whole.components().next() {
        Some(Component::Prefix(prefix)) => match prefix.kind() {
            Prefix::Disk(letter) | Prefix::VerbatimDisk(letter) => letter,
            _ => return true,
        },
        _ => return true,
    };
    let root = [u16::from(letter), u16::from(b':'), u16::from(b'\\'), 0];
    // SAFETY: `root` is a text that ends with a zero and outlives the call, which only reads it.
    let kind = unsafe { GetDriveTypeW(root.as_ptr()) };
    !BUILT_IN.contains(&kind)
}

/// Copies the first `length` bytes of a file into a temporary file that no other program can reach.
///
/// # Errors
/// The system's error when the file cannot be read or the copy cannot be written; an error when the
/// file has fewer bytes.
pub(super) fn copied(file: &File, length: u64) -> io::Result<File> {
    let mut copy = tempfile::tempfile()?;
    match io::copy(&mut file.take(length), &mut copy) {
        Ok(count) if count == length => Ok(copy),
        Ok(count) => Err(io::Error::other(format!(
            "it became shorter while it was read, from {length} to {count} bytes; open a whole copy of it"
        ))),
        Err(error) => Err(io::Error::new(
            error.kind(),
            format!(
                "{error}, while a temporary copy of it was made; copy it to a disk of this computer and open that"
            ),
        )),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Write as _;

    #[test]
    fn a_copy_has_the_bytes_that_were_there_and_stands_without_the_file() {
        let mut file = tempfile::NamedTempFile::new().expect("a file");
        file.write_all(b"pings and more").expect("bytes");
        let source = File::open(file.path()).expect("the file");
        let copy = copied(&source, 5).expect("a copy");
        drop(file);
        let map = crate::support::mapped_file::MappedFile::beginning(&copy, 5).expect("a map");
        assert_eq!(&*map, b"pings");
        let error = copied(&source, 20).expect_err("it is shorter");
        assert!(error.to_string().contains("from 20 to 9 bytes"), "{error}");
    }
}
