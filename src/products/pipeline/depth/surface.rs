//! The surface of the depths of a survey.

use super::plane::CloudPlane;
use super::swath::log_echoes;
use crate::pipeline::ProcessedLog;
use bathyscope_bottom::bathymetry::{DepthPoint, Surface, SwathDepth, surface};
use bathyscope_bottom::swath::{LogEchoes, correct};
use bathyscope_log::support::geo::MapPlane;
use bathyscope_log::support::progress::{Cancelled, Progress};

/// The surface of the kept points of all logs of a survey in the plane of a map, by the `surface.*`
/// settings of the first. Each log's points weigh what its own settings give them; where logs meet
/// in a cell the weighted median stands, so that a log with many points there counts more. Where
/// one side alone sees a slope, the depth under the boat that follows from it counts as well.
/// Depths between the lines come from the levels of the echoes of all logs where `surface.swath`
/// says so. `None` where the depths span no surface.
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
    let settings = &first.products.settings.surface;
    let mut points = joint_depth_points(logs, map, progress)?;
    for log in logs {
        let plane = CloudPlane::new(&log.survey, &log.products, map.clone());
        points.append(&mut plane.slope_points(&log.products));
    }
    let mut made = match settings.swath {
        SwathDepth::Off => surface(points, settings, progress)?,
        _ => {
            let mut made = surface(points.clone(), settings, progress)?;
            if let Some(made) = &mut made {
                let echoes: Vec<LogEchoes<'_>> =
                    logs.iter().map(|log| echoes_of(log, map)).collect();
                correct(made, echoes, &points, progress, settings.swath)?;
            }
            made
        }
    };
    if let Some(made) = &mut made {
        for log in logs {
            let plane = CloudPlane::new(&log.survey, &log.products, map.clone());
            made.doubt(&plane.doubtful_points(&log.products));
        }
    }
    Ok(made)
}

/// The kept points of all logs of a survey that count for its surface, in the plane of a map.
///
/// # Errors
/// When the work was cancelled.
pub fn joint_depth_points(
    logs: &[ProcessedLog],
    map: &MapPlane,
    progress: &Progress,
) -> Result<Vec<DepthPoint>, Cancelled> {
    let mut points = Vec::new();
    for log in logs {
        progress.check()?;
        let plane = CloudPlane::new(&log.survey, &log.products, map.clone());
        points.append(&mut plane.depth_points(&log.products));
    }
    Ok(points)
}

fn echoes_of<'a>(log: &'a ProcessedLog, map: &MapPlane) -> LogEchoes<'a> {
    let (track, navigation) = (&log.survey.track, &log.products.navigation);
    log_echoes(&log.survey, &log.products, |[east_m, north_m]| {
        map.place(navigation.to_lon_lat(track, east_m, north_m))
    })
}
