//! Makes points of depths across the track. They are depths already, without a slant range or a
//! first return.

use super::{CloudPoint, Correction, PointSource, RecordIndex};
use bathyscope_log::support::progress::{Cancelled, Progress};
use bathyscope_log::support::statistics::upper_median;
use bathyscope_log::survey::{
    Navigation, PingNav, Survey, SwathPing, SwathSounding, nearest_in_time,
};
use rayon::prelude::*;

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
pub(super) fn swath_points(
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
    use bathyscope_log::survey::Side;

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
