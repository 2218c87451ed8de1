//! Measures an object across the track, and computes the standard deviations.
//!
//! With the height `V` of the transducer above the bottom at the object and a slant range `r`, a
//! point of the bottom is `sqrt(r^2 - V^2)` across-track, and a point at height `h` above the
//! bottom is `sqrt(r^2 - (V - h)^2)` across-track. From a shadow from `r_t` (the far edge of the
//! top) to `r_e` follows `h = H (r_e - r_t) / r_e` with the altitude `H` under the boat, on a level
//! bottom and on one that slopes evenly.

use super::echo::Shadow;

/// Standard deviation of an edge in range, metres: a pulse is 2 to 5 cm long, and edges are
/// rounded.
pub(super) const EDGE_SIGMA_M: f64 = 0.05;
/// Standard deviation of an edge that is drawn by hand, metres: the eye adds about another 5 cm,
/// the size of a speckle.
pub(super) const DRAWN_SIGMA_M: f64 = 0.07;
/// Standard deviation of the altitude at the object, as a share of the altitude: the bottom is not
/// flat.
pub(super) const ALTITUDE_SIGMA: f64 = 0.05;
/// Standard deviation of the slope of the bottom between the object and the end of its shadow: 2
/// degrees.
pub(super) const SLOPE_SIGMA: f64 = 0.035;
/// Standard deviation of the middle of an echo that no shadow ends, as a share of its extent; and
/// the least extent that is then assumed, metres.
const LOOSE_SIGMA: f64 = 0.25;
const USUAL_WIDTH_M: f64 = 0.6;
/// Height that an object without a shadow may have, metres. It matters little at long range; near
/// the boat, a top at some slant range is much farther out than the bottom at the same slant range.
const USUAL_HEIGHT_M: f64 = 0.3;
/// Least ground range that is used, as a share of the slant range: below it, a shadow gives no
/// height.
const STEEPEST: f64 = 0.2;
/// Standard deviation of the middle of the echo about that of the object, as a share of the extent.
pub(super) const PART_SIGMA: f64 = 0.15;

/// Measurements of an object by the current calibration. Slant ranges and heights in metres.
#[derive(Clone, Copy, Debug)]
pub(super) struct MeasuredObject {
    /// Height of the transducer above the bottom under the boat.
    pub(super) altitude_m: f64,
    /// Height of the transducer above the bottom at the object.
    pub(super) altitude_there_m: f64,
    /// Near edge of the echo.
    pub(super) near_m: f64,
    /// Far edge of the echo: where the shadow starts, or the end of the bright run.
    pub(super) far_m: f64,
    /// True if a shadow, or an edge drawn by hand, ends the echo.
    pub(super) bounded: bool,
    /// Far edge of the box, which was drawn as the end of the shadow.
    pub(super) box_end_m: f64,
    /// Standard deviation of an edge in range.
    pub(super) edge_sigma_m: f64,
    /// Longest shadow; `None` without a shadow.
    pub(super) longest: Option<Shadow>,
    /// Standard deviation of the shadows of neighbouring pings, as shares of the altitude.
    pub(super) spread: f64,
}

impl MeasuredObject {
    /// Creates the measurements of a point, which has no size.
    pub(super) fn point([altitude_m, altitude_there_m]: [f64; 2], range_m: f64) -> Self {
        Self {
            altitude_m,
            altitude_there_m,
            near_m: range_m,
            far_m: range_m,
            bounded: true,
            box_end_m: range_m,
            edge_sigma_m: DRAWN_SIGMA_M,
            longest: None,
            spread: 0.0,
        }
    }

    /// Returns start and end of the longest shadow; NaN without a shadow.
    pub(super) fn shadow_m(&self) -> [f64; 2] {
        let shadow = self.longest.map(|shadow| [shadow.start_m, shadow.end_m]);
        shadow.unwrap_or([f64::NAN; 2])
    }

    /// Returns the slant range of the middle of the echo.
    pub(super) fn slant_m(&self) -> f64 {
        0.5 * (self.near_m + self.far_m)
    }

    /// Returns the height above the bottom; NaN without a shadow that ends.
    pub(super) fn height_m(&self) -> f64 {
        self.longest.map_or(f64::NAN, |shadow| {
            self.altitude_m * (shadow.end_m - shadow.start_m) / shadow.end_m
        })
    }

    /// Returns the standard deviation of the height, due to both ends of the shadow, the altitude,
    /// the slope, the shape, and the differences between the shadows of neighbouring pings.
    ///
    /// The shadow starts somewhere between the bright run and the dark run. The deviation of its
    /// end includes half of the difference between its end and that of the box. The last ray over a
    /// round top touches its far flank: on a half ball, this is at `ground / slant` of the height
    /// of the top; on a flat top, at the full height. The shape of the top is not known; under the
    /// boat, where the ray comes from above, this makes most of the height uncertain.
    pub(super) fn height_sigma_m(&self) -> f64 {
        self.longest.map_or(f64::NAN, |shadow| {
            let Shadow { bright_end_m, start_m, end_m } = shadow;
            let height_m = self.height_m();
            // The standard deviation of an even distribution is its width over the root of 12.
            let start_sigma_m = self.edge_sigma_m.hypot((start_m - bright_end_m) / 12f64.sqrt());
            let end_sigma_m = self.edge_sigma_m.hypot(0.5 * (self.box_end_m - end_m));
            let start = self.altitude_m / end_m * start_sigma_m;
            let end = self.altitude_m * start_m / (end_m * end_m) * end_sigma_m;
            let ground_m = across_m(end_m, self.altitude_there_m);
            let shadow_m = ground_m - across_m(start_m, self.altitude_there_m - height_m);
            let flank = 0.5 * (end_m / ground_m.max(STEEPEST * end_m) - 1.0);
            start
                .hypot(end)
                .hypot(ALTITUDE_SIGMA * height_m)
                .hypot(SLOPE_SIGMA * shadow_m)
                .hypot(flank * height_m)
                .hypot(self.altitude_m * self.spread)
        })
    }

    /// Returns the extent across the track on the bottom.
    pub(super) fn width_m(&self) -> f64 {
        let [near_m, far_m] = self.ground_m(self.raised_m());
        far_m - near_m
    }

    /// Returns the distance from the track to the middle of the object.
    pub(super) fn middle_m(&self) -> f64 {
        self.middle_raised_m(self.raised_m())
    }

    /// Returns the standard deviation of [`MeasuredObject::middle_m`]: how far the middle moves
    /// when the edges in range, the altitude and the height change by their standard deviations.
    /// The middle moves far under the boat and little at long range, as `d ground / d slant = slant
    /// / ground`.
    pub(super) fn across_sigma_m(&self) -> f64 {
        let here_m = self.middle_m();
        let moved = |change: &dyn Fn(f64) -> f64| {
            let [less_m, more_m] = [-1.0, 1.0].map(change);
            (less_m - here_m).abs().max((more_m - here_m).abs())
        };
        let raised_m = self.raised_m();
        let edges_m = moved(&|sign| {
            let edge_m = sign * self.edge_sigma_m;
            let seen = Self { near_m: self.near_m + edge_m, far_m: self.far_m + edge_m, ..*self };
            seen.middle_raised_m(raised_m)
        });
        let altitude_m = moved(&|sign| {
            let factor = 1.0 + sign * ALTITUDE_SIGMA;
            Self {
                altitude_m: self.altitude_m * factor,
                altitude_there_m: self.altitude_there_m * factor,
                ..*self
            }
            .middle_raised_m(raised_m)
        });
        let height_sigma_m = self.height_sigma_m();
        let height_m = moved(&|sign| {
            let other_m = if height_sigma_m.is_nan() {
                USUAL_HEIGHT_M
            } else {
                raised_m + sign * height_sigma_m
            };
            self.middle_raised_m(other_m)
        });
        let loose_m =
            if self.bounded { 0.0 } else { LOOSE_SIGMA * self.width_m().max(USUAL_WIDTH_M) };
        let part_m = PART_SIGMA * self.width_m();
        edges_m.hypot(altitude_m).hypot(height_m).hypot(loose_m).hypot(part_m)
    }

    fn raised_m(&self) -> f64 {
        let height_m = self.height_m();
        if height_m.is_nan() { 0.0 } else { height_m }
    }

    /// Returns the distances of both edges from the track, for an object of a height, metres.
    fn ground_m(&self, raised_m: f64) -> [f64; 2] {
        let below_m = (self.altitude_there_m - raised_m).max(0.0);
        [self.near_m, self.far_m].map(|range_m| across_m(range_m, below_m))
    }

    /// Returns the distance from the track to the middle of an object of a height, metres. If no
    /// shadow shows the far edge, possibly only a bright near face is visible: the object then
    /// counts as having at least the usual width.
    fn middle_raised_m(&self, raised_m: f64) -> f64 {
        let [near_m, far_m] = self.ground_m(raised_m);
        let width_m =
            if self.bounded { far_m - near_m } else { (far_m - near_m).max(USUAL_WIDTH_M) };
        near_m + 0.5 * width_m
    }
}

/// Returns the distance across the track of a place at a slant range, given how far the place lies
/// below the transducer, metres; 0 for a place nearer than that.
pub(super) fn across_m(range_m: f64, below_m: f64) -> f64 {
    (range_m * range_m - below_m * below_m).max(0.0).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Creates a block 0.5 m high and 0.6 m wide, from `ground_m` across-track on, on a bottom 2.5
    /// m below the transducer, with its shadow.
    fn block(ground_m: f64) -> MeasuredObject {
        let back_m = ground_m + 0.6;
        let shadow_end_m = back_m * 2.5 / 2.0;
        let start_m = back_m.hypot(2.0);
        let end_m = shadow_end_m.hypot(2.5);
        MeasuredObject {
            altitude_m: 2.5,
            altitude_there_m: 2.5,
            near_m: ground_m.hypot(2.0),
            far_m: start_m,
            box_end_m: end_m,
            edge_sigma_m: EDGE_SIGMA_M,
            bounded: true,
            longest: Some(Shadow { bright_end_m: start_m, start_m, end_m }),
            spread: 0.0,
        }
    }

    #[test]
    fn a_block_stands_where_it_is_as_high_as_it_is() {
        for ground_m in [0.5, 2.0, 6.0, 12.0] {
            let seen = block(ground_m);
            assert!((seen.height_m() - 0.5).abs() < 1e-9, "{seen:?}");
            assert!((seen.middle_m() - ground_m - 0.3).abs() < 1e-9, "{seen:?}");
            assert!((seen.width_m() - 0.6).abs() < 1e-9, "{seen:?}");
        }
    }

    #[test]
    fn what_lies_below_or_is_not_sharp_is_less_certain() {
        let [below, beside] = [0.2, 5.0].map(block);
        assert!(below.across_sigma_m() > 2.0 * beside.across_sigma_m());
        assert!(below.height_sigma_m() > 2.0 * beside.height_sigma_m());
        let mut other = beside;
        other.box_end_m += 0.6;
        // Half of 0.6 m, times `H start / end^2`.
        let Shadow { start_m, end_m, .. } = beside.longest.expect("a shadow");
        let more_m = 0.3 * 2.5 * start_m / (end_m * end_m);
        let expected_m = beside.height_sigma_m().hypot(more_m);
        assert!((other.height_sigma_m() - expected_m).abs() < 1e-9);
        // Without a shadow, the height and the far edge of the object are guesses.
        other.longest = None;
        other.bounded = false;
        assert!(other.height_m().is_nan() && other.height_sigma_m().is_nan());
        assert!(other.across_sigma_m() > 1.3 * beside.across_sigma_m());
    }

    #[test]
    fn a_point_lies_where_its_ray_meets_the_bottom_and_has_no_height() {
        let point = MeasuredObject::point([3.0; 2], 5.0);
        assert!((point.middle_m() - 4.0).abs() < 1e-12);
        assert!(point.height_m().is_nan() && point.shadow_m()[0].is_nan());
        assert!(point.across_sigma_m() > 0.0);
        // Nearer to the boat, the same slant range determines the place less well.
        assert!(MeasuredObject::point([3.0; 2], 3.2).across_sigma_m() > point.across_sigma_m());
    }

    #[test]
    fn an_edge_drawn_by_hand_is_a_little_less_certain() {
        let mut drawn = block(6.0);
        let found_m = drawn.height_sigma_m();
        drawn.edge_sigma_m = DRAWN_SIGMA_M;
        assert!(drawn.height_sigma_m() > found_m);
    }
}
