//! The surface as rasters.

use super::DepthWritten;
use crate::bathymetry::{Grid, Surface};
use crate::export::{Summary, geotiff, qgis_style};
use crate::formats::geotiff::{Band, Cells, NODATA, RASTER_TILE, RasterSpec};
use crate::outputs::record::{Coordinates, Made};
use crate::pipeline::{Plane, Products};
use crate::presentation::colours::{depth_colour, distance_colour, uncertainty_colour};
use crate::progress::Progress;
use std::path::Path;

/// A raster to write.
struct Layer<'a> {
    name: &'static str,
    /// Its colours in QGIS.
    style: &'static str,
    band: Band,
    /// What the record calls the values.
    measured: &'static str,
    values: &'a [f32],
    what: &'static str,
    colour: fn(f32) -> [u8; 3],
}

fn layers(surface: &Surface) -> [Layer<'_>; 3] {
    let band = |name, positive_down| Band {
        name,
        unit: "metre",
        positive_down,
    };
    [
        Layer {
            name: "depth.tif",
            style: "depth.qml",
            band: band("depth", true),
            measured: "depth_m",
            values: &surface.depth_m,
            what: "Depth in metres, positive down",
            colour: depth_colour,
        },
        Layer {
            name: "uncertainty.tif",
            style: "uncertainty.qml",
            band: band("standard deviation of depth", false),
            measured: "standard_deviation_m",
            values: &surface.spread_m,
            what: "Standard deviation in metres of the depths that carry a cell",
            colour: uncertainty_colour,
        },
        Layer {
            name: "distance.tif",
            style: "distance.qml",
            band: band("distance to the nearest depth", false),
            measured: "distance_m",
            values: &surface.distance_m,
            what: "Distance in metres from a cell to the nearest depth",
            colour: distance_colour,
        },
    ]
}

/// Steps of the colours in a style.
const STEPS: usize = 10;

/// Writes `depth.tif`, `uncertainty.tif` and `distance.tif`: metres as f32 on one grid, each with what was and was not
/// corrected in its description, and beside each its colours for QGIS (`.qml`).
pub(super) fn write(
    surface: &Surface,
    plane: &Plane<'_>,
    products: &Products,
    folder: &Path,
    progress: &Progress,
    written: &mut DepthWritten,
) -> Result<(), String> {
    let grid = &surface.grid;
    let tiles = tiles(grid, &surface.depth_m);
    let applied = applied(products, grid);
    let crs = &plane.map.crs;
    for layer in layers(surface) {
        let spec = RasterSpec {
            columns: grid.columns,
            rows: grid.rows,
            west: plane.map.in_crs([grid.west_m, 0.0])[0],
            north: plane.map.in_crs([0.0, grid.north_m])[1],
            cell: plane.map.in_crs([grid.cell_m; 2]),
            crs: crs.clone(),
            cells: Cells::Metres,
            band: Some(layer.band),
            description: format!("{}; {}. {applied}", layer.what, plane.survey.name()),
        };
        let draw = |tile| draw(grid, layer.values, tile);
        geotiff(&folder.join(layer.name), &spec, &tiles, draw, progress)
            .map_err(|error| error.to_string())?;
        let summary = summary(plane, grid, layer.values);
        qgis_style(
            &folder.join(layer.style),
            summary.values.unwrap_or_default(),
            STEPS,
            layer.colour,
        )
        .map_err(|error| error.to_string())?;
        written.made.push(Made {
            name: layer.name,
            what: layer.what,
            coordinates: Coordinates::System(crs.clone()),
            counted: "cells",
            measured: layer.measured,
            summary,
            regardless_of: &["detector", "isobaths", "mosaic"],
        });
    }
    Ok(())
}

/// The cells that are known, and the whole raster around them.
fn summary(plane: &Plane<'_>, grid: &Grid, values: &[f32]) -> Summary {
    let mut summary = Summary::default();
    let known = values.iter().filter(|value| !value.is_nan());
    known.for_each(|value| summary.add([f64::NAN; 2], f64::from(*value)));
    let corners = [[0, 0], [grid.rows, grid.columns]];
    for [rows, columns] in corners.map(|corner| corner.map(|cells| cells as f64)) {
        let corner = [
            grid.west_m + columns * grid.cell_m,
            grid.north_m - rows * grid.cell_m,
        ];
        summary.reach(plane.map.in_crs(corner));
    }
    summary
}

/// What was and was not corrected, and how the cells were filled.
fn applied(products: &Products, grid: &Grid) -> String {
    let settings = &products.settings;
    let method = match settings.surface.method {
        crate::bathymetry::SurfaceMethod::Linear => "linear triangles",
        crate::bathymetry::SurfaceMethod::Natural => "natural neighbours",
        crate::bathymetry::SurfaceMethod::InverseDistance => "inverse distance",
    };
    format!(
        "{} By {method} in cells of {} m, none farther than {} m from a depth.",
        products.correction.statement(),
        grid.cell_m,
        settings.surface.max_gap_m
    )
}

/// Row and column of the tiles that hold something.
fn tiles(grid: &Grid, values: &[f32]) -> Vec<[usize; 2]> {
    let across = grid.columns.div_ceil(RASTER_TILE);
    let mut holds = vec![false; across * grid.rows.div_ceil(RASTER_TILE)];
    for (row, cells) in values.chunks_exact(grid.columns).enumerate() {
        for (column, cells) in cells.chunks(RASTER_TILE).enumerate() {
            holds[row / RASTER_TILE * across + column] |= cells.iter().any(|value| !value.is_nan());
        }
    }
    let filled = (0..holds.len()).filter(|tile| holds[*tile]);
    filled.map(|tile| [tile / across, tile % across]).collect()
}

fn draw(grid: &Grid, values: &[f32], [row, column]: [usize; 2]) -> Vec<u8> {
    let mut tile = Vec::with_capacity(4 * RASTER_TILE * RASTER_TILE);
    for row in row * RASTER_TILE..(row + 1) * RASTER_TILE {
        for column in column * RASTER_TILE..(column + 1) * RASTER_TILE {
            let inside = row < grid.rows && column < grid.columns;
            let value = if inside {
                values[row * grid.columns + column]
            } else {
                f32::NAN
            };
            let stored = if value.is_nan() { NODATA } else { value };
            tile.extend(stored.to_le_bytes());
        }
    }
    tile
}
