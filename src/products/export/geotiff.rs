//! Rasters as GeoTIFF files.

use super::atomic_write::{ExportError, scratch_near, write_atomically};
use bathyscope_log::formats::geotiff::{self, RasterSpec};
use bathyscope_log::support::progress::{Cancelled, Progress};
use std::io;
use std::path::Path;

/// Error of writing a raster.
#[derive(Debug, thiserror::Error)]
pub enum RasterError {
    /// The file could not be written.
    #[error(transparent)]
    Write(#[from] ExportError),
    /// Cancelled.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

/// Writes a GeoTIFF as [`geotiff::write`] lays it out. On the way its tiles lie in a second file
/// beside the first, where there is room for them.
///
/// # Errors
/// When the file cannot be written, a tile cannot be drawn, or the work was cancelled; none of them
/// leaves a file.
pub fn geotiff(
    path: &Path,
    spec: &RasterSpec,
    tiles: &[[usize; 2]],
    draw: impl Fn([usize; 2]) -> io::Result<Vec<u8>> + Sync,
    progress: &Progress,
) -> Result<(), RasterError> {
    let written = write_atomically(path, |file| {
        geotiff::write(file, scratch_near(path)?, spec, tiles, draw, progress)
    });
    progress.check()?;
    Ok(written?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use bathyscope_log::formats::geotiff::{CellFormat, RASTER_TILE};
    use bathyscope_log::support::geo::Crs;

    #[test]
    fn a_raster_is_one_file_and_a_cancelled_one_is_none() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.tif");
        let spec = RasterSpec {
            columns: 300,
            rows: 300,
            west: 500_000.0,
            north: 4_000_000.0,
            cell: [0.5, 0.5],
            crs: Crs::from_epsg(32_612).unwrap(),
            cells: CellFormat::Level,
            band: None,
            description: "echoes".into(),
        };
        let draw = |_| Ok(vec![1; RASTER_TILE * RASTER_TILE]);
        let files = || std::fs::read_dir(folder.path()).unwrap().count();
        let cancelled = Progress::new();
        cancelled.cancel();
        let stopped = geotiff(&path, &spec, &[[0, 0]], draw, &cancelled);
        assert!(matches!(stopped, Err(RasterError::Cancelled(_))));
        assert_eq!(files(), 0);
        geotiff(&path, &spec, &[[0, 0]], draw, &Progress::new()).unwrap();
        assert!(path.is_file());
        assert_eq!(files(), 1);
    }
}
