//! The cells that the side-scan mosaic of a run has.

use crate::pipeline::Mosaic;
use bathyscope_bottom::bathymetry::Grid;
use bathyscope_bottom::mosaic::{TILE_CELLS, joint_grid};

/// Most tiles that a mosaic may span, with those that hold nothing: a fix that is far off makes a
/// huge, empty map.
const MOST_TILES: usize = 1_000_000;

/// Reason why there is no mosaic.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NoMosaic {
    /// There are no echoes that have a place.
    #[error("no mosaic: no ping has side-scan, a place, a heading and an altitude")]
    NoPings,
    /// It would span more than any file.
    #[error(
        "no mosaic: it would have {columns} by {rows} cells; choose a larger mosaic.cell_m, or look for positions that are far off"
    )]
    TooManyCells {
        /// Cells from west to east.
        columns: usize,
        /// Cells from north to south.
        rows: usize,
    },
}

/// The cells of the file with a mosaic, where there is one.
///
/// # Errors
/// When it cannot be drawn.
pub(super) fn mosaic_grid(mosaic: Option<&Mosaic>, cell_m: f64) -> Result<Grid, NoMosaic> {
    let grid = mosaic.and_then(|mosaic| joint_grid(&mosaic.logs, cell_m));
    let grid = grid.ok_or(NoMosaic::NoPings)?;
    let [down, across] = [grid.rows, grid.columns].map(|cells| cells.div_ceil(TILE_CELLS));
    if down.saturating_mul(across) > MOST_TILES {
        return Err(NoMosaic::TooManyCells { columns: grid.columns, rows: grid.rows });
    }
    Ok(grid)
}
