//! Levels by slant range in some pings of one side.

use crate::Mark;
use bathyscope_log::support::statistics::median;
use bathyscope_log::survey::{Side, Survey};
use std::ops::Range;

/// Pings to each side of the box that the background is taken from, and those next to it that are
/// left out.
const NEIGHBOUR_PINGS: usize = 24;
const APART: usize = 2;

/// Equal steps of slant range on one side.
pub(super) struct RangeSteps {
    pub(super) side: Side,
    pub(super) from_m: f64,
    pub(super) step_m: f64,
    pub(super) steps: usize,
}

impl RangeSteps {
    /// Mean level of some pings at each step; `None` where none of them was recorded.
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

    /// Pings before and behind a box, that the background is taken from.
    pub(super) fn beside(survey: &Survey, mark: &Mark) -> [Range<usize>; 2] {
        let before = mark.pings.start.saturating_sub(APART);
        let behind = (mark.pings.end + APART).min(survey.side_scan.len());
        [
            before.saturating_sub(NEIGHBOUR_PINGS)..before,
            behind..(behind + NEIGHBOUR_PINGS).min(survey.side_scan.len()),
        ]
    }

    /// Returns the levels on the pings before and behind the box; `None` where there are none.
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
        let mut swings: Vec<f64> = pings
            .into_iter()
            .flatten()
            .filter_map(|ping| self.swing(survey, ping, &levels))
            .collect();
        Some(BackgroundLevels { speckle: median(&mut swings), levels })
    }

    /// Standard deviation of one ping's samples about its own mean level over the background.
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

/// Levels on the pings next to a box.
pub(super) struct BackgroundLevels {
    /// Mean level at each step, smoothed over range.
    pub(super) levels: Vec<f64>,
    /// Standard deviation of single samples about it; NaN where it is not known.
    pub(super) speckle: f64,
}
