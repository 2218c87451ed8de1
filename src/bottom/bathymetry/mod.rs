//! Makes depth maps from soundings: merges repeated positions, and samples the depth only where
//! something was measured.
//!
//! In: depths with their places. Out: surfaces, and what is derived from them: isobaths,
//! comparisons, offsets between logs.
//!
//! `nodes` defines depths with their places and merges and sorts them, `tin` finds the depth
//! between them, `left_out` estimates its error, `grid` chooses the cells and records the source of
//! the depth in each, and `surface` fills them; `slopes` bends the surface between the lines;
//! `local` fills a part of a larger map. `hill_shade` lights surfaces, `isobaths` draws lines on
//! them and chooses the depths that a chart prints, `compare` compares points with a reference,
//! `crosslines` compares the passes of a survey with each other and `crossing_error` estimates the
//! error of a depth from that, `contradicted` finds the stretches that other logs show to be false,
//! `height_offsets` finds the height offsets between the depths of logs, `position_offsets` finds
//! the offsets and delays of their positions, `resampled` samples surfaces along a line and in
//! other cells and extends them over more ground, `change` finds what changed between two of them,
//! and `from_levels` defines the setting and result of depths from echo levels.

pub mod change;
pub mod compare;
mod contradicted;
mod crossing_error;
pub mod crosslines;
mod from_levels;
mod grid;
pub mod height_offsets;
mod hill_shade;
pub mod isobaths;
mod left_out;
mod local;
mod nodes;
pub mod position_offsets;
mod resampled;
mod slopes;
mod surface;
#[cfg(test)]
mod testing;
mod tin;

pub use contradicted::{ContradictedStretch, Contradiction, contradicted};
pub use crossing_error::CrossingError;
pub use from_levels::{FromLevels, LevelsRefused, SwathDepth};
pub(crate) use grid::suited_cell_m;
pub use grid::{CellSource, Grid};
pub use hill_shade::{Light, hill_shade};
pub use isobaths::{spot_radius_m, spot_soundings};
pub use left_out::{SigmaByDistance, sigma_by_distance};
pub use local::{LOCAL_MARGIN_CELLS, local_reach_m, local_surface};
pub(crate) use nodes::merge_repeated;
pub use nodes::{DepthPoint, Node, depth_points};
pub use resampled::{Corner, TransectStation, transect};
pub use slopes::Bends;
pub(crate) use slopes::BentSampler;
pub use surface::{Spread, Surface, SurfaceMethod, SurfaceSettings, surface, surface_of_depths};
pub(crate) use tin::{Between, Tin, TinSampler};
