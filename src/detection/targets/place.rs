//! From a box to a place on the bottom.
//!
//! The bottom around the boat is taken as flat. With the altitude `H` and a slant range `r`, a point of the bottom lies
//! `sqrt(r^2 - H^2)` beside the track, and one that stands `h` above it `sqrt(r^2 - (H - h)^2)`. A shadow from `r_t` (the far
//! edge of the top) to `r_e` tells `h = H (r_e - r_t) / r_e`.

use super::{Target, parts};
use crate::calibration::Calibration;
use crate::detection::Mark;
use crate::first_return::FirstReturns;
use crate::statistics::median;
use crate::survey::{Navigation, PingNav, Side, SideSpan, Survey};

/// Width of a side beam along the track, radians: about a degree at the usual 455 kHz.
const BEAM_RAD: f64 = 0.0157;
/// Standard deviation of an edge in range, metres: a pulse is 2 to 5 cm long, and edges are rounded.
const EDGE_SIGMA_M: f64 = 0.05;
/// Standard deviation of the altitude at the object: the bottom is not flat. A share of the altitude.
const ALTITUDE_SIGMA: f64 = 0.05;
/// Standard deviation of a heading from the fitted track, radians (2 degrees), and what a turn adds: a share of the change of
/// heading over so many pings before and behind.
const HEADING_SIGMA_RAD: f64 = 0.035;
const TURN_SIGMA: f64 = 0.08;
const TURN_PINGS: usize = 20;
/// Standard deviation of the fitted track about the true one where fixes are rounded to a metre.
const FIX_SIGMA_M: f64 = 0.15;
/// Share of the echo's extent by which its middle may be off where no shadow ends it, and the extent assumed then at least,
/// metres.
const LOOSE_SIGMA: f64 = 0.25;
const USUAL_WIDTH_M: f64 = 0.6;

/// Places boxes of one survey.
pub struct Placer<'a> {
    survey: &'a Survey,
    navigation: &'a Navigation,
    returns: &'a FirstReturns,
    calibration: &'a Calibration,
    /// Distance sailed up to each ping, metres.
    sailed_m: Vec<f64>,
}

impl<'a> Placer<'a> {
    /// Gets ready for the boxes of a survey.
    pub fn new(
        survey: &'a Survey,
        navigation: &'a Navigation,
        returns: &'a FirstReturns,
        calibration: &'a Calibration,
    ) -> Self {
        let mut sailed_m = Vec::with_capacity(navigation.pings.len());
        let (mut sum_m, mut last): (f64, Option<[f64; 2]>) = (0.0, None);
        for place in &navigation.pings {
            if let Some([east_m, north_m]) = last {
                let step_m = f64::hypot(place.east_m - east_m, place.north_m - north_m);
                sum_m += if step_m.is_finite() { step_m } else { 0.0 };
            }
            last = Some([place.east_m, place.north_m]);
            sailed_m.push(sum_m);
        }
        Self {
            survey,
            navigation,
            returns,
            calibration,
            sailed_m,
        }
    }

    /// Where a box's object lies; `None` where the boat has no position or heading there, nothing was recorded, or the
    /// altitude is unknown.
    pub fn place(&self, mark: &Mark) -> Option<Target> {
        let middle = usize::midpoint(mark.pings.start, mark.pings.end);
        let span = self.survey.span(middle, mark.side)?;
        let altitude_m = self.altitude_m(mark)?;
        let seen = self.seen(mark, span, altitude_m);
        let ground_m = seen.middle_m();
        let boat = self.boat(mark)?;
        let [x, y] = boat.starboard()?;
        let out_m = match mark.side {
            Side::Port => -ground_m,
            Side::Starboard => ground_m,
        };
        let (east_m, north_m) = (boat.east_m + x * out_m, boat.north_m + y * out_m);
        if !(east_m.is_finite() && north_m.is_finite()) {
            return None;
        }
        let track = &self.survey.track;
        Some(Target {
            slant_m: seen.slant_m,
            ground_m,
            altitude_m,
            east_m,
            north_m,
            position: self.navigation.to_lon_lat(track, east_m, north_m),
            length_m: self.length_m(mark, seen.slant_m),
            width_m: seen.width_m(),
            height_m: seen.height_m,
            depth_m: altitude_m,
            sigma_m: sigma_m(&seen, ground_m, altitude_m, self.turn_rad(mark)),
            sailed_m: self.sailed_m.get(middle).copied().unwrap_or(0.0),
            mark: mark.clone(),
        })
    }

    /// The recorded depth over the box where the recorder had the bottom, else the first return on its side.
    fn altitude_m(&self, mark: &Mark) -> Option<f64> {
        let pings = mark.pings.start..mark.pings.end.min(self.survey.side_scan.len());
        let locked = |ping| f64::from(self.survey.locked_depth_m(ping));
        let mut depths_m: Vec<f64> = pings
            .clone()
            .map(locked)
            .filter(|depth_m| *depth_m > 0.0)
            .collect();
        if depths_m.is_empty() {
            let picks = self.returns.side(mark.side);
            depths_m = pings
                .filter_map(|ping| {
                    let pick = picks
                        .get(ping)
                        .filter(|pick| pick.is_some() && !pick.canopy)?;
                    let span = self.survey.span(ping, mark.side)?;
                    Some(self.calibration.range_m(span, f64::from(pick.sample)))
                })
                .filter(|depth_m| *depth_m > 0.0)
                .collect();
        }
        let altitude_m = median(&mut depths_m);
        (altitude_m > 0.0).then_some(altitude_m)
    }

    /// What is seen of the object in a box.
    fn seen(&self, mark: &Mark, span: &SideSpan, altitude_m: f64) -> Seen {
        let calibrated = |recorded_m: f64| {
            let sample = span.sample_at(recorded_m);
            self.calibration.range_m(span, sample).max(0.0)
        };
        let found = parts(self.survey, mark);
        // The box begins where the echo does, and holds more shadow than echo. Of the echo itself often one face is bright.
        let near_m = calibrated(mark.near_m);
        let mut far_m = calibrated(match &found {
            Some(found) => found.echo_m[1],
            None => mark.near_m + (mark.far_m - mark.near_m) / 3.0,
        });
        let shadow = found.and_then(|found| found.shadow_m);
        let shadow = shadow.map(|[start_m, end_m]| {
            let end_m = if end_m.is_nan() {
                end_m
            } else {
                calibrated(end_m)
            };
            [calibrated(start_m), end_m]
        });
        let mut height_m = f64::NAN;
        if let Some([start_m, end_m]) = shadow {
            far_m = start_m;
            height_m = altitude_m * (end_m - start_m) / end_m;
        }
        let raised_m = if height_m.is_nan() { 0.0 } else { height_m };
        let below_m = (altitude_m - raised_m).max(0.0);
        let ground = |range_m: f64| (range_m * range_m - below_m * below_m).max(0.0).sqrt();
        Seen {
            slant_m: 0.5 * (near_m + far_m),
            ground_m: [ground(near_m), ground(far_m)],
            height_m,
            bounded: shadow.is_some(),
        }
    }

    /// The boat in the middle of the box, between two pings where the middle lies there.
    fn boat(&self, mark: &Mark) -> Option<PingNav> {
        let last = mark.pings.end.checked_sub(1)?;
        let before = *self.navigation.pings.get((mark.pings.start + last) / 2)?;
        let behind = *self
            .navigation
            .pings
            .get((mark.pings.start + last).div_ceil(2))?;
        Some(PingNav {
            east_m: 0.5 * (before.east_m + behind.east_m),
            north_m: 0.5 * (before.north_m + behind.north_m),
            ..before
        })
    }

    /// Change of the heading around the box, 0 to pi; 0 where it is not known.
    fn turn_rad(&self, mark: &Mark) -> f64 {
        let heading = |ping: usize| {
            self.navigation
                .pings
                .get(ping)
                .map(|place| place.heading_rad)
        };
        let last = self.navigation.pings.len().saturating_sub(1);
        let from = heading(mark.pings.start.saturating_sub(TURN_PINGS));
        let to = heading((mark.pings.end + TURN_PINGS).min(last));
        let change = from.zip(to).map_or(0.0, |(from, to)| (to - from).cos());
        if change.is_finite() {
            change.clamp(-1.0, 1.0).acos()
        } else {
            0.0
        }
    }

    /// Distance sailed over the box, with the beam's width there taken off (as widths of two blurs are).
    fn length_m(&self, mark: &Mark, slant_m: f64) -> f64 {
        let count = mark.pings.len() as f64;
        let last = mark.pings.end.saturating_sub(1);
        let ends = (self.sailed_m.get(mark.pings.start), self.sailed_m.get(last));
        let (Some(from_m), Some(to_m)) = ends else {
            return f64::NAN;
        };
        // From the middle of the first ping to that of the last is one ping too little.
        let spacing_m = (to_m - from_m) / (count - 1.0).max(1.0);
        let sailed_m = to_m - from_m + spacing_m;
        let beam_m = BEAM_RAD * slant_m;
        (sailed_m * sailed_m - beam_m * beam_m)
            .max(spacing_m * spacing_m)
            .sqrt()
    }
}

/// What is seen of an object, by the calibration in force.
struct Seen {
    slant_m: f64,
    /// Near and far edge, distances from the track on the bottom.
    ground_m: [f64; 2],
    height_m: f64,
    /// A shadow ends it.
    bounded: bool,
}

impl Seen {
    /// Extent across the track on the bottom.
    fn width_m(&self) -> f64 {
        self.ground_m[1] - self.ground_m[0]
    }

    /// Distance from the track to the middle of the object. Where no shadow tells its far edge, a bright near face may be all
    /// that is seen: it then counts as of the usual width at least.
    fn middle_m(&self) -> f64 {
        let width_m = if self.bounded {
            self.width_m()
        } else {
            self.width_m().max(USUAL_WIDTH_M)
        };
        self.ground_m[0] + 0.5 * width_m
    }
}

/// The position's standard deviation, the larger of along and across the track, with that of the fixes: along it the heading
/// times the distance; across it how far the place moves when the edges in range and the altitude change by theirs (far under
/// the boat, little at long range).
fn sigma_m(seen: &Seen, ground_m: f64, altitude_m: f64, turn_rad: f64) -> f64 {
    let beside_m = |range_m: f64, altitude_m: f64| {
        (range_m * range_m - altitude_m * altitude_m)
            .max(0.0)
            .sqrt()
    };
    let here_m = beside_m(seen.slant_m, altitude_m);
    let [mut edge_sigma_m, mut altitude_sigma_m] = [0.0_f64; 2];
    for sign in [-1.0, 1.0] {
        let edge_m = beside_m(seen.slant_m + sign * EDGE_SIGMA_M, altitude_m);
        let altitude_m = beside_m(seen.slant_m, altitude_m * (1.0 + sign * ALTITUDE_SIGMA));
        edge_sigma_m = edge_sigma_m.max((edge_m - here_m).abs());
        altitude_sigma_m = altitude_sigma_m.max((altitude_m - here_m).abs());
    }
    if !seen.bounded {
        edge_sigma_m += LOOSE_SIGMA * seen.width_m().max(USUAL_WIDTH_M);
    }
    let across_m = edge_sigma_m.hypot(altitude_sigma_m);
    let along_m = HEADING_SIGMA_RAD.hypot(TURN_SIGMA * turn_rad) * ground_m;
    across_m.max(along_m).hypot(FIX_SIGMA_M)
}
