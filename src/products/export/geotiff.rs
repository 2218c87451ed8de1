//! Writes rasters as GeoTIFF files: any raster, and the cells of a grid.

use super::atomic_write::{scratch_near, write_atomically};
use crate::Error;
use bathyscope_bottom::bathymetry::{CellSource, Grid, Surface};
use bathyscope_log::formats::geotiff::{self, Band, CellFormat, NODATA, RASTER_TILE, RasterSpec};
use bathyscope_log::support::geo::MapPlane;
use bathyscope_log::support::progress::Progress;
use std::io;
use std::path::Path;

/// Returns the description of a raster over the cells of a grid in the plane of a map; the caller
/// sets the kind of cells, the band and the text.
pub(crate) fn raster_over(grid: &Grid, map: &MapPlane) -> RasterSpec {
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

/// Writes a GeoTIFF in the layout of [`geotiff::write`]. During the work the tiles are stored in a
/// second file in the same folder, where there is room for them.
///
/// # Errors
/// When the file cannot be written, a tile cannot be drawn, or the work was cancelled; no file is
/// left then.
pub fn geotiff(
    path: &Path,
    spec: &RasterSpec,
    tiles: &[[usize; 2]],
    draw: impl Fn([usize; 2]) -> io::Result<Vec<u8>> + Sync,
    progress: &Progress,
) -> Result<(), Error> {
    let written = write_atomically(path, |file| {
        geotiff::write(file, scratch_near(path)?, spec, tiles, draw, progress)
    });
    progress.check()?;
    Ok(written?)
}

/// Writes the cells of a grid. `stored` returns the bytes of a cell; for `None`, those of a cell
/// without a value. Tiles without any cell for which `is_known` is true are left out.
///
/// # Errors
/// When the file cannot be written, or the work was cancelled; no file is left then.
fn grid_raster<const BYTES: usize>(
    path: &Path,
    spec: &RasterSpec,
    grid: &Grid,
    is_known: impl Fn(usize) -> bool,
    stored: impl Fn(Option<usize>) -> [u8; BYTES] + Sync,
    progress: &Progress,
) -> Result<(), Error> {
    let draw = |tile| Ok(draw(grid, tile, &stored));
    geotiff(path, spec, &tiles(grid, is_known), draw, progress)
}

/// Writes values in metres, NaN where nothing is known.
///
/// # Errors
/// As [`grid_raster`].
pub fn metres_raster(
    path: &Path,
    spec: &RasterSpec,
    grid: &Grid,
    values_m: &[f32],
    progress: &Progress,
) -> Result<(), Error> {
    let stored = |cell: Option<usize>| {
        let value_m = cell.map_or(f32::NAN, |cell| values_m[cell]);
        let stored = if value_m.is_nan() { NODATA } else { value_m };
        stored.to_le_bytes()
    };
    grid_raster(path, spec, grid, |cell| !values_m[cell].is_nan(), stored, progress)
}

/// Writes the source of the depths of a surface, as the numbers of [`CellSource`]; `about` follows
/// the names of these numbers in the description.
///
/// # Errors
/// As [`grid_raster`].
pub(crate) fn source_raster(
    path: &Path,
    spec: RasterSpec,
    surface: &Surface,
    about: &str,
    progress: &Progress,
) -> Result<(), Error> {
    let names = CellSource::KNOWN.map(|source| format!("{} {}", source as u8, source.name()));
    let spec = RasterSpec {
        cells: CellFormat::Class,
        band: Some(Band { name: "source of the depth", unit: "", positive_down: false }),
        description: format!("The source of the depth in a cell: {}; {about}", names.join(", ")),
        ..spec
    };
    let is_known = |cell: usize| !surface.depth_m[cell].is_nan();
    let stored = |cell: Option<usize>| [cell.map_or(0, |cell| surface.source[cell] as u8)];
    grid_raster(path, &spec, &surface.grid, is_known, stored, progress)
}

/// Returns the row and column of each tile that has a known cell.
fn tiles(grid: &Grid, is_known: impl Fn(usize) -> bool) -> Vec<[usize; 2]> {
    let across = grid.columns.div_ceil(RASTER_TILE);
    let mut holds = vec![false; across * grid.rows.div_ceil(RASTER_TILE)];
    for cell in 0..grid.len() {
        let (row, column) = (cell / grid.columns, cell % grid.columns);
        let tile = row / RASTER_TILE * across + column / RASTER_TILE;
        holds[tile] = holds[tile] || is_known(cell);
    }
    let filled = (0..holds.len()).filter(|tile| holds[*tile]);
    filled.map(|tile| [tile / across, tile % across]).collect()
}

/// Returns the bytes of a tile; `stored` is called with `None` for cells beyond the grid.
fn draw<const BYTES: usize>(
    grid: &Grid,
    [row, column]: [usize; 2],
    stored: impl Fn(Option<usize>) -> [u8; BYTES],
) -> Vec<u8> {
    let mut tile = Vec::with_capacity(BYTES * RASTER_TILE * RASTER_TILE);
    for row in row * RASTER_TILE..(row + 1) * RASTER_TILE {
        for column in column * RASTER_TILE..(column + 1) * RASTER_TILE {
            let inside = row < grid.rows && column < grid.columns;
            tile.extend(stored(inside.then_some(row * grid.columns + column)));
        }
    }
    tile
}

#[cfg(test)]
mod tests {
    use super::*;
    use bathyscope_log::support::geo::Crs;
    use bathyscope_log::support::progress::Cancelled;

    #[test]
    fn a_raster_is_one_file_and_a_cancelled_one_is_none() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.tif");
        let spec = RasterSpec {
            columns: 300,
            rows: 300,
            west: 500_000.0,
            north: 4_000_000.0,
            cell: [0.5, 0.5],
            crs: Crs::from_epsg(32_612).unwrap(),
            cells: CellFormat::Level,
            band: None,
            description: "echoes".into(),
        };
        let draw = |_| Ok(vec![1; RASTER_TILE * RASTER_TILE]);
        let files = || std::fs::read_dir(folder.path()).unwrap().count();
        let cancelled = Progress::new();
        cancelled.cancel();
        let stopped = geotiff(&path, &spec, &[[0, 0]], draw, &cancelled);
        assert_eq!(stopped, Err(Error::from(Cancelled)));
        assert_eq!(files(), 0);
        geotiff(&path, &spec, &[[0, 0]], draw, &Progress::new()).unwrap();
        assert!(path.is_file());
        assert_eq!(files(), 1);
    }
}
