//! Computes the products of the depths: the surface, its uncertainty, and the agreement of
//! side-scan with soundings. All are in the coordinate system that `crs` names.
//!
//! In: the results of logs, and settings. Out: surfaces, uncertainties and comparisons.

mod residuals;
mod surface;
mod uncertainty;

pub use residuals::{GeometryChoice, choices};
pub(crate) use residuals::{NamedComparison, comparisons};
pub(crate) use surface::CloudPlane;
pub use surface::{depth_points, joint_depth_points, joint_depth_surface, log_echoes};
pub use uncertainty::CommonUncertainty;
