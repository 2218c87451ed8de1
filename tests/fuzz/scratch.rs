//! A place on disk for the readers that read no bytes from memory: one file a thread, written anew
//! for each input.

use std::fs;
use std::path::{Path, PathBuf};
use tempfile::TempDir;

thread_local! {
    static FOLDER: TempDir = tempfile::tempdir().expect("a folder for files to read");
}

/// The folder of this thread.
pub(super) fn folder() -> PathBuf {
    FOLDER.with(|folder| folder.path().to_owned())
}

/// Writes bytes under a name and hands over the path.
pub(super) fn with_file<T>(name: &str, bytes: &[u8], read: impl FnOnce(&Path) -> T) -> T {
    let path = folder().join(name);
    if fs::write(&path, bytes).is_err() {
        // A file in a folder of its own, for the first time.
        fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
        fs::write(&path, bytes).expect("a file to read");
    }
    read(&path)
}

/// Returns the bytes that `write` puts into a file.
pub(super) fn written(name: &str, write: impl FnOnce(fs::File)) -> Vec<u8> {
    let path = folder().join(name);
    let file = fs::File::options().read(true).write(true).create(true).truncate(true).open(&path);
    write(file.expect("a file to write"));
    fs::read(&path).expect("a file that was written")
}
