//! Computes the surface of the depths of a survey.

use super::plane::CloudPlane;
use crate::pipeline::{ProcessedLog, Products};
use bathyscope_bottom::bathymetry::{DepthPoint, Surface, SwathDepth, surface};
use bathyscope_bottom::swath::{LogEchoes, PingPlace, SideEchoes, correct};
use bathyscope_log::support::geo::MapPlane;
use bathyscope_log::support::progress::{Cancelled, Progress};
use bathyscope_log::survey::{PingNav, Side, Survey};

/// Computes the surface of the kept points of all logs of a survey in the plane of a map, by the
/// `surface.*` settings of the first log. The points of each log have the weights of its own
/// settings; a cell with points of several logs has their weighted median, so that a log with many
/// points there counts more. Where one side alone sees a slope, the depth under the boat that
/// follows from it counts as well. If `surface.swath` is set, depths between the lines come from
/// the echo levels of all logs. `None` if the depths span no surface.
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

/// Returns the kept points of all logs of a survey that count for its surface, in the plane of a
/// map.
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

/// Returns the echoes and places of the pings of a log, for depths from echo levels. `place`
/// transforms east and north in the plane of the survey into those of another plane, metres.
/// Excluded pings have no place. A log without usable side-scan has no pings.
pub fn log_echoes<'a>(
    survey: &'a Survey,
    products: &Products,
    place: impl Fn([f64; 2]) -> [f64; 2],
) -> LogEchoes<'a> {
    let count = if survey.has_side_scan() { survey.side_scan.len() } else { 0 };
    let of_ping = |ping: usize| {
        let time_s = survey.side_scan.get(ping).map_or(f64::NAN, |ping| ping.time_s);
        let navigation = products.navigation.pings.get(ping);
        let counts = products.exclusions.ping(ping).is_none();
        let (place_m, starboard) = navigation
            .filter(|_| counts)
            .and_then(|navigation| placed(navigation, &place))
            .unwrap_or(([f64::NAN; 2], [f64::NAN; 2]));
        PingPlace {
            time_s,
            place_m,
            starboard,
            transducer_m: -products.correction.z_m(time_s, 0.0),
            sides: Side::BOTH.map(|side| side_echoes(survey, products, ping, side)),
        }
    };
    LogEchoes { levels: survey, pings: (0..count).map(of_ping).collect() }
}

/// Returns the place of a ping in the plane to which `place` transforms, and the direction of
/// starboard there: the north directions of two planes may differ. `None` if the direction is
/// unknown.
fn placed(
    navigation: &PingNav,
    place: impl Fn([f64; 2]) -> [f64; 2],
) -> Option<([f64; 2], [f64; 2])> {
    let starboard = navigation.starboard()?;
    let from = navigation.place();
    let here = place(from);
    let beside = place([from[0] + starboard[0], from[1] + starboard[1]]);
    let across = [beside[0] - here[0], beside[1] - here[1]];
    let length_m = across[0].hypot(across[1]);
    (length_m > 0.0).then(|| (here, across.map(|part| part / length_m)))
}

fn side_echoes(survey: &Survey, products: &Products, ping: usize, side: Side) -> SideEchoes {
    let reduction = products.reduction();
    let range_m = |sample: f64| {
        let span = survey.span(ping, side);
        span.map_or(f64::NAN, |span| reduction.range_m(span, sample))
    };
    let pick = products.returns.side(side).get(ping);
    let near_m = range_m(0.0);
    SideEchoes {
        near_m,
        step_m: range_m(1.0) - near_m,
        first_return: pick.map_or(f64::NAN, |pick| f64::from(pick.sample)),
        above_bottom: pick.is_some_and(|pick| pick.above_bottom),
    }
}
