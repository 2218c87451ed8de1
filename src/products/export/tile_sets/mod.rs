//! Writes the tiles of a map to files that other programs open: MBTiles for plotters and apps,
//! PMTiles for the web, and a page that shows the PMTiles.
//!
//! In: the tiles of a map. Out: MBTiles, PMTiles and an HTML page.

mod archives;
mod page;
mod store;

pub(crate) use archives::{mbtiles, pmtiles};
pub(crate) use page::map_page;
pub(crate) use store::TileStore;

use crate::map_tiles::MapScales;

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

#[cfg(test)]
mod tests;
