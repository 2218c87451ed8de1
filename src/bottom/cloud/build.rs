//! Makes points in the survey's plane of picks and soundings, and finds the properties of first
//! returns that do not depend on the geometry and the calibration. Depths across the track are
//! depths already, without a slant range or a first return.

use super::above_bottom::{AboveDepth, height_m, way_m};
use super::clutter::{Clutter, clutter};
use super::specular::{
    BeamAngles, BottomPoint, Pair, across_track, beam_angles, fixed_bottom_point,
};
use super::{
    BySource, CloudPoint, CloudSettings, Correction, DownScan, Geometry, PointCloud, PointDoubt,
    PointSource, RecordIndex, Reduction, SlopeEnd,
};
use crate::calibration::Calibration;
use crate::first_return::{FirstReturns, Pick, ground_confidence};
use bathyscope_log::support::progress::{Cancelled, Progress};
use bathyscope_log::support::statistics::upper_median;
use bathyscope_log::survey::{
    Navigation, PingNav, Side, Sounding, Survey, SwathPing, SwathSounding, nearest_in_time,
};
use rayon::prelude::*;
use std::sync::Arc;

/// Properties of a first return, wherever it is placed.
#[derive(Clone, Copy, Debug)]
struct PickTrait {
    /// True if the first return is something above the bottom.
    above_bottom: bool,
    /// Length of the stretch of above-bottom returns, metres; 0 for the bottom and for clutter.
    above_bottom_m: f32,
    /// True if the first return is clutter, which does not show the slope of the bottom.
    is_clutter: bool,
    /// Confidence that the first return is what `above_bottom` states.
    confidence: f32,
    /// Level of the echo, 0 to 255.
    level: u8,
}

/// Properties of all first returns. Several clouds of the same returns share them, since they cost
/// as much as all the rest of a cloud.
pub struct PickTraits {
    /// Properties by side, port first, one for each ping.
    sides: [Vec<PickTrait>; 2],
    /// Clutter among the first returns; `None` without any.
    pub clutter: Option<Clutter>,
}

/// Slant range from the edge of a first return within which its echo is strongest, metres.
const ECHO_M: f64 = 0.2;
/// Most soundings with a fault in a row that first returns may confirm: a longer run is a loss of
/// the bottom, in which the depth may meet a first return by chance.
const LONGEST: usize = 4;
/// Largest difference between a first return and the depth of a sounding that it confirms, metres:
/// a part of what a sounding stands out by.
const WITHIN_M: f64 = 0.15;

impl PickTraits {
    /// Finds the properties of a survey's first returns.
    pub fn new(survey: &Survey, navigation: &Navigation, returns: &FirstReturns) -> Self {
        let (is_clutter, clutter) = clutter(survey, returns, &way_m(&navigation.pings));
        let above = AboveDepth::new(survey, navigation, returns, &is_clutter);
        let lengths_m = Side::BOTH.map(|side| above.stretches_m(side));
        let usual_m = above.usual_departures_m();
        let of_pick = |side: Side, ping: usize, pick: &Pick| {
            let is_clutter = is_clutter[side as usize].get(ping) == Some(&true);
            let high_m = height_m(survey, returns, ping, side);
            // Where the recorded depth was found to be false, so may be what lies above it.
            let is_usual = high_m <= usual_m[ping];
            let above_bottom = is_clutter || pick.above_bottom && !is_usual;
            PickTrait {
                above_bottom,
                is_clutter,
                // Without a good depth the height of the return is not known.
                above_bottom_m: if above_bottom && !is_clutter && high_m.is_finite() {
                    lengths_m[side as usize][ping]
                } else {
                    0.0
                },
                // A first return that does not stand out is ground.
                confidence: if above_bottom {
                    pick.confidence
                } else {
                    ground_confidence(pick.confidence, pick.above_bottom)
                },
                level: if pick.is_some() { echo_level(survey, ping, side, pick.sample) } else { 0 },
            }
        };
        let of_side = |side: Side| {
            let picks = returns.side(side).par_iter().enumerate();
            picks.map(|(ping, pick)| of_pick(side, ping, pick)).collect()
        };
        Self { sides: Side::BOTH.map(of_side), clutter }
    }

    /// Returns the properties of a side, one for each ping.
    fn side(&self, side: Side) -> &[PickTrait] {
        &self.sides[side as usize]
    }
}

/// Returns the greatest level, 0 to 255, within a pulse's length of a first return `sample` samples
/// outward: the pick itself lies on the edge of the echo, where the level hardly depends on the
/// ground. 0 where that side was not recorded.
fn echo_level(survey: &Survey, ping: usize, side: Side, sample: f32) -> u8 {
    let level = || {
        let (span, samples) = (survey.span(ping, side)?, survey.samples(ping, side)?);
        let length = (ECHO_M / span.metres_per_sample()).clamp(1.0, f64::from(u16::MAX)) as usize;
        let first = sample.max(0.0) as usize;
        let last = samples.len().min(first.saturating_add(length));
        (first..last).map(|sample| samples.get(sample)).max()
    };
    level().unwrap_or(0)
}

/// Builds a cloud as [`place`] does, with properties of the first returns for this cloud alone.
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

/// Builds the cloud of first returns whose properties are known.
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
    let angles = match settings.geometry {
        Geometry::Slope => {
            angles(survey, (&ranges, traits), reduction, calibration.beams.overlap_rad)
        }
        _ => Vec::new(),
    };
    progress.advance(1);
    progress.check()?;
    let points_of = |side: Side, ranges_m: &[f64]| -> Vec<CloudPoint> {
        let bottom_point = |ping: usize, range_m: f64| match angles.get(ping) {
            Some(angles) => (angles.bottom_point(side, range_m), angles.slope_end(side)),
            None => (
                fixed_bottom_point(settings.geometry, range_m, settings.alpha2_deg),
                SlopeEnd::NO_SLOPE,
            ),
        };
        let z_m =
            |ping: usize, below_m: f64| correction.z_m(survey.side_scan[ping].time_s, below_m);
        let picks = returns.side(side).iter().zip(traits.side(side));
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

/// Longest slant range of a side-scan, metres: where a calibration gives more, it is wrong.
const FARTHEST_M: f64 = 10_000.0;

/// Returns the slant range of every pick of a side by the true speed of sound, metres; NaN without
/// a pick, or where the range is impossible.
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

/// Returns the angles of the first returns of both sides from straight below at every ping,
/// radians. Above-bottom returns count, except clutter: on a steep slope the bottom itself lies
/// above the recorded depth, and an above-bottom return on one side moves only the points of that
/// side.
fn angles(
    survey: &Survey,
    ([port, starboard], traits): (&[Vec<f64>; 2], &PickTraits),
    reduction: Reduction<'_>,
    overlap_rad: f64,
) -> Vec<BeamAngles> {
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
    beam_angles(&pairs, overlap_rad)
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
            doubt: match sounding.fault {
                Some(fault) if !counts[index] => PointDoubt::Fault(fault),
                _ => PointDoubt::None,
            },
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

fn side_points<'a>(
    navigation: &'a Navigation,
    picks: impl Iterator<Item = (&'a Pick, &'a PickTrait)> + 'a,
    side: Side,
    ranges_m: &'a [f64],
    bottom_point: impl Fn(usize, f64) -> (BottomPoint, SlopeEnd) + 'a,
    z_m: impl Fn(usize, f64) -> f64 + 'a,
) -> impl Iterator<Item = CloudPoint> + 'a {
    let source = match side {
        Side::Port => PointSource::Port,
        Side::Starboard => PointSource::Starboard,
    };
    let pings = navigation.pings.iter().zip(picks).zip(ranges_m);
    let detected = pings.enumerate().filter(|(_, (_, range_m))| **range_m > 0.0);
    detected.filter_map(move |(ping, ((place, (pick, traits)), &range_m))| {
        let (bottom_point, slope_end) = bottom_point(ping, range_m);
        let [east_m, north_m] = across_track(place, side, bottom_point.across_m)?;
        Some(CloudPoint {
            doubt: if traits.above_bottom { PointDoubt::AboveBottom } else { PointDoubt::None },
            level: traits.level,
            above_bottom_m: traits.above_bottom_m,
            confidence: traits.confidence,
            sample: pick.sample,
            slope_end,
            ..CloudPoint::new(
                source,
                ping as u32,
                [east_m, north_m, z_m(ping, bottom_point.depth_m)],
            )
        })
    })
}

/// Returns a flag for each sounding, true if it counts although it stands out from those around it:
/// the recorder had the bottom right before and after it, and a first return of the nearest ping,
/// or of the one before or behind that, lies at its depth. `ranges_m` are the ranges of port and
/// starboard, NaN without a first return, on the scale of `altitude_m`.
///
/// A rock or a pile under the boat is passed in a few soundings, as a wrong depth is, but the
/// side-scan detects it too.
fn confirmed(
    survey: &Survey,
    ranges_m: &[Vec<f64>; 2],
    altitude_m: impl Fn(f64) -> f64,
) -> Vec<bool> {
    let is_confirmed = |sounding: &Sounding| {
        let depth_m = altitude_m(f64::from(sounding.depth_m));
        let ping = nearest_in_time(&survey.side_scan, sounding.time_s, |ping| ping.time_s);
        let near = ping.map_or(0..0, |ping| ping.saturating_sub(1)..ping + 2);
        let ranges = ranges_m.iter().flat_map(|side| side.get(near.clone()));
        let mut ranges = ranges.flatten();
        ranges.any(|range_m| (range_m - depth_m).abs() <= WITHIN_M)
    };
    let mut confirmed = vec![false; survey.soundings.len()];
    let mut start = 0;
    for run in survey.soundings.chunk_by(|a, b| a.is_good() == b.is_good()) {
        let end = start + run.len();
        let is_between = start > 0 && end < survey.soundings.len();
        if !run[0].is_good() && is_between && run.len() <= LONGEST {
            for (sounding, confirmed) in run.iter().zip(&mut confirmed[start..end]) {
                *confirmed = is_confirmed(sounding);
            }
        }
        start = end;
    }
    confirmed
}

/// Length of a stretch across the track as a share of the depth: the depths of a ping in a stretch
/// make one point, as the sonar resolves nothing finer.
const STRETCH_SHARE: f64 = 0.1;
/// Least length of a stretch, metres.
const LEAST_STRETCH_M: f64 = 0.2;
/// Number of pings between two checks for cancellation.
const CHUNK: usize = 256;

/// Returns the points of the swath, in the order of its pings; pings without a heading give none.
///
/// # Errors
/// When the work was cancelled.
fn swath_points(
    survey: &Survey,
    navigation: &Navigation,
    correction: &Correction,
    progress: &Progress,
) -> Result<Vec<CloudPoint>, Cancelled> {
    let chunks = survey.swath.par_chunks(CHUNK).enumerate();
    let parts = chunks.map(|(chunk, pings)| {
        progress.check()?;
        let mut points = Vec::new();
        for (index, ping) in (CHUNK * chunk..).zip(pings) {
            if let Some(place) = navigation.swath.get(index) {
                add_points(survey, index, ping, place, correction, &mut points);
            }
        }
        Ok(points)
    });
    let parts: Vec<Vec<CloudPoint>> = parts.collect::<Result<_, Cancelled>>()?;
    Ok(parts.concat())
}

fn add_points(
    survey: &Survey,
    index: usize,
    ping: &SwathPing,
    place: &PingNav,
    correction: &Correction,
    points: &mut Vec<CloudPoint>,
) {
    let nearest = nearest_in_time(&survey.side_scan, ping.time_s, |ping| ping.time_s);
    let point = |sounding: SwathSounding| {
        // The speed of sound scales the distance out and the depth.
        let [east_m, north_m] =
            place.abeam(sounding.side, correction.range_factor() * sounding.out_m)?;
        Some(CloudPoint {
            record: RecordIndex::new(index),
            sample: sounding.number as f32,
            ..CloudPoint::new(
                PointSource::Swath,
                nearest.unwrap_or(0) as u32,
                [east_m, north_m, -correction.depth_m(ping.time_s, sounding.depth_m)],
            )
        })
    };
    let placed = thinned(survey.swath_soundings(ping).collect());
    let placed = placed.into_iter().filter_map(point);
    points.extend(placed.filter(|point| point.east_m.is_finite()));
}

/// Keeps the sounding of median depth of each stretch across the track: a place that was measured,
/// and no spike.
fn thinned(mut soundings: Vec<SwathSounding>) -> Vec<SwathSounding> {
    let mut depths_m: Vec<f64> = soundings.iter().map(|sounding| sounding.depth_m).collect();
    let Some(depth_m) = upper_median(&mut depths_m, f64::total_cmp) else {
        return Vec::new();
    };
    let stretch_m = (STRETCH_SHARE * depth_m).max(LEAST_STRETCH_M);
    let stretch = |sounding: &SwathSounding| (sounding.side, (sounding.out_m / stretch_m) as u32);
    soundings.sort_by(|a, b| {
        let by_depth = a.depth_m.total_cmp(&b.depth_m);
        stretch(a).cmp(&stretch(b)).then(by_depth)
    });
    let stretches = soundings.chunk_by(|a, b| stretch(a) == stretch(b));
    stretches.map(|those| those[those.len() / 2]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use bathyscope_log::survey::{SidePing, mark_faults};

    /// Soundings of 3 m but for a stretch of them, at every other of pings whose port sees `port_m`
    /// there and whose starboard sees the bed.
    fn confirmed_at(stretch: std::ops::Range<usize>, depth_m: f32, port_m: f64) -> Vec<usize> {
        let mut soundings: Vec<Sounding> = (0..60)
            .map(|index| {
                let depth_m = if stretch.contains(&index) { depth_m } else { 3.0 };
                Sounding::new(0.2 * index as f64, depth_m)
            })
            .collect();
        mark_faults(&mut soundings, &[], true);
        let ping = |ping: usize| SidePing::with_depth(0.1 * ping as f64, 3.0);
        let survey =
            Survey { soundings: Arc::new(soundings), ..Survey::of_pings((0..120).map(ping)) };
        let port = (0..120).map(|ping| if stretch.contains(&(ping / 2)) { port_m } else { 3.0 });
        let ranges_m = [port.collect(), vec![3.0; 120]];
        let all = confirmed(&survey, &ranges_m, |depth_m| depth_m);
        (0..60).filter(|index| all[*index]).collect()
    }

    #[test]
    fn a_rock_that_one_side_sees_counts_and_a_glitch_that_none_sees_does_not() {
        assert_eq!(confirmed_at(30..32, 2.4, 2.45), [30, 31]);
        assert!(confirmed_at(30..32, 2.4, 3.0).is_empty());
        assert!(confirmed_at(30..31, 9.0, 2.45).is_empty());
    }

    #[test]
    fn a_depth_that_keeps_its_lock_needs_no_first_return() {
        assert!(confirmed_at(30..45, 2.4, 2.45).is_empty());
    }

    #[test]
    fn a_stretch_has_one_point_and_a_spike_has_none() {
        let sounding = |number: usize| SwathSounding {
            number,
            side: if number < 300 { Side::Port } else { Side::Starboard },
            out_m: 0.05 * (number % 300) as f64,
            depth_m: if number % 10 == 7 { 1.0 } else { 4.0 + 1e-3 * number as f64 },
        };
        let kept = thinned((0..600).map(sounding).collect());
        // 15 m on each side in stretches of 0.43 m.
        assert_eq!(kept.len(), 2 * 36);
        assert!(kept.iter().all(|sounding| sounding.depth_m > 3.9), "{kept:?}");
        assert!(kept.iter().any(|sounding| sounding.number > 300));
        assert!(thinned(Vec::new()).is_empty());
    }
}
