//! What is made on the ground: points, surfaces, isobaths, depths between the lines from echo levels, and lines to survey next.
//!
//! In: a survey with first returns and calibration. Out: point clouds, surfaces and plans. It uses `sonar`, `survey` and `support`.

pub(crate) mod bathymetry;
pub(crate) mod cloud;
pub(crate) mod planning;
pub(crate) mod swath;
