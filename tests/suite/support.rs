//! The program, what a run says of its files, and how pictures are compared.

pub(super) use bathyscope_test_support::{demo_log, real_data};

use serde_json::Value;
use std::path::{Path, PathBuf};

/// The program, which cargo builds with the tests.
pub(super) fn program() -> PathBuf {
    PathBuf::from(env!("CARGO_BIN_EXE_bathyscope"))
}

/// Reads the manifest of a run.
pub(super) fn manifest(folder: &Path) -> Value {
    let text = std::fs::read(folder.join("manifest.json")).expect("a manifest");
    serde_json::from_slice(&text).expect("JSON")
}

/// Reads the entry of one file in the manifest of a run.
pub(super) fn manifest_entry(folder: &Path, name: &str) -> Value {
    let manifest = manifest(folder);
    let mut files = manifest["files"].as_array().expect("files").iter();
    let entry = files.find(|file| file["file"] == name);
    entry.unwrap_or_else(|| panic!("{name} is not in it")).clone()
}

/// Returns the options for the comparison of pictures with those in `tests/snapshots/`. lavapipe
/// compiles for the processor it runs on, so the last bit of a colour and the odd pixel of an edge
/// differ between machines, up to 45 of a map; a changed picture differs in far more.
pub(super) fn snapshot_options() -> egui_kittest::SnapshotOptions {
    egui_kittest::SnapshotOptions::new().threshold(1.0).max_failed_pixels(64usize)
}
