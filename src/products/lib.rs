//! Runs the stages of a survey, keeps what was decided about it, and writes its files.
//!
//! [`pipeline`] runs the stages of each log and what all logs give together, each from its input
//! and settings alone, and keeps what is still valid. [`outputs`] writes the files of a run, all of
//! them or none: [`export`] has the files of each kind, [`html_report`] the report, [`map_tiles`]
//! the tiles. [`archive`] keeps one map of many logs, [`project`] what an analyst decided.
//!
//! # Make the depth map of a log, and write its files
//!
//! ```
//! use bathyscope_log::formats::open;
//! use bathyscope_log::support::progress::Progress;
//! use bathyscope_objects::objects::SurveyReview;
//! use bathyscope_products::outputs::{Order, Product, RunFolder, write};
//! use bathyscope_products::pipeline::{Derived, ProcessedLog, Settings, run};
//! use std::sync::Arc;
//!
//! let progress = Progress::new();
//! # let demo = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets/demo.sl2");
//! let survey = Arc::new(open(&demo, &progress)?);
//! let products = run(&survey, &Settings::default(), None, &progress, |_| ())?;
//! let logs = [ProcessedLog { survey, products }];
//! let derived = Derived::default();
//! let depth_map = derived.depth_map(&logs, &progress)?.expect("the depths span a surface");
//! let [shallowest_m, deepest_m] = depth_map.surface.range_m();
//! assert!(1.0 < shallowest_m && deepest_m < 3.0);
//!
//! let folder = tempfile::tempdir()?;
//! let order = Order {
//!     logs: &logs,
//!     derived: &derived,
//!     requested: &[Product::Track],
//!     reference: None,
//!     search: None,
//!     review: &SurveyReview::default(),
//!     corrections: &[],
//! };
//! let written = write(&order, RunFolder::begin(folder.path())?, &progress, |_| ())?;
//! println!("{} files", written.file_count);
//! # assert!(folder.path().join("report.json").is_file());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

// Their failure is the failure of the test.
#![cfg_attr(test, allow(clippy::expect_used, clippy::unwrap_used))]

pub mod archive;
mod error;
pub mod export;
pub mod file_in_use;
pub mod file_name;
pub(crate) mod html_report;
pub mod map_tiles;
pub mod outputs;
pub mod pipeline;
pub mod project;

pub use error::Error;
