//! The surface of the depths of a survey.

use super::plane::Plane;
use crate::bathymetry::{Surface, surface};
use crate::geo::MapPlane;
use crate::pipeline::ProcessedLog;
use crate::progress::{Cancelled, Progress};

/// The surface of the kept points of all logs of a survey in the plane of a map, by the `surface.*` settings of the first. Each log's
/// points weigh what its own settings give them; where logs meet in a cell the weighted median stands, so that a log with many points
/// there counts more. `None` where the depths span no surface.
///
/// # Errors
/// When the work was cancelled.
pub fn joint_depth_surface(
    logs: &[ProcessedLog],
    map: &MapPlane,
    progress: &Progress,
) -> Result<Option<Surface>, Cancelled> {
    let Some(first) = logs.first() else {
        return Ok(None);
    };
    let mut points = Vec::new();
    for log in logs {
        progress.check()?;
        let plane = Plane::new(&log.survey, &log.products, map.clone());
        points.append(&mut plane.depth_points(&log.products));
    }
    surface(points, &first.products.settings.surface, progress)
}
