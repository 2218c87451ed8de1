//! Joins the parts of all logs to the mosaic of a tile.

use super::log_mosaic::{in_words, levels_spec, open_part};
use super::log_record::LogRecord;
use super::offsets::Offsets;
use super::record::Archive;
use super::tile::TileId;
use super::{MOSAIC, WEIGHTS};
use crate::Error;
use crate::export::geotiff;
use bathyscope_bottom::mosaic::{MosaicPart, join_parts};
use bathyscope_log::formats::geotiff::{CellsError, RasterTiles};
use bathyscope_log::support::progress::Progress;
use std::collections::BTreeSet;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};

/// Returns the logs that have a part in the mosaic of a tile, in the order in which they are laid
/// over each other: by the time of recording, as in `bathyscope process`. Logs without a known time
/// come first; logs that began at the same time are ordered by their hashes.
pub(super) fn logs_in_order(tile: TileId, logs: &[LogRecord]) -> Vec<&LogRecord> {
    let has_part = |log: &&LogRecord| log.rows_in(tile).is_some_and(|rows| rows.mosaic_cells > 0);
    let mut with_part: Vec<&LogRecord> = logs.iter().filter(has_part).collect();
    let start_s = |log: &LogRecord| log.start_unix_s.unwrap_or(f64::NEG_INFINITY);
    with_part.sort_by(|a, b| {
        let in_time = start_s(a).total_cmp(&start_s(b));
        in_time.then_with(|| a.log.cmp(&b.log))
    });
    with_part
}

/// Writes the mosaic of a tile and returns the number of cells that have a level. Writes no file if
/// there is no such cell. Memory grows neither with the cells nor with the logs.
///
/// # Errors
/// When a part cannot be read, the file cannot be written, or the work was cancelled.
pub(super) fn write_mosaic(
    archive: &Archive,
    tile: TileId,
    logs: &[LogRecord],
    offsets: &Offsets,
    path: &Path,
    progress: &Progress,
) -> Result<usize, Error> {
    let overlap = archive.record.settings()?.mosaic.overlap;
    let grid = archive.record.mosaic_grid(tile)?;
    let parts = (logs_in_order(tile, logs).into_iter())
        .map(|log| {
            let factor = offsets.level_factor(&log.log);
            StoredPart::open(archive, tile, &log.log, overlap.is_weighted(), factor)
        })
        .collect::<Result<Vec<_>, _>>()?;
    if let Some(other) = (parts.iter()).find(|part| part.levels.size() != [grid.columns, grid.rows])
    {
        return Err(Error::from(format!(
            "this part of the mosaic has other cells than the archive; process its log again: {}",
            other.path.display()
        )));
    }
    let places: BTreeSet<[usize; 2]> = parts.iter().flat_map(|part| part.levels.tiles()).collect();
    let places: Vec<[usize; 2]> = places.into_iter().collect();
    if places.is_empty() {
        return Ok(0);
    }
    let cells = AtomicUsize::new(0);
    let draw = |place: [usize; 2]| {
        let here = parts.iter().filter(|part| part.levels.may_hold(place));
        let levels = join_parts(here.map(|part| part.read(place)), overlap)?;
        let known = levels.iter().filter(|level| **level > 0).count();
        cells.fetch_add(known, Ordering::Relaxed);
        Ok(levels)
    };
    let description = format!("Side-scan mosaic of all logs in tile {tile} of an archive");
    let spec = levels_spec(tile, &grid, description);
    geotiff(path, &spec, &places, draw, progress)?;
    Ok(cells.into_inner())
}

/// Files of the part of a log in the mosaic of a tile.
struct StoredPart {
    path: PathBuf,
    levels: RasterTiles,
    weights: Option<RasterTiles>,
    /// Factor on the levels of the log.
    factor: f32,
}

impl StoredPart {
    fn open(
        archive: &Archive,
        tile: TileId,
        log: &str,
        is_weighted: bool,
        factor: f64,
    ) -> Result<Self, Error> {
        let (levels, path) = open_part(archive, MOSAIC, tile, log)?;
        let weights = is_weighted.then(|| open_part(archive, WEIGHTS, tile, log));
        Ok(Self {
            path,
            levels,
            weights: weights.transpose()?.map(|(weights, _)| weights),
            factor: factor as f32,
        })
    }

    fn read(&self, place: [usize; 2]) -> io::Result<MosaicPart> {
        let fail = |error: CellsError| io::Error::other(in_words(&error, &self.path));
        let weights = self.weights.as_ref().map(|weights| weights.values(place));
        let part = MosaicPart {
            levels: self.levels.levels(place).map_err(fail)?,
            weights: weights.transpose().map_err(fail)?.unwrap_or_default(),
        };
        Ok(part.brightened(self.factor))
    }
}
