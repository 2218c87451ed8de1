//! The echo and the shadow inside a box.

use crate::detection::Mark;
use crate::statistics::median;
use crate::survey::{Side, Survey};
use std::ops::Range;

/// Echo and shadow of a box by slant range on the recorder's scale, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parts {
    /// Near and far edge of the echo.
    pub echo_m: [f64; 2],
    /// Start and end of the shadow behind it, where there is one; the end is NaN where it runs off the range.
    pub shadow_m: Option<[f64; 2]>,
}

/// Steps that the box and its margin are divided into at most.
const STEPS: usize = 192;
/// Margin behind the box that is looked at, as a share of it: boxes are rarely drawn to the sample.
const MARGIN: f64 = 0.15;
/// Pings to each side of the box that the background is taken from, and those next to it that are left out.
const BESIDE: usize = 24;
const APART: usize = 2;
/// Share of the box's pings, around the middle, in which the object is looked at, and how many at least: fewer are speckle.
const CORE: f64 = 0.5;
const CORE_PINGS: usize = 6;
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
    let core = core(&mark.pings);
    let heard = grid.profile(survey, core)?;
    let background = grid.background(survey, mark).unwrap_or_else(|| {
        let mut levels = heard.clone();
        vec![median(&mut levels); heard.len()]
    });
    let contrast: Vec<f64> = heard
        .iter()
        .zip(&background)
        .map(|(heard, quiet)| heard - quiet)
        .collect();
    let level = background.iter().sum::<f64>() / background.len() as f64;
    let runs = runs(&contrast, (GAP_M / grid.step_m) as usize)?;
    let at = |step: usize| grid.from_m + step as f64 * grid.step_m;
    let dark = runs.shadow.clone().filter(|dark| {
        let mean = contrast[dark.clone()].iter().sum::<f64>() / dark.len() as f64;
        let dark_m = dark.len() as f64 * grid.step_m;
        -mean > DARKER * level && dark_m > SHORTEST_SHADOW_M.max(SHORTEST_SHADOW * length_m)
    });
    let shadow_m = dark.map(|dark| {
        let ends = at(dark.end) < limits[1] - 2.0 * grid.step_m;
        [at(dark.start), if ends { at(dark.end) } else { f64::NAN }]
    });
    Some(Parts {
        echo_m: [at(runs.echo.start), at(runs.echo.end)],
        shadow_m,
    })
}

/// The middle pings of a box.
fn core(pings: &Range<usize>) -> Range<usize> {
    let count = ((CORE * pings.len() as f64).ceil() as usize).max(CORE_PINGS);
    let start = (pings.start + pings.end).saturating_sub(count) / 2;
    start.max(pings.start)..(start + count).min(pings.end)
}

/// Equal steps of slant range on one side.
struct Grid {
    side: Side,
    from_m: f64,
    step_m: f64,
    steps: usize,
}

impl Grid {
    /// Mean level of some pings at each step; `None` where none of them was recorded.
    fn profile(&self, survey: &Survey, pings: Range<usize>) -> Option<Vec<f64>> {
        let mut sums = vec![0.0; self.steps];
        let mut count = 0.0;
        for ping in pings {
            let (Some(span), Some(samples)) = (
                survey.span(ping, self.side),
                survey.samples(ping, self.side),
            ) else {
                continue;
            };
            count += 1.0;
            for (step, sum) in sums.iter_mut().enumerate() {
                let near_m = self.from_m + step as f64 * self.step_m;
                let first = span.sample_at(near_m).max(0.0) as usize;
                let last = span.sample_at(near_m + self.step_m).max(0.0) as usize;
                let covered = first..last.max(first + 1).min(samples.len());
                let width = covered.len();
                if width > 0 {
                    let levels = covered.map(|index| f64::from(samples.get(index)));
                    *sum += levels.sum::<f64>() / width as f64;
                }
            }
        }
        (count > 0.0).then(|| sums.iter().map(|sum| sum / count).collect())
    }

    /// What the pings before and behind the box hear, smoothed over range.
    fn background(&self, survey: &Survey, mark: &Mark) -> Option<Vec<f64>> {
        let before = mark.pings.start.saturating_sub(APART);
        let behind = mark.pings.end + APART;
        let pings = [
            before.saturating_sub(BESIDE)..before,
            behind..(behind + BESIDE).min(survey.side_scan.len()),
        ];
        let heard = pings
            .into_iter()
            .filter_map(|pings| self.profile(survey, pings));
        let both: Vec<Vec<f64>> = heard.collect();
        if both.is_empty() {
            return None;
        }
        let mean = |step: usize| {
            let levels = both.iter().map(|profile| profile[step]);
            levels.sum::<f64>() / both.len() as f64
        };
        let rough: Vec<f64> = (0..self.steps).map(mean).collect();
        let reach = self.steps / 16 + 1;
        let smooth = |step: usize| {
            let around = step.saturating_sub(reach)..(step + reach + 1).min(self.steps);
            let count = around.len() as f64;
            rough[around].iter().sum::<f64>() / count
        };
        Some((0..self.steps).map(smooth).collect())
    }
}

/// The bright and the dark run of a profile.
struct Runs {
    echo: Range<usize>,
    shadow: Option<Range<usize>>,
}

/// The bright run, and the dark run that begins at most `gap` steps behind it, that explain most: a run of `n` steps that
/// sums to `s` takes `s^2 / n` off the squares. `None` where nothing is bright.
fn runs(contrast: &[f64], gap: usize) -> Option<Runs> {
    let count = contrast.len();
    let mut sums = vec![0.0; count + 1];
    for (step, value) in contrast.iter().enumerate() {
        sums[step + 1] = sums[step] + value;
    }
    let gain = |run: &Range<usize>, sign: f64| {
        let sum = sign * (sums[run.end] - sums[run.start]);
        if sum > 0.0 {
            sum * sum / run.len() as f64
        } else {
            0.0
        }
    };
    let best = |candidates: &mut dyn Iterator<Item = Range<usize>>, sign: f64| {
        let gains = candidates.map(|run| (gain(&run, sign), run));
        let best = gains.max_by(|(a, _), (b, _)| a.total_cmp(b));
        best.unwrap_or((0.0, 0..0))
    };
    let dark: Vec<(f64, Range<usize>)> = (0..count)
        .map(|start| best(&mut (start + 1..=count).map(|end| start..end), -1.0))
        .collect();
    let mut found = (0.0, 0..0, 0..0);
    for end in 1..=count {
        let (bright, echo) = best(&mut (0..end).map(|start| start..end), 1.0);
        let behind = &dark[end.min(count)..(end + gap + 1).min(count)];
        let (shadowed, shadow) = behind
            .iter()
            .max_by(|(a, _), (b, _)| a.total_cmp(b))
            .cloned()
            .unwrap_or((0.0, 0..0));
        if bright > 0.0 && bright + shadowed > found.0 {
            found = (bright + shadowed, echo, shadow);
        }
    }
    let (_, echo, shadow) = found;
    (!echo.is_empty()).then(|| Runs {
        shadow: (gain(&shadow, -1.0) > 0.0 && !shadow.is_empty()).then_some(shadow),
        echo,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bright_run_and_the_dark_run_behind_it_are_found() {
        let mut profile = vec![0.5, -0.5, 0.2, -0.1, 0.0, 0.4];
        profile.extend([20.0, 26.0, 18.0, 3.0]);
        profile.extend([-15.0; 6]);
        profile.extend([0.3, -0.8, 0.1, 0.6]);
        let found = runs(&profile, 4).expect("an echo");
        assert_eq!(found.echo, 6..9);
        assert_eq!(found.shadow, Some(10..16));
        assert!(runs(&[-1.0, -2.0], 4).is_none());
    }
}
