//! Writes the side-scan mosaic.

use super::content::{FileContent, FileResult};
use super::results::Results;
use crate::export::{Summary, geotiff, raster_over};
use bathyscope_bottom::bathymetry::Grid;
use bathyscope_bottom::mosaic::{Colours, MosaicLog, TILE_CELLS, TileIndex, joint_tile};
use bathyscope_log::formats::geotiff::{Band, CellFormat, RASTER_TILE, RasterSpec};
use bathyscope_log::support::geo::MapPlane;
use std::collections::BTreeSet;
use std::path::Path;

/// Writes `mosaic.tif`: all side-scan echoes in the coordinate system of the setting `crs`, as a
/// GeoTIFF with one band of levels with a mask, or with colours and opacity. Memory does not grow
/// with the area.
pub(super) fn write(results: &Results<'_>, path: &Path) -> FileResult {
    let (settings, map) = (&results.products.settings.mosaic, &results.map);
    let mosaic = results.mosaic()?;
    let grid = results.mosaic_grid(mosaic.as_deref())?;
    let logs = mosaic.as_ref().map_or(&[][..], |mosaic| &mosaic.logs);
    let indices: Vec<TileIndex> = logs.iter().map(|log| log.layout.index(&grid)).collect();
    let parts: Vec<(&MosaicLog, &TileIndex)> = logs.iter().zip(&indices).collect();
    let places: BTreeSet<(usize, usize)> = indices.iter().flat_map(TileIndex::tiles).collect();
    let places: Vec<[usize; 2]> = (places.into_iter()).map(|(row, column)| [row, column]).collect();
    let draw = |place: [usize; 2]| {
        let levels = joint_tile(&parts, &grid, settings, place);
        Ok(match settings.colours {
            Colours::Grey => levels,
            Colours::Copper => {
                (levels.iter()).flat_map(|&level| settings.colours.rgba(level)).collect()
            }
        })
    };
    let spec = spec(&grid, map, &results.name(), settings.colours);
    geotiff(path, &spec, &places, draw, results.progress)?;
    Ok(FileContent::in_system(&map.crs, summary(&grid, map)))
}

fn summary(grid: &Grid, map: &MapPlane) -> Summary {
    let mut summary = Summary { count: grid.len(), ..Summary::default() };
    let [west_m, south_m, east_m, north_m] = grid.bounds_m();
    summary.reach(map.in_crs([west_m, north_m]));
    summary.reach(map.in_crs([east_m, south_m]));
    summary
}

const _: () = assert!(TILE_CELLS == RASTER_TILE, "a tile is drawn as it is stored");

fn spec(grid: &Grid, map: &MapPlane, name: &str, colours: Colours) -> RasterSpec {
    // Levels are one band, which a map program can stretch; colours are a picture.
    let (cells, band) = match colours {
        Colours::Grey => (CellFormat::Level, Some(Band::ECHO_LEVEL)),
        Colours::Copper => (CellFormat::Rgba, None),
    };
    RasterSpec {
        cells,
        band,
        description: format!("Side-scan mosaic of {name}"),
        ..raster_over(grid, map)
    }
}
