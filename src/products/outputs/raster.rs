//! Places a raster in the system of a map.

use bathyscope_bottom::bathymetry::Grid;
use bathyscope_log::formats::geotiff::{CellFormat, RasterSpec};
use bathyscope_log::support::geo::MapPlane;

/// A raster over the cells of a grid in the plane of a map; of nothing yet, which whoever writes it
/// says.
pub(super) fn over(grid: &Grid, map: &MapPlane) -> RasterSpec {
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
