//! What is written: files of every kind, the report, the files of a run, map tiles, and archives of many logs.
//!
//! In: results of the pipeline. Out: files in a folder. It uses `pipeline` and all that comes before it.

pub mod archive;
pub mod export;
pub mod html_report;
pub mod map_tiles;
pub mod outputs;
