//! Draws the tiles of a depth map, which several files share.

use super::applied;
use crate::Error;
use crate::export::tile_sets::{TileSet, TileStore};
use crate::map_tiles::{
    LitSurface, MapScales, PixelPlaces, Pixels, PyramidSource, WebTile, ZoomRange, web_line,
};
use crate::pipeline::{DepthMap, Isobaths, Products};
use bathyscope_bottom::bathymetry::isobaths::{Isobath, IsobathSettings};
use bathyscope_log::support::geo::{MapPlane, boxes_meet};
use bathyscope_log::support::progress::Progress;
use bathyscope_log::survey::Survey;
use std::io;
use std::path::Path;

/// The tiles of a depth map, drawn once for all files that hold them.
pub(crate) struct MapTiles {
    pub(super) store: TileStore,
    pub(super) set: TileSet,
}

impl MapTiles {
    /// Draws all tiles of the depth map of one or of all logs; the pictures take room in a folder
    /// until the tiles are dropped.
    ///
    /// # Errors
    /// When the folder cannot be written into, or the work was cancelled.
    pub(crate) fn new(
        depth_map: &DepthMap,
        isobaths: &Isobaths,
        (survey, products): (&Survey, &Products),
        folder: &Path,
        progress: &Progress,
    ) -> Result<Self, Error> {
        let settings = &products.settings.isobaths;
        let source = RunTiles::new(
            depth_map,
            depth_map.shade(progress)?,
            &isobaths.lines,
            isobaths.levels_m.clone(),
            settings,
        );
        let store = TileStore::draw(folder, &source, progress)?;
        Ok(Self {
            set: TileSet {
                name: survey.name(),
                description: format!("Depth in metres. {}", applied(products, &depth_map.surface)),
                scales: source.scales,
            },
            store,
        })
    }
}

/// The depth map of a run as a source of tiles.
struct RunTiles<'a> {
    lit: LitSurface<'a>,
    map: &'a MapPlane,
    scales: MapScales,
    /// Isobaths in pixels of the finest zoom.
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
            points: web_line(line.points.iter().map(|place| map.to_lon_lat(*place)), zooms.finest),
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
