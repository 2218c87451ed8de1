//! Writes the files of a survey: one run, the same from Bathyscope and from the command line.
//!
//! In: the results of a survey, and what is ordered. Out: the files of a run, with their manifest.
//!
//! `registry` has a row for each file, `product_files` says of those of a product what they are and
//! how large; `write` makes all files of a run from `results`, those of several `groups` at once,
//! `run_folder` puts them in place together, `overwrite` keeps them from taking the place of what
//! they are made from, `earlier_run` tells which are out of date. `order` is what is asked for,
//! `content` what a file holds and what it cannot be made without. `clouds` writes the files of
//! points, `track` those of the boat's way, `depth` the depth map and what follows from it,
//! `residuals` and `comparison` how the depths agree, `mosaic` the side-scan mosaic, `geopackage`
//! all lines and areas in one file, `object_files` what a search proposes and what a review
//! decided, `objects` makes one object of its sightings in all logs, `report_page` writes the
//! report; `manifest` lists the files with what each is. `boxes` writes what was decided about
//! boxes, `training_tiles` as pictures for training, `ground` says where a raster lies.

mod boxes;
mod clouds;
mod comparison;
mod content;
mod depth;
mod earlier_run;
mod error;
mod geopackage;
mod ground;
mod groups;
mod manifest;
mod mosaic;
mod object_files;
mod objects;
mod order;
mod overwrite;
mod product_files;
mod registry;
mod report_page;
mod residuals;
mod results;
mod run_folder;
mod track;
mod training_tiles;
mod write;

pub use boxes::write_boxes;
pub use comparison::{ComparisonRecord, write_differences};
pub use earlier_run::{EarlierRun, is_run_of};
pub use error::OutputError;
pub use object_files::Proposed;
pub use order::{Order, Product, When, log_names};
pub use overwrite::begin;
pub use product_files::{Amounts, about_bytes, files_in_words};
pub use registry::row_of;
pub use registry::{OUTPUT_FILES, OutputFile};
pub use run_folder::Replaced;
pub use run_folder::RunFolder;
pub use write::{Written, write, write_detected, write_detected_in_picture};

/// The file that names all files of a run, in place last.
pub const MANIFEST: &str = "manifest.json";
