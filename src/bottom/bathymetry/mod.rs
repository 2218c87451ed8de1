//! Depth maps from soundings: repeated positions merged, and sampled only where something was
//! measured.
//!
//! In: depths with their places. Out: surfaces, and what is read from them: isobaths, comparisons,
//! offsets between logs.
//!
//! `nodes` takes the depths with their places and merges those of one place, `tin` (in an
//! `insertion_order`), `inverse_distance` find the depth between them, `left_out` says what it is
//! worth, `grid` chooses the cells and says what was measured in each, and `surface` fills them;
//! `slopes` bend it between the lines; `local` fills a part of a larger map. `spot_soundings`
//! chooses those that a chart prints. `hill_shade` lights them, `isobaths` draws through them,
//! `compare` compares points with a reference, `crosslines` compares the passes of a survey with
//! each other and `crossing_error` says what a depth is worth by that, `contradicted` finds the
//! stretches that other logs show to be false, `height_offsets` finds what sets the depths of one
//! log off from those of others, `position_offsets` how far its positions are off and how late they
//! are, `transect` looks at them along a line; `coarser` gives it larger cells,
//! `flat_extrapolation` more ground, `change` says what changed between two of them.

pub mod change;
mod coarser;
pub mod compare;
mod contradicted;
mod crossing_error;
pub mod crosslines;
mod flat_extrapolation;
mod from_levels;
mod grid;
pub mod height_offsets;
mod hill_shade;
mod insertion_order;
mod inverse_distance;
pub mod isobaths;
mod left_out;
mod local;
mod nodes;
pub mod position_offsets;
mod slopes;
mod spot_soundings;
mod surface;
#[cfg(test)]
mod testing;
mod tin;
mod transect;

pub use contradicted::{ContradictedStretch, Contradiction, contradicted};
pub use crossing_error::CrossingError;
pub use from_levels::{FromLevels, LevelsRefused, SwathDepth};
pub(crate) use grid::suited_cell_m;
pub use grid::{CellSource, Grid};
pub use hill_shade::{Light, hill_shade};
pub use left_out::{SigmaByDistance, sigma_by_distance};
pub use local::{LOCAL_MARGIN_CELLS, local_reach_m, local_surface};
pub(crate) use nodes::merge_repeated;
pub use nodes::{DepthPoint, Node, depth_points, depth_range};
pub use slopes::Bends;
pub(crate) use slopes::BentSampler;
pub use spot_soundings::{spot_radius_m, spot_soundings};
pub use surface::{Spread, Surface, SurfaceMethod, SurfaceSettings, surface, surface_of_depths};
pub(crate) use tin::{Between, Tin, TinSampler};
pub use transect::{Corner, TransectStation, transect};
