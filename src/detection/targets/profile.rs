//! Levels by slant range in some pings of one side.

use crate::detection::Mark;
use crate::survey::{Side, Survey};
use std::ops::Range;

/// Pings to each side of the box that the background is taken from, and those next to it that are left out.
const BESIDE: usize = 24;
const APART: usize = 2;

/// Equal steps of slant range on one side.
pub(super) struct Grid {
    pub(super) side: Side,
    pub(super) from_m: f64,
    pub(super) step_m: f64,
    pub(super) steps: usize,
}

impl Grid {
    /// Mean level of some pings at each step; `None` where none of them was recorded.
    pub(super) fn profile(&self, survey: &Survey, pings: Range<usize>) -> Option<Vec<f64>> {
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
    pub(super) fn background(&self, survey: &Survey, mark: &Mark) -> Option<Vec<f64>> {
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
