//! Positions and planes, times, progress, statistics, files and their faults: plain values that all
//! crates use, and that know nothing of logs.

pub mod calendar;
pub mod catch_panic;
pub mod file_error;
pub mod geo;
pub mod mapped_file;
mod named;
pub mod outline;
pub mod picture_file;
pub mod printable;
pub mod progress;
pub mod regular_file;
pub mod statistics;
pub mod versions;
