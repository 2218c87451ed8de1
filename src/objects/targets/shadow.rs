//! Computes the height of the object that casts a shadow which the analyst measures on one ping.

use super::place::{Placer, reach_m};
use super::seen::{ALTITUDE_SIGMA, EDGE_SIGMA_M, SLOPE_SIGMA, across_m};
use bathyscope_log::survey::Side;

/// Number of pings to either side of the measured one over which the altitude is the median: a fish
/// or a lost pick must not change the height.
const ALTITUDE_PINGS: usize = 6;

/// A shadow across one ping, and the height that follows from it: `h = H (r_e - r_t) / r_e`, exact
/// on a level bottom and on one that slopes evenly.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShadowHeight {
    /// Height of the transducer above the bottom, `H`, metres.
    pub altitude_m: f64,
    /// Slant range of the top, where the shadow begins, `r_t`, metres.
    pub top_m: f64,
    /// Slant range of the shadow's end, `r_e`, metres.
    pub end_m: f64,
    /// Slant range of one sample, metres.
    pub sample_m: f64,
    /// True if the shadow was measured to the last sample of the ping and may continue: the height
    /// is then a lower limit.
    pub is_least: bool,
}

/// Reason why a shadow has no height.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ShadowError {
    /// The ping has no samples on that side.
    #[error("nothing was recorded there")]
    NotRecorded,
    /// Neither a depth nor a first return is known near the ping.
    #[error("the altitude of the transducer is not known there: draw the bottom (M)")]
    NoAltitude,
    /// The shadow ends nearer than the bottom, in the water column.
    #[error("the shadow ends in the water column: its end lies on the bottom")]
    InWater,
    /// Both ends of the shadow are at the same range.
    #[error("the shadow has no length")]
    NoLength,
}

impl ShadowHeight {
    /// Returns the height above the bottom, `h`, metres.
    pub fn height_m(&self) -> f64 {
        self.altitude_m * (self.end_m - self.top_m) / self.end_m
    }

    /// Returns the standard deviation of the height, metres, due to both ends of the shadow (the
    /// width of a pulse and a sample), an altitude error of 5 %, and a bottom that slopes by 2
    /// degrees between the object and the end of its shadow.
    pub fn sigma_m(&self) -> f64 {
        // The standard deviation of an even distribution is its width over the root of 12.
        let edge_sigma_m = EDGE_SIGMA_M.hypot(self.sample_m / 12f64.sqrt());
        let top = self.altitude_m / self.end_m * edge_sigma_m;
        let end = self.altitude_m * self.top_m / (self.end_m * self.end_m) * edge_sigma_m;
        let [top_m, end_m] = self.ground_m();
        top.hypot(end).hypot(ALTITUDE_SIGMA * self.height_m()).hypot(SLOPE_SIGMA * (end_m - top_m))
    }

    /// Returns the distances from the track, on a level bottom, of the object's top and of the
    /// shadow's end, metres.
    pub fn ground_m(&self) -> [f64; 2] {
        let below_m = self.altitude_m - self.height_m();
        [across_m(self.top_m, below_m), across_m(self.end_m, self.altitude_m)]
    }
}

impl Placer<'_> {
    /// Converts a ping and a slant range in the recorder's scale to a place on the bottom, metres
    /// east and north. `None` if the boat has no position or heading, or the side was not recorded.
    /// In the water column, the place is that of the boat.
    pub fn ground(&self, side: Side, ping: usize, recorded_m: f64) -> Option<[f64; 2]> {
        let slant_m = self.calibrated_m(self.survey.span(ping, side)?, recorded_m);
        let near = ping.saturating_sub(ALTITUDE_PINGS)..ping + ALTITUDE_PINGS + 1;
        let altitude_m = self.altitude_over_m(side, near).unwrap_or(0.0);
        let ground_m = self.relief.across(side, ping).ground_m(altitude_m, slant_m);
        let place = self.navigation.pings.get(ping)?.abeam(side, ground_m)?;
        place.iter().all(|metres| metres.is_finite()).then_some(place)
    }

    /// Computes the height of the object that casts a shadow between two slant ranges of a ping,
    /// given in the recorder's scale in either order.
    ///
    /// # Errors
    /// When no height follows from the shadow: see [`ShadowError`].
    pub fn shadow_height(
        &self,
        side: Side,
        ping: usize,
        recorded_m: [f64; 2],
    ) -> Result<ShadowHeight, ShadowError> {
        let span = self.survey.span(ping, side).ok_or(ShadowError::NotRecorded)?;
        let near = ping.saturating_sub(ALTITUDE_PINGS)..ping + ALTITUDE_PINGS + 1;
        let altitude_m = self.altitude_over_m(side, near);
        let altitude_m = altitude_m.ok_or(ShadowError::NoAltitude)?;
        let [one, other] = recorded_m;
        let far_m = span.range_m(f64::from(span.count));
        let [top_m, end_m] = [one.min(other), one.max(other)]
            .map(|range_m| self.calibrated_m(span, range_m.min(far_m)));
        let before_m = span.range_m(f64::from(span.count) - 1.0);
        let sample_m = self.calibrated_m(span, far_m) - self.calibrated_m(span, before_m);
        if end_m <= altitude_m {
            return Err(ShadowError::InWater);
        }
        if end_m - top_m < 0.5 * sample_m {
            return Err(ShadowError::NoLength);
        }
        Ok(ShadowHeight {
            altitude_m,
            top_m,
            end_m,
            sample_m,
            is_least: one.max(other) >= reach_m(span),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `H`, ground range of the top, height; slant ranges of the top and of the shadow's end:
    /// golden values of the usual formula, computed from the geometry.
    const GOLDEN: [[f64; 5]; 4] = [
        [3.0, 6.0, 0.5, 6.5, 7.8],
        [3.0, 6.0, 1.0, 6.3246, 9.4868],
        [2.3, 8.0, 0.3, 8.2462, 9.4831],
        [10.0, 30.0, 2.0, 31.0483, 38.8104],
    ];

    fn shadow([altitude_m, _, _, top_m, end_m]: [f64; 5]) -> ShadowHeight {
        ShadowHeight { altitude_m, top_m, end_m, sample_m: 0.0085, is_least: false }
    }

    #[test]
    fn the_height_is_that_of_the_geometry() {
        for golden in GOLDEN {
            let [_, ground_m, height_m, ..] = golden;
            let shadow = shadow(golden);
            assert!((shadow.height_m() - height_m).abs() < 5e-5, "{golden:?}");
            let [top_m, end_m] = shadow.ground_m();
            assert!((top_m - ground_m).abs() < 2e-3, "{golden:?}: {top_m}");
            // The same formula with the distances on the bottom.
            let by_ground_m = shadow.altitude_m * (end_m - top_m) / end_m;
            assert!((by_ground_m - height_m).abs() < 1e-3, "{golden:?}");
        }
    }

    #[test]
    fn the_standard_deviation_holds_what_the_ends_and_the_altitude_change() {
        let here = shadow(GOLDEN[0]);
        // A shadow that is 10 cm longer makes the object 3.2 cm higher, an altitude that is 11.6 cm
        // less makes it 1.9 cm lower.
        let longer = ShadowHeight { end_m: here.end_m + 0.1, ..here };
        assert!((longer.height_m() - here.height_m() - 0.032).abs() < 5e-4);
        let lower = ShadowHeight { altitude_m: here.altitude_m - 0.116, ..here };
        assert!((lower.height_m() - here.height_m() + 0.019).abs() < 5e-4);
        let ends_m = 0.05 * (3.0 / 7.8) * f64::hypot(1.0, 6.5 / 7.8);
        let [top_m, end_m] = here.ground_m();
        let expected_m = ends_m.hypot(0.05 * 0.5).hypot(0.035 * (end_m - top_m));
        assert!((here.sigma_m() - expected_m).abs() < 5e-4, "{}", here.sigma_m());
        let blurred = ShadowHeight { sample_m: 0.5, ..here };
        assert!(blurred.sigma_m() > 1.3 * here.sigma_m());
    }
}
