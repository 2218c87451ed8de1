//! Objects on the bottom: the picture that a detector sees, what it finds, and where that lies in the survey.
//!
//! `raster` resamples one side of the survey into a picture whose pixels are square on the bottom, in tiles; `mark` is a
//! box in the survey's own terms (side, pings, slant range), `rect` the same box in a picture's pixels; `level` brings the
//! levels of a tile to one scale.
//! `dataset` makes labelled pictures to learn from.
//! `nms` keeps the surest of boxes that overlap.
//! `review` holds what the analyst decides about the boxes.
//! `metrics` measures predicted boxes against true ones.

pub mod dataset;
mod level;
mod mark;
pub mod metrics;
mod nms;
mod raster;
mod rect;
pub mod review;

pub use level::level;
pub use mark::{Detection, Mark};
pub use nms::{Nms, Overlap, suppress};
pub use raster::{Raster, TILE_PX, Tile};
pub use rect::{Labelled, Rect, Scored};
