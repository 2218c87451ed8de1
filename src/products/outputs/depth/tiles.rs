//! The depth map as tiles: for plotters and apps with isobaths, for web maps without, as depths, and with a page that shows them.

use super::rasters::applied;
use crate::bottom::bathymetry::isobaths::{Isobath, IsobathSettings, clipped};
use crate::pipeline::DepthMap;
use crate::products::export::Summary;
use crate::products::export::tile_sets::{TileSet, TileStore, map_page, mbtiles, pmtiles};
use crate::products::map_tiles::{
    LitSurface, MapScales, Pixels, TileSource, TileStyle, WebTile, ZoomRange, web_pixel,
};
use crate::products::outputs::OutputError;
use crate::products::outputs::manifest::{Coordinates, FileContent};
use crate::products::outputs::results::Results;
use crate::support::geo::{Crs, LonLat, MapPlane, boxes_meet, web_mercator};
use std::io;
use std::path::Path;

/// Web Mercator.
const WEB_MERCATOR: u16 = 3857;
/// The archives that the page shows, in its folder.
const ARCHIVES: [&str; 2] = ["depth.pmtiles", "depth_values.pmtiles"];

/// The tiles of a depth map, drawn once for all files of them.
pub struct MapTiles {
    store: TileStore,
    set: TileSet,
}

/// Writes `depth.mbtiles`.
pub fn chart(results: &Results<'_>, path: &Path) -> Result<FileContent, OutputError> {
    let tiles = results.map_tiles(path)?;
    mbtiles(path, &tiles.store, TileStyle::Chart, &tiles.set)?;
    content(results, tiles, TileStyle::Chart)
}

/// Writes `depth.pmtiles`.
pub fn colours(results: &Results<'_>, path: &Path) -> Result<FileContent, OutputError> {
    archive(results, path, TileStyle::Colours)
}

/// Writes `depth_values.pmtiles`.
pub fn values(results: &Results<'_>, path: &Path) -> Result<FileContent, OutputError> {
    archive(results, path, TileStyle::Elevations)
}

fn archive(
    results: &Results<'_>,
    path: &Path,
    picture: TileStyle,
) -> Result<FileContent, OutputError> {
    let tiles = results.map_tiles(path)?;
    pmtiles(path, &tiles.store, picture, &tiles.set)?;
    content(results, tiles, picture)
}

/// Writes `index.html`, behind the archives.
pub fn page(results: &Results<'_>, path: &Path) -> Result<FileContent, OutputError> {
    let tiles = results.map_tiles(path)?;
    map_page(path, &tiles.set, ARCHIVES)?;
    Ok(FileContent::new(Coordinates::None, Summary::default()))
}

fn content(
    results: &Results<'_>,
    tiles: &MapTiles,
    picture: TileStyle,
) -> Result<FileContent, OutputError> {
    let surface = results.surface()?.ok_or(super::NO_SURFACE)?;
    let mut summary = Summary {
        count: tiles.store.tiles(picture).len(),
        values: Some(surface.range_m()),
        ..Summary::default()
    };
    let [west, south, east, north] = tiles.set.scales.zooms.bounds_deg;
    for [lon_deg, lat_deg] in [[west, south], [east, north]] {
        summary.reach(web_mercator(LonLat { lon_deg, lat_deg }));
    }
    let crs = Crs::from_epsg(WEB_MERCATOR).map_err(|error| error.to_string())?;
    Ok(FileContent::new(Coordinates::System(crs), summary))
}

impl MapTiles {
    /// Draws all tiles; on the way their pictures take room in a folder.
    ///
    /// # Errors
    /// When the folder cannot be written into, or the work was cancelled.
    pub fn new(results: &Results<'_>, folder: &Path) -> Result<Self, OutputError> {
        let depth_map = results.depth_map()?.ok_or(super::NO_SURFACE)?;
        let isobaths = results.isobaths()?.map(|made| made.as_ref().clone());
        // Too many isobaths are a warning of their group; the map is drawn without.
        let isobaths = isobaths.unwrap_or_default();
        let settings = &results.products.settings.isobaths;
        let source = RunTiles::new(
            depth_map,
            depth_map.shade(results.progress)?,
            &isobaths.lines,
            isobaths.levels_m.clone(),
            settings,
        );
        let store = TileStore::draw(folder, &source, results.progress)?;
        Ok(Self {
            set: TileSet {
                name: results.plane.survey.name(),
                description: format!(
                    "Depth in metres. {}",
                    applied(results.products, &depth_map.surface)
                ),
                scales: source.scales,
            },
            store,
        })
    }
}

/// The depth map of a run.
struct RunTiles<'a> {
    lit: LitSurface<'a>,
    map: &'a MapPlane,
    scales: MapScales,
    /// In pixels of the finest zoom.
    lines: Vec<Isobath>,
}

impl<'a> RunTiles<'a> {
    fn new(
        depth_map: &'a DepthMap,
        shade: &'a [u8],
        lines: &[Isobath],
        levels_m: Vec<f64>,
        settings: &IsobathSettings,
    ) -> Self {
        let map = &depth_map.map;
        let zooms = ZoomRange::of_map(depth_map.bounds_deg(), depth_map.surface.grid.cell_m);
        let in_pixels = |line: &Isobath| Isobath {
            points: (line.points.iter())
                .map(|place| web_pixel(map.to_lon_lat(*place), zooms.finest))
                .collect(),
            ..*line
        };
        Self {
            lit: LitSurface::new(&depth_map.surface, shade, &depth_map.light),
            map,
            scales: MapScales {
                zooms,
                range_m: depth_map.colour_range_m,
                levels_m,
                isobaths: settings.clone(),
            },
            lines: lines.iter().map(in_pixels).collect(),
        }
    }
}

impl TileSource for RunTiles<'_> {
    fn scales(&self) -> &MapScales {
        &self.scales
    }

    fn reaches(&self, tile: WebTile) -> bool {
        boxes_meet(tile.bounds_deg(), self.scales.zooms.bounds_deg)
    }

    fn pixels(&self, tile: WebTile) -> io::Result<Option<Pixels>> {
        Ok(Pixels::draw(tile, |at| self.lit.at(self.map.place(at))))
    }

    fn isobaths(&self, tile: WebTile) -> io::Result<Vec<Isobath>> {
        let bounds = tile.pixel_bounds(self.scales.zooms.finest);
        Ok(self
            .lines
            .iter()
            .flat_map(|line| clipped(line, bounds))
            .collect())
    }
}
