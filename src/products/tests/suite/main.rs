//! Whole runs without a window: simulated surveys of known truth through all stages, and the real
//! recordings.

#![allow(
    clippy::expect_used,
    clippy::unwrap_used,
    reason = "their failure is the failure of the test"
)]

mod bathymetry;
mod calibration;
mod cloud;
mod detection_targets;
mod export;
mod garbled;
mod html_report;
mod large_boxes;
mod missions;
mod mosaic;
mod mosaic_gain;
mod navigation;
mod offsets;
mod picture_log;
mod point_classes;
mod rates;
mod river;
mod swath;
mod trusted_depths;
mod truth;
