//! Which passes of the boat covered a place.

use super::heading::heading_sigma_rad;
use crate::survey::{Navigation, Side, Survey};

/// One pass of the boat along a place, within the range of one side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pass {
    /// The ping that is abeam of the place.
    pub ping: usize,
    /// The first ping that may be, as well as the heading is known. In a turn about the place many are.
    pub first_ping: usize,
    /// The last ping that may be.
    pub last_ping: usize,
    /// The side that the place lies on at [`Pass::ping`].
    pub side: Side,
    /// Distance from the track to the place, metres.
    pub ground_m: f64,
}

/// A place ahead or astern by less than this is abeam of some ping, metres; half the step of a fast boat's slow pings.
const ABEAM_M: f64 = 0.75;
/// And by less than so many standard deviations of the heading.
const ABEAM_SIGMAS: f64 = 2.0;
/// Pings without the place abeam that end a pass.
const GAP: usize = 20;

/// Every pass in which a side could insonify a place (metres in the survey's plane): it is abeam, recorded, and within the range.
pub fn passes_over(survey: &Survey, navigation: &Navigation, place: [f64; 2]) -> Vec<Pass> {
    let mut passes: Vec<Pass> = Vec::new();
    // Least distance ahead or astern of the pass that is going on.
    let mut least_m = f64::INFINITY;
    for ping in 0..navigation.pings.len() {
        let Some((side, ground_m, along_m)) = abeam(survey, navigation, ping, place) else {
            continue;
        };
        let here = Pass {
            ping,
            first_ping: ping,
            last_ping: ping,
            side,
            ground_m,
        };
        match passes.last_mut() {
            Some(pass) if pass.side == side && ping - pass.last_ping <= GAP => {
                pass.last_ping = ping;
                if along_m < least_m {
                    (pass.ping, pass.ground_m, least_m) = (ping, ground_m, along_m);
                }
            }
            _ => {
                passes.push(here);
                least_m = along_m;
            }
        }
    }
    passes
}

/// The side on which a ping has a place abeam, and its distances across and along the track, metres; `None` where it is out of
/// the range, or ahead or astern.
fn abeam(
    survey: &Survey,
    navigation: &Navigation,
    ping: usize,
    [east_m, north_m]: [f64; 2],
) -> Option<(Side, f64, f64)> {
    let boat = navigation.pings.get(ping)?;
    let [x, y] = boat.starboard()?;
    let [dx, dy] = [east_m - boat.east_m, north_m - boat.north_m];
    let (across_m, along_m) = (dx * x + dy * y, (dy * x - dx * y).abs());
    let side = if across_m < 0.0 {
        Side::Port
    } else {
        Side::Starboard
    };
    let depth_m = f64::from(survey.locked_depth_m(ping));
    let slant_m = across_m.hypot(if depth_m > 0.0 { depth_m } else { 0.0 });
    let within = slant_m < f64::from(survey.span(ping, side)?.far_m);
    let askew_m = ABEAM_SIGMAS * heading_sigma_rad(navigation, &(ping..ping + 1)) * across_m.abs();
    // NaN is not abeam.
    let abeam = along_m < ABEAM_M.hypot(askew_m);
    (abeam && within).then_some((side, across_m.abs(), along_m))
}
