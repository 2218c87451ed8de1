//! What is measured of an object across the track, and how well.
//!
//! The bottom around the boat is taken as flat. With the altitude `H` and a slant range `r`, a point of the bottom lies
//! `sqrt(r^2 - H^2)` beside the track, and one that stands `h` above it `sqrt(r^2 - (H - h)^2)`. A shadow from `r_t` (the far
//! edge of the top) to `r_e` tells `h = H (r_e - r_t) / r_e`.

/// Standard deviation of an edge in range, metres: a pulse is 2 to 5 cm long, and edges are rounded.
const EDGE_SIGMA_M: f64 = 0.05;
/// Standard deviation of the altitude at the object: the bottom is not flat. A share of the altitude.
const ALTITUDE_SIGMA: f64 = 0.05;
/// Share of the echo's extent by which its middle may be off where no shadow ends it, and the extent assumed then at least,
/// metres.
const LOOSE_SIGMA: f64 = 0.25;
const USUAL_WIDTH_M: f64 = 0.6;
/// Height that an object without a shadow may well have, metres. Far out it matters little; near the boat the echo of its
/// top comes from much farther out than the bottom at the same range.
const USUAL_HEIGHT_M: f64 = 0.3;
/// Share of the height by which the top may be higher than the shadow tells: of a round top the ray that ends the shadow
/// touches the far flank.
const ROUND_SIGMA: f64 = 0.08;

/// What is measured of an object, by the calibration in force. Slant ranges and heights in metres.
#[derive(Clone, Copy, Debug)]
pub(super) struct Seen {
    /// Height of the transducer above the bottom.
    pub(super) altitude_m: f64,
    /// Near edge of the echo.
    pub(super) near_m: f64,
    /// Far edge of the echo: where the shadow starts, or the end of what is bright.
    pub(super) far_m: f64,
    /// A shadow ends it.
    pub(super) bounded: bool,
    /// Start and end of the longest shadow; the end is NaN where it runs off the range.
    pub(super) longest_m: Option<[f64; 2]>,
}

impl Seen {
    /// Slant range of the middle of the echo.
    pub(super) fn slant_m(&self) -> f64 {
        0.5 * (self.near_m + self.far_m)
    }

    /// Height above the bottom; NaN without a shadow that ends.
    pub(super) fn height_m(&self) -> f64 {
        self.longest_m.map_or(f64::NAN, |[start_m, end_m]| {
            self.altitude_m * (end_m - start_m) / end_m
        })
    }

    /// Standard deviation of the height: of both ends of the shadow, the altitude, and the round top.
    pub(super) fn height_sigma_m(&self) -> f64 {
        self.longest_m.map_or(f64::NAN, |[start_m, end_m]| {
            let start = self.altitude_m / end_m * EDGE_SIGMA_M;
            let end = start * start_m / end_m;
            let level = ALTITUDE_SIGMA * self.height_m();
            let round = ROUND_SIGMA * self.height_m();
            start.hypot(end).hypot(level).hypot(round)
        })
    }

    /// Extent across the track on the bottom.
    pub(super) fn width_m(&self) -> f64 {
        let [near_m, far_m] = self.ground_m(self.raised_m());
        far_m - near_m
    }

    /// Distance from the track to the middle of the object.
    pub(super) fn middle_m(&self) -> f64 {
        self.middle_raised_m(self.raised_m())
    }

    /// Standard deviation of [`Seen::middle_m`]: how far the middle moves when the edges in range, the altitude and the
    /// height change by theirs. That is far under the boat and little at long range, as `d ground / d slant = slant / ground`.
    pub(super) fn across_sigma_m(&self) -> f64 {
        let here_m = self.middle_m();
        let moved = |change: &dyn Fn(f64) -> f64| {
            let [less_m, more_m] = [-1.0, 1.0].map(change);
            (less_m - here_m).abs().max((more_m - here_m).abs())
        };
        let raised_m = self.raised_m();
        let edges_m = moved(&|sign| {
            let edge_m = sign * EDGE_SIGMA_M;
            let seen = Self {
                near_m: self.near_m + edge_m,
                far_m: self.far_m + edge_m,
                ..*self
            };
            seen.middle_raised_m(raised_m)
        });
        let altitude_m = moved(&|sign| {
            let altitude_m = self.altitude_m * (1.0 + sign * ALTITUDE_SIGMA);
            Self {
                altitude_m,
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
        let loose_m = if self.bounded {
            0.0
        } else {
            LOOSE_SIGMA * self.width_m().max(USUAL_WIDTH_M)
        };
        edges_m.hypot(altitude_m).hypot(height_m).hypot(loose_m)
    }

    fn raised_m(&self) -> f64 {
        let height_m = self.height_m();
        if height_m.is_nan() { 0.0 } else { height_m }
    }

    /// Distances of both edges from the track, of an object so high.
    fn ground_m(&self, raised_m: f64) -> [f64; 2] {
        let below_m = (self.altitude_m - raised_m).max(0.0);
        [self.near_m, self.far_m]
            .map(|range_m| (range_m * range_m - below_m * below_m).max(0.0).sqrt())
    }

    /// Where no shadow tells the far edge, a bright near face may be all that is seen: the object then counts as of the usual
    /// width at least.
    fn middle_raised_m(&self, raised_m: f64) -> f64 {
        let [near_m, far_m] = self.ground_m(raised_m);
        let width_m = if self.bounded {
            far_m - near_m
        } else {
            (far_m - near_m).max(USUAL_WIDTH_M)
        };
        near_m + 0.5 * width_m
    }
}
