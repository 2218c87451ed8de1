//! Depth maps from soundings: repeated positions merged, triangulated, and sampled only where something was measured.
//!
//! `soundings` takes the depths with their places, `tin` is the triangulated surface, `depth_map` the grid sampled from it.

mod depth_map;
mod soundings;
mod tin;

pub use depth_map::{DepthMap, DepthMapSettings, depth_map};
pub use soundings::{DepthPoint, depth_points, depth_range, merge_repeated};
pub use tin::Tin;
