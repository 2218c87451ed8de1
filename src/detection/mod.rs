//! Objects on the bottom: the picture that a detector sees, what it finds, and where that lies in the survey.
//!
//! In: a survey with first returns and calibration, and a model. Out: boxes, decisions about them, and objects with places and sizes.
//! It uses `sonar`, `survey` and `support`.
//!
//! `raster` resamples one side of the survey into a picture whose pixels are square on the bottom, in tiles; `mark` is a
//! box in the survey's own terms (side, pings, slant range), `extent` how the size of what lies in it is known, `rect` the same box in a picture's pixels; `level` brings the
//! levels of a tile to one scale.
//! `dataset` makes labelled pictures to learn from.
//! `nms` keeps the surest of boxes that overlap, `vote` moves it to their mean, `test_time_augmentation` combines the boxes of a picture and of its mirror image.
//! `model` is a detector from an ONNX file, `decode` reads boxes from its numbers, `picture` is what it searches. `find` searches
//! a survey tile by tile, `merge` makes one box of what several tiles saw.
//! `review` holds what the analyst decides about the boxes.
//! `metrics` measures predicted boxes against true ones, and `labels` reads both from files.
//! `targets` places boxes in the world. `truth` is what is known to lie in a survey, and what the boxes make of it.

mod class;
pub(crate) mod dataset;
pub(crate) mod decode;
mod extent;
mod find;
pub(crate) mod labels;
mod level;
mod mark;
mod merge;
pub(crate) mod metrics;
pub(crate) mod model;
mod nms;
pub(crate) mod objects;
mod picture;
mod raster;
mod rect;
pub(crate) mod review;
pub(crate) mod targets;
mod test_time_augmentation;
#[cfg(test)]
mod testing;
pub(crate) mod truth;
mod vote;

pub(crate) use class::{NAMELESS_CLASS, ReviewSettings, class_index};
pub(crate) use extent::{MeasuredShadow, ObjectExtent};
pub use find::{DetectorSettings, find};
pub(crate) use find::{SoFar, find_in_picture};
pub(crate) use level::level;
pub use mark::{Detection, Mark};
pub use model::Model;
pub(crate) use model::{DetectError, ModelError};
pub(crate) use nms::{Nms, OverlapMeasure, suppress};
pub(crate) use picture::Picture;
pub(crate) use raster::{Raster, RasterTile, TILE_PX};
pub(crate) use rect::{Labelled, Rect, Scored};
pub(crate) use vote::vote;
