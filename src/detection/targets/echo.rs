//! The echo and the shadow inside a box.

use super::profile::Grid;
use super::runs::{Runs, runs};
use crate::detection::Mark;
use crate::statistics::median;
use crate::survey::Survey;
use std::ops::Range;

/// Echo and shadow of a box by slant range on the recorder's scale, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parts {
    /// Near and far edge of the echo.
    pub echo_m: [f64; 2],
    /// Start and end of the shadow behind it, where there is one; the end is NaN where it runs off the range.
    pub shadow_m: Option<[f64; 2]>,
    /// The longest shadow behind a few neighbouring pings: that of the object's top. Where the top is round, or the object
    /// lies askew, [`Parts::shadow_m`] ends before it, where half of the pings hear the bottom again.
    pub longest_m: Option<[f64; 2]>,
}

/// Steps that the box and its margin are divided into at most.
const STEPS: usize = 192;
/// Margin behind the box that is looked at, as a share of it: boxes are rarely drawn to the sample.
const MARGIN: f64 = 0.15;
/// Share of the box's pings, around the middle, in which the object is looked at, and how many at least: fewer are speckle.
const CORE: f64 = 0.5;
const CORE_PINGS: usize = 6;
/// Neighbouring pings in which the longest shadow is looked for: at least so many, and a share of the box; and in how many
/// places of a long box at most.
const SLICE_PINGS: usize = 3;
const SLICE: f64 = 0.2;
const SLICES: usize = 24;
/// A shadow is at least this share of the background's level darker than it; the bytes are decibels, more or less.
const DARKER: f64 = 0.12;
/// Shortest shadow, metres and as a share of the box: a shorter dark run is speckle.
const SHORTEST_SHADOW_M: f64 = 0.1;
const SHORTEST_SHADOW: f64 = 0.15;
/// The shadow begins at most so far behind what is bright, metres: the top of an object may be no brighter than the bottom.
const GAP_M: f64 = 1.2;

/// Finds the echo and its shadow: the bright run, and the dark run behind it, that explain the levels in the middle pings of
/// the box best (least squares about the background, which is what the pings before and behind the box hear at the same
/// range). `None` where the box holds no samples.
pub fn parts(survey: &Survey, mark: &Mark) -> Option<Parts> {
    let look = Look::new(survey, mark)?;
    let (echo, shadow_m) = look.at(core(&mark.pings))?;
    let longest_m = shadow_m.and_then(|shadow| {
        let slices = slices(&mark.pings).filter_map(|pings| look.at(pings)?.1);
        longest(slices.filter(|[_, end]| end.is_finite() || shadow[1].is_nan()))
    });
    Some(Parts {
        echo_m: [look.range_m(echo.start), look.range_m(echo.end)],
        shadow_m,
        longest_m,
    })
}

/// A box, ready to be looked at in some of its pings.
struct Look<'a> {
    survey: &'a Survey,
    grid: Grid,
    background: Vec<f64>,
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
        let grid = Grid {
            side: mark.side,
            from_m,
            step_m: (to_m - from_m) / steps.min(STEPS as f64),
            steps: (steps as usize).min(STEPS),
        };
        let background = match grid.background(survey, mark) {
            Some(background) => background,
            None => {
                let mut levels = grid.profile(survey, core(&mark.pings))?;
                vec![median(&mut levels); grid.steps]
            }
        };
        Some(Self {
            survey,
            level: background.iter().sum::<f64>() / background.len() as f64,
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

    /// The echo, and start and end of the shadow, in some pings.
    fn at(&self, pings: Range<usize>) -> Option<(Range<usize>, Option<[f64; 2]>)> {
        let heard = self.grid.profile(self.survey, pings)?;
        let contrast: Vec<f64> = heard
            .iter()
            .zip(&self.background)
            .map(|(heard, quiet)| heard - quiet)
            .collect();
        let Runs { echo, shadow } = runs(&contrast, (GAP_M / self.grid.step_m) as usize)?;
        let dark = shadow.filter(|dark| {
            let mean = contrast[dark.clone()].iter().sum::<f64>() / dark.len() as f64;
            let dark_m = dark.len() as f64 * self.grid.step_m;
            -mean > DARKER * self.level && dark_m > self.shortest_m
        });
        let shadow_m = dark.map(|dark| {
            let end_m = self.range_m(dark.end);
            let ends = end_m < self.end_m - 2.0 * self.grid.step_m;
            [
                self.range_m(dark.start),
                if ends { end_m } else { f64::NAN },
            ]
        });
        Some((echo, shadow_m))
    }
}

/// The middle pings of a box.
fn core(pings: &Range<usize>) -> Range<usize> {
    let count = ((CORE * pings.len() as f64).ceil() as usize).max(CORE_PINGS);
    let start = (pings.start + pings.end).saturating_sub(count) / 2;
    start.max(pings.start)..(start + count).min(pings.end)
}

/// A few neighbouring pings in several places of a box.
fn slices(pings: &Range<usize>) -> impl Iterator<Item = Range<usize>> {
    let count = ((SLICE * pings.len() as f64).ceil() as usize)
        .max(SLICE_PINGS)
        .min(pings.len());
    let (start, last) = (pings.start, pings.len() - count);
    let stride = last.div_ceil(SLICES).max(1);
    (0..=last)
        .step_by(stride)
        .map(move |first| start + first..start + first + count)
}

/// The shadow of the highest top: by `(end - start) / end`, where the height is in proportion to it. Not the very longest of
/// them, which speckle may have made, but the second where there are three.
fn longest(shadows: impl Iterator<Item = [f64; 2]>) -> Option<[f64; 2]> {
    let share = |[start, end]: &[f64; 2]| if end.is_nan() { 1.0 } else { 1.0 - start / end };
    let mut shadows: Vec<[f64; 2]> = shadows.collect();
    shadows.sort_by(|a, b| share(b).total_cmp(&share(a)));
    shadows.get(usize::from(shadows.len() > 2)).copied()
}
