//! Determines the position and size, on the bottom, of the object in a box.

use super::echo::Shadow;
use super::seen::{DRAWN_SIGMA_M, EDGE_SIGMA_M, MeasuredObject, PART_SIGMA};
use super::{Parts, Target, TopShape, echo, parts};
use crate::{Mark, MeasuredShadow, ObjectExtent};
use bathyscope_bottom::calibration::Calibration;
use bathyscope_bottom::first_return::FirstReturns;
use bathyscope_log::support::statistics::median;
use bathyscope_log::survey::{Navigation, PingNav, Relief, Side, SideSpan, Survey};
use std::ops::Range;
use std::sync::OnceLock;

/// Width of a side beam along the track, radians: about a degree at the usual 455 kHz.
const BEAM_RAD: f64 = 0.0157;
/// Slant range, in altitudes, up to which a shadow begins where the echo ends: under the boat, a
/// flat top covers only a few samples, and the dark run follows the echo at once.
const UNDER: f64 = 1.1;
/// Standard deviation of the fitted track about the true one if fixes are rounded to a metre: on a
/// line along the grid, the error is the same all the way.
const FIX_SIGMA_M: f64 = 0.25;
/// Standard deviation of a heading from the fitted track, radians (2 degrees); the share of the
/// change of heading that a turn adds to it; and the number of pings before and behind over which
/// this change is measured.
const HEADING_SIGMA_RAD: f64 = 0.035;
const TURN_SIGMA: f64 = 0.08;
const TURN_PINGS: usize = 20;

/// Returns the slant range in the recorder's scale from which a shadow counts as continuing beyond
/// the range, metres: nobody draws exactly to the last sample.
pub(super) fn reach_m(span: &SideSpan) -> f64 {
    f64::from(span.far_m) - 1.5 * span.metres_per_sample()
}

/// Computes the positions and sizes of boxes of one survey.
pub struct Placer<'a> {
    pub(super) survey: &'a Survey,
    pub(super) navigation: &'a Navigation,
    returns: &'a FirstReturns,
    calibration: &'a Calibration,
    /// Factor for recorded ranges and depths.
    range_factor: f64,
    /// Shape of the bottom across the track.
    pub(super) relief: &'a Relief,
    /// Distance sailed up to each ping, metres. Computed for the first box, since measurements on a
    /// single ping do not need it.
    sailed_m: OnceLock<Vec<f64>>,
}

impl<'a> Placer<'a> {
    /// Creates a placer for the boxes of a survey. `range_factor` is a factor for all ranges and
    /// depths: the true speed of sound over the one that the recorder assumed. The depths of
    /// `relief` must include it.
    pub fn new(
        survey: &'a Survey,
        navigation: &'a Navigation,
        returns: &'a FirstReturns,
        calibration: &'a Calibration,
        range_factor: f64,
        relief: &'a Relief,
    ) -> Self {
        Self {
            survey,
            navigation,
            returns,
            calibration,
            range_factor,
            relief,
            sailed_m: OnceLock::new(),
        }
    }

    /// Returns the position and size of a box's object, with a source of the extent (found, set by
    /// the analyst, or a point, which has no size), a shadow that the analyst has measured, which
    /// determines the height, and the shape of the top for the class. `None` if the boat has no
    /// position or heading there, the side was not recorded, or the altitude is unknown.
    pub fn place(
        &self,
        mark: &Mark,
        extent: ObjectExtent,
        measured: Option<MeasuredShadow>,
        top: TopShape,
    ) -> Option<Target> {
        let middle = self.middle(mark);
        let span = self.survey.span(middle, mark.side)?;
        let altitude_m = self.altitude_over_m(mark.side, mark.pings.clone())?;
        let found = self.parts(mark, extent, span, top);
        // The box begins where the echo begins, and holds more shadow than echo.
        let near_m = self.calibrated_m(span, mark.near_m);
        let altitude_there_m = self.altitude_at_m(mark.side, middle, altitude_m, near_m);
        let altitudes_m = [altitude_m, altitude_there_m];
        let seen = self.seen(mark, extent, found, span, altitudes_m);
        let seen = match measured {
            Some(shadow) => self.with_shadow(seen, mark, shadow),
            None => seen,
        };
        let ground_m = seen.middle_m();
        let boat = self.boat(mark)?;
        let [east_m, north_m] = boat.abeam(mark.side, ground_m)?;
        if !(east_m.is_finite() && north_m.is_finite()) {
            return None;
        }
        let track = &self.survey.track;
        let is_point = extent == ObjectExtent::Point;
        let sized = |size_m: f64| if is_point { f64::NAN } else { size_m };
        let length_m = sized(self.length_m(mark, seen.slant_m(), ground_m));
        let askew_m = heading_sigma_rad(self.navigation, &mark.pings) * ground_m;
        let ends_sigma_m = match extent {
            // Both ends are drawn to within the width of the beam.
            ObjectExtent::Drawn { .. } => BEAM_RAD * seen.slant_m(),
            ObjectExtent::Found | ObjectExtent::Point => PART_SIGMA * length_m.max(0.0),
        };
        let along_sigma_m = askew_m.hypot(ends_sigma_m).hypot(FIX_SIGMA_M);
        let across_sigma_m = seen.across_sigma_m().hypot(FIX_SIGMA_M);
        Some(Target {
            slant_m: seen.slant_m(),
            ground_m,
            altitude_m,
            east_m,
            north_m,
            position: self.navigation.to_lon_lat(track, east_m, north_m),
            length_m,
            width_m: sized(seen.width_m()),
            shadow_m: seen.shadow_m(),
            height_m: seen.height_m(),
            height_sigma_m: seen.height_sigma_m(),
            depth_m: altitude_there_m,
            sigma_m: along_sigma_m.max(across_sigma_m),
            along_sigma_m,
            across_sigma_m,
            heading_rad: boat.heading_rad,
            sailed_m: self.sailed_m().get(middle).copied().unwrap_or(0.0),
            mark: mark.clone(),
            extent,
            measured_shadow: measured,
            parts: found,
        })
    }

    /// Returns the altitude over some pings on a side, metres; `None` if no ping has a known
    /// bottom. The altitude is the median of the bottom edits; without edits, of the recorded
    /// depths where the recorder had bottom lock; without these, of the first returns on this side.
    /// Edits come first, because an analyst who draws the bottom sees the recorder's own.
    pub(super) fn altitude_over_m(&self, side: Side, pings: Range<usize>) -> Option<f64> {
        let (survey, returns) = (self.survey, self.returns);
        let pings = pings.start..pings.end.min(survey.side_scan.len());
        let first_return_m = |ping: usize| {
            let pick = returns.side(side).get(ping)?;
            let span = survey.span(ping, side)?;
            let range_m = self.calibration.range_m(span, f64::from(pick.sample));
            (pick.is_some() && !pick.above_bottom && range_m > 0.0).then_some(range_m)
        };
        let is_drawn = |&ping: &usize| returns.is_drawn(side, ping);
        let drawn = pings.clone().filter(is_drawn).filter_map(first_return_m);
        let mut depths_m: Vec<f64> = drawn.collect();
        if depths_m.is_empty() {
            let recorded = pings.clone();
            let recorded = recorded.map(|ping| f64::from(survey.good_depth_m(ping)));
            depths_m = recorded.filter(|depth_m| *depth_m > 0.0).collect();
        }
        if depths_m.is_empty() {
            depths_m = pings.filter_map(first_return_m).collect();
        }
        let altitude_m = median(&mut depths_m) * self.range_factor;
        (altitude_m > 0.0).then_some(altitude_m)
    }

    /// Returns the height of the transducer above the bottom at a slant range, given the height
    /// above the bottom under the boat.
    pub(super) fn altitude_at_m(
        &self,
        side: Side,
        ping: usize,
        altitude_m: f64,
        range_m: f64,
    ) -> f64 {
        let across = self.relief.across(side, ping);
        altitude_m + across.deeper_m(across.ground_m(altitude_m, range_m))
    }

    /// Converts a slant range in the recorder's scale to one by the current calibration, metres.
    pub(super) fn calibrated_m(&self, span: &SideSpan, recorded_m: f64) -> f64 {
        let sample = span.sample_at(recorded_m);
        self.calibration.range_m(span, sample).max(0.0) * self.range_factor
    }

    /// Returns echo and shadow of a box, as the analyst has set them or as they are found; `None`
    /// for a point.
    fn parts(
        &self,
        mark: &Mark,
        extent: ObjectExtent,
        span: &SideSpan,
        top: TopShape,
    ) -> Option<Parts> {
        match extent {
            ObjectExtent::Point => None,
            ObjectExtent::Drawn { border_m } => {
                Some(echo::set_parts(mark, border_m, reach_m(span)))
            }
            ObjectExtent::Found if echo::is_large(mark, self.sailed_over_m(mark)) => {
                echo::drawn_parts(self.survey, mark)
            }
            ObjectExtent::Found => parts(self.survey, mark, top),
        }
    }

    /// Measures the object in a box.
    fn seen(
        &self,
        mark: &Mark,
        extent: ObjectExtent,
        found: Option<Parts>,
        span: &SideSpan,
        altitudes_m: [f64; 2],
    ) -> MeasuredObject {
        let calibrated = |recorded_m: f64| self.calibrated_m(span, recorded_m);
        if extent == ObjectExtent::Point {
            let range_m = calibrated(0.5 * (mark.near_m + mark.far_m));
            return MeasuredObject::point(altitudes_m, range_m);
        }
        let is_drawn = extent.border_m().is_some();
        let large = echo::is_large(mark, self.sailed_over_m(mark));
        // The box begins where the echo begins, and holds more shadow than echo. Often only one
        // face of the object is bright in the echo.
        let shadow_m = found.and_then(|found| found.shadow_m);
        let far_m = match (&found, shadow_m) {
            (_, Some([start_m, _])) => start_m,
            (Some(found), None) => found.echo_m[1],
            (None, None) => mark.near_m + (mark.far_m - mark.near_m) / 3.0,
        };
        // A range of NaN (no end of the shadow) stays NaN.
        let end =
            |recorded_m: f64| if recorded_m.is_nan() { recorded_m } else { calibrated(recorded_m) };
        let longest = found.and_then(|found| found.longest);
        let [altitude_m, altitude_there_m] = altitudes_m;
        MeasuredObject {
            altitude_m,
            altitude_there_m,
            near_m: calibrated(mark.near_m),
            far_m: calibrated(far_m),
            box_end_m: calibrated(mark.far_m),
            // The echo ends at a shadow, or where someone drew the edges or the box of a large
            // object.
            bounded: large || is_drawn || shadow_m.is_some(),
            edge_sigma_m: if is_drawn { DRAWN_SIGMA_M } else { EDGE_SIGMA_M },
            longest: longest.map(|shadow| {
                let bright_end_m = calibrated(shadow.bright_end_m);
                let start_m = calibrated(shadow.start_m);
                let is_under = !is_drawn && start_m < UNDER * altitude_m;
                Shadow {
                    bright_end_m,
                    start_m: if is_under { bright_end_m } else { start_m },
                    end_m: end(shadow.end_m),
                }
            }),
            spread: found.map_or(0.0, |found| found.spread),
        }
    }

    /// Replaces the shadow of the box by a measured one.
    fn with_shadow(
        &self,
        seen: MeasuredObject,
        mark: &Mark,
        shadow: MeasuredShadow,
    ) -> MeasuredObject {
        let Some(span) = self.survey.span(shadow.ping, mark.side) else {
            return seen;
        };
        let [start_m, last_m] =
            [shadow.top_m, shadow.end_m].map(|range_m| self.calibrated_m(span, range_m));
        let end_m = if shadow.end_m < reach_m(span) { last_m } else { f64::NAN };
        MeasuredObject {
            box_end_m: last_m,
            longest: Some(Shadow { bright_end_m: start_m, start_m, end_m }),
            spread: 0.0,
            ..seen
        }
    }

    /// Returns the distance sailed up to each ping, metres.
    fn sailed_m(&self) -> &[f64] {
        self.sailed_m.get_or_init(|| {
            let (mut sum_m, mut last): (f64, Option<[f64; 2]>) = (0.0, None);
            let pings = self.navigation.pings.iter();
            let sailed = pings.map(|place| {
                if let Some([east_m, north_m]) = last {
                    let step_m = f64::hypot(place.east_m - east_m, place.north_m - north_m);
                    sum_m += if step_m.is_finite() { step_m } else { 0.0 };
                }
                last = Some(place.place());
                sum_m
            });
            sailed.collect()
        })
    }

    /// Returns the distance that the boat sailed over a box, metres.
    fn sailed_over_m(&self, mark: &Mark) -> f64 {
        let at_m = |ping: usize| self.sailed_m().get(ping).copied().unwrap_or(f64::NAN);
        at_m(mark.pings.end.saturating_sub(1)) - at_m(mark.pings.start)
    }

    /// Returns the ping in the middle of a box by distance sailed: over a long box, the speed of
    /// the boat changes.
    fn middle(&self, mark: &Mark) -> usize {
        let count = usize::midpoint(mark.pings.start, mark.pings.end);
        let (first, last) = (mark.pings.start, mark.pings.end.saturating_sub(1));
        let (Some(from_m), Some(way)) =
            (self.sailed_m().get(first), self.sailed_m().get(first..=last))
        else {
            return count;
        };
        let half_m = from_m + 0.5 * self.sailed_over_m(mark);
        if half_m > *from_m {
            first + way.partition_point(|sailed_m| *sailed_m < half_m)
        } else {
            count
        }
    }

    /// Returns the place and heading of the boat in the middle of a box by distance sailed,
    /// interpolated between two pings.
    fn boat(&self, mark: &Mark) -> Option<PingNav> {
        let behind_ping = self.middle(mark).min(mark.pings.end.checked_sub(1)?);
        let before_ping = behind_ping.saturating_sub(1).max(mark.pings.start);
        let before = *self.navigation.pings.get(before_ping)?;
        let behind = self.navigation.pings.get(behind_ping)?;
        let [from_m, to_m] = [before_ping, behind_ping].map(|ping| self.sailed_m()[ping]);
        let half_m = self.sailed_m()[mark.pings.start] + 0.5 * self.sailed_over_m(mark);
        let share =
            if to_m > from_m { ((half_m - from_m) / (to_m - from_m)).clamp(0.0, 1.0) } else { 0.5 };
        let between = |from: f64, to: f64| from + share * (to - from);
        Some(PingNav {
            east_m: between(before.east_m, behind.east_m),
            north_m: between(before.north_m, behind.north_m),
            ..before
        })
    }

    /// Returns the extent along the track at the distance of the object, less the beam's width
    /// there (widths of two blurs are subtracted as squares). In a turn, the beam sweeps slower or
    /// faster there than the boat sails.
    fn length_m(&self, mark: &Mark, slant_m: f64, ground_m: f64) -> f64 {
        let abeam = |ping: usize| self.navigation.pings.get(ping)?.abeam(mark.side, ground_m);
        let ends = abeam(mark.pings.start).zip(abeam(mark.pings.end.saturating_sub(1)));
        let Some(([from_east, from_north], [to_east, to_north])) = ends else {
            return f64::NAN;
        };
        let swept_m = f64::hypot(to_east - from_east, to_north - from_north);
        // The distance from the middle of the first ping to the middle of the last is one ping too
        // short.
        let count = mark.pings.len() as f64;
        let spacing_m = swept_m / (count - 1.0).max(1.0);
        let whole_m = swept_m + spacing_m;
        let beam_m = BEAM_RAD * slant_m;
        (whole_m * whole_m - beam_m * beam_m).max(spacing_m * spacing_m).sqrt()
    }
}

/// Returns the standard deviation of the heading over some pings, radians: in a turn, the line that
/// is fitted to the fixes lags behind.
pub(super) fn heading_sigma_rad(navigation: &Navigation, pings: &Range<usize>) -> f64 {
    HEADING_SIGMA_RAD.hypot(TURN_SIGMA * turn_rad(navigation, pings))
}

/// Returns the change of the heading around some pings, radians, 0 to pi; 0 if it is not known.
fn turn_rad(navigation: &Navigation, pings: &Range<usize>) -> f64 {
    let heading = |ping: usize| navigation.pings.get(ping).map(|place| place.heading_rad);
    let last = navigation.pings.len().saturating_sub(1);
    let from = heading(pings.start.saturating_sub(TURN_PINGS));
    let to = heading((pings.end + TURN_PINGS).min(last));
    let change = from.zip(to).map_or(0.0, |(from, to)| (to - from).cos());
    if change.is_finite() { change.clamp(-1.0, 1.0).acos() } else { 0.0 }
}
