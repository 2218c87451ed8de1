//! What every other module may use: positions and planes, colours and numbers, progress, statistics, files and texts.
//!
//! In: plain values. Out: plain values. It names no other module of the program.

#[cfg(feature = "gui")]
pub(crate) mod block_on;
pub(crate) mod calendar;
pub(crate) mod catch_panic;
pub(crate) mod crash_report;
#[cfg(feature = "gui")]
pub(crate) mod drives;
pub(crate) mod file_error;
pub(crate) mod file_in_use;
pub(crate) mod file_name;
pub(crate) mod geo;
pub(crate) mod mapped_file;
pub(crate) mod named;
pub(crate) mod nearest;
pub(crate) mod outline;
pub(crate) mod picture_file;
pub(crate) mod presentation;
pub(crate) mod printable;
pub(crate) mod progress;
#[cfg(test)]
pub(crate) mod random_cases;
pub(crate) mod regular_file;
pub(crate) mod sparse;
pub(crate) mod statistics;
pub(crate) mod system_words;
pub(crate) mod vectors;
pub(crate) mod versions;
