//! What a log says of the bottom: first returns, calibration, points, surfaces, mosaics and pictures of echoes.
//!
// Their failure is the failure of the test.
#![cfg_attr(test, allow(clippy::expect_used, clippy::unwrap_used))]

pub mod bathymetry;
pub mod calibration;
pub mod cloud;
pub mod first_return;
pub mod mosaic;
mod nearest;
pub mod picture;
pub mod planning;
pub mod presentation;
mod sparse;
pub mod swath;
pub mod vectors;
pub mod waterfall;
