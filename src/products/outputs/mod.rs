//! Writes the files of a survey: one run, the same from Bathyscope and from the command line.
//!
//! In: the results of a survey, and what is ordered. Out: the files of a run, with their manifest.
//!
//! `registry` has a row for each file; `write` makes all files of a run from `results`, those of
//! several `groups` at once, `run_folder` puts them in place together, `overwrite` keeps them from
//! taking the place of what they are made from, `earlier_run` tells which are out of date. `order`
//! is what is asked for, `content` and `need` what a file holds and what it cannot be made without,
//! `run` a run while its files are written. `clouds` writes the files of points, `track` those of
//! the boat's way, `depth` the depth map and what follows from it, `residuals` and `comparison` how
//! the depths agree, `mosaic` the side-scan mosaic, `detections` what a search proposes, `targets`
//! what a review decided, `objects` makes one object of its sightings in all logs, `page` writes
//! the report; `manifest` lists the files with what each is. `boxes` writes what was decided about
//! boxes, `training_tiles` as pictures for training, `raster` says where a raster lies.

mod boxes;
mod clouds;
mod comparison;
mod content;
mod depth;
mod detected;
mod detections;
mod earlier_run;
mod error;
mod geopackage;
mod ground;
mod groups;
mod logs;
mod manifest;
mod mosaic;
mod mosaic_grid;
mod need;
mod objects;
mod order;
mod overwrite;
mod product;
mod product_files;
mod raster;
mod registry;
mod report_page;
mod residuals;
mod results;
mod run;
mod run_folder;
mod sizes;
mod targets;
mod track;
mod training_tiles;
mod write;

pub use boxes::write_boxes;
pub use comparison::{ComparisonRecord, write_differences};
pub use detected::{write_detected, write_detected_in_picture};
pub use detections::Proposed;
pub use earlier_run::{EarlierRun, is_run_of};
pub use error::OutputError;
pub use logs::log_names;
pub use order::Order;
pub use order::When;
pub use overwrite::begin;
pub use product::Product;
pub use product_files::files_in_words;
pub use registry::row_of;
pub use registry::{OUTPUT_FILES, OutputFile};
pub use run_folder::Replaced;
pub use run_folder::RunFolder;
pub use sizes::{Amounts, about_bytes};
pub use write::{Written, write};

/// The file that names all files of a run, in place last.
pub const MANIFEST: &str = "manifest.json";
