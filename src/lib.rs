//! Bathyscope: from the log of a low-cost side-scan fish-finder to a depth map and a 3D point cloud.
//!
//! Data flows one way, and so do the dependencies between the modules below (a test guards it):
//!
//! ```text
//! bytes --formats--> Survey --first_return--> FirstReturns --cloud--> PointCloud --export--> files
//!   ^                 | |                                      ^
//!   '-- simulation    | |                                      '-- calibration (pixels per metre)
//!                     | |--bathymetry: surfaces, isobaths, and what they are worth against a reference
//!                     | |--map_tiles: the depth map as pictures for plotters and the web
//!                     | |--swath: depth between the lines, from the brightness of the echoes
//!                     | |--planning: where to sail next, from what the soundings leave in doubt
//!                     | '--detection: objects on the bottom
//!                     '--waterfall: picture tiles, shown with gain and levels by picture
//! pipeline runs the stages, lake keeps what many logs measured in tiles, html_report makes the report of the results, outputs writes all files of a run, project keeps what was decided about a survey, app holds what the analyst sees and decides, ui shows it, render draws it, cli is the program.
//! base_map is a picture of the analyst's own under the map, manual holds the pages of the manual with tables derived from the program.
//! geo (positions and planes), presentation (colours, numbers, plots), progress, statistics, calendar, catch_panic, outline, printable, regular_file, sparse, system_words and versions (lists that grow) serve them all.
//! ```
//!
//! From a log to its points, and to the depth map of all logs of a survey:
//!
//! ```
//! use bathyscope::formats;
//! use bathyscope::pipeline::{self, Derived, ProcessedLog, Settings};
//! use bathyscope::progress::Progress;
//! use std::{path::Path, sync::Arc};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let progress = Progress::new();
//! let survey = Arc::new(formats::open(Path::new("assets/demo.sl2"), &progress)?);
//! let products = pipeline::run(&survey, &Settings::default(), None, &progress, |_| ())?;
//! assert!(products.cloud.points.len() > 1000);
//!
//! let logs = [ProcessedLog { survey, products }];
//! let depth_map = Derived::default().depth_map(&logs, &progress)?;
//! let depth_map = depth_map.expect("the depths span a surface");
//! let [shallowest_m, deepest_m] = depth_map.surface.range_m();
//! assert!(1.0 < shallowest_m && deepest_m < 3.0);
//! # Ok(())
//! # }
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
pub mod lake;
pub mod manual;
pub mod map_tiles;
pub mod mosaic;
mod outline;
pub mod outputs;
pub mod picture;
pub mod pipeline;
pub mod planning;
pub mod presentation;
mod printable;
pub mod progress;
pub mod project;
mod regular_file;
#[cfg(feature = "gui")]
pub mod render;
pub mod simulation;
mod sparse;
mod statistics;
pub mod survey;
pub mod swath;
mod system_words;
#[cfg(feature = "gui")]
pub mod ui;
mod versions;
pub mod waterfall;
