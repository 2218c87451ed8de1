//! Prepares one mosaic of several logs: its grid, and levels that match where the logs show the
//! same ground.
//!
//! Each log is normalised independently, to its own mean level. If one log covers gravel and
//! another mud, the same ground is darker in the first than in the second, and the edge of a swath
//! is a visible step. The cells that both logs show determine the difference.

use super::layout::{Bounds, bounds_of, grid_over};
use super::{Gain, MosaicLog, MosaicSettings, Overlap, window};
use crate::bathymetry::Grid;
use crate::bathymetry::height_offsets::{Datum, LogOverlap, OverlapKind, adjust};
use bathyscope_log::support::progress::{Cancelled, Progress};
use std::collections::BTreeMap;

/// Side of the cells in which levels are compared, metres, and largest number of such cells along a
/// side: above it, the cells are larger.
pub const LEVEL_CELL_M: f64 = 1.0;
const MOST_CELLS: f64 = 2000.0;
/// Side in cells of a block, and the least number of cells in it. A block gives one difference,
/// since neighbouring cells show the same echoes.
const BLOCK_CELLS: usize = 10;
const LEAST_CELLS: usize = 10;
/// Bounds of the factor on a log: beyond them the logs show different ground.
const FACTORS: [f64; 2] = [0.25, 4.0];

/// Returns the factor on the levels of a log, within bounds; `ln` is its logarithm, from an
/// adjustment of differences.
pub fn level_factor(ln: f64) -> f64 {
    ln.exp().clamp(FACTORS[0], FACTORS[1])
}

/// Returns the differences of the logarithms of levels where logs show the same ground. Each
/// element of `logs` holds the levels of all cells of a grid of about [`LEVEL_CELL_M`], 0 where the
/// log shows nothing; the overlaps identify logs by their indices in `logs`.
pub fn level_differences(logs: &[Vec<u8>], grid: &Grid) -> Vec<LogOverlap> {
    let band = BLOCK_CELLS * grid.columns;
    let mut found = Vec::new();
    // One row of blocks at a time takes little memory for many logs.
    for first in (0..grid.len()).step_by(band.max(1)) {
        let mut cells: BTreeMap<usize, Vec<(usize, u8)>> = BTreeMap::new();
        for (index, levels) in logs.iter().enumerate() {
            let levels = levels.iter().enumerate().skip(first).take(band);
            for (cell, level) in levels.filter(|(_, level)| **level > 0) {
                cells.entry(cell).or_default().push((index, *level));
            }
        }
        found.extend(differences(&cells, grid));
    }
    found
}

/// Returns the bounds of all logs: west, south, east and north, metres; `None` when nothing is
/// shown.
pub fn joint_bounds(logs: &[MosaicLog]) -> Option<Bounds> {
    bounds_of(logs.iter().map(|log| &*log.layout))
}

/// Returns the grid that holds the ground of all logs, its edges at whole cells; `None` when
/// nothing is shown.
pub fn joint_grid(logs: &[MosaicLog], cell_m: f64) -> Option<Grid> {
    joint_bounds(logs).map(|bounds| grid_over(bounds, cell_m))
}

/// Matches the levels of the logs where they show the same ground, by one factor for each log. The
/// logarithms of the factors fit the differences best by robust least squares, with a mean of 0, so
/// that the mean brightness stays. Nothing changes where levels are shown as recorded.
///
/// # Errors
/// When the work was cancelled.
pub fn match_levels(
    mut logs: Vec<MosaicLog>,
    settings: &MosaicSettings,
    progress: &Progress,
) -> Result<Vec<MosaicLog>, Cancelled> {
    let sides = joint_grid(&logs, LEVEL_CELL_M).map(|grid| grid.columns.max(grid.rows) as f64);
    let Some(most) = sides.filter(|_| logs.len() > 1 && settings.gain == Gain::Empirical) else {
        return Ok(logs);
    };
    let cell_m = LEVEL_CELL_M * (most / MOST_CELLS).max(1.0);
    let Some(grid) = joint_grid(&logs, cell_m) else {
        return Ok(logs);
    };
    let coarse = MosaicSettings { cell_m, overlap: Overlap::Blend, ..settings.clone() };
    let mut cells: BTreeMap<usize, Vec<(usize, u8)>> = BTreeMap::new();
    for (index, log) in logs.iter().enumerate() {
        let thinned = log.layout.thinned(cell_m);
        let levels = window(&log.survey, &thinned, &grid, &log.gain, &coarse, progress)?;
        let shown = levels.into_iter().enumerate().filter(|(_, level)| *level > 0);
        for (cell, level) in shown {
            cells.entry(cell).or_default().push((index, level));
        }
    }
    let found = adjust(logs.len(), &differences(&cells, &grid), Datum::Mean);
    for (log, offset) in logs.iter_mut().zip(found.logs) {
        let factor = level_factor(offset.offset_m);
        log.gain = log.gain.clone().brightened(factor as f32);
    }
    Ok(logs)
}

/// Returns differences of the logarithms of levels, one for each block that two logs show.
fn differences(cells: &BTreeMap<usize, Vec<(usize, u8)>>, grid: &Grid) -> Vec<LogOverlap> {
    let mut blocks: BTreeMap<([usize; 2], [usize; 2]), Vec<f64>> = BTreeMap::new();
    for (cell, logs) in cells {
        let block = [cell / grid.columns, cell % grid.columns].map(|place| place / BLOCK_CELLS);
        for (rank, &(first, first_level)) in logs.iter().enumerate() {
            for &(second, second_level) in &logs[rank + 1..] {
                let ratio = f64::from(second_level) / f64::from(first_level);
                blocks.entry(([first, second], block)).or_default().push(ratio.ln());
            }
        }
    }
    let enough = blocks.into_iter().filter(|(_, ratios)| ratios.len() >= LEAST_CELLS);
    enough
        .map(|((logs, [row, column]), mut ratios)| {
            let place = grid.centre(row * BLOCK_CELLS, column * BLOCK_CELLS);
            let difference = bathyscope_log::support::statistics::median(&mut ratios);
            LogOverlap::new(logs, OverlapKind::Overlap, place, difference, 0.0)
        })
        .collect()
}
