//! How far along the track first returns lie above the recorded depth.
//!
//! A clump of weed, a fish and an object are soon passed; a field of boulders or the foot of a bank goes on. Since the echo does
//! not distinguish weed from boulders, their length along the track has to.

use crate::first_return::FirstReturns;
use crate::survey::{Navigation, PingNav, Side, Survey};

/// Way to both sides of a ping over which most first returns must lie above the recorded depth for the ping to belong to a
/// stretch of them, metres.
const AROUND_M: f64 = 5.0;
/// Steps longer than this are gaps of the log: a stretch ends there, metres.
const LONGEST_STEP_M: f64 = 5.0;

/// For every ping, the length of the stretch that it belongs to, metres; 0 outside of any.
pub(super) fn stretches_m(
    survey: &Survey,
    navigation: &Navigation,
    returns: &FirstReturns,
) -> Vec<f32> {
    let way_m = way_m(&navigation.pings);
    // First returns that can be judged, and those of them that lie above: sums up to each ping.
    let (mut judged, mut above) = (vec![0_u32], vec![0_u32]);
    for (ping, recorded) in survey.side_scan.iter().enumerate() {
        let picks = Side::BOTH.map(|side| returns.side(side).get(ping));
        let picks = picks.into_iter().flatten().filter(|pick| pick.is_some());
        let has_depth = recorded.locked_depth_m() > 0.0;
        judged.push(judged[ping] + picks.clone().filter(|_| has_depth).count() as u32);
        above.push(above[ping] + picks.filter(|pick| pick.above_bottom).count() as u32);
    }
    let pings = way_m.len().min(survey.side_scan.len());
    let belongs = |ping: usize| {
        let from = way_m.partition_point(|at| *at < way_m[ping] - AROUND_M);
        let to = way_m
            .partition_point(|at| *at <= way_m[ping] + AROUND_M)
            .min(pings);
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
fn way_m(pings: &[PingNav]) -> Vec<f64> {
    let mut way_m = 0.0;
    let mut last: Option<&PingNav> = None;
    pings
        .iter()
        .map(|ping| {
            let step_m = last.map_or(0.0, |last| {
                (ping.east_m - last.east_m).hypot(ping.north_m - last.north_m)
            });
            // A ping without a place has a step of NaN: it stays where the boat was.
            way_m += if step_m > LONGEST_STEP_M {
                2.0 * AROUND_M + step_m
            } else {
                step_m.max(0.0)
            };
            if ping.east_m.is_finite() {
                last = Some(ping);
            }
            way_m
        })
        .collect()
}
