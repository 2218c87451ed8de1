//! Lines of equal depth, the areas between them, and what lies below a level.
//!
//! In: a surface and the depths of the lines. Out: isobaths, depth areas, and area and volume below
//! a level.
//!
//! `march` cuts the squares between the centres of cells, `lines` joins the cuts to isobaths,
//! `areas` to polygons, `levels` chooses the depths, `shoalest` keeps lines from understating a
//! shoal, `smooth` rounds lines where that is asked for, `clip` cuts lines at the edges of tiles,
//! `clip_area` lines and areas at a shoreline, and `storage` counts area and volume.

mod areas;
mod clip;
mod clip_area;
mod levels;
mod lines;
mod march;
mod shoalest;
mod smooth;
mod storage;

pub use areas::{DepthArea, Polygon, depth_areas, polygons};
pub use clip::{clipped, joined};
pub use clip_area::ClipArea;
pub use levels::{DepthExtent, INDEX, IsobathSettings, NoIsobaths, evenly_apart_m};
pub use lines::{Isobath, isobaths};
pub use shoalest::{shoalest_m, with_shoalest};
pub use smooth::{Smoothing, smoothed};
pub use storage::{Storage, storage};
