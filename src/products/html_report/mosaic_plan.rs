//! Draws the map of echoes: the mosaic with the track and the objects.

use super::frame::PageTransform;
use super::map::map;
use super::{ReportData, raster};
use crate::pipeline::Mosaic;
use bathyscope_bottom::bathymetry::Grid;
use bathyscope_bottom::mosaic::joint_grid;
use bathyscope_bottom::presentation::page::Value;
use bathyscope_log::support::progress::{Cancelled, Progress};
use rayon::prelude::*;

/// Largest number of cells along the longer side: more would not be visible on a screen, and fewer
/// cells make a smaller file.
const MOST_CELLS: f64 = 1500.0;
/// Number of rows that are drawn together.
const BAND_ROWS: usize = 128;
/// Grey level of places that were not insonified.
const PAPER: u8 = 0xf7;

/// Draws the map of all logs; `None` where no ping has side-scan, a place, a heading and an
/// altitude.
pub(super) fn mosaic_plan(
    from: &ReportData<'_>,
    progress: &Progress,
) -> Result<Option<Value>, Cancelled> {
    let Some(mosaic) = from.mosaic else {
        return Ok(None);
    };
    let [west, south, east, north] = mosaic.bounds;
    let extent_m = (east - west).max(north - south);
    let cell_m = (extent_m / MOST_CELLS).max(from.products.settings.mosaic.cell_m);
    let Some(grid) = joint_grid(&mosaic.logs, cell_m) else {
        return Ok(None);
    };
    let Some(frame) = PageTransform::around(grid.bounds_m(), from.map) else {
        return Ok(None);
    };
    let pixels = pixels(mosaic, &grid, progress)?;
    let address = raster::grey(&pixels, grid.columns, grid.rows);
    let picture = frame.picture(&grid, 1, [grid.columns, grid.rows], address);
    Ok(Some(map(from, &frame, picture)))
}

/// Returns the levels of all cells, row by row.
fn pixels(mosaic: &Mosaic, grid: &Grid, progress: &Progress) -> Result<Vec<u8>, Cancelled> {
    let tops: Vec<usize> = (0..grid.rows).step_by(BAND_ROWS).collect();
    progress.start(tops.len() as u64);
    let bands = tops.into_par_iter().map(|top| {
        let band = Grid {
            north_m: grid.north_m - top as f64 * grid.cell_m,
            rows: BAND_ROWS.min(grid.rows - top),
            ..*grid
        };
        let mut levels = mosaic.levels(&band, progress)?;
        for level in levels.iter_mut().filter(|level| **level == 0) {
            *level = PAPER;
        }
        progress.advance(1);
        Ok(levels)
    });
    let bands = bands.collect::<Result<Vec<_>, Cancelled>>()?;
    Ok(bands.concat())
}
