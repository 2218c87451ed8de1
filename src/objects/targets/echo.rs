//! The echo and the shadow inside a box.

use super::profile::{BackgroundLevels, RangeSteps};
use super::runs::{self, Runs, runs};
use crate::Mark;
use bathyscope_log::support::statistics::median;
use bathyscope_log::survey::Survey;
use std::ops::Range;

/// Echo and shadow of a box by slant range on the recorder's scale, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parts {
    /// Near and far edge of the echo.
    pub echo_m: [f64; 2],
    /// Start and end of the shadow behind it, where there is one; the end is NaN where it runs off
    /// the range.
    pub shadow_m: Option<[f64; 2]>,
    /// The longest shadow but for a tenth behind a few neighbouring pings: that of the object's
    /// top. Where the top is round, or the object lies askew, [`Parts::shadow_m`] ends before it,
    /// where half of the pings receive the bottom again.
    pub longest: Option<Shadow>,
}

/// A shadow in a few pings, metres of slant range.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shadow {
    /// Where what is bright before it ends. What lies between may be the object's top, no brighter
    /// than the bottom, or bottom.
    pub bright_end_m: f64,
    /// Where the dark starts.
    pub start_m: f64,
    /// Where the echo of the bottom returns; NaN where the dark runs off the range.
    pub end_m: f64,
}

/// Steps that the box and its margin are divided into at most.
const STEPS: usize = 192;
/// Margin behind the box that is looked at, as a share of it: boxes are rarely drawn to the sample.
const MARGIN: f64 = 0.15;
/// Share of the box's pings, around the middle, in which the object is looked at, and how many at
/// least: fewer are speckle.
const CORE: f64 = 0.5;
const CORE_PINGS: usize = 6;
/// Neighbouring pings in which the longest shadow is looked for: at least so many, and a share of
/// the box; and in how many places of a long box at most. Over more pings the edges of what lies
/// askew run into each other.
const SLICE_PINGS: usize = 2;
const SLICE: f64 = 0.1;
const SLICES: usize = 24;
/// The share of those places whose shadow is no longer than the one taken for the longest: speckle
/// lengthens some of so few pings. Heights of simulated objects then have no bias.
const LONGEST: f64 = 0.9;
/// A shadow is at least this share of the background's level darker than it; the bytes are
/// decibels, more or less.
const DARKER: f64 = 0.12;
/// A shadow ends where half of the bottom's power returns: pulse and beam blur the edge evenly in
/// power, and the middle of the levels lies deep in the shadow where they are decibels. Of fully
/// developed speckle the decibels have a standard deviation of 5.57, whatever the level, and the
/// amplitudes one of 0.52 of their mean; half of the power, 3 dB or 0.29 of the amplitude, is 0.55
/// of either: so many standard deviations below the background, whatever the recorder's curve.
const HALF_POWER: f64 = 0.55;
/// Shortest shadow, metres and as a share of the box: a shorter dark run is speckle.
const SHORTEST_SHADOW_M: f64 = 0.1;
const SHORTEST_SHADOW: f64 = 0.15;
/// Longer side of a box from which on its object is large, metres: a hull, a bank, a pier. The
/// bright run and the dark run behind it are those of one wall of a large object then, or of a
/// hold, and of one part of it where it lies askew.
const LARGE_M: f64 = 12.0;
/// Share of a slice's echo that something bright behind its shadow must explain to be part of the
/// same object.
const GOES_ON: f64 = 0.2;
/// The shadow begins at most so far behind what is bright, metres: a flat top may be wide and no
/// brighter than the bottom.
const GAP_M: f64 = 3.0;

/// A border so near the far edge of a box leaves no shadow, metres.
const LEAST_DRAWN_M: f64 = 0.02;

/// Whether a box holds a large object, of which [`drawn_parts`] speaks. `length_m` is its extent
/// along the track.
pub(super) fn is_large(mark: &Mark, length_m: f64) -> bool {
    // NaN is not large.
    length_m > LARGE_M || mark.far_m - mark.near_m > LARGE_M
}

/// The echo and the shadow in the box of a large object. The box is what whoever drew it took for
/// the object, and its near edge and its far one stand, unless what lies farthest out is the
/// object's shadow all along: the echo then ends where in the slice that reaches farthest the
/// shadow begins. `None` where the box holds no samples.
pub(super) fn drawn_parts(survey: &Survey, mark: &Mark) -> Option<Parts> {
    let look = Look::new(survey, mark)?;
    let all: Vec<Range<usize>> = slices(&mark.pings).collect();
    let shadows: Vec<Shadow> =
        (all.iter()).filter_map(|pings| look.behind_all(pings.clone(), mark.far_m)).collect();
    let start_m = shadows.iter().map(|one| one.start_m).reduce(f64::max);
    // Where most of the box ends in echo, a hollow in the rest is no shadow.
    let start_m = start_m.filter(|start_m| *start_m < mark.far_m && 2 * shadows.len() > all.len());
    let Some(start_m) = start_m else {
        return Some(Parts { echo_m: [mark.near_m, mark.far_m], shadow_m: None, longest: None });
    };
    let ends = shadows.iter().map(|one| one.end_m);
    let longest = longest(shadows.iter().copied());
    Some(Parts {
        echo_m: [mark.near_m, start_m],
        // NaN is the larger: a shadow that runs off the range is longer than any.
        shadow_m: ends.max_by(f64::total_cmp).map(|end_m| [start_m, end_m]),
        longest,
    })
}

/// The echo and the shadow as the analyst has set them. One that ends with what was recorded, to
/// `reach_m` on the recorder's scale, runs off the range.
pub(super) fn set_parts(mark: &Mark, border_m: f64, reach_m: f64) -> Parts {
    let shadow = (mark.far_m - border_m > LEAST_DRAWN_M).then_some(Shadow {
        bright_end_m: border_m,
        start_m: border_m,
        end_m: match mark.far_m < reach_m {
            true => mark.far_m,
            false => f64::NAN,
        },
    });
    Parts {
        echo_m: [mark.near_m, border_m],
        shadow_m: shadow.map(|shadow| [shadow.start_m, shadow.end_m]),
        longest: shadow,
    }
}

/// Finds the echo and its shadow: the bright run, and the dark run behind it, that explain the
/// levels in the middle pings of the box best (least squares about the background, which is what
/// the pings before and behind the box receive at the same range). `None` where the box holds no
/// samples.
pub fn parts(survey: &Survey, mark: &Mark) -> Option<Parts> {
    let look = Look::new(survey, mark)?;
    let (echo_m, shadow) = look.at(core(&mark.pings))?;
    let longest = shadow.and_then(|shadow| {
        let slices = slices(&mark.pings).filter_map(|pings| look.at(pings)?.1);
        longest(slices.filter(|slice| slice.end_m.is_finite() || shadow.end_m.is_nan()))
    });
    Some(Parts { echo_m, shadow_m: shadow.map(|shadow| [shadow.start_m, shadow.end_m]), longest })
}

/// A box, ready to be looked at in some of its pings.
struct Look<'a> {
    survey: &'a Survey,
    grid: RangeSteps,
    background: BackgroundLevels,
    /// Mean level of the background.
    level: f64,
    /// Shortest dark run that is a shadow, and the end of what was recorded, metres.
    shortest_m: f64,
    end_m: f64,
}

impl<'a> Look<'a> {
    fn new(survey: &'a Survey, mark: &Mark) -> Option<Self> {
        let middle = usize::midpoint(mark.pings.start, mark.pings.end);
        let span = survey.span(middle, mark.side)?;
        let length_m = mark.far_m - mark.near_m;
        if !(length_m > 0.0 && length_m.is_finite()) {
            return None;
        }
        let limits = [f64::from(span.near_m), f64::from(span.far_m)];
        let from_m = mark.near_m.max(limits[0]);
        let to_m = (mark.far_m + MARGIN * length_m).min(limits[1]);
        let steps = ((to_m - from_m) / span.metres_per_sample()).floor();
        if steps < 3.0 {
            return None;
        }
        let grid = RangeSteps {
            side: mark.side,
            from_m,
            step_m: (to_m - from_m) / steps.min(STEPS as f64),
            steps: (steps as usize).min(STEPS),
        };
        let background = match grid.background(survey, mark) {
            Some(background) => background,
            None => {
                let mut levels = grid.profile(survey, core(&mark.pings))?;
                BackgroundLevels {
                    levels: vec![median(&mut levels); grid.steps],
                    speckle: f64::NAN,
                }
            }
        };
        Some(Self {
            survey,
            level: background.levels.iter().sum::<f64>() / background.levels.len() as f64,
            shortest_m: SHORTEST_SHADOW_M.max(SHORTEST_SHADOW * length_m),
            end_m: limits[1],
            grid,
            background,
        })
    }

    /// Slant range at which a step begins, metres.
    fn range_m(&self, step: usize) -> f64 {
        self.grid.from_m + step as f64 * self.grid.step_m
    }

    /// How much brighter than the background each step is in some pings.
    fn contrast(&self, pings: Range<usize>) -> Option<Vec<f64>> {
        let echo = self.grid.profile(self.survey, pings)?;
        let both = echo.iter().zip(&self.background.levels);
        Some(both.map(|(echo, quiet)| echo - quiet).collect())
    }

    /// The shadow in some pings behind which nothing of the object comes any more up to the end of
    /// its box.
    fn behind_all(&self, pings: Range<usize>, far_m: f64) -> Option<Shadow> {
        let contrast = self.contrast(pings.clone())?;
        let (echo_m, shadow) = self.at(pings)?;
        let shadow = shadow?;
        let step_of = |range_m: f64| ((range_m - self.grid.from_m) / self.grid.step_m).round();
        // A shadow that runs off the range has nothing behind it.
        let from = match shadow.end_m.is_nan() {
            true => return Some(shadow),
            false => step_of(shadow.end_m) as usize,
        };
        let behind = from..(step_of(far_m) as usize).min(contrast.len());
        let echo = step_of(echo_m[0]) as usize..step_of(echo_m[1]) as usize;
        let echo_gain = runs::gain(contrast.get(echo)?);
        let goes_on = (contrast.get(behind))
            .is_some_and(|behind| runs::brightest(behind) > GOES_ON * echo_gain);
        (!goes_on).then_some(shadow)
    }

    /// The echo and its shadow in some pings.
    fn at(&self, pings: Range<usize>) -> Option<([f64; 2], Option<Shadow>)> {
        let contrast = self.contrast(pings)?;
        let Runs { echo, shadow } = runs(&contrast, (GAP_M / self.grid.step_m) as usize)?;
        let echo_m = [self.range_m(echo.start), self.range_m(echo.end)];
        let shadow = shadow.and_then(|dark| {
            let darkness = -contrast[dark.clone()].iter().sum::<f64>() / dark.len() as f64;
            let dark_m = dark.len() as f64 * self.grid.step_m;
            if darkness < DARKER * self.level || dark_m < self.shortest_m {
                return None;
            }
            // NaN gives half of the darkness.
            let lit = (HALF_POWER * self.background.speckle).min(0.5 * darkness);
            let end_m = self.range_m(last_below(&contrast, dark.start, -lit));
            let ends = end_m < self.end_m - 2.0 * self.grid.step_m;
            Some(Shadow {
                bright_end_m: echo_m[1],
                start_m: self.range_m(dark.start),
                end_m: if ends { end_m } else { f64::NAN },
            })
        });
        Some((echo_m, shadow))
    }
}

/// The step up to which a profile stays below a level from a step on: where the sum of what is
/// below it is largest.
fn last_below(contrast: &[f64], start: usize, level: f64) -> usize {
    let (mut sum, mut largest, mut end) = (0.0, 0.0, start);
    for (step, value) in contrast.iter().enumerate().skip(start) {
        sum += level - value;
        if sum > largest {
            (largest, end) = (sum, step + 1);
        }
    }
    end
}

/// The middle pings of a box.
fn core(pings: &Range<usize>) -> Range<usize> {
    let count = ((CORE * pings.len() as f64).ceil() as usize).max(CORE_PINGS);
    let start = (pings.start + pings.end).saturating_sub(count) / 2;
    start.max(pings.start)..(start + count).min(pings.end)
}

/// A few neighbouring pings in several places of a box.
fn slices(pings: &Range<usize>) -> impl Iterator<Item = Range<usize>> {
    let count = ((SLICE * pings.len() as f64).ceil() as usize).max(SLICE_PINGS).min(pings.len());
    let (start, last) = (pings.start, pings.len() - count);
    let stride = last.div_ceil(SLICES).max(1);
    (0..=last).step_by(stride).map(move |first| start + first..start + first + count)
}

/// The shadow of the highest top: by `(end - start) / end`, where the height is in proportion to
/// it. One that runs off the range is longer than any.
fn longest(shadows: impl Iterator<Item = Shadow>) -> Option<Shadow> {
    let share = |one: &Shadow| match one.end_m.is_nan() {
        true => 1.0,
        false => 1.0 - one.start_m / one.end_m,
    };
    let mut all: Vec<Shadow> = shadows.collect();
    all.sort_by(|a, b| share(a).total_cmp(&share(b)));
    let last = all.len().checked_sub(1)?;
    all.get((LONGEST * last as f64).round() as usize).copied()
}

#[cfg(test)]
mod tests {
    use super::*;
    use bathyscope_log::survey::Side;

    #[test]
    fn drawn_edges_are_the_parts_and_a_shadow_to_the_end_has_no_end() {
        let mark = Mark::new(Side::Port, 3..9, [4.0, 7.0]);
        let whole = set_parts(&mark, 5.0, 12.0);
        assert_eq!(whole.echo_m, [4.0, 5.0]);
        assert_eq!(whole.shadow_m, Some([5.0, 7.0]));
        assert_eq!(whole.longest.map(|one| one.bright_end_m), Some(5.0));
        let none = set_parts(&mark, 7.0, 12.0);
        assert_eq!((none.shadow_m, none.longest), (None, None));
        let off = set_parts(&mark, 5.0, 7.0);
        assert!(off.shadow_m.is_some_and(|shadow| shadow[1].is_nan()));
    }
}
