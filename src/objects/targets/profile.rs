//! Computes levels by slant range in some pings of one side, and finds their bright and their dark
//! run.

use crate::Mark;
use bathyscope_log::support::statistics::median_of;
use bathyscope_log::survey::{Side, Survey};
use std::ops::Range;

/// Number of pings on each side of the box from which the background is computed, and number of
/// pings next to the box that are left out.
const NEIGHBOUR_PINGS: usize = 24;
const APART: usize = 2;

/// Equal steps of slant range on one side of the survey.
pub(super) struct RangeSteps {
    pub(super) side: Side,
    pub(super) from_m: f64,
    pub(super) step_m: f64,
    pub(super) steps: usize,
}

impl RangeSteps {
    /// Returns the mean level of some pings at each step; `None` if none of the pings was recorded.
    pub(super) fn profile(&self, survey: &Survey, pings: Range<usize>) -> Option<Vec<f64>> {
        let mut sums = vec![0.0; self.steps];
        let mut count = 0.0;
        for ping in pings {
            let (Some(span), Some(samples)) =
                (survey.span(ping, self.side), survey.samples(ping, self.side))
            else {
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

    /// Returns the pings before and behind a box from which the background is computed.
    pub(super) fn beside(survey: &Survey, mark: &Mark) -> [Range<usize>; 2] {
        let before = mark.pings.start.saturating_sub(APART);
        let behind = (mark.pings.end + APART).min(survey.side_scan.len());
        [
            before.saturating_sub(NEIGHBOUR_PINGS)..before,
            behind..(behind + NEIGHBOUR_PINGS).min(survey.side_scan.len()),
        ]
    }

    /// Returns the levels of the background; `None` if no ping before or behind the box was
    /// recorded.
    pub(super) fn background(&self, survey: &Survey, mark: &Mark) -> Option<BackgroundLevels> {
        let pings = Self::beside(survey, mark);
        let both: Vec<Vec<f64>> =
            pings.iter().filter_map(|pings| self.profile(survey, pings.clone())).collect();
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
        let levels: Vec<f64> = (0..self.steps).map(smooth).collect();
        let pings = pings.into_iter().flatten();
        let swings = pings.filter_map(|ping| self.swing(survey, ping, &levels));
        Some(BackgroundLevels { speckle: median_of(swings), levels })
    }

    /// Returns the standard deviation of one ping's samples about its own mean level above the
    /// background.
    fn swing(&self, survey: &Survey, ping: usize, levels: &[f64]) -> Option<f64> {
        let span = survey.span(ping, self.side)?;
        let samples = survey.samples(ping, self.side)?;
        let (mut sum, mut squares, mut count) = (0.0, 0.0, 0.0);
        for (step, level) in levels.iter().enumerate() {
            let range_m = self.from_m + (step as f64 + 0.5) * self.step_m;
            let index = span.sample_at(range_m).max(0.0) as usize;
            if index < samples.len() {
                let above = f64::from(samples.get(index)) - level;
                (sum, squares, count) = (sum + above, squares + above * above, count + 1.0);
            }
        }
        (count > 2.0).then(|| (squares / count - (sum / count).powi(2)).max(0.0).sqrt())
    }
}

/// Levels of the background of a box.
pub(super) struct BackgroundLevels {
    /// Mean level at each step, smoothed over range.
    pub(super) levels: Vec<f64>,
    /// Standard deviation of single samples about the mean level; NaN if it is not known.
    pub(super) speckle: f64,
}

/// Returns the bright run and the dark run behind it, which begins at most `gap` steps later, that
/// together explain most, in steps: a run of `n` steps with the sum `s` reduces the sum of squares
/// by `s^2 / n`. `None` if nothing is brighter than the background.
pub(super) fn runs(contrast: &[f64], gap: usize) -> Option<(Range<usize>, Option<Range<usize>>)> {
    let count = contrast.len();
    let mut sums = vec![0.0; count + 1];
    for (step, value) in contrast.iter().enumerate() {
        sums[step + 1] = sums[step] + value;
    }
    let gain = |run: &Range<usize>, sign: f64| {
        let sum = sign * (sums[run.end] - sums[run.start]);
        if sum > 0.0 { sum * sum / run.len() as f64 } else { 0.0 }
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
        let (shadowed, shadow) =
            behind.iter().max_by(|(a, _), (b, _)| a.total_cmp(b)).cloned().unwrap_or((0.0, 0..0));
        if bright > 0.0 && bright + shadowed > found.0 {
            found = (bright + shadowed, echo, shadow);
        }
    }
    let (_, echo, shadow) = found;
    let is_dark = gain(&shadow, -1.0) > 0.0 && !shadow.is_empty();
    (!echo.is_empty()).then_some((echo, is_dark.then_some(shadow)))
}

/// Returns the reduction of the sum of squares by a run; 0 if the run is no brighter than the
/// background.
pub(super) fn gain(run: &[f64]) -> f64 {
    let sum: f64 = run.iter().sum();
    if sum > 0.0 { sum * sum / run.len() as f64 } else { 0.0 }
}

/// Returns the largest reduction of the sum of squares by a bright run; 0 if nothing is brighter
/// than the background.
pub(super) fn brightest(contrast: &[f64]) -> f64 {
    let starts = 0..contrast.len();
    let runs = starts.flat_map(|start| (start + 1..=contrast.len()).map(move |end| start..end));
    runs.map(|run| gain(&contrast[run])).fold(0.0, f64::max)
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
        assert_eq!(runs(&profile, 4), Some((6..9, Some(10..16))));
        assert!(runs(&[-1.0, -2.0], 4).is_none());
    }
}
