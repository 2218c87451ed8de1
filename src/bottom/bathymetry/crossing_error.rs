//! Estimates the error of a depth from the differences between two passes where they cross.

use super::crosslines::{Crossing, TrackDepth};
use bathyscope_log::support::statistics::{SIGMA_PER_MAD, median_of, sigma_of_sizes, sorted};
use serde::Serialize;

/// Fewest crossings from which the part that grows with the slope is estimated.
const FEWEST: usize = 6;
/// Rounds of the iteration that separates the two parts.
const ROUNDS: usize = 4;

/// Standard deviation of a depth, estimated from crossings. One part is the same everywhere, for
/// example because of waves or the water level. The other part grows with the slope of the bottom,
/// for example because of errors of positions, delays and wide beams. From `FEWEST` crossings on,
/// the noise from one sounding to the next is removed, because the map averages it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct CrossingError {
    /// Part on a level bottom, metres.
    pub level_m: f64,
    /// Part that is proportional to the slope: its size at a slope of 1, metres; 0 where the
    /// crossings do not determine it.
    pub per_slope_m: f64,
}

impl CrossingError {
    /// Returns the error that the crossings of `tracks` show; `None` if no crossing has a known
    /// difference. Each of the two passes is taken to have half of the variance of the difference.
    pub fn of(crossings: &[Crossing], tracks: &[Vec<TrackDepth>]) -> Option<Self> {
        let slope =
            |crossing: &Crossing| if crossing.slope().is_nan() { 0.0 } else { crossing.slope() };
        let size_m = |crossing: &Crossing| crossing.difference_m().abs() / 2f64.sqrt();
        let mut both: Vec<[f64; 2]> =
            crossings.iter().map(|crossing| [slope(crossing), size_m(crossing)]).collect();
        both.retain(|[slope, size_m]| slope.is_finite() && size_m.is_finite());
        if both.is_empty() {
            return None;
        }
        if both.len() < FEWEST {
            let squares: f64 = both.iter().map(|[_, size_m]| size_m * size_m).sum();
            return Some(Self { level_m: (squares / both.len() as f64).sqrt(), per_slope_m: 0.0 });
        }
        both.sort_unstable_by(|a, b| a[0].total_cmp(&b[0]));
        let (gentle, steep) = both.split_at(both.len() / 2);
        let square = |half: &[[f64; 2]]| {
            sigma_of_sizes(&sorted(half.iter().map(|[_, size_m]| *size_m))).powi(2)
        };
        let slopes = |half: &[[f64; 2]]| {
            half.iter().map(|[slope, _]| slope * slope).sum::<f64>() / half.len() as f64
        };
        let (gentle_m2, steep_m2) = (square(gentle), square(steep));
        let (mut level_m2, mut per_slope_m2) = (gentle_m2, 0.0);
        for _ in 0..ROUNDS {
            per_slope_m2 = ((steep_m2 - level_m2) / slopes(steep).max(f64::MIN_POSITIVE)).max(0.0);
            level_m2 = (gentle_m2 - per_slope_m2 * slopes(gentle)).max(0.0);
        }
        // A bed that is level everywhere does not determine the part for slopes.
        let is_told = slopes(steep) > LEAST_SLOPE * LEAST_SLOPE;
        let noises_m2 = tracks.iter().map(|track| noise_m(track).powi(2));
        let noise_m2 = noises_m2.sum::<f64>() / tracks.len().max(1) as f64;
        Some(Self {
            level_m: (level_m2 - noise_m2).max(0.0).sqrt(),
            per_slope_m: if is_told { per_slope_m2.sqrt() } else { 0.0 },
        })
    }

    /// Returns the standard deviation at a slope, metres.
    pub fn at(&self, slope: f64) -> f64 {
        self.level_m.hypot(self.per_slope_m * slope)
    }
}

/// Least slope from which the part for slopes is estimated: the root mean square over the steeper
/// half of the crossings.
const LEAST_SLOPE: f64 = 0.03;

/// Returns the standard deviation of the noise from one depth of a track to the next, metres; 0 for
/// fewer than three depths. Each depth is compared with the mean of its two neighbours, which has
/// half of the variance of a single depth, so that the difference has 1.5 times this variance.
fn noise_m(track: &[TrackDepth]) -> f64 {
    let off = |three: &[TrackDepth]| {
        (three[1].depth_m - 0.5 * (three[0].depth_m + three[2].depth_m)).abs()
    };
    let off_m = median_of(track.windows(3).map(off));
    if track.len() < 3 { 0.0 } else { SIGMA_PER_MAD * off_m / 1.5f64.sqrt() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bathymetry::crosslines::CrosslinePass;
    use crate::bathymetry::testing::random;

    /// Returns the error found from 400 crossings on slopes from 0 to 0.6, whose passes have errors
    /// of `level_m` and of `per_slope_m` times the slope.
    fn found(level_m: f64, per_slope_m: f64) -> CrossingError {
        let mut random = random();
        let mut normal = move || (0..12).map(|_| random()).sum::<f64>() - 6.0;
        let crossings: Vec<Crossing> = (0..400)
            .map(|index| {
                let slope = 0.6 * f64::from(index) / 400.0;
                let pass = |error_m: f64| CrosslinePass {
                    track: 0,
                    time_s: 0.0,
                    depth_m: 5.0 + error_m,
                    velocity_mps: [0.0; 2],
                };
                let mut error_m = || level_m * normal() + per_slope_m * slope * normal();
                let passes = [pass(error_m()), pass(error_m())];
                Crossing { place: [0.0; 2], passes, angle_deg: 90.0, gradient: [slope, 0.0] }
            })
            .collect();
        CrossingError::of(&crossings, &[]).unwrap()
    }

    #[test]
    fn the_two_parts_are_told_apart() {
        let waves = found(0.1, 0.0);
        assert!((waves.level_m - 0.1).abs() < 0.015 && waves.per_slope_m < 0.15, "{waves:?}");
        let late = found(0.02, 1.0);
        assert!(late.level_m < 0.08 && (late.per_slope_m - 1.0).abs() < 0.15, "{late:?}");
        assert!((late.at(0.5) - 0.5).abs() < 0.08);
    }

    #[test]
    fn no_crossings_say_nothing() {
        assert_eq!(CrossingError::of(&[], &[]), None);
    }

    #[test]
    fn noise_of_soundings_is_that_about_their_neighbours() {
        let mut random = random();
        let mut normal = move || (0..12).map(|_| random()).sum::<f64>() - 6.0;
        let depth = |index| {
            let along_m = 0.1 * f64::from(index);
            TrackDepth::new(along_m, [along_m, 0.0], 3.0 + 0.3 * along_m + 0.02 * normal())
        };
        let track: Vec<TrackDepth> = (0..2000).map(depth).collect();
        assert!((noise_m(&track) - 0.02).abs() < 0.002);
    }
}
