//! Writes the side-scan mosaic.

use super::manifest::{Coordinates, FileContent};
use super::results::Results;
use crate::bottom::bathymetry::Grid;
use crate::formats::geotiff::{Band, Cells, RASTER_TILE, RasterSpec};
use crate::imagery::mosaic::{Colours, MosaicLog, TILE_CELLS, TileIndex, joint_grid, joint_tile};
use crate::products::export::{Summary, geotiff};
use crate::products::outputs::OutputError;
use crate::products::outputs::raster;
use crate::support::geo::MapPlane;
use std::collections::BTreeSet;
use std::path::Path;

/// Most tiles that a mosaic may span, with those that hold nothing: a fix that is far off makes a huge, empty map.
const MOST_TILES: usize = 1_000_000;

/// Why there is no mosaic.
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

/// The cells of the file; why it cannot be drawn.
///
/// # Errors
/// When the work was cancelled.
pub fn grid(results: &Results<'_>) -> Result<Result<Grid, NoMosaic>, OutputError> {
    let cell_m = results.products.settings.mosaic.cell_m;
    let Some(grid) = (results.mosaic()?).and_then(|mosaic| joint_grid(&mosaic.logs, cell_m)) else {
        return Ok(Err(NoMosaic::NoPings));
    };
    let [down, across] = [grid.rows, grid.columns].map(|cells| cells.div_ceil(TILE_CELLS));
    if down.saturating_mul(across) > MOST_TILES {
        return Ok(Err(NoMosaic::TooManyCells {
            columns: grid.columns,
            rows: grid.rows,
        }));
    }
    Ok(Ok(grid))
}

/// Writes `mosaic.tif`: all side-scan echoes in the system that `crs` names, as a GeoTIFF: one band of levels with a mask, or colours
/// with opacity. Memory does not grow with the area.
pub fn write(results: &Results<'_>, path: &Path) -> Result<FileContent, OutputError> {
    let (settings, map) = (&results.products.settings.mosaic, &results.plane.map);
    let grid = grid(results)??;
    let mosaic = results.mosaic()?;
    let logs = mosaic.as_ref().map_or(&[][..], |mosaic| &mosaic.logs);
    let indices: Vec<TileIndex> = logs.iter().map(|log| log.layout.index(&grid)).collect();
    let parts: Vec<(&MosaicLog, &TileIndex)> = logs.iter().zip(&indices).collect();
    let places: BTreeSet<(usize, usize)> = indices.iter().flat_map(TileIndex::tiles).collect();
    let places: Vec<[usize; 2]> = (places.into_iter())
        .map(|(row, column)| [row, column])
        .collect();
    let draw = |place: [usize; 2]| {
        let levels = joint_tile(&parts, &grid, settings, place).levels;
        Ok(match settings.colours {
            Colours::Grey => levels,
            Colours::Copper => (levels.iter())
                .flat_map(|&level| settings.colours.rgba(level))
                .collect(),
        })
    };
    let spec = spec(&grid, map, &results.name(), settings.colours);
    geotiff(path, &spec, &places, draw, results.progress)?;
    Ok(FileContent::new(
        Coordinates::System(map.crs.clone()),
        summary(&grid, map),
    ))
}

fn summary(grid: &Grid, map: &MapPlane) -> Summary {
    let mut summary = Summary {
        count: grid.len(),
        ..Summary::default()
    };
    let (width_m, height_m) = (
        grid.columns as f64 * grid.cell_m,
        grid.rows as f64 * grid.cell_m,
    );
    summary.reach(map.in_crs([grid.west_m, grid.north_m]));
    summary.reach(map.in_crs([grid.west_m + width_m, grid.north_m - height_m]));
    summary
}

const _: () = assert!(TILE_CELLS == RASTER_TILE, "a tile is drawn as it is stored");

fn spec(grid: &Grid, map: &MapPlane, name: &str, colours: Colours) -> RasterSpec {
    // Levels are one band, which a map program can stretch; colours are a picture.
    let (cells, band) = match colours {
        Colours::Grey => (Cells::Level, Some(Band::ECHO_LEVEL)),
        Colours::Copper => (Cells::Rgba, None),
    };
    RasterSpec {
        cells,
        band,
        description: format!("Side-scan mosaic of {name}"),
        ..raster::over(grid, map)
    }
}
