//! Computes lines of equal depth, the areas between them, and the area and volume below a level.
//!
//! In: a surface and the depths of the lines. Out: isobaths, depth areas, and area and volume below
//! a level.
//!
//! `lines` cuts the squares between the centres of cells, joins the cuts to isobaths rounds these
//! on request, and cuts them at the edges of tiles, `areas` joins the cuts to polygons, `levels`
//! chooses the depths, `shoalest` keeps lines from understating a shoal and chooses the depths that
//! a chart prints, and `clip_area` cuts lines and areas at a shoreline and computes area and
//! volume.

mod areas;
mod clip_area;
mod levels;
mod lines;
mod shoalest;

pub use areas::{DepthArea, Polygon, depth_areas, polygons};
pub use clip_area::{ClipArea, Storage, storage};
pub use levels::{DepthExtent, INDEX, IsobathSettings, NoIsobaths, evenly_apart_m};
pub use lines::{Isobath, Smoothing, clipped, isobaths, joined, smoothed};
pub use shoalest::{shoalest_m, spot_radius_m, spot_soundings, with_shoalest};
