//! Bathyscope: from the log of a low-cost side-scan fish-finder to a depth map and a 3D point cloud.
//!
//! Data flows one way, and so do the dependencies between the modules below (a test guards it). Each module uses only those above it:
//!
//! ```text
//! support      positions, colours, progress, statistics: serves all
//! survey       one log as it was recorded: pings, samples, track
//! formats      bytes -> Survey, and the files of other instruments
//! simulation   scenes of known truth, written as logs
//! sonar        Survey -> first returns, calibration
//! bottom       -> points, surfaces, isobaths, depths from echo levels, planned lines
//! imagery      -> waterfall, picture, mosaic
//! detection    -> boxes, review, objects, shapes
//! pipeline     runs the stages, keeps what is valid, knows what is out of date
//! products     results -> files, report, map tiles, archives of many logs
//! project      what was decided about a survey, on disk
//! app          what the analyst sees and decides: state, commands, undo; the manual
//! ui           the window (egui); render draws on the GPU and knows no survey
//! cli          the program: arguments -> window or headless run
//! ```
//!
//! From a log to its points, and to the depth map of all logs of a survey:
//!
//! ```
//! use bathyscope::formats;
//! use bathyscope::pipeline::{self, Derived, ProcessedLog, Settings};
//! use bathyscope::support::progress::Progress;
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
//! Without the feature `gui`, which is on by default, there is no `ui`, and no crate for windows and GPUs.

pub mod app;
pub mod bottom;
pub mod cli;
pub mod detection;
pub mod formats;
pub mod imagery;
pub mod pipeline;
pub mod products;
pub mod project;
pub mod simulation;
pub mod sonar;
pub mod support;
pub mod survey;
#[cfg(feature = "gui")]
pub mod ui;

/// The benchmarks, run by `cargo bench --features bench`.
#[cfg(all(feature = "bench", not(test)))]
#[path = "../tests/bench/mod.rs"]
pub mod bench;
#[cfg(all(test, feature = "gui"))]
#[path = "../tests/suite/mod.rs"]
mod suite;
