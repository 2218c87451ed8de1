//! What every other module may use: positions and planes, colours and numbers, progress,
//! statistics, files and texts.
//!
//! In: plain values. Out: plain values. It names no other module of the program.

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
