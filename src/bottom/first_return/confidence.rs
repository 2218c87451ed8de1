//! Computes the confidence of a first return: the probability that it is within 25 cm of the
//! nearest ground on its side.
//!
//! Evidence for and against a pick ([`Evidence`]) is gathered from the method that found it, from
//! the picks around it, from those of the other side and from the recorded depth. For each method,
//! a law converts the evidence into a probability. Both laws were fitted to the picks of simulated
//! ponds (seeds 101 to 120 of each kind, all troubles on; 154 000 picks of the tracker and twice as
//! many of the threshold on bytes and words), a third of them as if no depth had been recorded, and
//! are checked on other ponds: `cargo bench -- confidence`. Over weed, whose echo comes before that
//! of the ground, no law can distinguish weed from a boulder: the confidence of a pick above the
//! recorded depth is the share of such picks that are the ground ([`ABOVE_BOTTOM_SHARE`]).

use super::{FirstReturns, Method, Pick, Settled};
use bathyscope_log::support::statistics::{median, spread_about};
use bathyscope_log::survey::{Side, Survey};
use rayon::prelude::*;
use std::ops::Range;
use std::sync::Arc;

/// First return that a method found, and the evidence of the method itself for it.
#[derive(Clone, Copy, Debug)]
pub(super) struct MethodPick {
    /// Distance outward from the middle, samples; NaN where nothing was found.
    pub sample: f32,
    /// Evidence of the method. Tracker: mean score of the line around the ping, and the decrease of
    /// the total score if the line must pass nearer, or farther, at this ping. Threshold: movement
    /// of the pick towards the boat and away from it when the level is changed by a tenth, as
    /// shares of its distance, and 0.
    pub signs: [f32; 3],
}

impl MethodPick {
    /// Result where no first return was found.
    pub(super) const NONE: MethodPick = MethodPick { sample: f32::NAN, signs: [0.0; 3] };
}

/// Evidence for and against a pick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Evidence {
    /// Slant range by the recorder's scale, metres; NaN without a pick.
    pub range_m: f32,
    /// Evidence of the method: mean score and margins of the tracker's line, or movements of the
    /// threshold's pick when its level is changed.
    pub signs: [f32; 3],
    /// Share of the neighbouring picks of the same side that are on a line with this pick, 0 to 1.
    pub own: f32,
    /// Share of the other side's picks around the ping that are about as far from the boat, 0 to 1.
    pub other: f32,
    /// Recorded depth, metres; NaN where there is none to believe.
    pub depth_m: f32,
    /// Distance of the pick beyond the dead zone, metres.
    pub beyond_dead_zone_m: f32,
}

/// Number of pings before and after a ping that are evaluated with it.
pub(super) const REACH: usize = 8;
/// Largest difference in range to a neighbour on a line with a pick, metres, and its growth for
/// each ping between them: a bed that slopes 20 degrees along the track moves 5 cm at every ping.
const ON_LINE_M: [f32; 2] = [0.10, 0.05];
/// Movement of the bottom from ping to ping from which the picks around a ping are compared along
/// it, metres: the boat runs up or down a bank.
const FAST_M: f32 = 0.08;
/// Share of the neighbouring picks on a line with a pick from which more of them do not make it
/// more likely.
const ENOUGH_SUPPORT: f32 = 0.9;
/// Largest difference at which the ranges of the two sides agree, metres, and its growth as a share
/// of the range.
const AS_FAR: [f32; 2] = [0.25, 0.15];

/// Share of the picks more than 0.34 m above the recorded depth that are the ground, 0 to 1. It was
/// 1.6 % of 1 430 picks on 12 logs of two simulators, with weed, fish, boulders, mounds and slopes.
const ABOVE_BOTTOM_SHARE: f32 = 0.03;
/// Share of the picks that are the ground, by the height above the recorded depth in metres: 98 %
/// of 60 picks from 0.20 to 0.25 m, 33 % of 80 to 0.30 m, 6 % of 330 to 0.35 m.
const ABOVE_BOTTOM: [(f32, f32); 3] = [(0.24, 1.0), (0.28, 0.25), (0.34, ABOVE_BOTTOM_SHARE)];

/// Returns the confidence if a return above the recorded depth is ground; the confidence of any
/// other return is not changed.
pub(crate) fn ground_confidence(confidence: f32, above_bottom: bool) -> f32 {
    if above_bottom { (confidence / ABOVE_BOTTOM_SHARE).min(1.0) } else { confidence }
}

/// Picks of both sides in a stretch of the log, with the data that their evidence needs.
pub(super) struct Gathering<'a> {
    pub survey: &'a Survey,
    /// Index of the ping of the first pick.
    pub first: usize,
    /// Found first returns, with the recorded depths.
    pub settled: &'a Settled,
    /// Difference by which a pick must be nearer than the depth to count as above the bottom,
    /// metres.
    pub margin_m: f64,
    pub dead_zone_m: f64,
    pub method: Method,
}

/// Slant ranges of the picks, port and starboard.
struct Ranges {
    /// By the recorder's scale, metres; NaN without a pick.
    m: [Vec<f32>; 2],
    /// True for a side without any pick.
    is_empty: [bool; 2],
}

impl Gathering<'_> {
    /// Returns the evidence for every pick, port and starboard.
    pub(super) fn evidence(&self) -> [Vec<Evidence>; 2] {
        let ranges = self.ranges();
        Side::BOTH.map(|side| {
            let pings = (0..ranges.m[side as usize].len()).into_par_iter().with_min_len(1024);
            pings.map(|ping| self.evidence_at(&ranges, side, ping)).collect()
        })
    }

    fn evidence_at(&self, ranges: &Ranges, side: Side, ping: usize) -> Evidence {
        let (own, other) = (&ranges.m[side as usize], &ranges.m[side.other() as usize]);
        let range_m = own[ping];
        let as_far = AS_FAR[0] + AS_FAR[1] * range_m;
        let own = support_along(own, ping);
        Evidence {
            range_m,
            signs: self.settled.found[side as usize][ping].signs,
            own,
            other: if ranges.is_empty[side.other() as usize] {
                own
            } else {
                support(other, ping, |_| range_m, |_| as_far)
            },
            depth_m: self.settled.depths_m[ping],
            beyond_dead_zone_m: range_m - self.dead_zone_m as f32,
        }
    }

    /// Returns the picks with their confidence, port and starboard; that of picks beyond the bottom
    /// below the boat is doubted.
    pub(super) fn picks(&self) -> [Vec<Pick>; 2] {
        let ranges = self.ranges();
        // The evidence of all picks at once would be the most memory of a step of the slider.
        let pick = |side: Side, index: usize| {
            let found = &self.settled.found[side as usize][index];
            if found.sample.is_nan() {
                return Pick::NONE;
            }
            let evidence = self.evidence_at(&ranges, side, index);
            Pick {
                sample: found.sample,
                confidence: evidence.chance(self.method),
                above_bottom: is_above(evidence.range_m, evidence.depth_m, self.margin_m),
            }
        };
        let picks = |index: usize| {
            let [mut port, mut starboard] = Side::BOTH.map(|side| pick(side, index));
            let depth_m = self.settled.depths_m[index];
            if ranges.m.iter().any(|side| side[index] > depth_m) {
                doubt(self.survey, self.first + index, [&mut port, &mut starboard], &farthest_m);
            }
            (port, starboard)
        };
        let pings = (0..self.settled.depths_m.len()).into_par_iter().with_min_len(1024);
        let (port, starboard) = pings.map(picks).unzip();
        [port, starboard]
    }

    fn ranges(&self) -> Ranges {
        let m = Side::BOTH.map(|side| self.ranges_m(side));
        let is_empty = m.each_ref().map(|side| side.iter().all(|range_m| range_m.is_nan()));
        Ranges { m, is_empty }
    }

    /// Returns the slant ranges by the recorder's scale, metres; NaN without a pick.
    fn ranges_m(&self, side: Side) -> Vec<f32> {
        let found = self.settled.found[side as usize].par_iter().enumerate().with_min_len(1024);
        found
            .map(|(index, found)| {
                let span = self.survey.span(self.first + index, side);
                span.map_or(f32::NAN, |span| span.range_m(f64::from(found.sample)) as f32)
            })
            .collect()
    }
}

/// Returns the share of the ranges around a ping, without that of the ping, that differ from what
/// is expected at their ping by no more than `allowed_m` returns. Both functions take the distance
/// from the ping, in pings.
fn support(
    ranges_m: &[f32],
    ping: usize,
    expected_m: impl Fn(f32) -> f32,
    allowed_m: impl Fn(f32) -> f32,
) -> f32 {
    let agrees = |range_m: f32, away: f32| {
        // Without a pick at the other ping the difference is NaN, and the comparison false.
        u32::from((range_m - expected_m(away)).abs() <= allowed_m(away.abs()))
    };
    let count = |window: &[f32], here: usize| {
        let around = window.iter().enumerate();
        let all = around.map(|(index, range_m)| agrees(*range_m, index as f32 - here as f32));
        all.sum::<u32>() - agrees(window[here], 0.0)
    };
    let start = ping.saturating_sub(REACH);
    let rest = &ranges_m[start..];
    match rest.first_chunk::<{ 2 * REACH + 1 }>() {
        // The compiler compares several ranges at once where it knows their number.
        Some(window) if ping >= REACH => count(window, REACH) as f32 / (2 * REACH) as f32,
        _ => {
            let window = &rest[..rest.len().min(ping - start + REACH + 1)];
            count(window, ping - start) as f32 / (window.len() - 1).max(1) as f32
        }
    }
}

/// Returns the share of the ranges around a ping that are on a line with its range: about as far,
/// or, where the bottom moves faster than [`FAST_M`], along this movement.
fn support_along(ranges_m: &[f32], ping: usize) -> f32 {
    let range_m = ranges_m[ping];
    let allowed_m = |away: f32| ON_LINE_M[0] + ON_LINE_M[1] * away;
    let level = support(ranges_m, ping, |_| range_m, allowed_m);
    if level >= ENOUGH_SUPPORT || range_m.is_nan() {
        return level;
    }
    let movement_m = movement_m(ranges_m, ping);
    if movement_m.abs() > FAST_M {
        let expected_m = |away: f32| range_m + movement_m * away;
        return level.max(support(ranges_m, ping, expected_m, allowed_m));
    }
    level
}

/// Returns the median movement of the bottom from ping to ping around a ping, metres; 0 where it is
/// no larger than [`FAST_M`].
fn movement_m(ranges_m: &[f32], ping: usize) -> f32 {
    // An array, and a count before the median: this is asked for many pings at each step of the
    // slider.
    let (mut moves, mut count, mut fast) = ([0.0; REACH], 0, 0);
    for away in 1..=REACH.min(ping).min(ranges_m.len() - 1 - ping) {
        let moved = f64::from(ranges_m[ping + away] - ranges_m[ping - away]) / (2 * away) as f64;
        if moved.is_finite() {
            moves[count] = moved;
            count += 1;
            fast += usize::from(moved.abs() as f32 > FAST_M);
        }
    }
    if 2 * fast < count || count == 0 { 0.0 } else { median(&mut moves[..count]) as f32 }
}

impl Evidence {
    /// Returns the probability that the pick is within 25 cm of the nearest ground, 0 to 1.
    pub fn chance(&self, method: Method) -> f32 {
        let of_first_return = match method {
            Method::Tracker => self.chance_of_line(),
            Method::Threshold => self.chance_of_level(),
        };
        of_first_return * between(self.above_m(), &ABOVE_BOTTOM)
    }

    /// Returns the probability for a pick of the tracker: the product of a factor for each sign.
    /// The tracker is seldom wrong, and then for one reason only. The factors are the shares of
    /// right picks at each value of the sign.
    pub(crate) fn chance_of_line(&self) -> f32 {
        let [step, nearer, farther] = self.signs;
        let shares = [
            between(step, &[(1.0, 0.6), (2.0, 0.85), (3.0, 0.985), (4.0, 1.0)]),
            between(nearer, &[(0.0, 0.8), (2.0, 0.84), (4.0, 0.96), (12.0, 0.975), (16.0, 1.0)]),
            between(
                farther,
                &[(0.0, 0.45), (2.0, 0.6), (3.0, 0.8), (6.0, 0.9), (9.0, 0.97), (14.0, 1.0)],
            ),
            between(self.own, &[(0.3, 0.6), (0.6, 0.95), (ENOUGH_SUPPORT, 1.0)]),
            between(self.of_depth(), &[(1.05, 1.0), (1.15, 0.4)]),
            between(self.above_m(), &[(0.15, 1.0), (0.25, 0.8)]),
        ];
        shares.into_iter().product()
    }

    /// Returns the probability for a pick of the threshold, by a logistic law: the threshold is
    /// wrong for many reasons, which depend on each other.
    pub(crate) fn chance_of_level(&self) -> f32 {
        let [nearer, farther, _] = self.signs;
        let is_unknown = f32::from(u8::from(self.depth_m.is_nan()));
        let in_ring_down = between(self.beyond_dead_zone_m, &[(0.0, 1.0), (0.3, 0.0)]);
        let odds = 8.75 + 3.5 * between(nearer, &[(0.0, 0.0), (0.3, 1.0)])
            - 15.7 * between(farther, &[(0.0, 0.0), (0.3, 1.0)])
            + 7.1 * self.own
            + 1.4 * self.other
            - 16.3 * between(self.above_m(), &[(0.1, 0.0), (0.25, 1.0)])
            - 1.9 * between(self.of_depth(), &[(0.75, 1.0), (0.85, 0.0)])
            - 14.4 * between(self.of_depth(), &[(1.05, 0.0), (1.15, 1.0)])
            - 11.2 * is_unknown
            - (22.4 + 21.4 * is_unknown) * in_ring_down;
        1.0 / (1.0 + (-odds).exp())
    }

    /// Returns the height of the pick above the recorded depth, metres; 0 without a pick or a
    /// depth.
    fn above_m(&self) -> f32 {
        let above_m = self.depth_m - self.range_m;
        if above_m.is_nan() { 0.0 } else { above_m }
    }

    /// Returns the ratio of the range to the recorded depth; 1 without a pick or a depth.
    fn of_depth(&self) -> f32 {
        let share = self.range_m / self.depth_m;
        if share.is_nan() { 1.0 } else { share }
    }
}

/// Returns the value at `at` by linear interpolation between places; beyond the ends, the value of
/// the end.
fn between(at: f32, places: &[(f32, f32)]) -> f32 {
    let after = places.partition_point(|(place, _)| *place <= at);
    match (after.checked_sub(1).and_then(|before| places.get(before)), places.get(after)) {
        (Some((from, low)), Some((to, high))) => low + (high - low) * (at - from) / (to - from),
        (Some((_, value)), None) | (None, Some((_, value))) => *value,
        (None, None) => 0.0,
    }
}

/// Returns true if a pick is nearer than the depth by more than `margin_m`, by the recorder's own
/// scale.
///
/// Boulders and banks are flagged like weed and fish, since the echo does not distinguish them. On
/// simulated ponds the echo grows behind weed and fades behind boulders (level 0.1 to 0.4 m behind
/// the recorded depth against that of the first 0.1 m behind the pick), but over the boulders of
/// the river of the tests it grows by 8 to 90 bytes, as behind weed; neither the edge nor the
/// plateau behind it differs more between weed and boulders than along either. Ground above the
/// recorded depth over a long stretch is recognised by its length along the track
/// ([`crate::cloud::CloudPoint::above_bottom_m`]).
fn is_above(range_m: f32, depth_m: f32, margin_m: f64) -> bool {
    // Comparisons with NaN are false: without a depth or a pick nothing is flagged.
    f64::from(range_m) < f64::from(depth_m) - margin_m
}

/// Least distance beyond the depth at which a first return is doubted, metres: depths may be
/// rounded to 0.1 m.
const LEAST_BEYOND_M: f64 = 0.2;
/// Least confidence at which a first return beyond the depth is believed all the same (the depth
/// may be wrong), unless the range of the other side confirms the depth: that range is then between
/// these shares of the depth, as on a bank.
const CERTAIN: f32 = 0.6;
const BEARS_OUT: Range<f64> = 0.75..1.0;
/// Largest ratio of the ranges of the two sides at which they confirm each other against the depth:
/// that of the lower side to the upper side on a bank of 35 degrees.
const MOST_APART: f64 = 1.25;
/// Largest difference of the two sides over a level bottom, as a share; fewest pings over a level
/// bottom that determine at which share of the depth the first returns of a log are; and distance
/// of the limit above the median of these shares, in standard deviations of their scatter.
const LEVEL: f64 = 0.03;
const FEWEST_LEVEL: usize = 200;
const OWN_SIGMAS: f64 = 4.0;

/// Returns the largest range of the echo of the bottom below the boat where the recorder's depth is
/// right, metres: differences of scale, rounding and noise between ranges and depths are no larger.
pub(super) fn farthest_m(depth_m: f64) -> f64 {
    const SHALLOW: f64 = 1.08;
    const DEEP: (f64, f64) = (1.03, 0.25);
    (SHALLOW * depth_m).min(DEEP.0 * depth_m + DEEP.1)
}

/// Doubts first returns as [`Gathering::picks`] does, with a limit measured on this log: the ratio
/// of ranges to depths where both sides detect a level bottom.
pub(super) fn doubt_by_own_scale(survey: &Survey, returns: &mut FirstReturns) {
    let Some(farthest) = farthest_share(survey, returns) else {
        return;
    };
    let FirstReturns { port, starboard, .. } = returns;
    let sides = [Arc::make_mut(port).as_mut_slice(), Arc::make_mut(starboard).as_mut_slice()];
    doubt_beyond(survey, sides, &|depth_m| farthest_m(depth_m).min(farthest * depth_m));
}

/// Returns the largest ratio of first return to depth over a level bottom in this log; `None` where
/// too few pings determine it.
fn farthest_share(survey: &Survey, returns: &FirstReturns) -> Option<f64> {
    let share = |ping: usize| {
        let picks = Side::BOTH.map(|side| &returns.side(side)[ping]);
        let [port_m, starboard_m] = Side::BOTH.map(|side| returns.range_m(survey, ping, side));
        let is_certain = picks.iter().all(|pick| pick.confidence >= CERTAIN);
        let is_level = (port_m - starboard_m).abs() < LEVEL * port_m.max(starboard_m);
        let share = port_m.max(starboard_m) / f64::from(survey.good_depth_m(ping));
        (is_certain && is_level && share.is_finite()).then_some(share)
    };
    let mut shares: Vec<f64> =
        (0..survey.side_scan.len()).into_par_iter().filter_map(share).collect();
    if shares.len() < FEWEST_LEVEL {
        return None;
    }
    let middle = median(&mut shares);
    Some(middle + OWN_SIGMAS * spread_about(&mut shares, middle))
}

/// Doubts first returns as [`doubt`] does at all pings.
fn doubt_beyond(
    survey: &Survey,
    [port, starboard]: [&mut [Pick]; 2],
    farthest_m: &(dyn Fn(f64) -> f64 + Sync),
) {
    let pings = port.par_iter_mut().zip(starboard).enumerate().with_min_len(1024);
    pings.for_each(|(ping, (port, starboard))| doubt(survey, ping, [port, starboard], farthest_m));
}

/// Sets the confidence of first returns of a ping beyond the range that `farthest_m` returns for
/// the depth to 0. A first return keeps its confidence in two cases: the first return of the other
/// side is beyond the depth too, at about the same range, since the depth may be wrong or the beams
/// may not reach the nadir; or it is certain and the other side does not confirm the depth. `picks`
/// are those of port and starboard.
fn doubt(
    survey: &Survey,
    ping: usize,
    [port, starboard]: [&mut Pick; 2],
    farthest_m: &(dyn Fn(f64) -> f64 + Sync),
) {
    let depth_m = f64::from(survey.good_depth_m(ping));
    let port_m = port.range_m(survey, ping, Side::Port);
    let starboard_m = starboard.range_m(survey, ping, Side::Starboard);
    for (pick, own_m, other_m) in [(port, port_m, starboard_m), (starboard, starboard_m, port_m)] {
        let is_beyond = own_m > farthest_m(depth_m).max(depth_m + LEAST_BEYOND_M);
        let is_certain = pick.confidence >= CERTAIN && !BEARS_OUT.contains(&(other_m / depth_m));
        let is_other_beyond = other_m > depth_m;
        let is_apart = is_other_beyond && own_m.max(other_m) > MOST_APART * own_m.min(other_m);
        if is_beyond && (is_apart || !is_other_beyond && !is_certain) {
            pick.confidence = 0.0;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Evidence with nothing against the pick.
    const SOUND: Evidence = Evidence {
        range_m: 3.0,
        signs: [5.0, 20.0, 20.0],
        own: 1.0,
        other: 1.0,
        depth_m: 3.0,
        beyond_dead_zone_m: 2.5,
    };

    #[test]
    fn what_speaks_against_a_pick_of_the_tracker_lowers_its_chance() {
        let chance = |evidence: Evidence| evidence.chance(Method::Tracker);
        assert!(chance(SOUND) > 0.99);
        let no_depth = Evidence { depth_m: f32::NAN, ..SOUND };
        assert!(chance(no_depth) > 0.99);
        let against = [
            Evidence { signs: [2.0, 20.0, 20.0], ..SOUND },
            Evidence { signs: [5.0, 1.0, 20.0], ..SOUND },
            Evidence { signs: [5.0, 20.0, 1.0], ..SOUND },
            Evidence { own: 0.4, ..SOUND },
            Evidence { depth_m: 2.6, ..SOUND },
            Evidence { depth_m: 3.3, ..SOUND },
        ];
        for evidence in against {
            assert!(chance(evidence) < 0.9, "{evidence:?}");
        }
    }

    #[test]
    fn a_return_above_the_recorded_depth_is_hardly_ever_the_bottom() {
        for method in [Method::Tracker, Method::Threshold] {
            let chance = |above_m: f32| {
                let depth_m = SOUND.range_m + above_m;
                let signs = match method {
                    Method::Tracker => SOUND.signs,
                    Method::Threshold => [0.0; 3],
                };
                let evidence = Evidence { depth_m, signs, ..SOUND };
                evidence.chance(method)
            };
            assert!(chance(0.1) > 0.99 && chance(0.35) <= ABOVE_BOTTOM_SHARE);
        }
    }

    #[test]
    fn a_threshold_that_is_met_in_the_ring_down_is_no_bottom_and_a_clear_edge_is() {
        let level = |evidence: Evidence| evidence.chance(Method::Threshold);
        let edge = Evidence { signs: [0.0; 3], ..SOUND };
        assert!(level(edge) > 0.99);
        let rings = Evidence { range_m: 0.51, beyond_dead_zone_m: 0.01, ..edge };
        assert!(level(rings) < 0.01);
        assert!(level(Evidence { depth_m: f32::NAN, ..rings }) < 0.01);
        assert!(level(Evidence { signs: [0.0, 0.3, 0.0], depth_m: f32::NAN, ..edge }) < 0.2);
    }
}
