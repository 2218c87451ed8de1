//! Which first returns above the recorded depth are no bottom, and how far along the track they go
//! on.
//!
//! A clump of weed, a fish and an object are soon passed; a field of boulders or the foot of a bank
//! goes on. Since the echo does not distinguish weed from boulders, their length along the track
//! has to. A recorder that smooths its depth, or writes it in steps of 10 cm, departs from a rough
//! bed all along: there only what stands out of that is above the bottom.

use crate::first_return::FirstReturns;
use bathyscope_log::support::statistics::{median, spread_about};
use bathyscope_log::survey::{Navigation, PingNav, Side, Survey};

/// Way to both sides of a ping over which most first returns of a side must lie above the recorded
/// depth for the ping to belong to a stretch of them, metres.
const AROUND_M: f64 = 5.0;
/// Way to both sides over which it is judged how closely the recorded depth follows the first
/// returns, metres: weed and objects fill less than half of it, else it is a long stretch.
const FOLLOWED_M: f64 = 30.0;
/// Pings on so much of the way share that judgement, metres.
const SHARED_M: f64 = 2.0;
/// A first return above the recorded depth by more standard deviations than this is above the
/// bottom.
const SIGMAS: f64 = 3.0;
/// Steps longer than this are gaps of the log: a stretch ends there, metres.
const LONGEST_STEP_M: f64 = 5.0;

/// For every ping, how far a first return has to lie above the recorded depth so as not to be what
/// this departs from the bed by nearby, metres.
pub(super) fn usual_departures_m(
    survey: &Survey,
    navigation: &Navigation,
    returns: &FirstReturns,
) -> Vec<f64> {
    let way_m = way_m(&navigation.pings);
    let pings = way_m.len().min(survey.side_scan.len());
    let heights_m: Vec<[f64; 2]> = (0..pings)
        .map(|ping| Side::BOTH.map(|side| height_m(survey, returns, ping, side)))
        .collect();
    let mut usual_m = Vec::with_capacity(pings);
    while usual_m.len() < pings {
        let from = usual_m.len();
        let at_m = way_m[from];
        let around = way_m.partition_point(|way| *way < at_m - FOLLOWED_M)
            ..way_m.partition_point(|way| *way <= at_m + FOLLOWED_M).min(pings);
        let heights = heights_m[around].as_flattened().iter().copied();
        let mut heights: Vec<f64> = heights.filter(|height| !height.is_nan()).collect();
        let middle_m = median(&mut heights);
        let sigma_m = spread_about(&mut heights, middle_m);
        let shared = way_m.partition_point(|way| *way < at_m + SHARED_M);
        usual_m.resize(shared.clamp(from + 1, pings), SIGMAS * sigma_m);
    }
    usual_m.resize(survey.side_scan.len(), f64::NAN);
    usual_m
}

/// How far a first return lies above the recorded depth, by the recorder's own scale, metres; NaN
/// without either.
pub(super) fn height_m(survey: &Survey, returns: &FirstReturns, ping: usize, side: Side) -> f64 {
    let found = survey.span(ping, side).zip(returns.side(side).get(ping));
    let range_m = found.map_or(f64::NAN, |(span, pick)| span.range_m(f64::from(pick.sample)));
    f64::from(survey.locked_depth_m(ping)) - range_m
}

/// For every ping, the length of the stretch of a side that it belongs to, metres; 0 outside of
/// any. A bank and the edge of a scarp lie on one side.
pub(super) fn stretches_m(
    survey: &Survey,
    navigation: &Navigation,
    returns: &FirstReturns,
    side: Side,
) -> Vec<f32> {
    let way_m = way_m(&navigation.pings);
    // First returns that can be judged, and those of them that lie above: sums up to each ping.
    let (mut judged, mut above) = (vec![0_u32], vec![0_u32]);
    for (ping, recorded) in survey.side_scan.iter().enumerate() {
        let pick = returns.side(side).get(ping).filter(|pick| pick.is_some());
        let has_depth = recorded.locked_depth_m() > 0.0;
        judged.push(judged[ping] + u32::from(pick.is_some() && has_depth));
        above.push(above[ping] + u32::from(pick.is_some_and(|pick| pick.above_bottom)));
    }
    let pings = way_m.len().min(survey.side_scan.len());
    let belongs = |ping: usize| {
        let from = way_m.partition_point(|at| *at < way_m[ping] - AROUND_M);
        let to = way_m.partition_point(|at| *at <= way_m[ping] + AROUND_M).min(pings);
        let (judged, above) = (judged[to] - judged[from], above[to] - above[from]);
        2 * above > judged
    };
    let mut lengths_m = vec![0.0; survey.side_scan.len()];
    let mut ping = 0;
    while ping < pings {
        let end = (ping..pings).find(|at| !belongs(*at)).unwrap_or(pings);
        if end > ping {
            lengths_m[ping..end].fill((way_m[end - 1] - way_m[ping]) as f32);
        }
        ping = end + 1;
    }
    lengths_m
}

/// Way up to each ping, metres. Over a gap it jumps by more than a stretch looks around.
pub(super) fn way_m(pings: &[PingNav]) -> Vec<f64> {
    let mut way_m = 0.0;
    let mut last: Option<&PingNav> = None;
    pings
        .iter()
        .map(|ping| {
            let step_m = last
                .map_or(0.0, |last| (ping.east_m - last.east_m).hypot(ping.north_m - last.north_m));
            // A ping without a place has a step of NaN: it stays where the boat was.
            way_m +=
                if step_m > LONGEST_STEP_M { 2.0 * AROUND_M + step_m } else { step_m.max(0.0) };
            if ping.east_m.is_finite() {
                last = Some(ping);
            }
            way_m
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::first_return::Pick;
    use bathyscope_log::survey::{SidePing, SideSpan};
    use std::sync::Arc;

    /// Heights of first returns above recorded depths, and how far above them is usual, along 120 m
    /// of a bed with a clump of weed of 0.4 m at 60 m. `bed_m` and `recorded_m` are depths at a
    /// way, metres.
    fn clump(bed_m: impl Fn(f64) -> f64, recorded_m: impl Fn(f64) -> f64) -> Vec<(f64, f64)> {
        let pings = 1200;
        let way_m = |ping: usize| 0.1 * ping as f64;
        let span = SideSpan::of_bytes(1000, [0.0, 10.0]);
        let ping = |ping: usize| SidePing {
            port: Some(span),
            starboard: Some(span),
            ..SidePing::with_depth(0.05 * ping as f64, recorded_m(way_m(ping)) as f32)
        };
        let pick = |ping: usize| {
            let weed_m = if (590..610).contains(&ping) { 0.4 } else { 0.0 };
            Pick {
                sample: span.sample_at(bed_m(way_m(ping)) - weed_m) as f32,
                confidence: 1.0,
                above_bottom: false,
            }
        };
        let survey = Survey::of_pings((0..pings).map(ping));
        let picks = Arc::new((0..pings).map(pick).collect());
        let returns =
            FirstReturns { port: Arc::clone(&picks), starboard: picks, ..FirstReturns::default() };
        let place = |ping: usize| PingNav::northbound([0.0, way_m(ping)], 2.0);
        let navigation = Navigation::of_pings((0..pings).map(place));
        let usual_m = usual_departures_m(&survey, &navigation, &returns);
        let height = |ping| height_m(&survey, &returns, ping, Side::Port);
        (0..pings).map(height).zip(usual_m).collect()
    }

    #[test]
    fn weed_stands_out_where_the_recorded_depth_follows_the_bed() {
        let depth_m = |way_m: f64| 3.0 + 0.01 * way_m;
        let pings = clump(depth_m, depth_m);
        let (height_m, usual_m) = pings[600];
        assert!((height_m - 0.4).abs() < 0.02 && height_m > usual_m + 0.3);
    }

    #[test]
    fn a_rough_bed_that_the_recorder_smooths_is_no_weed() {
        // Boulders of half a metre, of which the recorder writes the depth between them in steps.
        let bed_m = |way_m: f64| 3.0 - 0.25 - 0.25 * (1.7 * way_m).sin();
        let recorded_m = |way_m: f64| 3.0 + 0.1 * ((0.1 * way_m).round() % 2.0);
        let pings = clump(bed_m, recorded_m);
        let (rough, _) = pings.split_at(580);
        assert!(rough.iter().any(|(height_m, _)| *height_m > 0.4));
        assert!(rough.iter().all(|(height_m, usual_m)| height_m < usual_m));
    }
}
