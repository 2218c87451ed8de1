//! The folders and files of an archive, by name.

use super::error::ArchiveError;
use crate::pipeline::Fingerprint;
use bathyscope_log::support::progress::Progress;
use std::fs;
use std::io::ErrorKind;
use std::path::Path;

/// The subfolder of the rows.
pub(super) const POINTS: &str = "points";
/// The subfolder of the rows.
pub(super) const PINGS: &str = "pings";
/// The subfolder of the rows.
pub(super) const ECHOES: &str = "echoes";
/// The subfolder of the levels.
pub(super) const MOSAIC: &str = "mosaic";
/// The subfolder of what the levels count.
pub(super) const WEIGHTS: &str = "mosaic_weights";
/// The folder of the records.
pub(super) const LOGS: &str = "logs";
/// The folders of what logs give to tiles, with the endings of their files.
pub(super) const KINDS: [(&str, &str); 5] = [
    (POINTS, "parquet"),
    (PINGS, "parquet"),
    (ECHOES, "parquet"),
    (MOSAIC, "tif"),
    (WEIGHTS, "tif"),
];
/// Longer than any record.
pub(super) const LONGEST_RECORD: u64 = 1 << 26;

/// The names in a folder; none where there is no folder.
pub(super) fn names_in(folder: &Path) -> Result<Vec<String>, ArchiveError> {
    if !folder.exists() {
        return Ok(Vec::new());
    }
    let fail = |error| format!("cannot read the folder: {error}: {}", folder.display());
    let entries = fs::read_dir(folder).map_err(fail)?;
    let names = entries.map(|entry| {
        let name = entry.map_err(fail)?.file_name();
        Ok(name.to_string_lossy().into_owned())
    });
    names.collect()
}

/// Removes a file, if it is there.
pub(super) fn remove(path: &Path) -> Result<(), ArchiveError> {
    match fs::remove_file(path) {
        Err(error) if error.kind() != ErrorKind::NotFound => {
            Err(format!("cannot remove the file: {error}: {}", path.display()).into())
        }
        _ => Ok(()),
    }
}

/// Computes the fingerprint of a file in a folder.
pub(super) fn fingerprint(
    folder: &Path,
    name: &str,
    progress: &Progress,
) -> Result<Fingerprint, ArchiveError> {
    let fail = |error| format!("cannot read the file: {error}: {}", folder.join(name).display());
    Ok(Fingerprint::of(folder, name, progress).map_err(fail)?)
}
