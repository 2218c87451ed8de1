//! The echo and the shadow inside a box.

use super::profile::{self, BackgroundLevels, RangeSteps, Runs, runs};
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
    /// The shadow of the object's top, where it is whole: dark, and behind most of the pings. Where
    /// the top is round, or the object lies askew, [`Parts::shadow_m`] ends before it, where half
    /// of the pings receive the bottom again.
    pub longest: Option<Shadow>,
    /// Standard deviation of the shadows of neighbouring pings about it, as shares of the altitude;
    /// 0 where the edges are set by hand.
    pub spread: f64,
}

/// A shadow in a few pings, metres of slant range.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shadow {
    /// End of the bright run before it. Between this and the dark may lie the object's top, no
    /// brighter than the bottom, or bottom.
    pub bright_end_m: f64,
    /// Start of the dark.
    pub start_m: f64,
    /// Range at which the echo of the bottom returns; NaN where the dark runs off the range.
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
/// The share of those places whose shadow is no longer than the one taken for that of the top:
/// speckle lengthens some of so few pings. An even top casts the same shadow everywhere, a peaked
/// one its longest in the middle, and the walls of a large object are of different heights. Where
/// the class does not say which it is, a flat top that is seen stands for an even one. Heights of
/// simulated objects then have no bias.
const EVEN_TOP: f64 = 0.5;
const PEAKED_TOP: f64 = 0.85;
const FLAT_TOP: f64 = 0.65;
const OTHER_TOP: f64 = 0.75;
const LARGE: f64 = 0.9;
/// A shadow is whole where it lies behind so large a share of those places, and is darker than the
/// background by so many standard deviations of its samples: what is lit in part, or broken, casts
/// no shadow that tells a height.
const WHOLE: f64 = 0.7;
const DARK_SPECKLES: f64 = 0.58;
/// A flat top that is no brighter than the bottom lies between what is bright and the shadow. It is
/// told apart where two levels explain what lies there so many times better than what is left
/// beside them, and the top is at most so large a share as dark as the shadow.
const TOP_GAIN: f64 = 10.0;
const TOP_DARKNESS: f64 = 0.7;
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

/// The height of an object along the track.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum TopShape {
    /// Not known.
    #[default]
    Unknown,
    /// The same all along, as of a pipe.
    Even,
    /// Highest in the middle, as of a rock.
    Peaked,
}

impl TopShape {
    /// Returns that of a class by its name.
    pub fn of_class(name: &str) -> Self {
        match name {
            "block" | "cylinder" | "pipe" => Self::Even,
            "rock" => Self::Peaked,
            _ => Self::Unknown,
        }
    }
}

/// Returns true if a box holds a large object, of which [`drawn_parts`] speaks. `length_m` is its
/// extent along the track.
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
        return Some(Parts {
            echo_m: [mark.near_m, mark.far_m],
            shadow_m: None,
            longest: None,
            spread: 0.0,
        });
    };
    let ends = shadows.iter().map(|one| one.end_m);
    let (longest, spread) = longest(shadows.clone(), LARGE).unzip();
    Some(Parts {
        echo_m: [mark.near_m, start_m],
        // NaN is the larger: a shadow that runs off the range is longer than any.
        shadow_m: ends.max_by(f64::total_cmp).map(|end_m| [start_m, end_m]),
        longest,
        spread: spread.unwrap_or(0.0),
    })
}

/// The echo and the shadow as the analyst has set them. One that ends with what was recorded, to
/// `reach_m` on the recorder's scale, runs off the range.
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

/// Finds the echo and its shadow: the bright run, and the dark run behind it, that explain the
/// levels in the middle pings of the box best (least squares about the background, which is what
/// the pings before and behind the box receive at the same range). `None` where the box holds no
/// samples.
pub fn parts(survey: &Survey, mark: &Mark, top: TopShape) -> Option<Parts> {
    let look = Look::new(survey, mark)?;
    let (echo_m, shadow) = look.at(core(&mark.pings))?;
    let of_top = shadow.and_then(|shadow| look.top_shadow(&mark.pings, &shadow, top));
    let (longest, spread) = of_top.unzip();
    Some(Parts {
        echo_m,
        shadow_m: shadow.map(|shadow| [shadow.start_m, shadow.end_m]),
        longest,
        spread: spread.unwrap_or(0.0),
    })
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

    /// Brightness of each step over the background in some pings.
    fn contrast(&self, pings: Range<usize>) -> Option<Vec<f64>> {
        let echo = self.grid.profile(self.survey, pings)?;
        let both = echo.iter().zip(&self.background.levels);
        Some(both.map(|(echo, quiet)| echo - quiet).collect())
    }

    /// The shadow of the top of an object, by places of its box, and the spread of these; `None`
    /// where it is not whole.
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
            let Some((contrast, dark, shadow)) = self.dark_at(pings.clone()) else {
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

    /// The step that holds a slant range.
    fn step_of(&self, range_m: f64) -> usize {
        ((range_m - self.grid.from_m) / self.grid.step_m).round().max(0.0) as usize
    }

    /// The shadow in some pings behind which nothing of the object comes any more up to the end of
    /// its box.
    fn behind_all(&self, pings: Range<usize>, far_m: f64) -> Option<Shadow> {
        let contrast = self.contrast(pings.clone())?;
        let (echo_m, shadow) = self.at(pings)?;
        let shadow = shadow?;
        // A shadow that runs off the range has nothing behind it.
        let from =
            if shadow.end_m.is_nan() { return Some(shadow) } else { self.step_of(shadow.end_m) };
        let behind = from..self.step_of(far_m).min(contrast.len());
        let echo = self.step_of(echo_m[0])..self.step_of(echo_m[1]);
        let echo_gain = profile::gain(contrast.get(echo)?);
        let goes_on = (contrast.get(behind))
            .is_some_and(|behind| profile::brightest(behind) > GOES_ON * echo_gain);
        (!goes_on).then_some(shadow)
    }

    /// The echo and its shadow in some pings.
    fn at(&self, pings: Range<usize>) -> Option<([f64; 2], Option<Shadow>)> {
        let contrast = self.contrast(pings)?;
        let Runs { echo, shadow } = runs(&contrast, (GAP_M / self.grid.step_m) as usize)?;
        let echo_m = [self.range_m(echo.start), self.range_m(echo.end)];
        Some((echo_m, shadow.and_then(|dark| self.shadow(&contrast, echo_m[1], dark))))
    }

    /// The contrast of some pings, the steps of the dark run behind their echo, and the shadow that
    /// it is of.
    fn dark_at(&self, pings: Range<usize>) -> Option<(Vec<f64>, Range<usize>, Shadow)> {
        let contrast = self.contrast(pings)?;
        let Runs { echo, shadow } = runs(&contrast, (GAP_M / self.grid.step_m) as usize)?;
        let dark = shadow?;
        let shadow = self.shadow(&contrast, self.range_m(echo.end), dark.clone())?;
        Some((contrast, dark, shadow))
    }

    /// The shadow of a dark run behind what is bright; `None` where it is speckle.
    fn shadow(&self, contrast: &[f64], bright_end_m: f64, dark: Range<usize>) -> Option<Shadow> {
        let darkness = darkness_of(&contrast[dark.clone()]);
        let dark_m = dark.len() as f64 * self.grid.step_m;
        if darkness < DARKER * self.level || dark_m < self.shortest_m {
            return None;
        }
        // NaN gives half of the darkness.
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

/// Mean darkness of a run: the level of the background less that of the run.
fn darkness_of(contrast: &[f64]) -> f64 {
    -contrast.iter().sum::<f64>() / contrast.len() as f64
}

/// Steps of a flat top before its shadow, in what lies between the bright face and the end of the
/// shadow: those before the split that explains the levels best, where it does so clearly. `None`
/// where all of it is one shadow.
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

/// The shadow of the top among those of several places: so large a share of them is no longer, by
/// `(end - start) / end`, which the height is in proportion to. One that runs off the range is
/// longer than any. With it the standard deviation of the others about it, in that measure.
fn longest(mut shadows: Vec<Shadow>, share: f64) -> Option<(Shadow, f64)> {
    let length =
        |one: &Shadow| if one.end_m.is_nan() { 1.0 } else { 1.0 - one.start_m / one.end_m };
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
        assert_eq!(whole.longest.map(|one| one.bright_end_m), Some(5.0));
        let none = set_parts(&mark, 7.0, 12.0);
        assert_eq!((none.shadow_m, none.longest), (None, None));
        let off = set_parts(&mark, 5.0, 7.0);
        assert!(off.shadow_m.is_some_and(|shadow| shadow[1].is_nan()));
    }
}
