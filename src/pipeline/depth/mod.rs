//! What the depths give: the surface, the agreement of side-scan with soundings, the crossings of the track. All in the system
//! that `crs` names.

mod chart;
mod choices;
mod crossed;
mod plane;
mod residuals;

pub use chart::{DepthChart, depth_surface, joint_depth_surface};
pub use choices::{Choice, choices};
pub use crossed::{Crossed, crossed};
pub use plane::Plane;
pub use residuals::{NamedComparison, comparisons};
