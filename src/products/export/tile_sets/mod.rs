//! Writes the tiles of a map to files that other programs open: MBTiles for plotters and apps,
//! PMTiles for the web, and a page that shows the PMTiles.
//!
//! In: the tiles of a map. Out: MBTiles, PMTiles and an HTML page.

mod archives;
mod page;

pub(crate) use archives::{mbtiles, pmtiles};
pub(crate) use page::map_page;

use crate::Error;
use crate::export::ExportError;
use crate::map_tiles::{MapScales, PyramidSource, TileStyle, WebTile, pyramid};
use bathyscope_log::support::progress::Progress;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, Read as _, Seek as _, SeekFrom, Write as _};
use std::path::Path;
use std::sync::{Mutex, PoisonError};

/// Description of a set of tiles for the programs that show it.
#[derive(Clone, Debug)]
pub(crate) struct TileSet {
    /// Name of the map.
    pub name: String,
    /// Description of the map, in a sentence or two.
    pub description: String,
    /// Extent of the map and scales of its drawing.
    pub scales: MapScales,
}

impl TileSet {
    /// Author of the tiles.
    pub(crate) const ATTRIBUTION: &'static str = "Bathyscope";

    /// Returns the longitude and latitude of the middle of the map.
    fn middle_deg(&self) -> [f64; 2] {
        let [west, south, east, north] = self.scales.zooms.bounds_deg;
        [0.5 * (west + east), 0.5 * (south + north)]
    }
}

/// Pictures of tiles after drawing, until they are written in the order of a file format. They are
/// in a nameless file, so that memory does not grow with the map.
pub(crate) struct TileStore {
    inner: Mutex<Inner>,
}

struct Inner {
    file: File,
    end: u64,
    /// Stored pictures, by style and by the tile's number along Hilbert's curve.
    places: BTreeMap<(TileStyle, u64), Stored>,
}

/// Location of the picture of a tile in the file of a store.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Stored {
    /// Tile of the picture.
    pub tile: WebTile,
    at: u64,
    /// Length of the picture, bytes.
    pub length: u32,
}

impl TileStore {
    /// Creates a store without pictures; its file takes room in a folder as long as the store
    /// exists.
    ///
    /// # Errors
    /// When the folder cannot be written into.
    pub(crate) fn in_folder(folder: &Path) -> io::Result<Self> {
        let file = if cfg!(windows) {
            // On Windows an open file keeps its name, and would be mistaken for a product.
            tempfile::tempfile()?
        } else {
            tempfile::tempfile_in(folder)?
        };
        Ok(Self { inner: Mutex::new(Inner { file, end: 0, places: BTreeMap::new() }) })
    }

    /// Creates a store and draws the pictures of a map into it.
    ///
    /// # Errors
    /// When the folder cannot be written into, the source cannot be read, or the work was
    /// cancelled.
    pub(crate) fn draw(
        folder: &Path,
        source: &impl PyramidSource,
        progress: &Progress,
    ) -> Result<Self, Error> {
        let fail = ExportError::at(folder);
        let store = Self::in_folder(folder).map_err(&fail)?;
        let keep = |picture, tile, bytes: Vec<u8>| store.keep(picture, tile, &bytes);
        let drawn = pyramid(source, progress, &keep);
        progress.check()?;
        drawn.map_err(fail)?;
        Ok(store)
    }

    /// Adds a picture to the store.
    pub(crate) fn keep(&self, picture: TileStyle, tile: WebTile, bytes: &[u8]) -> io::Result<()> {
        let length = u32::try_from(bytes.len()).map_err(io::Error::other)?;
        let mut inner = self.inner.lock().unwrap_or_else(PoisonError::into_inner);
        let at = inner.end;
        inner.file.seek(SeekFrom::Start(at))?;
        inner.file.write_all(bytes)?;
        inner.end += u64::from(length);
        let stored = Stored { tile, at, length };
        inner.places.insert((picture, tile.hilbert_id()), stored);
        Ok(())
    }

    /// Returns the tiles that have a picture of a style, along Hilbert's curve, from the coarsest
    /// zoom to the finest.
    pub(crate) fn tiles(&self, picture: TileStyle) -> Vec<(u64, Stored)> {
        let inner = self.inner.lock().unwrap_or_else(PoisonError::into_inner);
        let of_picture = inner.places.range((picture, 0)..=(picture, u64::MAX));
        of_picture.map(|((_, id), stored)| (*id, *stored)).collect()
    }

    /// Reads the bytes of a picture.
    ///
    /// # Errors
    /// When the file cannot be read.
    pub(crate) fn read(&self, stored: Stored) -> io::Result<Vec<u8>> {
        let mut bytes = vec![0; stored.length as usize];
        let mut inner = self.inner.lock().unwrap_or_else(PoisonError::into_inner);
        inner.file.seek(SeekFrom::Start(stored.at))?;
        inner.file.read_exact(&mut bytes)?;
        Ok(bytes)
    }
}

#[cfg(test)]
mod tests;
