//! Finds the echo and the shadow inside a box.

use super::profile::{self, BackgroundLevels, RangeSteps, runs};
use crate::Mark;
use bathyscope_log::support::statistics::median;
use bathyscope_log::survey::Survey;
use std::ops::Range;

/// Echo and shadow of a box by slant range in the recorder's scale, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parts {
    /// Near and far edge of the echo.
    pub echo_m: [f64; 2],
    /// Start and end of the shadow behind the echo; `None` without a shadow. The end is NaN if the
    /// shadow continues beyond the recorded range.
    pub shadow_m: Option<[f64; 2]>,
    /// Shadow of the object's top; `None` unless it is dark and behind most of the pings. If the
    /// top is round, or the object is askew, [`Parts::shadow_m`] ends before this shadow, where
    /// half of the pings receive the bottom again.
    pub longest: Option<Shadow>,
    /// Standard deviation of the shadows of neighbouring pings about `longest`, as shares of the
    /// altitude; 0 if the edges were set by hand.
    pub spread: f64,
}

/// A shadow on a few pings, metres of slant range.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shadow {
    /// End of the bright run before the shadow. Between this and the dark run there may be the
    /// object's top, no brighter than the bottom, or bottom.
    pub bright_end_m: f64,
    /// Start of the dark run.
    pub start_m: f64,
    /// Range at which the echo of the bottom returns; NaN if the dark run continues beyond the
    /// recorded range.
    pub end_m: f64,
}

/// Greatest number of steps that the box and its margin are divided into.
const STEPS: usize = 192;
/// Margin behind the box that is examined, as a share of the box: boxes are rarely drawn to the
/// sample.
const MARGIN: f64 = 0.15;
/// Share of the box's pings, around the middle, in which the object is examined, and their least
/// number: fewer pings are mostly speckle.
const CORE: f64 = 0.5;
const CORE_PINGS: usize = 6;
/// Number of neighbouring pings (a slice) in which a shadow is searched: the least number, and a
/// share of the box; and the greatest number of slices, for a long box. In more pings at once, the
/// edges of an object that is askew blur into each other.
const SLICE_PINGS: usize = 2;
const SLICE: f64 = 0.1;
const SLICES: usize = 24;
/// Share of the slices whose shadow is no longer than the one that is used for the top: speckle
/// lengthens some shadows of so few pings. An even top casts the same shadow everywhere, a peaked
/// one casts its longest in the middle, and the walls of a large object are of different heights.
/// If the class does not determine the shape of the top, a visible flat top counts as nearly even.
/// With these shares, the heights of simulated objects have no bias.
const EVEN_TOP: f64 = 0.5;
const PEAKED_TOP: f64 = 0.85;
const FLAT_TOP: f64 = 0.65;
const OTHER_TOP: f64 = 0.75;
const LARGE: f64 = 0.9;
/// Least share of the slices with a shadow behind them, and least darkness of the shadow below the
/// background in standard deviations of its samples, for the shadow to be whole: an object that is
/// lit in part, or broken, casts no shadow from which a height can be computed.
const WHOLE: f64 = 0.7;
const DARK_SPECKLES: f64 = 0.58;
/// A flat top that is no brighter than the bottom lies between the bright run and the shadow. It is
/// detected if two levels explain this stretch better than one by at least [`TOP_GAIN`] times the
/// mean square that is left, and the top is at most [`TOP_DARKNESS`] times as dark as the shadow.
const TOP_GAIN: f64 = 10.0;
const TOP_DARKNESS: f64 = 0.7;
/// Least darkness of a shadow below the background, as a share of the background's level; the bytes
/// are decibels, more or less.
const DARKER: f64 = 0.12;
/// Level at which a shadow ends, in standard deviations of the samples below the background. A
/// shadow ends where half of the bottom's power returns: pulse and beam blur the edge evenly in
/// power, and if the levels are decibels, the middle of the levels is deep in the shadow. For fully
/// developed speckle, decibels have a standard deviation of 5.57 at any level, and amplitudes have
/// one of 0.52 of their mean; half of the power, 3 dB or 0.29 of the amplitude, is 0.55 of either,
/// so this holds for any curve of the recorder.
const HALF_POWER: f64 = 0.55;
/// Least length of a shadow, metres and as a share of the box: a shorter dark run is speckle.
const SHORTEST_SHADOW_M: f64 = 0.1;
const SHORTEST_SHADOW: f64 = 0.15;
/// Longer side of a box above which its object is large, metres: a hull, a bank, a pier. For a
/// large object, the bright run and the dark run behind it may be those of only one wall or of a
/// hold, or of only one part if the object is askew.
const LARGE_M: f64 = 12.0;
/// Share of a slice's echo that a bright run behind its shadow must explain to be part of the same
/// object.
const GOES_ON: f64 = 0.2;
/// Greatest distance between the bright run and its shadow, metres: a flat top may be wide and no
/// brighter than the bottom.
const GAP_M: f64 = 3.0;

/// Distance between the border and the far edge of a box up to which there is no shadow, metres.
const LEAST_DRAWN_M: f64 = 0.02;

/// Shape of the top of an object along the track.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum TopShape {
    /// The shape is not known.
    #[default]
    Unknown,
    /// The height is the same all along, as for a pipe.
    Even,
    /// The top is highest in the middle, as for a rock.
    Peaked,
}

impl TopShape {
    /// Returns the shape of the top of a class by its name.
    pub fn of_class(name: &str) -> Self {
        match name {
            "block" | "cylinder" | "pipe" => Self::Even,
            "rock" => Self::Peaked,
            _ => Self::Unknown,
        }
    }
}

/// Returns true if a box holds a large object, to which [`drawn_parts`] applies. `length_m` is the
/// extent of the box along the track.
pub(super) fn is_large(mark: &Mark, length_m: f64) -> bool {
    // A length of NaN does not count as large.
    length_m > LARGE_M || mark.far_m - mark.near_m > LARGE_M
}

/// Returns the echo and the shadow in the box of a large object. The near and the far edge of the
/// box are kept as the edges of the object, unless its outermost part is shadow along most of the
/// box: the echo then ends where the shadow begins in the slice that reaches farthest. `None` if
/// the box holds no samples.
pub(super) fn drawn_parts(survey: &Survey, mark: &Mark) -> Option<Parts> {
    let look = Look::new(survey, mark)?;
    let all: Vec<Range<usize>> = slices(&mark.pings).collect();
    let shadows: Vec<Shadow> =
        (all.iter()).filter_map(|pings| look.behind_all(pings.clone(), mark.far_m)).collect();
    let start_m = shadows.iter().map(|shadow| shadow.start_m).reduce(f64::max);
    // If most of the box ends in echo, a hollow in the rest of it is no shadow.
    let start_m = start_m.filter(|start_m| *start_m < mark.far_m && 2 * shadows.len() > all.len());
    let shadows = if start_m.is_some() { shadows } else { Vec::new() };
    // NaN counts as the largest: a shadow that continues beyond the range is longer than any other.
    let end_m = shadows.iter().map(|shadow| shadow.end_m).max_by(f64::total_cmp);
    let (longest, spread) = longest(shadows, LARGE).unzip();
    Some(Parts {
        echo_m: [mark.near_m, start_m.unwrap_or(mark.far_m)],
        shadow_m: start_m.zip(end_m).map(|(start_m, end_m)| [start_m, end_m]),
        longest,
        spread: spread.unwrap_or(0.0),
    })
}

/// Returns the echo and the shadow as the analyst has set them. A shadow that ends at the end of
/// the recording, at `reach_m` in the recorder's scale, has no known end.
pub(super) fn set_parts(mark: &Mark, border_m: f64, reach_m: f64) -> Parts {
    let shadow = (mark.far_m - border_m > LEAST_DRAWN_M).then_some(Shadow {
        bright_end_m: border_m,
        start_m: border_m,
        end_m: if mark.far_m < reach_m { mark.far_m } else { f64::NAN },
    });
    Parts {
        echo_m: [mark.near_m, border_m],
        shadow_m: shadow.map(|shadow| [shadow.start_m, shadow.end_m]),
        longest: shadow,
        spread: 0.0,
    }
}

/// Finds the echo and its shadow: the bright run, and the dark run behind it, that together explain
/// best the levels in the middle pings of the box (least squares about the background, which is the
/// level of the pings before and behind the box at the same range). `None` if the box holds no
/// samples.
pub fn parts(survey: &Survey, mark: &Mark, top: TopShape) -> Option<Parts> {
    let look = Look::new(survey, mark)?;
    let (echo_m, dark) = look.at(&look.contrast(core(&mark.pings))?)?;
    let shadow = dark.map(|(_, shadow)| shadow);
    let of_top = shadow.and_then(|shadow| look.top_shadow(&mark.pings, &shadow, top));
    let (longest, spread) = of_top.unzip();
    Some(Parts {
        echo_m,
        shadow_m: shadow.map(|shadow| [shadow.start_m, shadow.end_m]),
        longest,
        spread: spread.unwrap_or(0.0),
    })
}

/// A box with its background, for searches in some of its pings.
struct Look<'a> {
    survey: &'a Survey,
    grid: RangeSteps,
    background: BackgroundLevels,
    /// Mean level of the background.
    level: f64,
    /// Least length of a dark run that is a shadow, and the end of the recorded range, metres.
    shortest_m: f64,
    end_m: f64,
}

/// Steps of a dark run behind an echo, and its shadow.
type DarkRun = (Range<usize>, Shadow);

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

    /// Returns the slant range at which a step begins, metres.
    fn range_m(&self, step: usize) -> f64 {
        self.grid.from_m + step as f64 * self.grid.step_m
    }

    /// Returns the level of each step above the background in some pings; `None` if none of them
    /// was recorded.
    fn contrast(&self, pings: Range<usize>) -> Option<Vec<f64>> {
        let echo = self.grid.profile(self.survey, pings)?;
        let both = echo.iter().zip(&self.background.levels);
        Some(both.map(|(echo, quiet)| echo - quiet).collect())
    }

    /// Returns the shadow of the top of an object, from the shadows of the slices of its box, and
    /// their spread; `None` if the shadow is not whole.
    fn top_shadow(
        &self,
        pings: &Range<usize>,
        core: &Shadow,
        top: TopShape,
    ) -> Option<(Shadow, f64)> {
        let places: Vec<Range<usize>> = slices(pings).collect();
        let mut darkness = Vec::with_capacity(places.len());
        let (mut shadows, mut flat) = (Vec::with_capacity(places.len()), 0);
        for pings in &places {
            let Some(contrast) = self.contrast(pings.clone()) else {
                continue;
            };
            let Some((_, Some((dark, shadow)))) = self.at(&contrast) else {
                continue;
            };
            darkness.push(darkness_of(&contrast[dark.clone()]));
            if shadow.end_m.is_nan() && core.end_m.is_finite() {
                continue;
            }
            let end = dark.end.max(self.step_of(shadow.end_m)).min(contrast.len());
            let from = self.step_of(shadow.bright_end_m).min(end);
            let level = flat_top(&contrast[from..end]);
            flat += usize::from(level.is_some());
            let start_m = level.map_or(shadow.start_m, |steps| self.range_m(from + steps));
            shadows.push(Shadow { start_m, ..shadow });
        }
        let is_whole = darkness.len() as f64 >= WHOLE * places.len() as f64
            && (self.background.speckle.is_nan()
                || median(&mut darkness) >= DARK_SPECKLES * self.background.speckle);
        let share = match top {
            TopShape::Even => EVEN_TOP,
            TopShape::Peaked => PEAKED_TOP,
            TopShape::Unknown if 2 * flat >= shadows.len() => FLAT_TOP,
            TopShape::Unknown => OTHER_TOP,
        };
        longest(shadows, share).filter(|_| is_whole)
    }

    /// Returns the step whose start is nearest to a slant range.
    fn step_of(&self, range_m: f64) -> usize {
        ((range_m - self.grid.from_m) / self.grid.step_m).round().max(0.0) as usize
    }

    /// Returns the shadow in some pings, if no part of the object follows behind it up to the far
    /// edge of the box.
    fn behind_all(&self, pings: Range<usize>, far_m: f64) -> Option<Shadow> {
        let contrast = self.contrast(pings)?;
        let (echo_m, dark) = self.at(&contrast)?;
        let (_, shadow) = dark?;
        // A shadow that continues beyond the range has nothing behind it.
        let from =
            if shadow.end_m.is_nan() { return Some(shadow) } else { self.step_of(shadow.end_m) };
        let behind = from..self.step_of(far_m).min(contrast.len());
        let echo = self.step_of(echo_m[0])..self.step_of(echo_m[1]);
        let echo_gain = profile::gain(contrast.get(echo)?);
        let goes_on = (contrast.get(behind))
            .is_some_and(|behind| profile::brightest(behind) > GOES_ON * echo_gain);
        (!goes_on).then_some(shadow)
    }

    /// Finds the echo in the contrast of some pings, the steps of the dark run behind it, and the
    /// shadow of this run.
    fn at(&self, contrast: &[f64]) -> Option<([f64; 2], Option<DarkRun>)> {
        let (echo, shadow) = runs(contrast, (GAP_M / self.grid.step_m) as usize)?;
        let echo_m = [self.range_m(echo.start), self.range_m(echo.end)];
        let dark = shadow.and_then(|dark| {
            let shadow = self.shadow(contrast, echo_m[1], dark.clone())?;
            Some((dark, shadow))
        });
        Some((echo_m, dark))
    }

    /// Creates the shadow from a dark run behind a bright one; `None` if the dark run is speckle.
    fn shadow(&self, contrast: &[f64], bright_end_m: f64, dark: Range<usize>) -> Option<Shadow> {
        let darkness = darkness_of(&contrast[dark.clone()]);
        let dark_m = dark.len() as f64 * self.grid.step_m;
        if darkness < DARKER * self.level || dark_m < self.shortest_m {
            return None;
        }
        // If the speckle is NaN, this is half of the darkness.
        let lit = (HALF_POWER * self.background.speckle).min(0.5 * darkness);
        let end_m = self.range_m(last_below(contrast, dark.start, -lit));
        let ends = end_m < self.end_m - 2.0 * self.grid.step_m;
        Some(Shadow {
            bright_end_m,
            start_m: self.range_m(dark.start),
            end_m: if ends { end_m } else { f64::NAN },
        })
    }
}

/// Returns the mean darkness of a run: the level of the background minus that of the run.
fn darkness_of(contrast: &[f64]) -> f64 {
    -contrast.iter().sum::<f64>() / contrast.len() as f64
}

/// Returns the number of steps of a flat top before its shadow, in the stretch between the bright
/// run and the end of the shadow: the steps before the split that explains the levels best. `None`
/// if the split explains little, so that the whole stretch is one shadow.
fn flat_top(contrast: &[f64]) -> Option<usize> {
    let count = contrast.len() as f64;
    let total: f64 = contrast.iter().sum();
    let squares: f64 = contrast.iter().map(|level| level * level).sum();
    let mut before = 0.0;
    let mut best: Option<(f64, usize, [f64; 2])> = None;
    for (step, level) in contrast.iter().enumerate().take(contrast.len().saturating_sub(1)) {
        before += level;
        let steps = (step + 1) as f64;
        let means = [before / steps, (total - before) / (count - steps)];
        let explained = means[0] * means[0] * steps + means[1] * means[1] * (count - steps);
        if best.is_none_or(|(most, ..)| explained > most) {
            best = Some((explained, step + 1, means));
        }
    }
    let (explained, steps, [top, shadow]) = best?;
    let gain = explained - total * total / count;
    let residual = (squares - explained) / count;
    (shadow < 0.0 && top > TOP_DARKNESS * shadow && gain >= TOP_GAIN * residual).then_some(steps)
}

/// Returns the step up to which a profile stays below a level from a step on: the step at which the
/// sum of the differences to the level is largest.
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

/// Returns the middle pings of a box.
fn core(pings: &Range<usize>) -> Range<usize> {
    let count = ((CORE * pings.len() as f64).ceil() as usize).max(CORE_PINGS);
    let start = (pings.start + pings.end).saturating_sub(count) / 2;
    start.max(pings.start)..(start + count).min(pings.end)
}

/// Returns the slices of a box: a few neighbouring pings at several places.
fn slices(pings: &Range<usize>) -> impl Iterator<Item = Range<usize>> {
    let count = ((SLICE * pings.len() as f64).ceil() as usize).max(SLICE_PINGS).min(pings.len());
    let (start, last) = (pings.start, pings.len() - count);
    let stride = last.div_ceil(SLICES).max(1);
    (0..=last).step_by(stride).map(move |first| start + first..start + first + count)
}

/// Returns the shadow of the top among the shadows of several slices: the share `share` of them is
/// no longer. The length is `(end - start) / end`, to which the height is in proportion; a shadow
/// that continues beyond the range is longer than any other. Also returns the standard deviation of
/// the shadows about it, in the same measure.
fn longest(mut shadows: Vec<Shadow>, share: f64) -> Option<(Shadow, f64)> {
    let length = |shadow: &Shadow| {
        if shadow.end_m.is_nan() { 1.0 } else { 1.0 - shadow.start_m / shadow.end_m }
    };
    shadows.sort_by(|a, b| length(a).total_cmp(&length(b)));
    let last = shadows.len().checked_sub(1)?;
    let at = |share: f64| shadows.get((share * last as f64).round() as usize);
    let ends = at(0.16).zip(at(0.84));
    let spread = ends.map_or(0.0, |(short, long)| 0.5 * (length(long) - length(short)));
    Some((*at(share)?, spread))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ReviewSettings;
    use bathyscope_log::survey::Side;

    #[test]
    fn some_usual_classes_tell_the_shape_of_the_top() {
        let classes = ReviewSettings::default().classes;
        let of_class = |top| classes.iter().filter(|name| TopShape::of_class(name) == top).count();
        assert_eq!([TopShape::Even, TopShape::Peaked].map(of_class), [3, 1], "{classes:?}");
        let shadow = |end_m: f64| Shadow { bright_end_m: 6.0, start_m: 6.0, end_m };
        let shadows: Vec<Shadow> = [7.0, 7.4, 7.8, 8.2, 8.6].map(shadow).to_vec();
        let end_m = |share: f64| longest(shadows.clone(), share).unwrap().0.end_m;
        assert_eq!([EVEN_TOP, FLAT_TOP, PEAKED_TOP].map(end_m), [7.8, 8.2, 8.2]);
    }

    #[test]
    fn drawn_edges_are_the_parts_and_a_shadow_to_the_end_has_no_end() {
        let mark = Mark::new(Side::Port, 3..9, [4.0, 7.0]);
        let whole = set_parts(&mark, 5.0, 12.0);
        assert_eq!(whole.echo_m, [4.0, 5.0]);
        assert_eq!(whole.shadow_m, Some([5.0, 7.0]));
        assert_eq!(whole.longest.map(|shadow| shadow.bright_end_m), Some(5.0));
        let none = set_parts(&mark, 7.0, 12.0);
        assert_eq!((none.shadow_m, none.longest), (None, None));
        let off = set_parts(&mark, 5.0, 7.0);
        assert!(off.shadow_m.is_some_and(|shadow| shadow[1].is_nan()));
    }
}
