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
pub mod export;
pub mod file_in_use;
pub mod file_name;
pub(crate) mod html_report;
pub mod map_tiles;
pub mod outputs;
pub mod pipeline;
pub mod project;

use bathyscope_bottom::bathymetry::isobaths::NoIsobaths;
use bathyscope_bottom::presentation::page::TemplateFault;
use bathyscope_log::formats::OpenError;
use bathyscope_log::support::file_error::FileError;
use bathyscope_log::support::geo::CrsError;
use bathyscope_log::support::progress::Cancelled;
use bathyscope_objects::DetectError;
use std::io;

/// Name and version of the program, as files state them.
pub(crate) const PROGRAM: &str = concat!("bathyscope ", env!("CARGO_PKG_VERSION"));

/// Reason why work failed or was cancelled, in a sentence that names the problem, the place and the
/// remedy.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct Error(String);

impl From<String> for Error {
    fn from(sentence: String) -> Self {
        Self(sentence)
    }
}

impl<Fault: std::error::Error + 'static> From<FileError<Fault>> for Error {
    fn from(error: FileError<Fault>) -> Self {
        Self(error.to_string())
    }
}

/// Takes the sentences of other errors.
macro_rules! from_sentences {
    ($($error:ty),+) => {$(
        impl From<$error> for Error {
            fn from(error: $error) -> Self {
                Self(error.to_string())
            }
        }
    )+};
}

from_sentences!(&str, Cancelled, CrsError, DetectError, NoIsobaths, OpenError);
from_sentences!(TemplateFault, io::Error, serde_json::Error);
