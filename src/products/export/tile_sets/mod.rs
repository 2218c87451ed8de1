//! Writes the tiles of a map to files that other programs open: MBTiles for plotters and apps,
//! PMTiles for the web, and a page that shows the PMTiles.
//!
//! In: the tiles of a map. Out: MBTiles, PMTiles and an HTML page.

mod archives;

pub(crate) use archives::{mbtiles, pmtiles};

use crate::Error;
use crate::export::{ExportError, write_atomically};
use crate::map_tiles::{MapScales, PyramidSource, TileStyle, WebTile, pyramid};
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use bathyscope_bottom::presentation::colours::depth_colour;
use bathyscope_bottom::presentation::ticks::round_up;
use bathyscope_log::support::printable::xml;
use bathyscope_log::support::progress::Progress;
use serde_json::json;
use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::{self, Read as _, Seek as _, SeekFrom, Write as _};
use std::path::Path;
use std::sync::{Mutex, PoisonError};

const PAGE: &str = include_str!("../../../../assets/map_page/index.html");
const STYLE: &str = include_str!("../../../../assets/map_page/style.css");
const SCRIPT: &str = include_str!("../../../../assets/map_page/script.js");

/// Archives that the page shows, in the same folder: colours, and elevations.
pub(crate) const PMTILES: [&str; 2] = ["depth.pmtiles", "depth_values.pmtiles"];
/// Largest total size of the archives that are put into the page itself, bytes: the page is then a
/// single file to send and can be opened from a disk, where browsers let no page read other files.
const MOST_INSIDE: u64 = 8 << 20;
/// Number of steps of the colours of the legend.
const STEPS: usize = 20;

/// Tiles of a map, with their description for the programs that show them.
pub(crate) struct TileSet {
    /// Name of the map.
    pub name: String,
    /// Description of the map, in a sentence or two.
    pub description: String,
    /// Extent of the map and scales of its drawing.
    pub scales: MapScales,
    /// Pictures of the tiles.
    pub store: TileStore,
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

/// Writes the page into the folder of its archives ([`PMTILES`]), which must exist already.
///
/// # Errors
/// When an archive cannot be read or the file cannot be written.
pub(crate) fn map_page(path: &Path, set: &TileSet) -> Result<(), ExportError> {
    write_atomically(path, |mut file| {
        let paths = PMTILES.map(|name| path.with_file_name(name));
        let mut bytes = 0;
        for archive in &paths {
            bytes += fs::metadata(archive)?.len();
        }
        let mut inside = String::new();
        if bytes <= MOST_INSIDE {
            for (name, archive) in PMTILES.iter().zip(&paths) {
                let text = STANDARD.encode(fs::read(archive)?);
                inside += &format!(
                    "<script type=\"application/octet-stream\" id=\"{name}\">{text}</script>\n"
                );
            }
        }
        file.write_all(html(set, &inside).as_bytes())
    })
}

fn html(set: &TileSet, inside: &str) -> String {
    let MapScales { zooms, range_m, .. } = &set.scales;
    let colours = (0..=STEPS).map(|step| {
        let [red, green, blue] = depth_colour(step as f32 / STEPS as f32);
        format!("#{red:02x}{green:02x}{blue:02x}")
    });
    let map = json!({
        "bounds": zooms.bounds_deg,
        "coarsest": zooms.coarsest,
        "finest": zooms.finest,
        "range": range_m,
        "interval": interval_m(&set.scales),
        "colours": colours.collect::<Vec<String>>(),
        "files": PMTILES,
    });
    let title = xml(&set.name);
    // The longest text is put in last, so that inserted texts are not searched for placeholders.
    PAGE.replace("{{style}}", STYLE)
        .replace("{{script}}", SCRIPT)
        .replace("{{map}}", &map.to_string())
        .replace("{{about}}", &xml(&set.description))
        .replace("{{title}}", &title)
        .replace("{{archives}}", inside)
}

/// Returns the interval of the isobaths, metres: that of evenly spaced levels, or a round number.
fn interval_m(scales: &MapScales) -> f64 {
    let [least_m, most_m] = scales.range_m.map(f64::from);
    let even_m = scales.interval_m().filter(|_| scales.levels_m.len() > 1);
    even_m.unwrap_or_else(|| round_up((most_m - least_m) / 10.0))
}

#[cfg(test)]
mod tests;
