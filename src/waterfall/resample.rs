//! From samples to texels: every ping placed by its metres, then pings and bins reduced to mean and maximum.

use super::axis::is_usable;
use super::{Level, RangeAxis};
use crate::survey::{Side, SideSpan, Survey};
use std::ops::Range;

/// Which samples fall into each bin, for spans of one scale.
struct Bins {
    /// `(near_m, far_m, count)` that the table is for.
    scale: Option<(f32, f32, u32)>,
    /// Sample range of each bin; empty where the span does not reach.
    samples: Vec<Range<u32>>,
}

impl Bins {
    /// Refills the table for a span of another scale; spans of a log mostly share theirs.
    fn fit(&mut self, span: &SideSpan, first_bin_m: f64, bin_m: f64) {
        let scale = (span.near_m, span.far_m, span.count);
        if self.scale == Some(scale) {
            return;
        }
        self.scale = Some(scale);
        for (index, samples) in self.samples.iter_mut().enumerate() {
            let near_m = first_bin_m + index as f64 * bin_m;
            *samples = samples_between(span, near_m, near_m + bin_m);
        }
    }
}

/// The samples whose centres lie between two ranges; the one under the middle where bins are finer than samples.
fn samples_between(span: &SideSpan, near_m: f64, far_m: f64) -> Range<u32> {
    let count = f64::from(span.count);
    let edge = |range_m: f64| (span.sample_at(range_m) + 0.5).floor().clamp(0.0, count) as u32;
    let (first, last) = (edge(near_m), edge(far_m));
    if first < last {
        return first..last;
    }
    let middle = span.sample_at((near_m + far_m) / 2.0).floor();
    if middle < 0.0 || middle >= count {
        return 0..0;
    }
    middle as u32..middle as u32 + 1
}

/// Sum, count and maximum of the samples of one texel.
#[derive(Clone, Copy, Default)]
struct Sum {
    total: u64,
    count: u64,
    max: u8,
}

impl Sum {
    fn add(&mut self, samples: &[u8]) {
        self.total += samples.iter().map(|&sample| u64::from(sample)).sum::<u64>();
        self.count += samples.len() as u64;
        self.max = samples.iter().copied().fold(self.max, u8::max);
    }

    fn texel(&self) -> [u8; 2] {
        match (self.total + self.count / 2).checked_div(self.count) {
            Some(mean) => [(mean as u8).max(1), self.max.max(1)],
            None => [0, 0],
        }
    }
}

/// The texels of one side over `pings` and `width` texels of range from `first_bin` outward, row by row.
/// The last row covers fewer pings when `pings` is no multiple of the level's.
pub(super) fn resample(
    survey: &Survey,
    axis: &RangeAxis,
    side: Side,
    level: Level,
    pings: Range<usize>,
    first_bin: usize,
    width: usize,
) -> Vec<[u8; 2]> {
    let bin_m = axis.bin_m * level.bins() as f64;
    let first_bin_m = axis.bin_m * first_bin as f64;
    let mut bins = Bins {
        scale: None,
        samples: vec![0..0; width],
    };
    let mut outward = Vec::new();
    let mut texels = Vec::with_capacity(width * pings.len().div_ceil(level.pings()));
    let mut row = vec![Sum::default(); width];
    for first in pings.clone().step_by(level.pings()) {
        row.fill(Sum::default());
        for ping in first..(first + level.pings()).min(pings.end) {
            let span = survey.side_scan.get(ping).and_then(|ping| ping.side(side));
            let (Some(span), Some(samples)) = (span, survey.samples(ping, side)) else {
                continue;
            };
            if !is_usable(span) {
                continue;
            }
            bins.fit(span, first_bin_m, bin_m);
            samples.copy_outward(&mut outward);
            for (sum, samples) in row.iter_mut().zip(&bins.samples) {
                sum.add(&outward[samples.start as usize..samples.end as usize]);
            }
        }
        texels.extend(row.iter().map(Sum::texel));
    }
    texels
}
