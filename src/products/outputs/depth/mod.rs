//! Writes the products of the depths: the map and its uncertainty as rasters and text, the bottom
//! as a body, isobaths and depth areas, and storage, all in the coordinate system of the setting
//! `crs`; and the map as web tiles.
//!
//! In: the depth map of a run, with its isobaths. Out: files of these.

pub(super) mod body;
pub(super) mod contours;
pub(super) mod map_tiles;
pub(super) mod rasters;
pub(super) mod tiles;

use crate::pipeline::Products;
use bathyscope_bottom::bathymetry::Surface;

/// Describes the corrections, applied or not, and the interpolation of the cells.
fn applied(products: &Products, surface: &Surface) -> String {
    let settings = &products.settings;
    format!(
        "{} By {} in cells of {} m, none farther than {} m from a depth.",
        products.correction.statement(),
        surface.method_in_words(),
        surface.grid.cell_m,
        settings.surface.max_gap_m
    )
}
