//! Finds first returns above the recorded depth that are no bottom, and how far along the track
//! they go on.
//!
//! A clump of weed, a fish and an object are soon passed; a bank or the edge of a scarp goes on, on
//! the side where it lies. First returns at the same height above the recorded depth on both sides
//! are the top of weed or of boulders, however long they go on: the ground below the boat is
//! between them, where the sounder measures it. On the river of the tests the first returns of the
//! boulder reach follow hyperbolas of boulders beside the boat in the recording of the wide beam,
//! 0.3 to 0.9 m above the echo of the narrow one. A recorder that smooths its depth, or writes it
//! in steps of 10 cm, departs from a rough bed to both sides: there a first return is above the
//! bottom only if it exceeds these departures.

use crate::first_return::FirstReturns;
use bathyscope_log::support::statistics::{median, spread_about};
use bathyscope_log::survey::{Navigation, PingNav, Side, Survey};
use std::ops::Range;

/// Way on each side of a ping over which most first returns of a side must lie above the recorded
/// depth for the ping to belong to a stretch of them, metres.
const AROUND_M: f64 = 5.0;
/// Way on each side of a ping over which it is judged how closely the recorded depth follows the
/// first returns, metres: weed and objects fill less than half of it, else they are a long stretch.
const FOLLOWED_M: f64 = 30.0;
/// Length of the way on which pings share this judgement, metres.
const SHARED_M: f64 = 2.0;
/// Number of standard deviations above the recorded depth beyond which a first return is above the
/// bottom.
const SIGMAS: f64 = 3.0;
/// Least height of the lower side above the depth, as a share of that of the higher side, at which
/// both sides are alike.
const LEAST_ALIKE: f64 = 0.5;
/// Least height of the lower side above the depth, as a share of the depth, at which both sides are
/// alike: on a bank of 20 degrees beams that reach 8 degrees past the nadir are nearer by a
/// twenty-fifth.
const LEAST_HIGH: f64 = 0.06;
/// Longest step that is no gap of the log, metres: a stretch ends at a gap.
const LONGEST_STEP_M: f64 = 5.0;

/// Heights of the first returns of a log above its recorded depths.
pub(super) struct AboveDepth {
    /// Way along the track up to each ping, metres.
    way_m: Vec<f64>,
    /// [`height_m`] of both sides of every ping; NaN for clutter.
    heights_m: Vec<[f64; 2]>,
    sums: Sums,
}

impl AboveDepth {
    /// Compares a survey's first returns with its depths. `is_clutter` is true, by side and ping,
    /// for a first return that is clutter and so left out.
    pub(super) fn new(
        survey: &Survey,
        navigation: &Navigation,
        returns: &FirstReturns,
        is_clutter: &[Vec<bool>; 2],
    ) -> Self {
        let height_m = |ping: usize, side: Side| match is_clutter[side as usize].get(ping) {
            Some(true) => f64::NAN,
            _ => height_m(survey, returns, ping, side),
        };
        let mut way_m = way_m(&navigation.pings);
        way_m.truncate(survey.side_scan.len());
        let pings = 0..survey.side_scan.len();
        let heights_m: Vec<[f64; 2]> =
            pings.map(|ping| Side::BOTH.map(|side| height_m(ping, side))).collect();
        Self { way_m, sums: Sums::new(survey, returns, &heights_m), heights_m }
    }

    /// Returns the pings within `reach_m` of the place `at_m` along the track.
    fn around(&self, at_m: f64, reach_m: f64) -> Range<usize> {
        self.way_m.partition_point(|way| *way < at_m - reach_m)
            ..self.way_m.partition_point(|way| *way <= at_m + reach_m)
    }

    /// Returns for every ping the height above the recorded depth up to which a first return is the
    /// bottom, metres: three standard deviations of the heights nearby, and 0 where both sides are
    /// alike above the depth.
    pub(super) fn usual_departures_m(&self) -> Vec<f64> {
        let pings = self.way_m.len();
        let mut usual_m = Vec::with_capacity(self.heights_m.len());
        while let Some(&at_m) = self.way_m.get(usual_m.len()) {
            let around = self.around(at_m, FOLLOWED_M);
            let is_alike = is_most(&self.sums.alike, &self.sums.pings, &around);
            let sigma_m = if is_alike { 0.0 } else { self.scatter_m(around) };
            let shared = self.way_m.partition_point(|way| *way < at_m + SHARED_M);
            usual_m.resize(shared.clamp(usual_m.len() + 1, pings), SIGMAS * sigma_m);
        }
        usual_m.resize(self.heights_m.len(), f64::NAN);
        usual_m
    }

    /// Returns the robust standard deviation of the heights on some pings, metres.
    fn scatter_m(&self, pings: Range<usize>) -> f64 {
        let heights_m = self.heights_m[pings].as_flattened().iter().copied();
        let mut heights_m: Vec<f64> = heights_m.filter(|height_m| !height_m.is_nan()).collect();
        let middle_m = median(&mut heights_m);
        spread_about(&mut heights_m, middle_m)
    }

    /// Returns for every ping the length of the stretch of a side that it belongs to, metres; 0
    /// outside of stretches. A bank and the edge of a scarp lie on one side.
    pub(super) fn stretches_m(&self, side: Side) -> Vec<f32> {
        let Self { way_m, .. } = self;
        let pings = way_m.len();
        let [apart, judged] =
            [&self.sums.apart, &self.sums.judged].map(|sides| &sides[side as usize]);
        let belongs = |ping: usize| is_most(apart, judged, &self.around(way_m[ping], AROUND_M));
        let mut lengths_m = vec![0.0; self.heights_m.len()];
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
}

/// Numbers of first returns above the recorded depth up to each ping: the difference of two sums is
/// a count.
struct Sums {
    /// Number of pings with a depth and a first return of any side.
    pings: Vec<u32>,
    /// Number of pings on which both sides are alike above the depth.
    alike: Vec<u32>,
    /// Number of first returns of pings with a depth, port and starboard.
    judged: [Vec<u32>; 2],
    /// Number of first returns above the depth on pings where the sides differ, port and starboard.
    apart: [Vec<u32>; 2],
}

impl Sums {
    /// Counts a survey's first returns by their heights above the recorded depth.
    fn new(survey: &Survey, returns: &FirstReturns, heights_m: &[[f64; 2]]) -> Self {
        let mut sums = Self {
            pings: vec![0],
            alike: vec![0],
            judged: [vec![0], vec![0]],
            apart: [vec![0], vec![0]],
        };
        let add = |sums: &mut Vec<u32>, is_one: bool| {
            sums.push(sums.last().copied().unwrap_or_default() + u32::from(is_one));
        };
        for (ping, heights_m) in heights_m.iter().enumerate() {
            let depth_m = f64::from(survey.side_scan[ping].good_depth_m());
            // True where the first return of a side lies above the depth; `None` without either.
            let sides = Side::BOTH.map(|side| {
                let pick = returns.side(side).get(ping).filter(|_| depth_m > 0.0);
                let pick = pick.filter(|_| !heights_m[side as usize].is_nan());
                pick.map(|pick| pick.above_bottom)
            });
            let is_alike = sides == [Some(true); 2] && are_alike(*heights_m, depth_m);
            add(&mut sums.pings, sides != [None; 2]);
            add(&mut sums.alike, is_alike);
            for (side, is_above) in sides.into_iter().enumerate() {
                add(&mut sums.judged[side], is_above.is_some());
                add(&mut sums.apart[side], is_above == Some(true) && !is_alike);
            }
        }
        sums
    }
}

/// Returns true if `part` counts most of what `all` counts on some pings.
fn is_most(part: &[u32], all: &[u32], pings: &Range<usize>) -> bool {
    let count = |sums: &[u32]| sums[pings.end] - sums[pings.start];
    2 * count(part) > count(all)
}

/// Returns true if both sides are at about the same height above the depth, so that the obstacle
/// lies below the boat. Over a bank the lower side, whose beam reaches past the nadir, lies above
/// the depth, too, by much less than the upper side.
fn are_alike([port_m, starboard_m]: [f64; 2], depth_m: f64) -> bool {
    let lower_m = port_m.min(starboard_m);
    lower_m > LEAST_ALIKE * port_m.max(starboard_m) && lower_m > LEAST_HIGH * depth_m
}

/// Returns the height of a first return above the recorded depth, by the recorder's own scale,
/// metres; NaN without a depth or a first return.
pub(super) fn height_m(survey: &Survey, returns: &FirstReturns, ping: usize, side: Side) -> f64 {
    f64::from(survey.good_depth_m(ping)) - returns.range_m(survey, ping, side)
}

/// Returns the way up to each ping, metres. Over a gap it jumps by more than both ways around a
/// ping.
pub(super) fn way_m(pings: &[PingNav]) -> Vec<f64> {
    let mut way_m = 0.0;
    let mut last: Option<&PingNav> = None;
    pings
        .iter()
        .map(|ping| {
            let step_m = last
                .map_or(0.0, |last| (ping.east_m - last.east_m).hypot(ping.north_m - last.north_m));
            // A ping without a place has a step of NaN, which counts as none.
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

    /// A log of 120 m, with a ping each 0.1 m, of which `bed_m` and `recorded_m` are depths at a
    /// way, metres: of the first returns of port and starboard, and of the recorder.
    fn log(
        bed_m: impl Fn(f64) -> [f64; 2],
        recorded_m: impl Fn(f64) -> f64,
    ) -> (Survey, Navigation, FirstReturns) {
        let way_m = |ping: usize| 0.1 * ping as f64;
        let span = SideSpan::of_bytes(1000, [0.0, 10.0]);
        let ping = |ping: usize| SidePing {
            port: Some(span),
            starboard: Some(span),
            ..SidePing::with_depth(0.05 * ping as f64, recorded_m(way_m(ping)) as f32)
        };
        let picks = |side: Side| {
            let pick = |ping: usize| {
                let range_m = bed_m(way_m(ping))[side as usize];
                Pick {
                    sample: span.sample_at(range_m) as f32,
                    confidence: 1.0,
                    above_bottom: range_m < recorded_m(way_m(ping)) - 0.15,
                }
            };
            Arc::new((0..PINGS).map(pick).collect())
        };
        let returns = FirstReturns {
            port: picks(Side::Port),
            starboard: picks(Side::Starboard),
            ..FirstReturns::default()
        };
        let place = |ping: usize| PingNav::northbound([0.0, way_m(ping)], 2.0);
        let navigation = Navigation::of_pings((0..PINGS).map(place));
        (Survey::of_pings((0..PINGS).map(ping)), navigation, returns)
    }

    const PINGS: usize = 1200;
    const NO_CLUTTER: [Vec<bool>; 2] = [Vec::new(), Vec::new()];

    /// Heights of first returns above recorded depths, and how far above them is usual, of a bed
    /// with a clump of weed of 0.4 m at 60 m.
    fn clump(bed_m: impl Fn(f64) -> f64, recorded_m: impl Fn(f64) -> f64) -> Vec<(f64, f64)> {
        let weed_m = |way_m: f64| if (58.95..60.95).contains(&way_m) { 0.4 } else { 0.0 };
        let (survey, navigation, returns) =
            log(|way_m| [bed_m(way_m) - weed_m(way_m); 2], recorded_m);
        let above = AboveDepth::new(&survey, &navigation, &returns, &NO_CLUTTER);
        let height = |ping| height_m(&survey, &returns, ping, Side::Port);
        (0..PINGS).map(height).zip(above.usual_departures_m()).collect()
    }

    #[test]
    fn a_bank_of_one_side_is_a_stretch_and_what_both_sides_see_is_none() {
        let lengths_m = |bed_m: [f64; 2]| {
            let (survey, navigation, returns) = log(|_| bed_m, |_| 3.0);
            let above = AboveDepth::new(&survey, &navigation, &returns, &NO_CLUTTER);
            (Side::BOTH.map(|side| above.stretches_m(side)[600]), above.usual_departures_m()[600])
        };
        let whole_m = 0.1 * (PINGS - 1) as f32;
        let is = |length_m: f32, other_m: f32| (length_m - other_m).abs() < 0.1;
        let ([port_m, starboard_m], _) = lengths_m([2.4, 3.0]);
        assert!(is(port_m, whole_m) && is(starboard_m, 0.0), "{port_m} {starboard_m}");
        // The lower side looks past the nadir.
        let ([port_m, starboard_m], _) = lengths_m([2.4, 2.84]);
        assert!(is(port_m, whole_m) && is(starboard_m, whole_m), "{port_m} {starboard_m}");
        // Boulders.
        assert_eq!(lengths_m([2.4, 2.5]), ([0.0; 2], 0.0));
    }

    #[test]
    fn boulders_that_the_sounder_sees_between_are_not_usual() {
        let bed_m = |way_m: f64| 3.0 - 0.5 - 0.2 * (1.7 * way_m).sin();
        let pings = clump(bed_m, |_| 3.0);
        assert!(pings[200..1000].iter().all(|(height_m, usual_m)| height_m > usual_m));
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
        // Boulders of half a metre, of which the recorder writes the mean depth in steps.
        let bed_m = |way_m: f64| 3.0 - 0.25 * (1.7 * way_m).sin();
        let recorded_m = |way_m: f64| 3.0 + 0.1 * ((0.1 * way_m).round() % 2.0);
        let pings = clump(bed_m, recorded_m);
        let (rough, _) = pings.split_at(580);
        assert!(rough.iter().any(|(height_m, _)| *height_m > 0.3));
        assert!(rough.iter().all(|(height_m, usual_m)| height_m < usual_m));
    }
}
