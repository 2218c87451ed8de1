//! Writes what the depths give: the map and its uncertainty as rasters and text, the bottom as a body, isobaths and depth areas, storage, all in the system
//! that `crs` names; and the map as tiles of the web.

pub mod body;
pub mod cells;
pub mod contours;
pub mod rasters;
pub mod tiles;

/// The registry asks for a surface before it has one written.
const NO_SURFACE: &str = "there is no depth map";
