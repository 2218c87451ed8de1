//! Picks and soundings to points in the survey's plane.

use super::geometry::{Foot, beside, fixed_foot};
use super::{CloudPoint, CloudSettings, PointCloud, PointSource};
use crate::calibration::{Calibration, ScaleMode};
use crate::first_return::FirstReturns;
use crate::progress::{Cancelled, Progress};
use crate::survey::{Navigation, Side, Survey};

/// Slant range of a pick by the calibration in force, metres; NaN without a pick. The only place where samples become metres.
pub fn slant_range_m(
    survey: &Survey,
    calibration: &Calibration,
    ping: usize,
    side: Side,
    sample: f32,
) -> f64 {
    let Some(span) = survey.side_scan.get(ping).and_then(|ping| ping.side(side)) else {
        return f64::NAN;
    };
    match (calibration.mode, calibration.ppd) {
        (ScaleMode::FlatSpot, Some(ppd)) => f64::from(sample) / ppd.px_per_m,
        _ => span.range_m(f64::from(sample)) - calibration.offset_m,
    }
}

/// Builds the cloud.
///
/// Every sounding and every pick of a ping with a heading gives a point. Each point lies on its own beam's side of the
/// track: starboard is `(h_y, -h_x) / |h|`.
pub fn build(
    survey: &Survey,
    navigation: &Navigation,
    returns: &FirstReturns,
    calibration: &Calibration,
    settings: &CloudSettings,
    progress: &Progress,
) -> Result<PointCloud, Cancelled> {
    progress.start(3);
    let mut points = sounding_points(survey, navigation);
    progress.advance(1);
    for side in Side::BOTH {
        progress.check()?;
        let feet: Vec<Option<Foot>> = returns
            .side(side)
            .iter()
            .enumerate()
            .map(|(ping, pick)| {
                let range_m = slant_range_m(survey, calibration, ping, side, pick.sample);
                (range_m > 0.0).then(|| fixed_foot(settings.geometry, range_m, settings.alpha2_deg))
            })
            .collect();
        points.extend(side_points(navigation, returns, side, &feet));
        progress.advance(1);
    }
    Ok(PointCloud {
        points,
        zero_heading: navigation.zero_heading,
    })
}

fn sounding_points(survey: &Survey, navigation: &Navigation) -> Vec<CloudPoint> {
    let soundings = survey
        .soundings
        .iter()
        .zip(&navigation.soundings)
        .enumerate();
    soundings
        .filter(|(_, (sounding, place))| sounding.depth_m > 0.0 && place.east_m.is_finite())
        .map(|(index, (sounding, place))| CloudPoint {
            source: PointSource::DownScan,
            ping: nearest_ping(survey, sounding.time_s) as u32,
            sounding: Some(index as u32),
            sample: f32::NAN,
            east_m: place.east_m,
            north_m: place.north_m,
            z_m: -f64::from(sounding.depth_m),
        })
        .collect()
}

/// The side-scan ping nearest in time; 0 without side-scan.
fn nearest_ping(survey: &Survey, time_s: f64) -> usize {
    let pings = &survey.side_scan;
    let after = pings.partition_point(|ping| ping.time_s < time_s);
    let before = after.saturating_sub(1);
    match (pings.get(before), pings.get(after)) {
        (Some(a), Some(b)) if b.time_s - time_s < time_s - a.time_s => after,
        _ => before,
    }
}

fn side_points<'a>(
    navigation: &'a Navigation,
    returns: &'a FirstReturns,
    side: Side,
    feet: &'a [Option<Foot>],
) -> impl Iterator<Item = CloudPoint> + 'a {
    let pings = navigation
        .pings
        .iter()
        .zip(returns.side(side))
        .zip(feet)
        .enumerate();
    pings.filter_map(move |(ping, ((place, pick), foot))| {
        let [east_m, north_m] = beside(place, side, (*foot)?.across_m)?;
        Some(CloudPoint {
            source: match side {
                Side::Port => PointSource::Port,
                Side::Starboard => PointSource::Starboard,
            },
            ping: ping as u32,
            sounding: None,
            sample: pick.sample,
            east_m,
            north_m,
            z_m: -(*foot)?.depth_m,
        })
    })
}
