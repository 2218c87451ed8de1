//! One mosaic of several logs: its grid, and levels that are alike where logs show the same ground.
//!
//! Each log is normalised by itself, to its own mean level. Where one went over gravel and another
//! over mud, the same ground would be darker in the one than in the other, and the edge of a swath
//! a step. What both show of the same cells tells by how much.

use super::layout::{Bounds, bounds_of, grid_over};
use super::{Gain, MosaicLog, MosaicSettings, Overlap, window};
use crate::bathymetry::Grid;
use crate::bathymetry::height_offsets::{Datum, LogOverlap, OverlapKind, adjust};
use bathyscope_log::support::progress::{Cancelled, Progress};
use std::collections::BTreeMap;

/// Side of the cells in which levels are compared, metres, and most such cells along a side:
/// beyond, the cells are larger.
pub const LEVEL_CELL_M: f64 = 1.0;
const MOST_CELLS: f64 = 2000.0;
/// Cells of a block give one difference, since neighbours show the same echoes: its side in cells,
/// and the fewest cells.
const BLOCK_CELLS: usize = 10;
const LEAST_CELLS: usize = 10;
/// Bounds of the factor that makes logs alike: beyond them they show different things.
const FACTORS: [f64; 2] = [0.25, 4.0];

/// The factor on the levels of a log whose logarithm an adjustment of differences gives.
pub fn level_factor(ln: f64) -> f64 {
    ln.exp().clamp(FACTORS[0], FACTORS[1])
}

/// Differences of the logarithms of levels where logs show the same ground. Each has all cells of a
/// grid of about [`LEVEL_CELL_M`], 0 where it shows nothing; the overlaps name logs by their places
/// in the list.
pub fn level_differences(logs: &[Vec<u8>], grid: &Grid) -> Vec<LogOverlap> {
    let band = BLOCK_CELLS * grid.columns;
    let mut found = Vec::new();
    // A row of blocks at a time, which is little to hold of many logs.
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

/// Bounds of all logs: west, south, east and north, metres; `None` when nothing is shown.
pub fn joint_bounds(logs: &[MosaicLog]) -> Option<Bounds> {
    bounds_of(logs.iter().map(|log| &*log.layout))
}

/// The grid that holds what all logs show, its edges at whole cells; `None` when nothing is shown.
pub fn joint_grid(logs: &[MosaicLog], cell_m: f64) -> Option<Grid> {
    joint_bounds(logs).map(|bounds| grid_over(bounds, cell_m))
}

/// Brings the levels of the logs to each other where they show the same ground, each by one factor:
/// those whose logarithms fit the differences best by robust least squares, and which leave the
/// mean brightness as it is. Nothing changes where levels are shown as recorded.
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

/// Differences of the logarithms of levels, one for each block that two logs show.
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
