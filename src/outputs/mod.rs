//! What is written of a survey: one run, the same from the window and the command line.
//!
//! `write` makes all files of a run, `run_folder` puts them in place together; `detected` those of a search alone; `overwrite` keeps them from
//! taking the place of what they are made from. `clouds` writes the files of points, `track` those of the boat's way, `depth` the
//! depth map and what follows from it, `residuals` and `comparison` how the depths agree, `mosaic` the side-scan mosaic,
//! `detections` what a search proposes; `record` is what lies beside each file. `boxes` writes what was decided about boxes,
//! `lessons` as pictures for training, `merged` the depth map of several logs.

mod boxes;
mod clouds;
mod comparison;
mod depth;
mod detected;
mod detections;
mod lessons;
mod merged;
mod mosaic;
mod overwrite;
mod product;
mod record;
mod residuals;
mod run_folder;
mod track;
mod write;

pub use boxes::{BoxesWritten, write_boxes};
pub use comparison::{ComparisonRecord, write_differences};
pub use detected::{write_detected, write_detected_in_picture};
pub use detections::Proposed;
pub use merged::Merged;
pub use mosaic::{MosaicWritten, write_mosaic};
pub use overwrite::refuse_overwrite;
pub use product::Product;
pub use run_folder::RunFolder;
pub use write::{Order, Searched, Written, write};
