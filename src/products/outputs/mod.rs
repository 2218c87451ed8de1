//! What is written of a survey: one run, the same from the window and the command line.
//!
//! `registry` has a row for each file; `write` makes all files of a run from `results`, `run_folder` puts them in place together,
//! `overwrite` keeps them from taking the place of what they are made from, `earlier_run` tells which are
//! out of date. `clouds` writes the files of points, `track` those of the
//! boat's way, `depth` the depth map and what follows from it, `residuals` and `comparison` how the depths agree, `mosaic` the
//! side-scan mosaic, `detections` what a search proposes, `targets` what a review decided, `objects` makes one object of its sightings in all logs, `page` writes the report; `manifest` lists the files with what each is. `boxes` writes
//! what was decided about boxes, `training_tiles` as pictures for training, `raster` says where a raster lies.

mod boxes;
mod clouds;
mod comparison;
mod depth;
mod detections;
mod earlier_run;
mod error;
mod geopackage;
mod logs;
mod manifest;
mod mosaic;
mod objects;
mod overwrite;
mod product;
mod raster;
mod registry;
mod report_page;
mod residuals;
mod results;
mod run_folder;
mod sizes;
mod targets;
mod track;
mod training_tiles;
mod write;

pub use boxes::write_boxes;
pub use comparison::{ComparisonRecord, write_differences};
pub use detections::{Proposed, write_detected, write_detected_in_picture};
pub use earlier_run::{EarlierRun, is_run_of};
pub use error::OutputError;
pub use logs::log_names;
pub use overwrite::begin;
pub use product::{Product, files_in_words};
#[cfg(any(test, feature = "bench"))]
pub use registry::row_of;
pub use registry::{OUTPUT_FILES, OutputFile, When};
pub use run_folder::{Replaced, RunFolder};
pub use sizes::{Amounts, about_bytes};
pub use write::{Order, Written, write};

/// The file that names all files of a run, in place last.
pub const MANIFEST: &str = "manifest.json";
