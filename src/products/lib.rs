//! What is written: files of every kind, the report, the files of a run, map tiles, and archives of many logs.
//!
//! In: results of the pipeline. Out: files in a folder. It uses `pipeline` and all that comes before it but `simulation`.

// Their failure is the failure of the test.
#![cfg_attr(test, allow(clippy::expect_used, clippy::unwrap_used))]

pub mod archive;
pub mod export;
pub mod file_in_use;
pub mod file_name;
pub mod html_report;
pub mod map_tiles;
pub mod outputs;
pub mod pipeline;
pub mod project;
