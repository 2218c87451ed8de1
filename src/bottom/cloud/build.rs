//! Picks and soundings to points in the survey's plane.

use super::confirmed::confirmed;
use super::geometry::{BottomPoint, across_track, fixed_bottom_point};
use super::pick_traits::{PickTrait, PickTraits};
use super::specular::{Pair, beam_angles_rad, specular_point};
use super::swath::swath_points;
use super::{
    BySource, CloudPoint, CloudSettings, Correction, DownScan, Geometry, PointCloud, PointSource,
    RecordIndex, Reduction,
};
use crate::calibration::Calibration;
use crate::first_return::{FirstReturns, Pick};
use bathyscope_log::support::progress::{Cancelled, Progress};
use bathyscope_log::survey::{Navigation, Side, Survey, nearest_in_time};
use rayon::prelude::*;
use std::sync::Arc;

/// Builds the cloud: [`place`] for a single time.
///
/// # Errors
/// When the work was cancelled.
pub fn build(
    survey: &Survey,
    navigation: &Navigation,
    returns: &FirstReturns,
    calibration: &Calibration,
    settings: &CloudSettings,
    correction: &Correction,
    progress: &Progress,
) -> Result<PointCloud, Cancelled> {
    let traits = PickTraits::new(survey, navigation, returns);
    let returns = (returns, &traits);
    place(survey, navigation, returns, calibration, settings, correction, progress)
}

/// Builds the cloud of first returns whose traits are known.
///
/// Every sounding, every pick of a ping with a heading and every stretch of a swath gives a point.
/// Each point lies on its own beam's side of the track: starboard is `(h_y, -h_x) / |h|`. Ranges
/// and depths are corrected before any geometry.
///
/// # Errors
/// When the work was cancelled.
pub fn place(
    survey: &Survey,
    navigation: &Navigation,
    (returns, traits): (&FirstReturns, &PickTraits),
    calibration: &Calibration,
    settings: &CloudSettings,
    correction: &Correction,
    progress: &Progress,
) -> Result<PointCloud, Cancelled> {
    progress.start(3);
    let reduction = Reduction::new(calibration, correction);
    let ranges = Side::BOTH.map(|side| ranges_m(survey, returns, reduction, side));
    let counts = match settings.down_scan {
        DownScan::All => vec![true; survey.soundings.len()],
        DownScan::Locked => confirmed(survey, &ranges, |depth_m| reduction.altitude_m(depth_m)),
    };
    let soundings = Arc::new(sounding_points(survey, navigation, &counts, correction));
    progress.advance(1);
    let angles_rad = match settings.geometry {
        Geometry::Slope => {
            angles_rad(survey, (&ranges, traits), reduction, calibration.beams.overlap_rad)
        }
        _ => Vec::new(),
    };
    progress.advance(1);
    progress.check()?;
    let points_of = |side: Side, ranges_m: &[f64]| -> Vec<CloudPoint> {
        let bottom_point = |ping: usize, range_m: f64| match angles_rad.get(ping) {
            Some(angles_rad) => specular_point(range_m, angles_rad[side as usize]),
            None => fixed_bottom_point(settings.geometry, range_m, settings.alpha2_deg),
        };
        let z_m =
            |ping: usize, below_m: f64| correction.z_m(survey.side_scan[ping].time_s, below_m);
        let picks = picks(returns, traits, side);
        // Nearly every ping has one: a list that grows is copied, and takes twice the memory then.
        let mut points = Vec::with_capacity(ranges_m.len());
        points.extend(side_points(navigation, picks, side, ranges_m, bottom_point, z_m));
        points
    };
    let swath = Arc::new(swath_points(survey, navigation, correction, progress)?);
    let [port_m, starboard_m] = &ranges;
    let points = BySource::from_parts(|source| match source {
        PointSource::DownScan => soundings.clone(),
        PointSource::Port => Arc::new(points_of(Side::Port, port_m)),
        PointSource::Starboard => Arc::new(points_of(Side::Starboard, starboard_m)),
        PointSource::Swath => swath.clone(),
    });
    progress.advance(1);
    Ok(PointCloud { points, zero_heading: navigation.zero_heading })
}

/// No side-scan reaches farther, metres: where a calibration says so, it is that which is wrong.
const FARTHEST_M: f64 = 10_000.0;

/// Slant range of every pick of a side, by the true speed of sound; NaN without one, or where it
/// cannot be.
fn ranges_m(
    survey: &Survey,
    returns: &FirstReturns,
    reduction: Reduction<'_>,
    side: Side,
) -> Vec<f64> {
    let picks = returns.side(side).par_iter().enumerate();
    picks
        .map(|(ping, pick)| reduction.range_at_m(survey, ping, side, pick.sample))
        .map(|range_m| if range_m <= FARTHEST_M { range_m } else { f64::NAN })
        .collect()
}

/// Angles of the first returns of both sides from straight below at every ping. Above-bottom
/// returns but clutter count: on a steep slope the bottom itself lies above the recorded depth, and
/// an above-bottom return on one side moves only the points of that side.
fn angles_rad(
    survey: &Survey,
    ([port, starboard], traits): (&[Vec<f64>; 2], &PickTraits),
    reduction: Reduction<'_>,
    overlap_rad: f64,
) -> Vec<[f64; 2]> {
    let bottom_m = |(range_m, traits): (&f64, &PickTrait)| {
        if traits.is_clutter || traits.confidence == 0.0 { f64::NAN } else { *range_m }
    };
    let port = port.iter().zip(traits.side(Side::Port)).map(bottom_m);
    let starboard = starboard.iter().zip(traits.side(Side::Starboard)).map(bottom_m);
    let pairs: Vec<Pair> = port
        .zip(starboard)
        .zip(survey.side_scan.iter())
        .map(|((port_m, starboard_m), ping)| Pair {
            time_s: ping.time_s,
            port_m,
            starboard_m,
            altitude_m: reduction.altitude_m(f64::from(ping.good_depth_m())),
        })
        .collect();
    beam_angles_rad(&pairs, overlap_rad)
}

fn sounding_points(
    survey: &Survey,
    navigation: &Navigation,
    counts: &[bool],
    correction: &Correction,
) -> Vec<CloudPoint> {
    let placed = survey.soundings.iter().zip(navigation.soundings.iter());
    let soundings = placed.enumerate();
    let nearest_ping =
        |time_s| nearest_in_time(&survey.side_scan, time_s, |ping| ping.time_s).unwrap_or(0);
    soundings
        .filter(|(_, (sounding, place))| sounding.depth_m > 0.0 && place.east_m.is_finite())
        .map(|(index, (sounding, place))| CloudPoint {
            record: RecordIndex::new(index),
            fault: sounding.fault.filter(|_| !counts[index]),
            ..CloudPoint::new(
                PointSource::DownScan,
                nearest_ping(sounding.time_s) as u32,
                [
                    place.east_m,
                    place.north_m,
                    -correction.depth_m(sounding.time_s, f64::from(sounding.depth_m)),
                ],
            )
        })
        .collect()
}

/// The picks of a side with what each is.
fn picks<'a>(
    returns: &'a FirstReturns,
    traits: &'a PickTraits,
    side: Side,
) -> impl Iterator<Item = (&'a Pick, &'a PickTrait)> {
    returns.side(side).iter().zip(traits.side(side))
}

fn side_points<'a>(
    navigation: &'a Navigation,
    picks: impl Iterator<Item = (&'a Pick, &'a PickTrait)> + 'a,
    side: Side,
    ranges_m: &'a [f64],
    bottom_point: impl Fn(usize, f64) -> BottomPoint + 'a,
    z_m: impl Fn(usize, f64) -> f64 + 'a,
) -> impl Iterator<Item = CloudPoint> + 'a {
    let source = match side {
        Side::Port => PointSource::Port,
        Side::Starboard => PointSource::Starboard,
    };
    let pings = navigation.pings.iter().zip(picks).zip(ranges_m);
    let detected = pings.enumerate().filter(|(_, (_, range_m))| **range_m > 0.0);
    detected.filter_map(move |(ping, ((place, (pick, traits)), &range_m))| {
        let bottom_point = bottom_point(ping, range_m);
        let [east_m, north_m] = across_track(place, side, bottom_point.across_m)?;
        Some(CloudPoint {
            above_bottom: traits.above_bottom,
            level: traits.level,
            above_bottom_m: traits.above_bottom_m,
            confidence: traits.confidence,
            sample: pick.sample,
            ..CloudPoint::new(
                source,
                ping as u32,
                [east_m, north_m, z_m(ping, bottom_point.depth_m)],
            )
        })
    })
}
