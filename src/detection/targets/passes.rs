//! Which passes of the boat covered a place.

use crate::survey::{Navigation, Side, Survey};

/// One pass of the boat along a place, within the range of one side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pass {
    /// The ping that is abeam of the place.
    pub ping: usize,
    /// The side that the place lies on.
    pub side: Side,
    /// Distance from the track to the place, metres.
    pub ground_m: f64,
}

/// A place ahead or astern by less than this is abeam of some ping, metres; half the step of a fast boat's slow pings.
const ABEAM_M: f64 = 0.75;
/// Pings without the place abeam that end a pass.
const GAP: usize = 20;

/// Every pass in which a side could hear a place (metres in the survey's plane): it is abeam, recorded, and within the range.
pub fn passes_over(
    survey: &Survey,
    navigation: &Navigation,
    [east_m, north_m]: [f64; 2],
) -> Vec<Pass> {
    let mut passes: Vec<Pass> = Vec::new();
    // Last ping and least distance ahead or astern of the pass that is going on.
    let (mut last, mut least_m) = (0, f64::INFINITY);
    for (ping, boat) in navigation.pings.iter().enumerate() {
        let Some([x, y]) = boat.starboard() else {
            continue;
        };
        let [dx, dy] = [east_m - boat.east_m, north_m - boat.north_m];
        let (across_m, along_m) = (dx * x + dy * y, (dy * x - dx * y).abs());
        let side = if across_m < 0.0 {
            Side::Port
        } else {
            Side::Starboard
        };
        let depth_m = f64::from(survey.locked_depth_m(ping));
        let slant_m = across_m.hypot(if depth_m > 0.0 { depth_m } else { 0.0 });
        let within = survey
            .span(ping, side)
            .is_some_and(|span| slant_m < f64::from(span.far_m));
        // NaN is not abeam.
        let abeam = along_m < ABEAM_M;
        if !(abeam && within) {
            continue;
        }
        let here = Pass {
            ping,
            side,
            ground_m: across_m.abs(),
        };
        match passes.last_mut() {
            Some(pass) if pass.side == side && ping - last <= GAP => {
                if along_m < least_m {
                    (*pass, least_m) = (here, along_m);
                }
            }
            _ => {
                passes.push(here);
                least_m = along_m;
            }
        }
        last = ping;
    }
    passes
}
