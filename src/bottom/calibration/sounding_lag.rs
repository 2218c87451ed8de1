//! Finds the delay of soundings behind the first returns recorded with them.
//!
//! A sounder that averages its depths over seconds, or shows them late, writes depths of a place
//! that the boat has passed; the side-scan of the same ping does not. Over level ground nothing
//! shows this delay. Where the bottom falls by `v` metres a second along the track, a sounding `d`
//! that is late by `t` and the range `r` of the first returns, which lie abeam and so at one depth
//! along the track, differ by `d - r = -v t`.

use super::Calibration;
use crate::first_return::FirstReturns;
use bathyscope_log::support::statistics::{SIGMA_PER_MAD, median, usual_step, weighted_median};
use bathyscope_log::survey::{Side, Survey};

/// Time on each side of a ping over which ranges rise or fall evenly, seconds, and fewest pings on
/// each side: a slow recorder has a ping a second.
const REACH_S: f64 = 1.0;
const LEAST_REACH: usize = 3;
/// Share of these pings that must have a range and a depth.
const LEAST_SHARE: f64 = 0.7;
/// Largest difference of the ranges of both sides, as a share of the range: with more, the bottom
/// slopes across the track.
const SIDES_AGREE: f64 = 0.1;
/// Largest scatter of ranges about their line: this share of the change in a second, plus these
/// metres.
const EVEN: (f64, f64) = (0.2, 0.03);
/// Least rate at which the bottom rises or falls, and rate below which it is level, metres a
/// second.
const SLOPING_MPS: f64 = 0.1;
const LEVEL_MPS: f64 = 0.05;
/// Fewest windows over slopes, and least share of them that must fall, and that must rise: with one
/// kind alone a lag looks like a draft.
const LEAST_WINDOWS: usize = 24;
const LEAST_OF_EACH: f64 = 0.1;
/// Number of windows that every ping is in.
const SHARED: f64 = 4.0;
/// Least lag that is reported: in seconds, as a number of its standard errors, and as a multiple of
/// the scatter of single windows.
const LEAST_LAG_S: f64 = 0.25;
const SIGMAS: f64 = 6.0;
const TIMES_SPREAD: f64 = 2.0;
/// Longest lag of any sounder, seconds.
const LONGEST_LAG_S: f64 = 10.0;
/// Remaining lag below which the rounds end, seconds, and their largest number. Averages follow a
/// slope with a delay, so that a first lag is too short: it is taken out, and the remaining lag is
/// found again.
const SETTLED_S: f64 = 0.01;
const ROUNDS: usize = 8;

/// Delay of soundings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SoundingLag {
    /// Delay after the first returns recorded with them, seconds.
    pub lag_s: f64,
    /// Standard error of the delay, seconds.
    pub standard_error_s: f64,
}

impl SoundingLag {
    /// Returns the lag that the slopes along a track show; `None` where they show none.
    pub(super) fn of(
        survey: &Survey,
        returns: &FirstReturns,
        calibration: &Calibration,
    ) -> Option<Self> {
        let ranges_m: Vec<f64> = (0..survey.side_scan.len())
            .map(|ping| range_m(survey, returns, calibration, ping))
            .collect();
        let windows = windows(survey, &ranges_m);
        let mut found = Self { lag_s: 0.0, standard_error_s: f64::NAN };
        for _ in 0..ROUNDS {
            let more = more_s(survey, &windows, found.lag_s)?;
            found = Self { lag_s: found.lag_s + more.lag_s, ..more };
            if more.lag_s.abs() < SETTLED_S {
                break;
            }
        }
        let is_told = found.lag_s > LEAST_LAG_S && found.lag_s < LONGEST_LAG_S;
        (is_told && found.lag_s > SIGMAS * found.standard_error_s).then_some(found)
    }

    /// Returns the lag rounded to hundredths of a second: it is not known any better.
    pub fn told_s(&self) -> f64 {
        (100.0 * self.lag_s).round() / 100.0
    }

    /// Returns the sentence about the lag.
    pub(super) fn warning(&self) -> String {
        format!(
            "Where the bottom rises or falls along the track, soundings are those of {:.2} s before (standard error {:.2} s), as the first returns of both sides show: the recorder averages its depths, or is late. Apply the sounding lag adds {:.2} s to mounting.sounding_lag_s; so does process --latency.",
            self.lag_s,
            self.standard_error_s,
            self.told_s()
        )
    }
}

/// Returns the range of the first returns of a ping where both sides are about equally far, metres;
/// otherwise NaN.
fn range_m(survey: &Survey, returns: &FirstReturns, calibration: &Calibration, ping: usize) -> f64 {
    let [port_m, starboard_m] =
        Side::BOTH.map(|side| calibration.first_return_m(survey, returns, ping, side));
    let farther_m = port_m.max(starboard_m);
    if (port_m - starboard_m).abs() <= SIDES_AGREE * farther_m { farther_m } else { f64::NAN }
}

/// Pings over which the bottom rises or falls evenly.
struct Window {
    /// Times and ranges of the first returns, seconds and metres.
    ranges: Vec<[f64; 2]>,
    /// Growth of the ranges, metres a second.
    growth_mps: f64,
}

fn windows(survey: &Survey, ranges_m: &[f64]) -> Vec<Window> {
    let pings = &survey.side_scan;
    let interval_s = usual_step(pings.iter().map(|ping| ping.time_s));
    if interval_s.is_nan() || interval_s <= 0.0 {
        return Vec::new();
    }
    let reach = ((REACH_S / interval_s).round() as usize).max(LEAST_REACH);
    let width = 2 * reach + 1;
    let longest_s = 1.5 * width as f64 * interval_s;
    let starts = (0..pings.len().saturating_sub(width)).step_by((reach / 2).max(1));
    let window = |start: usize| {
        let inside = start..start + width;
        let took_s = pings[inside.end - 1].time_s - pings[start].time_s;
        let ranges: Vec<[f64; 2]> = inside
            .map(|ping| [pings[ping].time_s, ranges_m[ping]])
            .filter(|[_, range_m]| range_m.is_finite())
            .collect();
        let is_whole = ranges.len() as f64 >= LEAST_SHARE * width as f64 && took_s <= longest_s;
        is_whole.then(|| Window::of(ranges)).flatten()
    };
    starts.filter_map(window).collect()
}

impl Window {
    /// Creates the window of some ranges; `None` where they do not lie on a line.
    fn of(ranges: Vec<[f64; 2]>) -> Option<Self> {
        let count = ranges.len() as f64;
        let mean = |of: &dyn Fn(&[f64; 2]) -> f64| ranges.iter().map(of).sum::<f64>() / count;
        let (time_s, range_m) = (mean(&|point| point[0]), mean(&|point| point[1]));
        let growth_mps = mean(&|point| (point[0] - time_s) * (point[1] - range_m))
            / mean(&|point| (point[0] - time_s).powi(2));
        let left_m = |point: &[f64; 2]| point[1] - range_m - growth_mps * (point[0] - time_s);
        let scatter_m = mean(&|point| left_m(point).powi(2)).sqrt();
        let is_even = scatter_m <= EVEN.0 * growth_mps.abs() + EVEN.1;
        is_even.then_some(Self { ranges, growth_mps })
    }

    /// Returns the median of soundings less ranges, metres, with the soundings taken `lag_s` later;
    /// `None` where too few soundings are known.
    fn difference_m(&self, survey: &Survey, lag_s: f64) -> Option<f64> {
        let difference = |&[time_s, range_m]: &[f64; 2]| {
            sounding_m(survey, time_s + lag_s).map(|depth_m| depth_m - range_m)
        };
        let mut differences: Vec<f64> = self.ranges.iter().filter_map(difference).collect();
        let is_enough = differences.len() as f64 >= LEAST_SHARE * self.ranges.len() as f64;
        is_enough.then(|| median(&mut differences))
    }
}

/// Returns the depth at a time, linear between the soundings before and after it, metres; `None`
/// where one of them does not count or there is none.
fn sounding_m(survey: &Survey, time_s: f64) -> Option<f64> {
    let soundings = &survey.soundings;
    let next = soundings.partition_point(|sounding| sounding.time_s < time_s);
    let (before, after) = (soundings.get(next.checked_sub(1)?)?, soundings.get(next)?);
    let span_s = after.time_s - before.time_s;
    if !(before.is_good() && after.is_good()) || span_s > 2.0 * REACH_S {
        return None;
    }
    let share = if span_s > 0.0 { (time_s - before.time_s) / span_s } else { 0.0 };
    let (before_m, after_m) = (f64::from(before.depth_m), f64::from(after.depth_m));
    Some(before_m + share * (after_m - before_m))
}

/// Returns the delay of soundings beyond `lag_s`; `None` where too little of the bottom slopes, or
/// the windows do not agree.
fn more_s(survey: &Survey, windows: &[Window], lag_s: f64) -> Option<SoundingLag> {
    let compared: Vec<(f64, f64)> = windows
        .iter()
        .filter_map(|window| Some((window.growth_mps, window.difference_m(survey, lag_s)?)))
        .collect();
    let level = compared.iter().filter(|(growth_mps, _)| growth_mps.abs() < LEVEL_MPS);
    let mut level: Vec<f64> = level.map(|(_, difference_m)| *difference_m).collect();
    let level_m = if level.is_empty() { 0.0 } else { median(&mut level) };
    let sloping = || compared.iter().filter(|(growth_mps, _)| growth_mps.abs() > SLOPING_MPS);
    let count = sloping().count();
    let falling = sloping().filter(|(growth_mps, _)| *growth_mps > 0.0).count();
    let least = LEAST_OF_EACH * count as f64;
    if count < LEAST_WINDOWS || (falling.min(count - falling) as f64) < least {
        return None;
    }
    let lag = |&(growth_mps, difference_m): &(f64, f64)| {
        ((level_m - difference_m) / growth_mps, growth_mps * growth_mps)
    };
    let mut lags: Vec<(f64, f64)> = sloping().map(lag).collect();
    let more_s = weighted_median(&mut lags);
    for (lag_s, _) in &mut lags {
        *lag_s = (*lag_s - more_s).abs();
    }
    let spread_s = SIGMA_PER_MAD * weighted_median(&mut lags);
    let is_alike = TIMES_SPREAD * spread_s < (lag_s + more_s).abs().max(LEAST_LAG_S);
    let standard_error_s = spread_s / (count as f64 / SHARED).sqrt();
    is_alike.then_some(SoundingLag { lag_s: more_s, standard_error_s })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::first_return::Pick;
    use bathyscope_log::survey::{SidePing, SideSpan, Sounding};
    use std::sync::Arc;

    /// A bed of hills, passed at 2 m/s, metres.
    fn bed_m(time_s: f64) -> f64 {
        6.0 + 2.0 * (0.12 * time_s).sin()
    }

    /// A log whose soundings are those of `lag_s` before, with the first returns of the bed.
    fn found(lag_s: f64, interval_s: f64, bed_m: impl Fn(f64) -> f64) -> Option<SoundingLag> {
        let count = (400.0 / interval_s) as usize;
        let span = SideSpan::of_bytes(2000, [0.0, 20.0]);
        let time_s = |ping: usize| interval_s * ping as f64;
        let noise_m = |ping: usize| 0.01 * [0.0, 1.0, -1.0, 0.5, -0.5][ping % 5];
        let pings = (0..count).map(|ping| SidePing {
            port: Some(span),
            starboard: Some(span),
            ..SidePing::with_depth(time_s(ping), 6.0)
        });
        let sounding = |ping: usize| {
            let depth_m = bed_m(time_s(ping) - lag_s) + noise_m(ping);
            Sounding::new(time_s(ping), depth_m as f32)
        };
        let survey = Survey {
            soundings: Arc::new((0..count).map(sounding).collect()),
            ..Survey::of_pings(pings)
        };
        let pick = |ping: usize| Pick {
            sample: span.sample_at(bed_m(time_s(ping))) as f32,
            confidence: 1.0,
            above_bottom: false,
        };
        let picks: Arc<Vec<Pick>> = Arc::new((0..count).map(pick).collect());
        let returns =
            FirstReturns { port: picks.clone(), starboard: picks, ..FirstReturns::default() };
        SoundingLag::of(&survey, &returns, &Calibration::default())
    }

    #[test]
    fn a_lag_is_found_at_any_rate_and_none_where_there_is_none() {
        for interval_s in [0.1, 0.5, 1.0] {
            let lag = found(1.3, interval_s, bed_m).expect("a lag");
            assert!((lag.lag_s - 1.3).abs() < 0.05, "{interval_s} s: {lag:?}");
            assert_eq!(found(0.0, interval_s, bed_m), None, "{interval_s} s");
        }
    }

    #[test]
    fn level_ground_shows_no_lag_and_a_bottom_that_only_falls_may_be_a_draft() {
        assert_eq!(found(1.3, 0.1, |_| 5.0), None);
        assert_eq!(found(1.3, 0.1, |time_s| 2.0 + 0.04 * time_s.max(0.0) * 5.0), None);
    }
}
