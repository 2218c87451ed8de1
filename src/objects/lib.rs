//! Finds objects on the bottom: draws the picture that a detector searches, and computes where the
//! detected objects lie in the survey.
//!
//! `raster` resamples one side of the survey into a picture whose pixels are square on the bottom,
//! in tiles; `mark` defines a box by side, pings and slant range, and the extent of the object in
//! it; `picture` defines the picture that a detector searches and boxes in its pixels, and brings
//! the grey levels of a tile to one scale. `dataset` makes labelled pictures to train on. `nms`
//! keeps the box of the highest score among boxes that overlap and moves it to their mean. `model`
//! loads a detector from an ONNX file, `decode` reads boxes from its numbers. `find` searches a
//! survey tile by tile, `merge` makes one box of an object that several tiles show. `review` holds
//! the analyst's decisions about the boxes. `metrics` measures predicted boxes against true ones,
//! and `labels` reads both from files. `targets` computes positions and heights of the objects in
//! the boxes. `truth` holds the known objects of a survey, and compares the boxes with them.
//!
//! # Search a log for objects
//!
//! ```no_run
//! use bathyscope_log::formats::open;
//! use bathyscope_log::support::progress::Progress;
//! use bathyscope_log::survey::{HeadingSettings, Projection, navigate};
//! use bathyscope_objects::{DetectorSettings, Model, find};
//!
//! let progress = Progress::new();
//! let survey = open("pond.sl2".as_ref(), &progress)?;
//! let navigation = navigate(&survey, &HeadingSettings::default(), Projection::Enu, &progress)?;
//! let model = Model::load("assets/detector/default.onnx".as_ref())?;
//! let settings = DetectorSettings::default();
//! for object in find(&survey, &navigation, &model, &settings, &progress, |_| ())? {
//!     println!("{:.2} at ping {}", object.score, object.mark.pings.start);
//! }
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

// A panic here is the failure of the test.
#![cfg_attr(test, allow(clippy::expect_used, clippy::unwrap_used))]

mod class;
pub mod dataset;
pub mod decode;
mod find;
pub mod labels;
mod mark;
mod merge;
pub mod metrics;
pub mod model;
mod nms;
pub mod objects;
mod picture;
mod raster;
pub mod review;
pub mod targets;
#[cfg(test)]
mod testing;
pub mod truth;

pub(crate) use class::class_index;
pub use class::{NAMELESS_CLASS, ReviewSettings};
pub use find::{DetectorSettings, SoFar, find, find_in_picture};
pub use mark::{Detection, Mark, MeasuredShadow, ObjectExtent};
pub use model::{DetectError, Model, ModelError};
pub use nms::{Nms, OverlapMeasure};
pub(crate) use nms::{suppress, vote};
pub use picture::{Labelled, Picture, Rect, Scored, level};
pub use raster::{Raster, RasterTile, TILE_PX};
