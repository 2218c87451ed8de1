//! Prepares one mosaic of several logs: its grid, the outline of the insonified ground, and levels
//! that match where the logs show the same ground.
//!
//! Each log is normalised independently, to its own mean level. If one log covers gravel and
//! another mud, the same ground is darker in the first than in the second, and the edge of a swath
//! is a visible step. The cells that both logs show determine the difference.

use super::canvas::Scan;
use super::layout::{Bounds, bounds_of, grid_over};
use super::{Gain, MosaicLayout, MosaicLog, MosaicSettings, Overlap, window};
use crate::bathymetry::height_offsets::{Datum, LogOverlap, OverlapKind, adjust};
use crate::bathymetry::isobaths::{Polygon, depth_areas};
use crate::bathymetry::{Grid, Surface};
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

/// Side of the squares that the ground is sampled with, metres; longer where there would be more
/// than [`MOST_SQUARES`] along a side.
const SQUARE_M: f64 = 0.5;
const MOST_SQUARES: f64 = 2000.0;

/// Returns the polygons of the ground that the strips of all logs cover, in the plane that their
/// layouts share, to half a square. Empty where nothing is shown.
///
/// # Errors
/// When the work was cancelled.
pub fn footprint(layouts: &[MosaicLayout], progress: &Progress) -> Result<Vec<Polygon>, Cancelled> {
    let Some(bounds) = bounds_of(layouts.iter()) else {
        return Ok(Vec::new());
    };
    let rough = grid_over(bounds, SQUARE_M);
    let most = rough.columns.max(rough.rows) as f64;
    let side_m = SQUARE_M * (most / MOST_SQUARES).max(1.0);
    let inner = grid_over(bounds, side_m);
    // One more square on every side, so that the outline closes within the grid.
    let grid = Grid {
        west_m: inner.west_m - inner.cell_m,
        north_m: inner.north_m + inner.cell_m,
        columns: inner.columns + 2,
        rows: inner.rows + 2,
        ..inner
    };
    let mut covered = vec![0.0_f32; grid.len()];
    for layout in layouts {
        for (_, _, strip) in layout.strips() {
            progress.check()?;
            cover(&grid, layout.corners(&strip), &mut covered);
        }
    }
    let surface = Surface::of_depths(grid, covered);
    // The grid is 1 where the ground was insonified and 0 elsewhere: its outline lies at 0.5.
    let areas = depth_areas(&surface, &[0.5, 2.0], progress)?;
    Ok(areas.into_iter().flat_map(|area| area.polygons).collect())
}

/// Marks the squares whose centre is in a strip.
fn cover(grid: &Grid, corners: [[f64; 2]; 4], covered: &mut [f32]) {
    let cells = |metres: f64| metres / grid.cell_m - 0.5;
    let corners = corners.map(|[x, y]| [cells(x - grid.west_m), cells(grid.north_m - y)]);
    let scan = Scan::new(&corners, grid.columns, grid.rows);
    for row in scan.rows.clone() {
        let (first, columns) = (row * grid.columns, scan.columns(row));
        if let Some(line) = covered.get_mut(first + columns.start..first + columns.end) {
            line.fill(1.0);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strips_side_by_side_cover_all_between_them() {
        let grid = Grid::at([0.0, 20.0], 0.5, [80, 40]);
        let mut covered = vec![0.0; grid.len()];
        // Thin slanting strips side by side: the parallelogram from x = 1 to 9 at the bottom, 6 m
        // to the right on top.
        for strip in 0..80 {
            let [from, to] = [strip, strip + 1].map(|edge| 1.0 + 0.1 * f64::from(edge));
            cover(
                &grid,
                [[from, 1.0], [from + 6.0, 19.0], [to + 6.0, 19.0], [to, 1.0]],
                &mut covered,
            );
        }
        let squares = covered.iter().filter(|square| **square == 1.0).count();
        let area_m2 = 0.25 * squares as f64;
        assert!((area_m2 - 8.0 * 18.0).abs() < 4.0, "{area_m2}");
    }
}
