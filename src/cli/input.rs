//! Small text files that the user names: settings, scenes.

use std::fs::{self, File};
use std::io::{self, Read as _};
use std::path::Path;

/// Longer than any settings or scene.
const LONGEST: u64 = 1 << 20;

/// The text of a file. A pipe or a device, which may never begin or never end, is refused.
pub fn text(path: &Path) -> io::Result<String> {
    let found = fs::metadata(path)?;
    if found.is_dir() {
        return Err(io::Error::other("it is a folder, and a file is expected"));
    }
    if !found.is_file() {
        return Err(io::Error::other("it is a pipe or a device, not a file"));
    }
    let mut text = String::new();
    File::open(path)?
        .take(LONGEST + 1)
        .read_to_string(&mut text)?;
    if text.len() as u64 > LONGEST {
        return Err(io::Error::other("it is longer than 1 MiB"));
    }
    Ok(text)
}
