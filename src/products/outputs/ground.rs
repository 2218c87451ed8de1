//! Computes the ground of a run on the map: the ground that the side-scan insonified, the cells of
//! the mosaic, and the place of a raster.

use crate::Error;
use crate::pipeline::Mosaic;
use bathyscope_bottom::bathymetry::Grid;
use bathyscope_bottom::bathymetry::isobaths::Polygon;
use bathyscope_bottom::mosaic::{TILE_CELLS, joint_grid};
use bathyscope_log::formats::geotiff::{CellFormat, RasterSpec};
use bathyscope_log::support::geo::MapPlane;

/// Largest number of tiles of a mosaic, empty ones included: a single wrong fix makes a huge, empty
/// map.
const MOST_TILES: usize = 1_000_000;

/// The ground that the side-scan insonified.
pub(super) struct SideScanCoverage {
    /// Outlines of the ground, in the plane of the map; empty without side-scan.
    pub shapes: Vec<Polygon>,
    /// Area on the ground, square metres.
    pub area_m2: f64,
}

impl SideScanCoverage {
    /// Creates the coverage from outlines in the plane of a map.
    pub(super) fn new(shapes: Vec<Polygon>, map: &MapPlane) -> Self {
        // Without any corner there is nothing to draw.
        let Some(first) = shapes.first().and_then(|shape| shape.outline.first()).copied() else {
            return Self { shapes: Vec::new(), area_m2: 0.0 };
        };
        let on_map_m2: f64 = shapes.iter().map(|shape| shape.area_m2()).sum();
        Self { shapes, area_m2: on_map_m2 / map.area_scale_at(first) }
    }
}

/// Returns the grid of the file with the mosaic.
///
/// # Errors
/// When no echo has a place, or the mosaic would have too many cells.
pub(super) fn mosaic_grid(mosaic: Option<&Mosaic>, cell_m: f64) -> Result<Grid, Error> {
    let grid = mosaic.and_then(|mosaic| joint_grid(&mosaic.logs, cell_m));
    let grid =
        grid.ok_or("no mosaic: no ping has side-scan, a place, a heading and an altitude")?;
    let [down, across] = [grid.rows, grid.columns].map(|cells| cells.div_ceil(TILE_CELLS));
    if down.saturating_mul(across) > MOST_TILES {
        return Err(format!(
            "no mosaic: it would have {} by {} cells; choose a larger mosaic.cell_m, or look for positions that are far off",
            grid.columns, grid.rows
        )
        .into());
    }
    Ok(grid)
}

/// Returns the description of a raster over the cells of a grid in the plane of a map; the caller
/// sets the kind of cells, the band and the text.
pub(super) fn raster_over(grid: &Grid, map: &MapPlane) -> RasterSpec {
    RasterSpec {
        columns: grid.columns,
        rows: grid.rows,
        west: map.in_crs([grid.west_m, 0.0])[0],
        north: map.in_crs([0.0, grid.north_m])[1],
        cell: map.in_crs([grid.cell_m; 2]),
        crs: map.crs.clone(),
        cells: CellFormat::Metres,
        band: None,
        description: String::new(),
    }
}
