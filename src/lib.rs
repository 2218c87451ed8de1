//! Bathyscope: from the log of a low-cost side-scan fish-finder to a depth map and a 3D point cloud.
//!
//! Data flows one way, and so do the dependencies between the modules below (a test guards it):
//!
//! ```text
//! bytes --formats--> Survey --first_return--> FirstReturns --cloud--> PointCloud --export--> files
//!   ^                 | |                                      ^
//!   '-- simulation    | |                                      '-- calibration (pixels per metre)
//!                     | |--bathymetry: surfaces, isobaths, and what they are worth against a reference
//!                     | '--detection: objects on the bottom
//!                     '--waterfall: picture tiles
//! pipeline runs the stages, html_report makes the report of the results, outputs writes all files of a run, app holds what the analyst sees and decides, ui shows it, render draws it, cli is the program.
//! manual holds the pages of the manual with tables derived from the program.
//! pipeline runs the stages, html_report makes the report of the results, outputs writes all files of a run, project keeps what was decided about a survey, app holds what the analyst sees and decides, ui shows it, render draws it, cli is the program.
//! base_map is a picture of the analyst's own under the map.
//! geo (positions and planes), presentation (colours, numbers, plots), progress, statistics, calendar, catch_panic, printable, regular_file and system_words serve them all.
//! ```
//!
//! Every stage is a pure function `fn(&input, &settings, &Progress) -> Result<output>`; outputs are immutable and shared
//! as `Arc`. Coordinates inside are SI: metres east and north of the survey's origin, radians clockwise from north,
//! depth positive down (`depth_m`), elevation positive up (`z_m`). Degrees and feet exist only at the edges.
//!
//! Without the feature `gui`, which is on by default, there is neither `ui` nor `render`, and no crate for windows and GPUs.

pub mod app;
pub mod base_map;
pub mod bathymetry;
mod calendar;
pub mod calibration;
mod catch_panic;
pub mod cli;
pub mod cloud;
pub mod detection;
pub mod export;
pub mod first_return;
pub mod formats;
pub mod geo;
pub mod html_report;
pub mod manual;
pub mod mosaic;
pub mod outputs;
pub mod pipeline;
pub mod presentation;
mod printable;
pub mod progress;
pub mod project;
mod regular_file;
#[cfg(feature = "gui")]
pub mod render;
pub mod simulation;
mod statistics;
pub mod survey;
mod system_words;
#[cfg(feature = "gui")]
pub mod ui;
pub mod waterfall;
