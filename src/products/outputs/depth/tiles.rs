//! Writes the depth map as tiles: with isobaths for plotters and apps, without for web maps, as
//! depths, and as a page that shows the tiles.

use super::map_tiles::MapTiles;
use crate::export::Summary;
use crate::export::tile_sets::{map_page, mbtiles, pmtiles};
use crate::map_tiles::TileStyle;
use crate::outputs::content::{FileContent, FileResult};
use crate::outputs::results::Results;
use bathyscope_log::support::geo::{Crs, LonLat, web_mercator};
use std::path::Path;

/// EPSG number of Web Mercator.
const WEB_MERCATOR: u16 = 3857;
/// Archives that the page shows, in the same folder.
const ARCHIVES: [&str; 2] = ["depth.pmtiles", "depth_values.pmtiles"];

/// Writes `depth.mbtiles`.
pub(crate) fn chart(results: &Results<'_>, path: &Path) -> FileResult {
    let tiles = results.map_tiles(path)?;
    mbtiles(path, &tiles.store, TileStyle::Chart, &tiles.set)?;
    content(results, tiles, TileStyle::Chart)
}

/// Writes `depth.pmtiles`.
pub(crate) fn colours(results: &Results<'_>, path: &Path) -> FileResult {
    archive(results, path, TileStyle::Colours)
}

/// Writes `depth_values.pmtiles`.
pub(crate) fn values(results: &Results<'_>, path: &Path) -> FileResult {
    archive(results, path, TileStyle::Elevations)
}

fn archive(results: &Results<'_>, path: &Path, picture: TileStyle) -> FileResult {
    let tiles = results.map_tiles(path)?;
    pmtiles(path, &tiles.store, picture, &tiles.set)?;
    content(results, tiles, picture)
}

/// Writes `index.html`, after the archives.
pub(crate) fn page(results: &Results<'_>, path: &Path) -> FileResult {
    let tiles = results.map_tiles(path)?;
    map_page(path, &tiles.set, ARCHIVES)?;
    Ok(FileContent::count(0))
}

fn content(results: &Results<'_>, tiles: &MapTiles, picture: TileStyle) -> FileResult {
    let surface = results.surface()?;
    let mut summary = Summary {
        count: tiles.store.tiles(picture).len(),
        values: Some(surface.range_m()),
        ..Summary::default()
    };
    let [west, south, east, north] = tiles.set.scales.zooms.bounds_deg;
    for [lon_deg, lat_deg] in [[west, south], [east, north]] {
        summary.reach(web_mercator(LonLat { lon_deg, lat_deg }));
    }
    let crs = Crs::from_epsg(WEB_MERCATOR)?;
    Ok(FileContent::in_system(&crs, summary))
}
