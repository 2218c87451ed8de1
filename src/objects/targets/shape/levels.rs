//! Extracts the levels that one pass recorded around a box.

use super::super::Placer;
use super::super::profile::{BackgroundLevels, RangeSteps};
use super::super::seen::across_m;
use crate::Mark;
use bathyscope_log::support::statistics::median;
use std::ops::Range;

/// Levels around a box, and the places from which they were recorded (a look). Slant ranges are by
/// the current calibration, metres.
#[derive(Clone, Debug)]
pub struct BoxLevels {
    /// Height of the transducer above the bottom.
    pub(super) altitude_m: f64,
    /// Near edge of the first bin, and width of every bin, in the recorder's scale.
    pub(super) recorded_m: [f64; 2],
    /// Near edge of the first bin, width of every bin, and number of bins, by the current
    /// calibration.
    pub(super) from_m: f64,
    pub(super) step_m: f64,
    pub(super) bins: usize,
    /// Mean distance between two neighbouring pings of the look, metres.
    pub(super) ping_m: f64,
    /// Pings in order; neighbouring ones are averaged if there are many.
    pub(super) pings: Vec<PingLevels>,
    /// Mean square of a level where there is no object.
    pub(super) noise: f64,
    /// Number of levels of the full picture in the mean that one level here is.
    pub(super) together: usize,
}

/// A ping of a look, or the mean of several.
#[derive(Clone, Debug)]
pub(super) struct PingLevels {
    /// Index of the ping; of several averaged pings, the middle one.
    pub(super) ping: usize,
    /// Point on the bottom from which ranges are measured, metres east and north: under the boat if
    /// the bottom is level.
    pub(super) boat_m: [f64; 2],
    /// Unit vector (east, north) across the track, to the side of the look.
    pub(super) outward: [f64; 2],
    /// Mean level of each bin above that of the bottom beside the box, in standard deviations of
    /// the speckle.
    pub(super) levels: Vec<f32>,
}

/// Greatest number of pings and bins of a look: a finer look would take time and give no more
/// information.
const PINGS: usize = 48;
const BINS: usize = 96;
/// Least width of a bin, that of a pulse, metres.
const LEAST_STEP_M: f64 = 0.03;
/// Margins around the box: in range, metres and a share of the box; along the track, least number
/// of pings, and the divisor of the box's pings (a quarter of them).
const RANGE_MARGIN_M: f64 = 0.3;
const RANGE_MARGIN: f64 = 0.15;
const PING_MARGIN: usize = 4;
const PING_SHARE: usize = 4;
/// Slant range at which the levels begin, in altitudes: there, the ray meets the bottom at an
/// angle; nearer is the first return.
const BEYOND_NADIR: f64 = 1.02;
/// Median of the square of a normally distributed number with a standard deviation of 1.
const MEDIAN_SQUARE: f64 = 0.4549;
/// Limits of a level, in standard deviations of the speckle: stronger glints give no more
/// information.
const LEVELS: [f64; 2] = [-5.0, 8.0];

impl PingLevels {
    /// Returns the sum of the squares of the levels.
    pub(super) fn squares(&self) -> f64 {
        let squares = self.levels.iter().map(|level| f64::from(level * level));
        squares.sum()
    }
}

impl BoxLevels {
    /// Returns the slant range at which a bin begins, in the recorder's scale, metres.
    pub(super) fn recorded_m(&self, bin: usize) -> f64 {
        self.recorded_m[0] + bin as f64 * self.recorded_m[1]
    }

    /// Returns the sum of the squares of all levels.
    pub(super) fn squares(&self) -> f64 {
        let levels = self.pings.iter().flat_map(|ping| &ping.levels);
        levels.map(|level| f64::from(level * level)).sum()
    }

    /// Returns the expected sum of the squares of all levels if there is no object.
    pub(super) fn speckle_squares(&self) -> f64 {
        self.noise * (self.pings.len() * self.bins) as f64
    }

    /// Returns a coarser look, of means of neighbouring pings and bins; `pings` and `bins` are
    /// their approximate numbers.
    #[must_use]
    pub(super) fn coarser(&self, [pings, bins]: [usize; 2]) -> Self {
        let [of_pings, of_bins] =
            [self.pings.len() / pings, self.bins / bins].map(|count| count.max(1));
        let bins = self.bins / of_bins;
        let mean_ping = |group: &[PingLevels]| {
            let mean = |bin: usize| {
                let stretch = bin * of_bins..(bin + 1) * of_bins;
                let levels = group.iter().flat_map(|ping| &ping.levels[stretch.clone()]);
                levels.sum::<f32>() / (group.len() * of_bins) as f32
            };
            let [first, last] = [&group[0], &group[group.len() - 1]].map(|ping| ping.boat_m);
            PingLevels {
                boat_m: [0, 1].map(|axis| 0.5 * (first[axis] + last[axis])),
                levels: (0..bins).map(mean).collect(),
                ..group[group.len() / 2].clone()
            }
        };
        Self {
            recorded_m: [self.recorded_m[0], self.recorded_m[1] * of_bins as f64],
            step_m: self.step_m * of_bins as f64,
            bins,
            ping_m: self.ping_m * of_pings as f64,
            pings: self.pings.chunks(of_pings).map(mean_ping).collect(),
            noise: self.noise / (of_pings * of_bins) as f64,
            together: self.together * of_pings * of_bins,
            ..*self
        }
    }

    /// Returns the excess of the sum of squares over that of bare bottom, as a share of the latter.
    pub(super) fn contrast(&self) -> f64 {
        self.squares() / self.speckle_squares() - 1.0
    }

    /// Returns the extent along the track, metres.
    pub(super) fn along_m(&self) -> f64 {
        self.ping_m * self.pings.len() as f64
    }

    /// Returns the extent across the track on a level bottom, metres.
    pub(super) fn across_m(&self) -> f64 {
        let out_m = |bin: usize| across_m(self.from_m + bin as f64 * self.step_m, self.altitude_m);
        out_m(self.bins) - out_m(0)
    }
}

impl Placer<'_> {
    /// Returns the levels that the pass of a box recorded around it; `None` if there are too few
    /// for a picture (less than three pings with a place, no samples, or no bottom next to the box
    /// for comparison).
    pub fn box_levels(&self, mark: &Mark) -> Option<BoxLevels> {
        let middle = usize::midpoint(mark.pings.start, mark.pings.end);
        let span = self.survey.span(middle, mark.side)?;
        let altitude_m = self.altitude_over_m(mark.side, mark.pings.clone())?;
        let length_m = mark.far_m - mark.near_m;
        let calibrated_m = |recorded_m: f64| self.calibrated_m(span, recorded_m);
        // Ranges by the current calibration are linear in the recorded ones.
        let [near_m, far_m] = [mark.near_m, mark.far_m].map(calibrated_m);
        let factor = (far_m - near_m) / length_m;
        let bottom_m = mark.near_m + (BEYOND_NADIR * altitude_m - near_m) / factor;
        let from_m = (mark.near_m - RANGE_MARGIN_M - RANGE_MARGIN * length_m)
            .max(f64::from(span.near_m))
            .max(bottom_m);
        let to_m =
            (mark.far_m + RANGE_MARGIN_M + RANGE_MARGIN * length_m).min(f64::from(span.far_m));
        let bins = ((to_m - from_m) / LEAST_STEP_M) as usize;
        if !(factor > 0.0 && factor.is_finite()) || bins < 4 {
            return None;
        }
        let bins = bins.min(BINS);
        let grid = RangeSteps {
            side: mark.side,
            from_m,
            step_m: (to_m - from_m) / bins as f64,
            steps: bins,
        };
        let background = grid.background(self.survey, mark)?;
        let more = PING_MARGIN.max(mark.pings.len() / PING_SHARE);
        let end = (mark.pings.end + more).min(self.survey.side_scan.len());
        let groups = groups(mark.pings.start.saturating_sub(more)..end);
        let noise = self.noise(&grid, &background, mark, groups.first()?.len())?;
        // On a bottom that slopes evenly, the geometry is that of a level bottom, moved along the
        // slope.
        let level_m = across_m(near_m, altitude_m);
        let moved_m = self.relief.across(mark.side, middle).ground_m(altitude_m, near_m) - level_m;
        let pings: Vec<PingLevels> = groups
            .into_iter()
            .filter_map(|pings| self.look_ping(&grid, &background, pings, moved_m))
            .collect();
        let [first, last] = [pings.first()?.boat_m, pings.last()?.boat_m];
        if pings.len() < 3 {
            return None;
        }
        let way_m = f64::hypot(last[0] - first[0], last[1] - first[1]);
        Some(BoxLevels {
            altitude_m,
            recorded_m: [from_m, grid.step_m],
            from_m: calibrated_m(from_m),
            step_m: grid.step_m * factor,
            bins,
            ping_m: way_m / (pings.len() - 1) as f64,
            pings,
            noise,
            together: 1,
        })
    }

    /// Averages some pings; `None` if they have no place or no samples.
    fn look_ping(
        &self,
        grid: &RangeSteps,
        background: &BackgroundLevels,
        pings: Range<usize>,
        moved_m: f64,
    ) -> Option<PingLevels> {
        let ping = usize::midpoint(pings.start, pings.end - 1);
        let boat = self.navigation.pings.get(ping)?;
        let [x, y] = boat.starboard()?;
        let outward = [x, y].map(|part| grid.side.to_starboard(part));
        let boat_m = [boat.east_m + moved_m * outward[0], boat.north_m + moved_m * outward[1]];
        if !boat_m.iter().all(|metres| metres.is_finite()) {
            return None;
        }
        Some(PingLevels {
            ping,
            boat_m,
            outward,
            levels: background.levels_above(&grid.profile(self.survey, pings)?)?,
        })
    }

    /// Returns the mean square of the levels next to the box, for means of `together` pings; `None`
    /// without levels. It is computed from their median: stones and other objects next to the box
    /// are no noise, and would let any shape explain all of a picture.
    fn noise(
        &self,
        grid: &RangeSteps,
        background: &BackgroundLevels,
        mark: &Mark,
        together: usize,
    ) -> Option<f64> {
        let mut squares = Vec::new();
        for pings in RangeSteps::beside(self.survey, mark) {
            for first in pings.clone().step_by(together) {
                let some = first..(first + together).min(pings.end);
                let levels = grid.profile(self.survey, some);
                let levels = levels.and_then(|levels| background.levels_above(&levels));
                squares.extend(levels.into_iter().flatten().map(|level| f64::from(level * level)));
            }
        }
        (!squares.is_empty()).then(|| median(&mut squares) / MEDIAN_SQUARE)
    }
}

impl BackgroundLevels {
    /// Converts levels to levels above the background, in standard deviations of its speckle;
    /// `None` if the speckle is not known.
    fn levels_above(&self, levels: &[f64]) -> Option<Vec<f32>> {
        // A speckle of NaN is unknown too.
        if self.speckle.is_nan() || self.speckle <= 0.0 {
            return None;
        }
        let both = levels.iter().zip(&self.levels);
        let above = both.map(|(level, bottom)| (level - bottom) / self.speckle);
        Some(above.map(|level| level.clamp(LEVELS[0], LEVELS[1]) as f32).collect())
    }
}

/// Divides pings into groups of neighbours that are averaged, so that there are not too many.
fn groups(pings: Range<usize>) -> Vec<Range<usize>> {
    let together = pings.len().div_ceil(PINGS).max(1);
    let first = pings.clone().step_by(together);
    first.map(|first| first..(first + together).min(pings.end)).collect()
}

#[cfg(test)]
impl BoxLevels {
    /// Creates a look of some pings, `ping_m` apart, over a bottom 3 m below, with bins of `step_m`
    /// from `from_m` on.
    pub(super) fn of_pings(
        pings: Vec<PingLevels>,
        ping_m: f64,
        [from_m, step_m]: [f64; 2],
    ) -> Self {
        Self {
            altitude_m: 3.0,
            recorded_m: [from_m, step_m],
            from_m,
            step_m,
            bins: pings[0].levels.len(),
            ping_m,
            pings,
            noise: 1.0,
            together: 1,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_coarser_look_has_means_where_the_levels_were() {
        let ping = |index: usize| PingLevels {
            ping: 10 + index,
            boat_m: [0.5, 0.1 * index as f64],
            outward: [1.0, 0.0],
            levels: (0..8).map(|bin| (10 * index + bin) as f32).collect(),
        };
        let look = BoxLevels::of_pings((0..5).map(ping).collect(), 0.1, [4.0, 0.1]);
        let coarse = look.coarser([2, 4]);
        assert_eq!((coarse.bins, coarse.pings.len(), coarse.together), (4, 3, 4));
        assert_eq!(coarse.pings[1].levels, [25.5, 27.5, 29.5, 31.5]);
        assert_eq!(coarse.pings[2].levels, [40.5, 42.5, 44.5, 46.5]);
        assert!((coarse.pings[1].boat_m[1] - 0.25).abs() < 1e-12);
        assert!((coarse.step_m - 0.2).abs() < 1e-12 && (coarse.noise - 0.25).abs() < 1e-12);
        assert_eq!(look.coarser([100, 100]).pings.len(), 5);
    }
}
