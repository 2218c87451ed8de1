//! Writes the files of a survey in a run, the same from Bathyscope and from the command line.
//!
//! In: the results of a survey, and the order. Out: the files of a run, with their manifest.
//!
//! `registry` has a row for each file, `product_files` describes the files of a product and
//! estimates their sizes; `write` makes all files of a run from `results` and prevents that they
//! replace their own inputs, `run_folder` puts them in place together. `order` is the request,
//! `content` describes the content of a file and the inputs without which it cannot be made.
//! `clouds` writes the files of points, and the bottom for 3D programs, `lines` the track,
//! isobaths, depth areas and storage, and all lines and areas in one file, `rasters` the depth map
//! as rasters and text, and the side-scan mosaic, `tiles` the map as web tiles, `comparison` the
//! agreement of the depths, `object_files` the objects of a search and of a review, `report_page`
//! writes the report; `manifest` lists and describes the files, and finds those that are out of
//! date. `boxes` writes reviewed boxes, and pictures of them for training.

mod boxes;
mod clouds;
mod comparison;
mod content;
mod lines;
mod manifest;
mod object_files;
mod order;
mod product_files;
mod rasters;
mod registry;
mod report_page;
mod results;
mod run_folder;
mod tiles;
mod write;

pub use boxes::write_boxes;
pub use comparison::{ComparisonRecord, write_differences};
pub use manifest::{EarlierRun, is_run_of};
pub use object_files::Proposed;
pub use order::{Order, Product, When, log_names};
pub use product_files::{Amounts, about_bytes, files_in_words};
pub use registry::{OUTPUT_FILES, OutputFile, row_of};
pub use run_folder::{Replaced, RunFolder, finish_killed_run};
pub use write::{Written, begin, write, write_detected, write_detected_in_picture};

/// The file that lists all files of a run; it is put in place last.
pub const MANIFEST: &str = "manifest.json";
