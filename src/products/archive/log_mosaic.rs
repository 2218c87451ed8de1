//! Draws a log's part of the mosaic, a raster for every tile that its echoes lie in:
//! `mosaic/tile=.../SHA256.tif`, and, where `mosaic.overlap` weighs echoes,
//! `mosaic_weights/tile=.../SHA256.tif`. The parts of all logs have the same cells, so that they
//! are joined without being drawn again.

use super::record::Archive;
use super::tile::TileId;
use super::{MOSAIC, WEIGHTS};
use crate::Error;
use crate::export::{geotiff, make_folder};
use crate::pipeline::{Derived, ProcessedLog, mosaic_layout};
use bathyscope_bottom::bathymetry::Grid;
use bathyscope_bottom::mosaic::{
    GainTable, MosaicLog, MosaicPart, MosaicSettings, TILE_CELLS, TileIndex, part,
};
use bathyscope_log::formats::geotiff::{
    Band, CellFormat, CellsError, NODATA, RASTER_TILE, RasterSpec, RasterTiles,
};
use bathyscope_log::support::geo::{Crs, MapPlane, UtmZone};
use bathyscope_log::support::progress::{Cancelled, Progress};
use std::collections::{BTreeMap, BTreeSet};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};

const _: () = assert!(TILE_CELLS == RASTER_TILE, "a tile is drawn as it is stored");

/// Band of the raster of weights.
const WEIGHT: Band = Band { name: "weight of the echo level", unit: "", positive_down: false };

/// The layout of the mosaic of a log in every zone that the log has rows in.
pub(super) struct LogMosaic {
    zones: BTreeMap<UtmZone, MosaicLog>,
    /// Tiles that the echoes of the log may lie in.
    pub tiles: BTreeSet<TileId>,
    settings: MosaicSettings,
    name: String,
}

impl LogMosaic {
    /// Lays out the mosaic of a log in some zones. The result has no tile if the log has no
    /// side-scan, or if no place on the bottom is known for its echoes.
    pub(super) fn new(
        log: &ProcessedLog,
        zones: BTreeSet<UtmZone>,
        progress: &Progress,
    ) -> Result<Self, Cancelled> {
        let mut made = Self {
            zones: BTreeMap::new(),
            tiles: BTreeSet::new(),
            settings: log.products.settings.mosaic.clone(),
            name: log.survey.name(),
        };
        let gain =
            if log.survey.has_side_scan() { Derived::default().gain(log, progress)? } else { None };
        let Some(gain) = gain else {
            return Ok(made);
        };
        for zone in zones {
            let plane = MapPlane { crs: Crs::of_zone(zone), units: [1.0; 2] };
            let layout = mosaic_layout(&log.survey, &log.products, &plane);
            let touched = layout.strip_bounds();
            made.tiles.extend(touched.flat_map(|bounds| TileId::touched(zone, bounds)));
            let of_zone = MosaicLog {
                survey: log.survey.clone(),
                layout: layout.into(),
                gain: GainTable::clone(&gain),
            };
            made.zones.insert(zone, of_zone);
        }
        Ok(made)
    }

    /// Writes the log's part of a tile and returns the number of cells that have a level. Writes no
    /// file if there is no such cell.
    ///
    /// # Errors
    /// When a file cannot be written, or the work was cancelled.
    pub(super) fn write(
        &self,
        archive: &Archive,
        tile: TileId,
        log: &str,
        progress: &Progress,
    ) -> Result<usize, Error> {
        let Some(of_zone) = self.zones.get(&tile.zone) else {
            return Ok(0);
        };
        let grid = archive.record.mosaic_grid(tile)?;
        let index = of_zone.layout.index(&grid);
        let tile_part =
            TilePart { log: of_zone, index: &index, settings: &self.settings, tile, grid };
        let places: Vec<[usize; 2]> = (index.tiles()).map(|(row, column)| [row, column]).collect();
        if places.iter().all(|place| tile_part.draw(*place).is_empty()) {
            return Ok(0);
        }
        let path = |kind: &str| {
            let path = archive.rows_path(kind, tile, log);
            make_folder(path.parent().unwrap_or(archive.folder()))?;
            Ok::<_, Error>(path)
        };
        let description = format!("side-scan mosaic of {}; tile {tile} of an archive", self.name);
        if self.settings.overlap.is_weighted() {
            tile_part.write_weights(&path(WEIGHTS)?, &places, &description, progress)?;
        }
        let draw = |place| Ok(tile_part.draw(place).levels);
        let description = format!("Part of the {description}");
        write_levels(&path(MOSAIC)?, (tile, &grid), description, &places, draw, progress)
    }

    /// Returns the kinds of files that each tile has of this mosaic.
    pub(super) fn kinds(&self) -> &'static [&'static str] {
        if self.settings.overlap.is_weighted() { &[MOSAIC, WEIGHTS] } else { &[MOSAIC] }
    }
}

/// Part of a tile that is drawn from one log.
struct TilePart<'a> {
    log: &'a MosaicLog,
    index: &'a TileIndex,
    settings: &'a MosaicSettings,
    tile: TileId,
    grid: Grid,
}

impl TilePart<'_> {
    fn draw(&self, place: [usize; 2]) -> MosaicPart {
        let mut drawn = part(self.log, self.index, &self.grid, self.settings, place);
        if !self.tile.is_within_zone() {
            self.blank_other_zones(&mut drawn, place);
        }
        drawn
    }

    /// Clears the cells of a tile that lie beyond the edge of its zone: they belong to the other
    /// zone.
    fn blank_other_zones(&self, drawn: &mut MosaicPart, [row, column]: [usize; 2]) {
        let zone = self.tile.zone;
        for (cell, level) in drawn.levels.iter_mut().enumerate() {
            let at = self.grid.centre(
                row * TILE_CELLS + cell / TILE_CELLS,
                column * TILE_CELLS + cell % TILE_CELLS,
            );
            if *level > 0 && UtmZone::of(zone.to_lon_lat(at)) != zone {
                *level = 0;
                if let Some(weight) = drawn.weights.get_mut(cell) {
                    *weight = 0.0;
                }
            }
        }
    }

    fn write_weights(
        &self,
        path: &Path,
        places: &[[usize; 2]],
        description: &str,
        progress: &Progress,
    ) -> Result<(), Error> {
        let draw = |place| {
            let weights = self.draw(place).weights.into_iter();
            let stored = weights.map(|weight| if weight > 0.0 { weight } else { NODATA });
            Ok(stored.flat_map(f32::to_le_bytes).collect())
        };
        let spec = RasterSpec {
            cells: CellFormat::Metres,
            band: Some(WEIGHT),
            ..levels_spec(self.tile, &self.grid, format!("What levels count in the {description}"))
        };
        geotiff(path, &spec, places, draw, progress)
    }
}

/// Opens a log's part of a tile; returns the raster and its path.
pub(super) fn open_part(
    archive: &Archive,
    kind: &str,
    tile: TileId,
    log: &str,
) -> Result<(RasterTiles, PathBuf), Error> {
    let path = archive.rows_path(kind, tile, log);
    let opened = RasterTiles::open(&path);
    let opened = opened.map_err(|error| Error::from(in_words(&error, &path)))?;
    Ok((opened, path))
}

/// Returns the message that a part of the mosaic cannot be used.
pub(super) fn in_words(error: &CellsError, path: &Path) -> String {
    format!(
        "a part of the mosaic cannot be used: {error}; process its log again: {}",
        path.display()
    )
}

/// Writes levels over the grid of a tile's mosaic; returns the number of cells that have one.
pub(super) fn write_levels(
    path: &Path,
    (tile, grid): (TileId, &Grid),
    description: String,
    places: &[[usize; 2]],
    draw: impl Fn([usize; 2]) -> io::Result<Vec<u8>> + Sync,
    progress: &Progress,
) -> Result<usize, Error> {
    let cells = AtomicUsize::new(0);
    let counted = |place| {
        let levels = draw(place)?;
        let known = levels.iter().filter(|level| **level > 0).count();
        cells.fetch_add(known, Ordering::Relaxed);
        Ok(levels)
    };
    geotiff(path, &levels_spec(tile, grid, description), places, counted, progress)?;
    Ok(cells.into_inner())
}

/// Returns the description of a raster of levels over the grid of a tile's mosaic.
fn levels_spec(tile: TileId, grid: &Grid, description: String) -> RasterSpec {
    RasterSpec {
        cells: CellFormat::Level,
        band: Some(Band::ECHO_LEVEL),
        description,
        ..tile.raster(grid)
    }
}
