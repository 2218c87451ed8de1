//! Support for tests of several crates: the folder of recordings, small logs written byte by byte
//! from the format notes, not by Bathyscope's own writers, and random numbers that are the same in
//! every run.

#![allow(clippy::expect_used, clippy::unwrap_used, missing_docs, reason = "as in tests")]

pub mod cerulean;
pub mod edgetech;
pub mod garmin;
pub mod handmade;
pub mod klein;
pub mod nmea;
mod random;
pub mod records;

pub use random::{Moments, Random};

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Time after which a test that waits for a worker fails. It ends an endless wait and bounds no
/// speed: on a busy machine a worker takes as long as it needs.
pub const PATIENCE: Duration = Duration::from_secs(900);

/// Returns the attempts of a test that waits for a worker: as many as [`PATIENCE`] has time for.
pub fn attempts() -> impl Iterator<Item = ()> {
    let start = Instant::now();
    std::iter::from_fn(move || (start.elapsed() < PATIENCE).then_some(()))
}

/// The folder of the repository.
pub fn repository() -> PathBuf {
    let own = Path::new(env!("CARGO_MANIFEST_DIR"));
    own.ancestors().nth(2).expect("the folder above tests").to_path_buf()
}

/// The folder of real recordings: `BATHYSCOPE_DATA`, or `../shared/data` beside the project. `None`
/// (after a line on stderr) where there is none: the test then has nothing to look at and says so.
pub fn real_data() -> Option<PathBuf> {
    let beside = repository().join("../shared/data");
    let folder = std::env::var_os("BATHYSCOPE_DATA").map_or(beside, PathBuf::from);
    if folder.is_dir() {
        return Some(folder);
    }
    eprintln!("skipped: no real recordings (set BATHYSCOPE_DATA to the folder that holds them)");
    None
}

/// A base map of `base_map`, which `make.py` there made by GDAL.
pub fn base_map(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("base_map").join(name)
}

/// The folder of small networks in the dialects of exporters, which `make.py` there made.
pub fn detector_models() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("detector_models")
}

/// The bundled demo survey as a file.
pub fn demo_log() -> PathBuf {
    repository().join("assets/demo.sl2")
}
