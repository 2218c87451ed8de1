//! Folders of logs in the place of logs.

use bathyscope_log::formats;
use std::path::PathBuf;

/// The paths, with each folder of several logs replaced by these. A recording of several files is a
/// folder, too, and stays.
pub(super) fn logs(paths: &[PathBuf]) -> Vec<PathBuf> {
    let each = paths.iter().flat_map(|path| {
        let logs = formats::logs_in(path);
        match logs.len() {
            0 | 1 => vec![path.clone()],
            _ => logs,
        }
    });
    each.collect()
}
