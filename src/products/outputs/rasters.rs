//! Writes the cells of the surface as rasters and as text. Rasters are metres as f32 on one grid,
//! and the source of the depths. The description of each states the corrections, applied or not,
//! and beside each are its colours for QGIS (`.qml`).

use super::content::{FileContent, FileResult};
use super::results::Results;
use crate::export::{
    self, Summary, metres_raster, qgis_classes, qgis_style, raster_over, source_raster,
};
use bathyscope_bottom::bathymetry::isobaths::shoalest_m;
use bathyscope_bottom::bathymetry::{CellSource, Grid, Spread, Surface};
use bathyscope_bottom::presentation::colours::{
    depth_colour, distance_colour, share_colour, uncertainty_colour,
};
use bathyscope_log::formats::geotiff::{Band, CellFormat, RasterSpec};
use bathyscope_log::support::geo::MapPlane;
use std::path::Path;

/// Descriptions of rasters, in their files and in the manifest.
pub(super) const DEPTH: &str = "Depth in metres, positive down";
pub(super) const SPREAD: &str = "Standard deviation in metres of the depths that carry a cell";
pub(super) const DISTANCE: &str = "Distance in metres from a cell to the nearest depth";
pub(super) const SHOALEST: &str =
    "Shoalest depth in metres that was measured in a cell, positive down";

/// A raster to write.
struct RasterLayer<'a> {
    band: Band,
    what: &'static str,
    colour: fn(f32) -> [u8; 3],
    /// Values of the cells of the surface; NaN where none is known.
    values: &'a [f32],
}

const fn band(name: &'static str, positive_down: bool) -> Band {
    Band { name, unit: "metre", positive_down }
}

/// Number of steps of the colours in a style.
const STEPS: usize = 10;

/// Writes `depth.tif`.
pub(super) fn depth(results: &Results<'_>, path: &Path) -> FileResult {
    let surface = results.surface()?;
    let layer = RasterLayer {
        band: band("depth", true),
        what: DEPTH,
        colour: depth_colour,
        values: &surface.depth_m,
    };
    write(&layer, surface, results, path)
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
    let layer = RasterLayer {
        band: band("standard deviation of depth", false),
        what,
        colour: uncertainty_colour,
        values: &surface.spread_m,
    };
    write(&layer, surface, results, path)
}

/// Writes `distance.tif`.
pub(super) fn distance(results: &Results<'_>, path: &Path) -> FileResult {
    let surface = results.surface()?;
    let layer = RasterLayer {
        band: band("distance to the nearest depth", false),
        what: DISTANCE,
        colour: distance_colour,
        values: &surface.distance_m,
    };
    write(&layer, surface, results, path)
}

/// Writes `shoalest.tif`.
pub(super) fn shoalest(results: &Results<'_>, path: &Path) -> FileResult {
    let depth_map = results.needed_depth_map()?;
    let surface = &depth_map.surface;
    let layer = RasterLayer {
        band: band("shoalest depth", true),
        what: SHOALEST,
        colour: depth_colour,
        values: &shoalest_m(&surface.grid, &depth_map.depth_points(results.progress)?),
    };
    write(&layer, surface, results, path)
}

/// Writes `hardness.tif`.
pub(super) fn hardness(results: &Results<'_>, path: &Path) -> FileResult {
    let surface = results.surface()?;
    let layer = RasterLayer {
        band: Band { unit: "decibel", ..band("brightness of the bed over the median", false) },
        what: "How much brighter the bed is than the median of the map, decibels of power, as echo levels tell it: without slope, angle, range and gain",
        colour: share_colour,
        values: surface.hardness_db.as_deref().unwrap_or_default(),
    };
    write(&layer, surface, results, path)
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

/// Writes a raster over the cells of a surface, and its colours beside it.
fn write(
    layer: &RasterLayer<'_>,
    surface: &Surface,
    results: &Results<'_>,
    path: &Path,
) -> FileResult {
    let (grid, map) = (&surface.grid, &results.map);
    let applied = results.applied(surface);
    let spec = RasterSpec {
        cells: CellFormat::Metres,
        band: Some(layer.band),
        description: format!("{}; {}. {applied}", layer.what, results.survey.name()),
        ..raster_over(grid, map)
    };
    metres_raster(path, &spec, grid, layer.values, results.progress)?;
    let summary = summary(map, grid, layer.values);
    let range = summary.values.unwrap_or_default();
    qgis_style(&path.with_extension("qml"), range, STEPS, layer.colour)?;
    Ok(FileContent::in_system(&spec.crs, summary))
}

/// Returns the number and range of the known values, and the extent of the whole raster.
fn summary(map: &MapPlane, grid: &Grid, values: &[f32]) -> Summary {
    let mut summary = Summary::default();
    let known = values.iter().filter(|value| !value.is_nan());
    known.for_each(|value| summary.add([f64::NAN; 2], f64::from(*value)));
    let corners = [[0, 0], [grid.rows, grid.columns]];
    for [rows, columns] in corners.map(|corner| corner.map(|cells| cells as f64)) {
        let corner = [grid.west_m + columns * grid.cell_m, grid.north_m - rows * grid.cell_m];
        summary.reach(map.in_crs(corner));
    }
    summary
}
