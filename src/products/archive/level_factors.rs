//! Computes the brightness of the echoes of each log relative to the others, from places that
//! several parts of the mosaic show.

use super::MOSAIC;
use super::log_mosaic::{in_words, open_part};
use super::log_record::LogRecord;
use super::offsets::{LevelFactor, Offsets, solve};
use super::record::Archive;
use super::tile::TileId;
use crate::Error;
use bathyscope_bottom::bathymetry::Grid;
use bathyscope_bottom::bathymetry::height_offsets::LogOverlap;
use bathyscope_bottom::mosaic::{Gain, LEVEL_CELL_M, level_differences, level_factor};
use bathyscope_log::formats::geotiff::RASTER_TILE;
use bathyscope_log::support::progress::Progress;
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Returns the factors of all logs. Known logs keep their factors, and new logs are matched to
/// them, so that an added log makes only the mosaics of its own tiles stale. All factors are 1
/// where the mosaic shows levels as recorded.
///
/// # Errors
/// When a part of the mosaic cannot be read, or the work was cancelled.
pub(super) fn level_factors(
    archive: &Archive,
    logs: &[LogRecord],
    known: &Offsets,
    progress: &Progress,
) -> Result<Vec<LevelFactor>, Error> {
    if archive.record.settings()?.mosaic.gain == Gain::Recorded {
        return Ok(vec![LevelFactor::NONE; logs.len()]);
    }
    let held = |log: &LogRecord| {
        let row = known.row(&log.log)?;
        (row.is_pinned || row.level.ties > 0).then_some(row.level)
    };
    let held: Vec<Option<LevelFactor>> = logs.iter().map(held).collect();
    let mut tiles: BTreeMap<TileId, Vec<usize>> = BTreeMap::new();
    for (index, log) in logs.iter().enumerate() {
        for rows in log.tiles.iter().filter(|rows| rows.mosaic_cells > 0) {
            tiles.entry(rows.tile).or_default().push(index);
        }
    }
    tiles.retain(|_, inside| inside.len() > 1 && inside.iter().any(|log| held[*log].is_none()));
    let of_tile = |(tile, inside): (&TileId, &Vec<usize>)| {
        progress.check()?;
        let mut found = log_overlaps(archive, *tile, inside.iter().map(|log| &logs[*log]))?;
        for log_overlap in &mut found {
            log_overlap.logs = log_overlap.logs.map(|log| inside[log]);
        }
        Ok(found)
    };
    let found = tiles.par_iter().map(of_tile);
    let found: Vec<Vec<LogOverlap>> = found.collect::<Result<_, Error>>()?;
    let mut log_overlaps: Vec<LogOverlap> = found.into_iter().flatten().collect();
    log_overlaps.sort_by_key(|log_overlap| log_overlap.logs);
    let mut ties = vec![0; logs.len()];
    for log in log_overlaps.iter().flat_map(|log_overlap| log_overlap.logs) {
        ties[log] += 1;
    }
    let pinned: Vec<Option<f64>> =
        (held.iter()).map(|level| level.map(|level| level.factor.ln())).collect();
    let solved = solve(&log_overlaps, &pinned);
    let factor = |(log, held): (usize, &Option<LevelFactor>)| {
        held.unwrap_or_else(|| LevelFactor {
            factor: (1e3 * level_factor(solved.logs[log].offset_m)).round() / 1e3,
            ties: ties[log],
        })
    };
    Ok(held.iter().enumerate().map(factor).collect())
}

/// Returns the level differences where logs of a tile show the same place, in cells of about a
/// metre. The logs are named by their indices in `logs`.
fn log_overlaps<'a>(
    archive: &Archive,
    tile: TileId,
    logs: impl Iterator<Item = &'a LogRecord>,
) -> Result<Vec<LogOverlap>, Error> {
    let fine = archive.record.mosaic_grid(tile)?;
    let halvings = halvings(fine.cell_m, fine.columns);
    let cells = (0..halvings).fold(fine.columns, |cells, _| cells.div_ceil(2));
    let grid = Grid {
        cell_m: fine.cell_m * f64::from(1 << halvings),
        columns: cells,
        rows: cells,
        ..fine
    };
    let levels = logs.map(|log| {
        let (part, path) = open_part(archive, MOSAIC, tile, &log.log)?;
        let levels = part.overview(halvings);
        levels.map_err(|error| Error::from(in_words(&error, &path)))
    });
    let levels: Vec<Vec<u8>> = levels.collect::<Result<_, Error>>()?;
    Ok(level_differences(&levels, &grid))
}

/// Number of times that the raster is reduced to half its size so that its cells are about a metre;
/// at most the number of overviews that a raster of this many cells has.
fn halvings(cell_m: f64, cells: usize) -> usize {
    let wanted = (LEVEL_CELL_M / cell_m).log2().round().max(0.0) as usize;
    let there = (cells as f64 / RASTER_TILE as f64).log2().ceil().max(0.0) as usize;
    wanted.min(there)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_are_compared_in_cells_of_about_a_metre() {
        assert_eq!(
            [0.1, 0.125, 0.25, 0.5, 1.0, 2.0].map(|m| halvings(m, (512.0 / m) as usize)),
            [3, 3, 2, 1, 0, 0]
        );
    }
}
