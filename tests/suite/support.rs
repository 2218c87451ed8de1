//! Where the real recordings are, and what a test says when they are not there.

use std::path::PathBuf;

/// The folder of real recordings: `BATHYSCOPE_DATA`, or `../shared/data` beside the project.
/// `None` (after a line on stderr) where there is none: the test then has nothing to look at and says so.
pub fn real_data() -> Option<PathBuf> {
    let beside = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../shared/data");
    let folder = std::env::var_os("BATHYSCOPE_DATA").map_or(beside, PathBuf::from);
    if folder.is_dir() {
        return Some(folder);
    }
    eprintln!("skipped: no real recordings (set BATHYSCOPE_DATA to the folder that holds them)");
    None
}

/// The bundled demo survey as a file.
pub fn demo_log() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("assets/demo.sl2")
}
