//! Reads the logs of fish-finders and side-scan sonars, and the files that belong to them: tracks, gauges, areas, points and rasters.
//!
// Their failure is the failure of the test.
#![cfg_attr(test, allow(clippy::expect_used, clippy::unwrap_used))]

pub mod formats;
pub mod support;
pub mod survey;
