//! Point files with some of their points.

use super::{ExportError, write_atomically};
use bathyscope_log::formats::points::{PointFile, PointFormat};
use std::path::Path;

/// Writes the points whose flag is set.
///
/// # Errors
/// When the file cannot be written, or the format cannot hold the points.
pub fn kept_points(
    path: &Path,
    format: PointFormat,
    points: &PointFile,
    kept: &[bool],
) -> Result<(), ExportError> {
    write_atomically(path, |file| points.write_kept(file, format, kept))
}
