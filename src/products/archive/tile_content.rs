//! Reads the maps of tiles from their files again and keeps the last ones, since neighbouring web
//! tiles need the same maps.

use super::LONGEST_RECORD;
use super::record::Archive;
use super::tile::TileId;
use super::tile_files::{DEPTH, ISOBATHS, folder_of};
use crate::map_tiles::web_line;
use bathyscope_bottom::bathymetry::isobaths::Isobath;
use bathyscope_bottom::bathymetry::{Grid, Surface};
use bathyscope_log::formats::geotiff::read_values;
use bathyscope_log::support::geo::LonLat;
use bathyscope_log::support::regular_file;
use serde::Deserialize;
use std::io;
use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};

/// Number of tiles whose maps are kept, some 4 MB each.
const KEPT: usize = 24;

/// Depths and isobaths of a tile.
pub(super) struct TileDepths {
    /// Grid of the tile's cells.
    grid: Grid,
    /// Depths of the cells, row by row, metres; NaN where none is known. Nothing else of a surface
    /// is kept: it would take three times the memory.
    depth_m: Vec<f32>,
    /// Isobaths of the tile, in pixels of a zoom of the web map.
    pub lines: Vec<Isobath>,
}

/// Reader of the maps of an archive's tiles, which are read when they are needed.
pub(super) struct TileContents {
    archive: Archive,
    /// Zoom of the web map in whose pixels lines are given.
    zoom: u8,
    /// Maps that were read; the last requested ones are at the end.
    kept: Mutex<Vec<(TileId, Arc<TileDepths>)>>,
}

impl TileContents {
    /// Creates a reader of the maps of an archive, with lines in pixels of a zoom.
    pub(super) fn new(archive: &Archive, zoom: u8) -> Self {
        Self { archive: archive.clone(), zoom, kept: Mutex::default() }
    }

    /// Returns the map of a tile.
    ///
    /// # Errors
    /// When a file of the tile cannot be read.
    pub(super) fn of(&self, tile: TileId) -> io::Result<Arc<TileDepths>> {
        let mut kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(at) = kept.iter().position(|(known, _)| *known == tile) {
            let found = kept.remove(at);
            let content = found.1.clone();
            kept.push(found);
            return Ok(content);
        }
        // The lock is held while reading: other threads will need the same tile.
        let content = Arc::new(self.read(tile)?);
        if kept.len() >= KEPT {
            kept.remove(0);
        }
        kept.push((tile, content.clone()));
        Ok(content)
    }

    fn read(&self, tile: TileId) -> io::Result<TileDepths> {
        let folder = folder_of(&self.archive, tile);
        let with_name = |path: &Path, error: &dyn std::fmt::Display| {
            io::Error::other(format!("{error}: {}", path.display()))
        };
        let depths = folder.join(DEPTH);
        let isobaths = folder.join(ISOBATHS);
        let grid = tile.grid(0.0, self.archive.record.cell_m);
        let raster = read_values(&depths).map_err(|error| with_name(&depths, &error))?;
        // A raster of another size is not that of the tile: missing cells have no depth.
        let mut depth_m = raster.values;
        depth_m.resize(grid.len(), f32::NAN);
        Ok(TileDepths {
            grid,
            depth_m,
            lines: lines(&isobaths, self.zoom).map_err(|error| with_name(&isobaths, &error))?,
        })
    }
}

/// Part of an isobath file that is read: lines with their depths.
#[derive(Deserialize)]
struct Lines {
    features: Vec<Line>,
}

#[derive(Deserialize)]
struct Line {
    geometry: Geometry,
    properties: Properties,
}

#[derive(Deserialize)]
struct Geometry {
    coordinates: Vec<[f64; 2]>,
}

#[derive(Deserialize)]
struct Properties {
    depth_m: f64,
}

fn lines(path: &Path, zoom: u8) -> io::Result<Vec<Isobath>> {
    let text = regular_file::read_text(path, LONGEST_RECORD)?;
    let lines: Lines = serde_json::from_str(&text)?;
    let lines = lines.features.into_iter().map(|line| Isobath {
        depth_m: line.properties.depth_m,
        points: web_line(
            (line.geometry.coordinates.into_iter())
                .map(|[lon_deg, lat_deg]| LonLat { lon_deg, lat_deg }),
            zoom,
        ),
    });
    Ok(lines.collect())
}

impl TileDepths {
    /// Returns the depths as a surface.
    pub(super) fn surface(&self) -> Surface {
        Surface::of_depths(self.grid, self.depth_m.clone())
    }

    /// Copies the depths into a grid of the same cells; cells outside of either grid are left
    /// unchanged.
    pub(super) fn copy_into(&self, grid: &Grid, depth_m: &mut [f32]) {
        let own = &self.grid;
        let offset = |from_m: f64| (from_m / own.cell_m).round() as i64;
        let (east, south) = (offset(own.west_m - grid.west_m), offset(grid.north_m - own.north_m));
        let span = |offset: i64, own: usize, count: usize| {
            let end = (count as i64 - offset).clamp(0, own as i64) as usize;
            (-offset).clamp(0, own as i64) as usize..end
        };
        let columns = span(east, own.columns, grid.columns);
        if columns.is_empty() {
            return;
        }
        for row in span(south, own.rows, grid.rows) {
            let from = &self.depth_m[row * own.columns..][columns.clone()];
            let to = (row as i64 + south) as usize * grid.columns;
            let first = to + (columns.start as i64 + east) as usize;
            depth_m[first..first + from.len()].copy_from_slice(from);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_are_copied_to_their_place() {
        let grid = |west_m: f64, north_m: f64, side: usize| Grid {
            west_m,
            north_m,
            cell_m: 0.5,
            columns: side,
            rows: side,
        };
        let own = grid(100.0, 50.0, 4);
        let content = TileDepths {
            grid: own,
            depth_m: (0..16).map(|cell| cell as f32).collect(),
            lines: Vec::new(),
        };
        let around = grid(99.0, 50.5, 8);
        let mut depth_m = vec![f32::NAN; around.len()];
        content.copy_into(&around, &mut depth_m);
        for (cell, &depth_m) in depth_m.iter().enumerate() {
            let [east_m, north_m] = around.centre(cell / 8, cell % 8);
            let inside = (100.0..102.0).contains(&east_m) && (48.0..50.0).contains(&north_m);
            let expected = own.index_at(east_m, north_m).filter(|_| inside);
            let found = Some(depth_m).filter(|depth| !depth.is_nan());
            assert_eq!(found, expected.map(|cell| cell as f32), "{cell}");
        }
        let inner_grid = grid(100.5, 49.5, 2);
        let mut depth_m = vec![f32::NAN; 4];
        content.copy_into(&inner_grid, &mut depth_m);
        assert_eq!(depth_m, [5.0, 6.0, 9.0, 10.0]);
        let elsewhere = grid(200.0, 49.5, 2);
        let mut depth_m = vec![-1.0; 4];
        content.copy_into(&elsewhere, &mut depth_m);
        assert_eq!(depth_m, [-1.0; 4]);
    }
}
