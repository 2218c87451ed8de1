//! What the depths give: the surface, isobaths, the agreement of side-scan with soundings, the crossings of the track. All in the system
//! that `crs` names.

mod chart;
mod choices;
mod contours;
mod crossed;
mod plane;
mod residuals;

pub use chart::{DepthChart, depth_surface, joint_depth_surface};
pub use choices::{Choice, choices};
pub use contours::Contours;
pub use crossed::{Crossed, crossed};
pub use plane::Plane;
pub use residuals::{NamedComparison, comparisons};
