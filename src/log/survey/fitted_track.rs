//! Fits a smooth track to coarse fixes, for the position and the velocity of the boat at any time.
//!
//! Recorders round positions to about a metre and repeat them for most pings, so a difference of
//! two recorded positions points to one of eight directions, or nowhere. The direction of a line
//! fitted over a few seconds is accurate to about a degree.

use super::local_fit::{LocalFit, TimedPosition};
use super::{Track, run_ranges};
use crate::support::outline::between;
use crate::support::statistics::{ends, quantile, sorted};
use std::ops::Range;

/// Longest time between two fixes that one fit covers, seconds (or three fix intervals, where those
/// are longer).
const MAX_GAP_S: f64 = 5.0;
/// Longest time for which an unchanged position counts as one measurement, seconds; a longer stay
/// counts as several, because the boat is slow or at rest.
const LONG_STAY_S: f64 = 2.0;
/// Largest number of measurements that a stay counts as: with a damaged clock a stay may last for
/// weeks.
const MOST_PARTS: f64 = 10_000.0;
/// Step after a long stay, metres, beyond which the receiver is assumed to have lost its position
/// during the stay.
const STALE_JUMP_M: f64 = 5.0;
/// Time beyond the fixes for which a fit is used, seconds.
const REACH_S: f64 = 2.0;
/// Speed below which the boat is at rest, metres a second.
const REST_SPEED_MPS: f64 = 0.2;
/// Shares of the window that are tried one after the other where the track bends.
const NARROWING: [f64; 2] = [1.0, 0.5];
/// Largest misfit of a curve that follows the boat, as a share of the resolution of the places.
const MISFIT: f64 = 0.5;
/// Shortest way within a window that counts as motion, in resolutions of the fixes: a boat at rest
/// whose rounded position toggles between two neighbours seems to travel up to twice their
/// distance.
const MOVED: f64 = 2.6;
/// Fix intervals that receivers are known to use, seconds, longest first.
const KNOWN_INTERVALS_S: [f64; 9] = [30.0, 15.0, 10.0, 5.0, 2.0, 1.0, 0.5, 0.2, 0.1];
/// Least time between nearly all changes of position, as a share of the fix interval: a position
/// does not change more often than the receiver gives fixes, apart from the beat of records against
/// fixes.
const LEAST_CHANGE: f64 = 0.8;
/// Share of a fix interval; records closer together than this repeat fixes.
const REPEATS: f64 = 0.9;
/// Share of the fixes that counts as nearly all.
const NEARLY_ALL: f64 = 0.95;
/// Longest time between two fixes over which the place of the boat is interpolated, seconds (or six
/// fix intervals, where those are longer).
const LONGEST_BRIDGE_S: f64 = 10.0;
/// Longest distance between two fixes over which the place of the boat is interpolated where times
/// are assumed, metres (or three times the distance between nearly all fixes, where that is
/// farther): in a longer gap rows are missing.
const LONGEST_BRIDGE_M: f64 = 30.0;

/// Largest number of places whose windows are used to estimate the rounding that is left in a fit.
const MOST_PLACES_TRIED: usize = 4_000;
/// Shortest step along an axis that is a step of the recorded positions, metres; shorter ones come
/// from the curvature of the earth.
const LEAST_STEP_M: f64 = 1e-3;

/// Place and motion of the boat at a time; NaN where unknown.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Motion {
    /// Place, metres east and north.
    pub(super) place_m: [f64; 2],
    /// Velocity to the east and north, metres a second; NaN where nothing can be fitted.
    pub(super) velocity: [f64; 2],
    /// True if the boat moves by more than its fixes can resolve.
    pub(super) moving: bool,
}

impl Motion {
    const UNKNOWN: Self = Self { place_m: [f64::NAN; 2], velocity: [f64::NAN; 2], moving: false };

    pub(super) fn speed_mps(&self) -> f64 {
        self.velocity[0].hypot(self.velocity[1])
    }
}

/// Distinct fixes of a track, prepared for local fits.
#[derive(Debug)]
pub(super) struct FittedTrack {
    places: Vec<TimedPosition>,
    /// Index ranges of `places` without a gap.
    segments: Vec<Range<usize>>,
    half_window_s: f64,
    reach_s: f64,
    bridge_s: f64,
    bridge_m: f64,
    /// Smallest step between two recorded positions, metres, at most 1: the resolution that the
    /// recorder's rounding leaves.
    resolution_m: f64,
    /// Misfit of a line, metres, beyond which three or four places give a parabola. It is that of
    /// rounding where each record has a fix of its own, and infinite where records repeat fixes.
    bends_beyond_m: f64,
}

impl FittedTrack {
    /// Prepares a track for fits over `window_s` seconds; the window is widened to four fix
    /// intervals where these are longer.
    pub(super) fn new(track: &Track, window_s: f64) -> Self {
        let stays = stays(track);
        if track.has_assumed_times
            && let Some(in_order) = Self::in_order(track, &stays, window_s)
        {
            return in_order;
        }
        let interval_s = fix_interval_s(&stays);
        let repeats = record_interval_s(track) < REPEATS * interval_s;
        let places = places(&stays, if repeats { interval_s } else { 0.0 });
        Self {
            segments: segments(&places, MAX_GAP_S.max(3.0 * interval_s), f64::INFINITY),
            bends_beyond_m: if repeats { f64::INFINITY } else { MISFIT * step_by_axis_m(&places) },
            places,
            half_window_s: window_s.max(4.0 * interval_s) / 2.0,
            reach_s: REACH_S + interval_s,
            bridge_s: LONGEST_BRIDGE_S.max(6.0 * interval_s),
            bridge_m: f64::INFINITY,
            resolution_m: resolution_m(&stays),
        }
    }

    /// Prepares a track whose times are assumed and whose records repeat fixes: each fix counts at
    /// its first record, with equal weights, as the time for which it is repeated has no meaning.
    /// `None` where the records do not repeat fixes.
    fn in_order(track: &Track, stays: &[Stay], window_s: f64) -> Option<Self> {
        let between_s = sorted_steps(stays, |from, to| to.first_s - from.first_s);
        let steps_m = sorted_steps(stays, step_m);
        if between_s.is_empty() || record_interval_s(track) >= REPEATS * quantile(&between_s, 0.5) {
            return None;
        }
        let usual_s = quantile(&between_s, 0.5);
        let longest_s = quantile(&between_s, NEARLY_ALL);
        let place = |stay: &Stay| TimedPosition {
            time_s: stay.first_s,
            place_m: stay.place_m,
            weight: 1.0,
        };
        let places: Vec<TimedPosition> = stays.iter().map(place).collect();
        let bridge_m = LONGEST_BRIDGE_M.max(3.0 * quantile(&steps_m, NEARLY_ALL));
        Some(Self {
            segments: segments(&places, 3.0 * longest_s, bridge_m),
            bends_beyond_m: f64::INFINITY,
            places,
            half_window_s: window_s.max(4.0 * usual_s) / 2.0,
            reach_s: usual_s,
            bridge_s: 6.0 * longest_s,
            bridge_m,
            resolution_m: resolution_m(stays),
        })
    }

    /// Returns position and velocity at a time. In short gaps of the fixes the position is
    /// interpolated and the velocity is NaN; in long gaps, before the first fix and after the last,
    /// both are NaN.
    pub(super) fn at(&self, time_s: f64) -> Motion {
        match self.fit(time_s) {
            Some((fit, half_window_s)) => {
                let speed = fit.velocity[0].hypot(fit.velocity[1]);
                let travelled_m = speed * 2.0 * half_window_s;
                Motion {
                    place_m: fit.position,
                    velocity: fit.velocity,
                    moving: speed >= REST_SPEED_MPS && travelled_m >= MOVED * self.resolution_m,
                }
            }
            None if self.is_known(time_s) => self.between(time_s),
            None => Motion::UNKNOWN,
        }
    }

    /// Returns the standard deviation of places that rounding leaves in the fit, along the axis
    /// where it is larger, metres; with `is_fitted` false, that of the recorded places.
    ///
    /// Rounding to multiples of `r` has a variance of `r²/12`. On a track along the lines that
    /// positions are rounded to, all values have the same error, however many there are. Where an
    /// axis takes `n` steps in the window of a fit, the errors go evenly through all parts of a
    /// step, and a share of about `1 / (1 + n²)` of the variance is left of them, but no less than
    /// of as many independent values (both from simulated fits).
    pub(super) fn rounding_m(&self, is_fitted: bool) -> f64 {
        let step = self.places.len().div_ceil(MOST_PLACES_TRIED).max(1);
        let tried = || self.places.iter().step_by(step);
        let sigmas_m = [0, 1].map(|axis| {
            let resolution_m = axis_resolution_m(&self.places, axis);
            let shares = tried().map(|place| {
                if !is_fitted {
                    return 1.0;
                }
                let window = self.window(place.time_s, self.half_window_s);
                let steps = span_m(window, axis) / resolution_m;
                (1.0 / (1.0 + steps * steps) + 1.0 / window.len().max(1) as f64).min(1.0)
            });
            let share = shares.sum::<f64>() / tried().count().max(1) as f64;
            resolution_m * (share / 12.0).sqrt()
        });
        sigmas_m[0].max(sigmas_m[1])
    }

    /// Returns true if the place of the boat at a time is known.
    fn is_known(&self, time_s: f64) -> bool {
        let next = self.places.partition_point(|place| place.time_s < time_s);
        let sides = [next.checked_sub(1), Some(next)];
        let sides = sides.map(|side| side.and_then(|index| self.places.get(index)));
        let is_near = |place: &TimedPosition| (place.time_s - time_s).abs() <= self.reach_s;
        match sides {
            [Some(before), Some(after)] if self.is_bridged(before, after) => true,
            sides => sides.into_iter().flatten().any(is_near),
        }
    }

    /// Returns true if two consecutive fixes are close enough to interpolate between them.
    fn is_bridged(&self, before: &TimedPosition, after: &TimedPosition) -> bool {
        after.time_s - before.time_s <= self.bridge_s
            && apart_m(before.place_m, after.place_m) <= self.bridge_m
    }

    /// Returns the fit over the whole window, or over a narrower one where the boat turns, and half
    /// the width of the window that was used; `None` where nothing can be fitted.
    fn fit(&self, time_s: f64) -> Option<(LocalFit, f64)> {
        let mut best = None;
        for half_window_s in NARROWING.map(|share| share * self.half_window_s) {
            let window = self.window(time_s, half_window_s);
            let Some(fit) = LocalFit::over(window, time_s, half_window_s, self.bends_beyond_m)
            else {
                break;
            };
            let follows = fit.misfit_m < MISFIT * self.resolution_m;
            best = Some((fit, half_window_s));
            if follows {
                break;
            }
        }
        best
    }

    /// Returns the places within the window around a time, without those across a gap; empty in a
    /// gap.
    fn window(&self, time_s: f64, half_window_s: f64) -> &[TimedPosition] {
        let index = self
            .segments
            .partition_point(|segment| self.places[segment.end - 1].time_s + self.reach_s < time_s);
        let Some(segment) = self.segments.get(index) else {
            return &[];
        };
        let places = &self.places[segment.clone()];
        if time_s < places[0].time_s - self.reach_s {
            return &[];
        }
        let start = places.partition_point(|place| place.time_s <= time_s - half_window_s);
        let end = places.partition_point(|place| place.time_s < time_s + half_window_s);
        &places[start..end]
    }

    /// Interpolates linearly between the places around a time. Before the first place, after the
    /// last, and in a gap that is not bridged the nearest place is returned.
    fn between(&self, time_s: f64) -> Motion {
        let next = self.places.partition_point(|place| place.time_s < time_s);
        let Some(after) = self.places.get(next).or(self.places.last()) else {
            return Motion::UNKNOWN;
        };
        let before = &self.places[next.saturating_sub(1).min(self.places.len() - 1)];
        let span_s = after.time_s - before.time_s;
        let share =
            if span_s > 0.0 { ((time_s - before.time_s) / span_s).clamp(0.0, 1.0) } else { 0.0 };
        let share = if self.is_bridged(before, after) { share } else { share.round() };
        Motion { place_m: between(before.place_m, after.place_m, share), ..Motion::UNKNOWN }
    }
}

/// A recorded position, and the times of the first and the last record that repeat it.
#[derive(Clone, Copy, Debug)]
struct Stay {
    first_s: f64,
    last_s: f64,
    /// The position, metres east and north.
    place_m: [f64; 2],
}

fn apart_m(from_m: [f64; 2], to_m: [f64; 2]) -> f64 {
    (to_m[0] - from_m[0]).hypot(to_m[1] - from_m[1])
}

fn step_m(from: &Stay, to: &Stay) -> f64 {
    apart_m(from.place_m, to.place_m)
}

/// Returns the steps from each item to the next, in ascending order.
fn sorted_steps<T>(items: &[T], step: impl Fn(&T, &T) -> f64) -> Vec<f64> {
    sorted(items.windows(2).map(|pair| step(&pair[0], &pair[1])))
}

fn stays(track: &Track) -> Vec<Stay> {
    let mut stays: Vec<Stay> = Vec::new();
    let mut shown = None;
    for fix in track.fixes.iter() {
        if !(fix.position.lon_deg.is_finite() && fix.position.lat_deg.is_finite()) {
            continue;
        }
        match stays.last_mut() {
            Some(stay) if shown == Some(fix.position) => stay.last_s = fix.time_s,
            _ => {
                let place_m = track.frame.to_enu(fix.position);
                stays.push(Stay { first_s: fix.time_s, last_s: fix.time_s, place_m });
                shown = Some(fix.position);
            }
        }
    }
    drop_stale_repeats(&mut stays);
    stays
}

/// Shortens long stays that end in a jump to their first record: the receiver had lost its
/// satellites, and the position was not true all that time.
fn drop_stale_repeats(stays: &mut [Stay]) {
    for index in 1..stays.len() {
        let [before, after] = [stays[index - 1], stays[index]];
        let jump_m = step_m(&before, &after);
        if before.last_s - before.first_s > MAX_GAP_S && jump_m > STALE_JUMP_M {
            stays[index - 1].last_s = before.first_s;
        }
    }
}

/// Estimates the seconds between two fixes of the receiver: the longest known interval that the
/// times of the position changes are in step with.
///
/// The time between changes does not show the interval: at 2 m/s and 10 fixes a second a position
/// rounded to a metre changes only every third or fourth fix.
fn fix_interval_s(stays: &[Stay]) -> f64 {
    if stays.len() < 8 {
        return 0.0;
    }
    let sampled = &stays[1..stays.len().min(400)];
    let between_s = sorted_steps(sampled, |from, to| to.first_s - from.first_s);
    let change_s = quantile(&between_s, 0.1);
    let beat = |interval_s: f64| {
        let (sin, cos) = sampled.iter().fold((0.0, 0.0), |(sin, cos), stay| {
            let (s, c) = (std::f64::consts::TAU * stay.first_s / interval_s).sin_cos();
            (sin + s, cos + c)
        });
        f64::hypot(sin, cos) / sampled.len() as f64
    };
    let keeps_beat =
        |interval_s: &f64| change_s >= LEAST_CHANGE * interval_s && beat(*interval_s) > 0.8;
    let known = KNOWN_INTERVALS_S.into_iter().find(keeps_beat);
    known.unwrap_or_else(|| between_s[between_s.len() / 20].clamp(0.0, 0.1))
}

/// Returns the median time between two records with a position, seconds.
fn record_interval_s(track: &Track) -> f64 {
    let fixes = &track.fixes[..track.fixes.len().min(400)];
    let between_s = sorted_steps(fixes, |from, to| to.time_s - from.time_s);
    if between_s.is_empty() { f64::INFINITY } else { quantile(&between_s, 0.5) }
}

/// Makes one or more measurements of each stay, around its middle, where the rounding error is as
/// likely ahead as behind. Where a recorder repeats the latest fix in each record, a fix is half a
/// fix interval old on average: `repeats_s` is that interval. Where each fix is recorded once, at
/// its own time, `repeats_s` is 0.
fn places(stays: &[Stay], repeats_s: f64) -> Vec<TimedPosition> {
    let mut places = Vec::with_capacity(stays.len());
    for stay in stays {
        let length_s = stay.last_s - stay.first_s;
        let parts = (length_s / LONG_STAY_S).ceil().clamp(1.0, MOST_PARTS);
        for part in 0..parts as usize {
            places.push(TimedPosition {
                time_s: stay.first_s + (part as f64 + 0.5) / parts * length_s - repeats_s / 2.0,
                place_m: stay.place_m,
                weight: (length_s / parts).max(0.02),
            });
        }
    }
    places
}

fn segments(places: &[TimedPosition], max_gap_s: f64, max_gap_m: f64) -> Vec<Range<usize>> {
    let is_gap = |before: &TimedPosition, after: &TimedPosition| {
        after.time_s - before.time_s > max_gap_s
            || apart_m(before.place_m, after.place_m) > max_gap_m
    };
    run_ranges(places, |before, after| !is_gap(before, after)).collect()
}

/// Checks which times have a known place on a track; `None` inside for a track without fixes.
#[derive(Debug)]
pub(crate) struct KnownTimes(Option<FittedTrack>);

impl KnownTimes {
    /// Creates the check for a track. For a track without fixes all times count as known.
    pub(crate) fn of(track: &Track) -> Self {
        Self((!track.fixes.is_empty()).then(|| FittedTrack::new(track, 0.0)))
    }

    /// Returns the number of times, of some times in order, at which the place is not known, and
    /// the first and the last of these; `None` where all are known.
    pub(crate) fn unknown(&self, times: impl Iterator<Item = f64>) -> Option<(usize, [f64; 2])> {
        let fitted = self.0.as_ref()?;
        let lost = times.filter(|time_s| !fitted.is_known(*time_s));
        lost.fold(None, |found, time_s| {
            let (count, [first_s, _]) = found.unwrap_or((0, [time_s; 2]));
            Some((count + 1, [first_s, time_s]))
        })
    }
}

fn resolution_m(stays: &[Stay]) -> f64 {
    let steps = stays.windows(2).map(|pair| step_m(&pair[0], &pair[1]));
    steps.fold(1.0, f64::min)
}

/// Returns the smallest step of the recorded positions along an axis, metres; at most 1.
fn axis_resolution_m(places: &[TimedPosition], axis: usize) -> f64 {
    let steps = places.windows(2).map(|pair| (pair[1].place_m[axis] - pair[0].place_m[axis]).abs());
    steps.filter(|step_m| *step_m > LEAST_STEP_M).fold(1.0, f64::min)
}

/// Returns the smallest step of the recorded positions along either axis, metres. A boat that
/// travels far between two fixes has no short steps, but short ones along an axis.
fn step_by_axis_m(places: &[TimedPosition]) -> f64 {
    axis_resolution_m(places, 0).min(axis_resolution_m(places, 1))
}

/// Returns the length that some places cover along an axis, metres.
fn span_m(places: &[TimedPosition], axis: usize) -> f64 {
    let [low_m, high_m] = ends(places.iter().map(|place| place.place_m[axis]));
    (high_m - low_m).max(0.0)
}
