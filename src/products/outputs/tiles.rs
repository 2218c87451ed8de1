//! Draws the tiles of the depth map and writes them: with isobaths for plotters and apps, without
//! for web maps, as depths, and as a page that shows the tiles.

use super::content::{FileContent, FileResult};
use super::results::Results;
use crate::Error;
use crate::export::Summary;
use crate::export::tile_sets::{TileSet, TileStore, map_page, mbtiles, pmtiles};
use crate::map_tiles::{
    LitSurface, MapScales, PixelPlaces, Pixels, PyramidSource, TileStyle, WebTile, ZoomRange,
    web_line,
};
use bathyscope_bottom::bathymetry::isobaths::Isobath;
use bathyscope_log::support::geo::{Crs, LonLat, MapPlane, boxes_meet, web_mercator};
use std::io;
use std::path::Path;

/// EPSG number of Web Mercator.
const WEB_MERCATOR: u16 = 3857;

/// Writes `depth.mbtiles`.
pub(super) fn chart(results: &Results<'_>, path: &Path) -> FileResult {
    let set = tiles(results, path)?;
    mbtiles(path, set, TileStyle::Chart)?;
    content(results, set, TileStyle::Chart)
}

/// Writes `depth.pmtiles`.
pub(super) fn colours(results: &Results<'_>, path: &Path) -> FileResult {
    archive(results, path, TileStyle::Colours)
}

/// Writes `depth_values.pmtiles`.
pub(super) fn values(results: &Results<'_>, path: &Path) -> FileResult {
    archive(results, path, TileStyle::Elevations)
}

fn archive(results: &Results<'_>, path: &Path, picture: TileStyle) -> FileResult {
    let set = tiles(results, path)?;
    pmtiles(path, set, picture)?;
    content(results, set, picture)
}

/// Writes `index.html`, after the archives.
pub(super) fn page(results: &Results<'_>, path: &Path) -> FileResult {
    map_page(path, tiles(results, path)?)?;
    Ok(FileContent::count(0))
}

fn content(results: &Results<'_>, set: &TileSet, picture: TileStyle) -> FileResult {
    let mut summary = Summary {
        count: set.store.tiles(picture).len(),
        values: Some(results.surface()?.range_m()),
        ..Summary::default()
    };
    let [west, south, east, north] = set.scales.zooms.bounds_deg;
    for [lon_deg, lat_deg] in [[west, south], [east, north]] {
        summary.reach(web_mercator(LonLat { lon_deg, lat_deg }));
    }
    let crs = Crs::from_epsg(WEB_MERCATOR)?;
    Ok(FileContent::in_system(&crs, summary))
}

/// Returns the tiles of the depth map of one or of all logs, which several files share: drawn at
/// the first call, they take room in the folder of `file` as long as the results exist.
///
/// # Errors
/// When the folder cannot be written into, or the work was cancelled.
fn tiles<'a>(results: &'a Results<'_>, file: &Path) -> Result<&'a TileSet, Error> {
    results.map_tiles(|| {
        let depth_map = results.needed_depth_map()?;
        // Too many isobaths are reported for the files of isobaths; the map is drawn without
        // isobaths.
        let isobaths = results.isobaths()?.unwrap_or_default();
        let (surface, map) = (&depth_map.surface, &depth_map.map);
        let zooms = ZoomRange::of_map(depth_map.bounds_deg(), surface.grid.cell_m);
        let in_pixels = |line: &Isobath| Isobath {
            points: web_line(line.points.iter().map(|place| map.to_lon_lat(*place)), zooms.finest),
            ..*line
        };
        let shade = depth_map.shade(results.progress)?;
        let source = RunTiles {
            lit: LitSurface::new(surface, shade, &depth_map.light),
            map,
            scales: MapScales {
                zooms,
                range_m: depth_map.colour_range_m,
                levels_m: isobaths.levels_m.clone(),
                isobaths: results.products.settings.isobaths.clone(),
            },
            lines: isobaths.lines.iter().map(in_pixels).collect(),
        };
        let store = TileStore::draw(file.parent().unwrap_or(file), &source, results.progress)?;
        Ok(TileSet {
            name: results.survey.name(),
            description: format!("Depth in metres. {}", results.applied(surface)),
            scales: source.scales,
            store,
        })
    })
}

/// The depth map of a run as a source of tiles.
struct RunTiles<'a> {
    lit: LitSurface<'a>,
    map: &'a MapPlane,
    scales: MapScales,
    /// Isobaths in pixels of the finest zoom.
    lines: Vec<Isobath>,
}

impl PyramidSource for RunTiles<'_> {
    fn scales(&self) -> &MapScales {
        &self.scales
    }

    fn reaches(&self, tile: WebTile) -> bool {
        boxes_meet(tile.bounds_deg(), self.scales.zooms.bounds_deg)
    }

    fn pixels(&self, tile: WebTile) -> io::Result<Option<Pixels>> {
        let places = PixelPlaces::new(tile, |at| self.map.place(at));
        Ok(Pixels::draw(|pixel| self.lit.at(places.of(pixel))))
    }

    fn isobaths(&self, tile: WebTile) -> io::Result<Vec<Isobath>> {
        Ok(tile.isobaths(self.lines.iter(), &self.scales.zooms))
    }
}
