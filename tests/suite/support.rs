//! Where the real recordings are, what a test says when they are not there, and how pictures are compared.

use serde_json::Value;
use std::path::{Path, PathBuf};

/// The folder of real recordings: `BATHYSCOPE_DATA`, or `../shared/data` beside the project.
/// `None` (after a line on stderr) where there is none: the test then has nothing to look at and says so.
pub(super) fn real_data() -> Option<PathBuf> {
    let beside = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../shared/data");
    let folder = std::env::var_os("BATHYSCOPE_DATA").map_or(beside, PathBuf::from);
    if folder.is_dir() {
        return Some(folder);
    }
    eprintln!("skipped: no real recordings (set BATHYSCOPE_DATA to the folder that holds them)");
    None
}

/// The program, which cargo builds with the tests.
///
/// # Panics
/// When it is missing or older than its source, as after `cargo test --lib`.
pub(super) fn program() -> PathBuf {
    let tests = std::env::current_exe().expect("the path of the tests");
    let folder = tests.ancestors().nth(2).expect("the folder of the build");
    let program = folder
        .join("bathyscope")
        .with_extension(std::env::consts::EXE_EXTENSION);
    let built = std::fs::metadata(&program).and_then(|file| file.modified());
    let source = newest_change(&PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("src"));
    assert!(
        built.is_ok_and(|built| built >= source),
        "{} is missing or older than its source: run `cargo build --release` first",
        program.display()
    );
    program
}

/// When a file in a folder was changed last.
fn newest_change(folder: &Path) -> std::time::SystemTime {
    let entries = std::fs::read_dir(folder).expect("the source");
    let changes = entries.map(|entry| {
        let entry = entry.expect("a file of the source");
        let about = entry.metadata().expect("a file of the source");
        match about.is_dir() {
            true => newest_change(&entry.path()),
            false => about.modified().expect("a time"),
        }
    });
    changes.max().unwrap_or(std::time::UNIX_EPOCH)
}

/// The bundled demo survey as a file.
pub(super) fn demo_log() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("assets/demo.sl2")
}

/// What the manifest of a run says, of all its files and of each.
pub(super) fn manifest(folder: &Path) -> Value {
    let text = std::fs::read(folder.join("manifest.json")).expect("a manifest");
    serde_json::from_slice(&text).expect("JSON")
}

/// What the manifest of a run says of one file.
pub(super) fn manifest_entry(folder: &Path, name: &str) -> Value {
    let manifest = manifest(folder);
    let mut files = manifest["files"].as_array().expect("files").iter();
    let entry = files.find(|file| file["file"] == name);
    entry
        .unwrap_or_else(|| panic!("{name} is not in it"))
        .clone()
}

/// How pictures are compared with those in `tests/snapshots/`. lavapipe compiles for the processor it runs on, so the last
/// bit of a colour and the odd pixel of an edge differ between machines, up to 45 of a map; a changed picture differs in far more.
pub(super) fn snapshot_options() -> egui_kittest::SnapshotOptions {
    egui_kittest::SnapshotOptions::new()
        .threshold(1.0)
        .max_failed_pixels(64usize)
}

/// Numbers that look random and are the same in every run.
pub(super) struct Moments(pub u64);

impl Moments {
    /// The next one, 0 to 1.
    pub(super) fn share(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        (self.0 >> 33) as f64 / (1_u64 << 31) as f64
    }
}
