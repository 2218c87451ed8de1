//! Writes the cells of the surface as rasters and as text, and the side-scan mosaic. Rasters of the
//! surface are metres as f32 on one grid, and the source of the depths. The description of each
//! states the corrections, applied or not, and beside each are its colours for QGIS (`.qml`).

use super::content::{FileContent, FileResult};
use super::results::Results;
use crate::export::{
    self, Summary, geotiff, metres_raster, qgis_classes, qgis_style, raster_over, source_raster,
};
use bathyscope_bottom::bathymetry::isobaths::shoalest_m;
use bathyscope_bottom::bathymetry::{CellSource, Grid, Spread, Surface};
use bathyscope_bottom::mosaic::{Colours, MosaicLog, TILE_CELLS, TileIndex, joint_tile};
use bathyscope_bottom::presentation::colours::{
    Rgb, depth_colour, distance_colour, share_colour, uncertainty_colour,
};
use bathyscope_log::formats::geotiff::{Band, CellFormat, RASTER_TILE, RasterSpec};
use bathyscope_log::support::geo::MapPlane;
use std::collections::BTreeSet;
use std::path::Path;

/// Descriptions of rasters, in their files and in the manifest.
pub(super) const DEPTH: &str = "Depth in metres, positive down";
pub(super) const SPREAD: &str = "Standard deviation in metres of the depths that carry a cell";
pub(super) const DISTANCE: &str = "Distance in metres from a cell to the nearest depth";
pub(super) const SHOALEST: &str =
    "Shoalest depth in metres that was measured in a cell, positive down";

const fn band(name: &'static str, positive_down: bool) -> Band {
    Band { name, unit: "metre", positive_down }
}

/// Number of steps of the colours in a style.
const STEPS: usize = 10;

/// Writes `depth.tif`.
pub(super) fn depth(results: &Results<'_>, path: &Path) -> FileResult {
    let values = &results.surface()?.depth_m;
    write(results, path, band("depth", true), DEPTH, depth_colour, values)
}

/// Writes `uncertainty.tif`.
pub(super) fn uncertainty(results: &Results<'_>, path: &Path) -> FileResult {
    let surface = results.surface()?;
    let what = match surface.spread_is {
        Spread::OfError => {
            "Standard deviation in metres of the depth's error, as left-out depths show it"
        }
        Spread::OfSoundings => SPREAD,
    };
    let band = band("standard deviation of depth", false);
    write(results, path, band, what, uncertainty_colour, &surface.spread_m)
}

/// Writes `distance.tif`.
pub(super) fn distance(results: &Results<'_>, path: &Path) -> FileResult {
    let band = band("distance to the nearest depth", false);
    let values = &results.surface()?.distance_m;
    write(results, path, band, DISTANCE, distance_colour, values)
}

/// Writes `shoalest.tif`.
pub(super) fn shoalest(results: &Results<'_>, path: &Path) -> FileResult {
    let depth_map = results.needed_depth_map()?;
    let points = depth_map.depth_points(results.progress)?;
    let values = shoalest_m(&depth_map.surface.grid, &points);
    write(results, path, band("shoalest depth", true), SHOALEST, depth_colour, &values)
}

/// Writes `hardness.tif`.
pub(super) fn hardness(results: &Results<'_>, path: &Path) -> FileResult {
    let band = Band { unit: "decibel", ..band("brightness of the bed over the median", false) };
    let what = "How much brighter the bed is than the median of the map, decibels of power, as echo levels tell it: without slope, angle, range and gain";
    let values = results.surface()?.hardness_db.as_deref().unwrap_or_default();
    write(results, path, band, what, share_colour, values)
}

/// Writes `source.tif`.
pub(super) fn source(results: &Results<'_>, path: &Path) -> FileResult {
    let surface = results.surface()?;
    let (grid, map) = (&surface.grid, &results.map);
    let spec = raster_over(grid, map);
    let about = format!("{}. {}", results.survey.name(), results.applied(surface));
    source_raster(path, spec, surface, &about, results.progress)?;
    qgis_classes(&path.with_extension("qml"), &CellSource::classes())?;
    let values = surface.source.iter().map(|source| match source {
        CellSource::None => f32::NAN,
        source => f32::from(*source as u8),
    });
    let values: Vec<f32> = values.collect();
    Ok(FileContent::in_system(&map.crs, summary(map, grid, &values)))
}

/// Writes `mosaic.tif`: all side-scan echoes in the coordinate system of the setting `crs`, as a
/// GeoTIFF with one band of levels with a mask, or with colours and opacity. Memory does not grow
/// with the area.
pub(super) fn mosaic(results: &Results<'_>, path: &Path) -> FileResult {
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
    // Levels are one band, which a map program can stretch; colours are a picture.
    let (cells, band) = match settings.colours {
        Colours::Grey => (CellFormat::Level, Some(Band::ECHO_LEVEL)),
        Colours::Copper => (CellFormat::Rgba, None),
    };
    let spec = RasterSpec {
        cells,
        band,
        description: format!("Side-scan mosaic of {}", results.name()),
        ..raster_over(&grid, map)
    };
    geotiff(path, &spec, &places, draw, results.progress)?;
    let summary = Summary { count: grid.len(), ..summary(map, &grid, &[]) };
    Ok(FileContent::in_system(&map.crs, summary))
}

const _: () = assert!(TILE_CELLS == RASTER_TILE, "a tile is drawn as it is stored");

/// Writes `depth.xyz`: the middles of the cells that have a depth.
pub(super) fn xyz(results: &Results<'_>, path: &Path) -> FileResult {
    let surface = results.surface()?;
    let map = &results.map;
    let cells = known_cells(surface, map).map(|(_, place, depth_m)| (place, depth_m));
    let decimals = if map.crs.is_degrees() { 9 } else { 3 };
    let cells = export::depth_xyz(path, decimals, cells, results.progress)?;
    Ok(FileContent::in_system(&map.crs, cells))
}

/// Returns the cells that have a depth: index, middle in the coordinate system of the map, depth.
pub(super) fn known_cells<'a>(
    surface: &'a Surface,
    map: &'a MapPlane,
) -> impl Iterator<Item = (usize, [f64; 2], f32)> + 'a {
    let grid = &surface.grid;
    let known = surface.depth_m.iter().enumerate().filter(|(_, depth_m)| !depth_m.is_nan());
    known.map(move |(index, &depth_m)| (index, map.in_crs(grid.centre_of(index)), depth_m))
}

/// Writes a raster with a value for each cell of the surface, NaN where none is known, and its
/// colours beside it.
fn write(
    results: &Results<'_>,
    path: &Path,
    band: Band,
    what: &str,
    colour: fn(f32) -> Rgb,
    values: &[f32],
) -> FileResult {
    let surface = results.surface()?;
    let (grid, map) = (&surface.grid, &results.map);
    let applied = results.applied(surface);
    let spec = RasterSpec {
        cells: CellFormat::Metres,
        band: Some(band),
        description: format!("{what}; {}. {applied}", results.survey.name()),
        ..raster_over(grid, map)
    };
    metres_raster(path, &spec, grid, values, results.progress)?;
    let summary = summary(map, grid, values);
    let range = summary.values.unwrap_or_default();
    qgis_style(&path.with_extension("qml"), range, STEPS, colour)?;
    Ok(FileContent::in_system(&spec.crs, summary))
}

/// Returns the number and range of the known values, and the extent of the whole raster.
fn summary(map: &MapPlane, grid: &Grid, values: &[f32]) -> Summary {
    let mut summary = Summary::default();
    let known = values.iter().filter(|value| !value.is_nan());
    known.for_each(|value| summary.add([f64::NAN; 2], f64::from(*value)));
    let [west_m, south_m, east_m, north_m] = grid.bounds_m();
    summary.reach(map.in_crs([west_m, north_m]));
    summary.reach(map.in_crs([east_m, south_m]));
    summary
}
