//! What is written: files of every kind, the report, the files of a run, map tiles, and archives of many logs.
//!
//! In: results of the pipeline. Out: files in a folder. It uses `pipeline` and all that comes before it but `simulation`.

pub(crate) mod archive;
pub(crate) mod export;
pub(crate) mod html_report;
pub(crate) mod map_tiles;
pub(crate) mod outputs;
