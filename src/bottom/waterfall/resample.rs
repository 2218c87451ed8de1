//! Computes the pixels (texels) of the waterfall at a level of detail: assigns the samples of each
//! ping to steps of range (bins), then takes mean and maximum of each block of pings and bins, so
//! that pings of different ranges line up. Coarse levels are reduced from a store of the whole
//! survey at 16 pings x 8 bins a texel, or a little coarser.

use super::axis::is_usable;
use super::{Level, RangeAxis, TILE, WaterfallTile, WaterfallTileKey};
use bathyscope_log::survey::{Side, SideSpan, Survey};
use std::ops::Range;

/// Samples that fall into each bin of range, for pings that have the same near range, far range and
/// number of samples.
struct Bins {
    /// Scale of the table, `(near_m, far_m, count)`; `None` while it is empty.
    scale: Option<(f32, f32, u32)>,
    /// Range of samples of each bin; empty where the span does not reach the bin.
    samples: Vec<Range<u32>>,
    /// First sample, and number of samples in every bin (except the last), when the bins follow
    /// each other in even steps.
    even: Option<(usize, usize)>,
}

impl Bins {
    /// Fills the table for a span, unless it has the scale already: most spans of a log share one
    /// scale.
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
        self.even = even_steps(&self.samples);
    }

    /// Adds the samples of a ping to the texels that they fall into.
    fn add(&self, outward: &[u8], row: &mut [Sum]) {
        // Sums over steps of a constant size are several times faster than over ranges; nearly
        // every log has such steps.
        match self.even {
            Some((first, 1)) => add_even::<1>(outward, first, row),
            Some((first, 2)) => add_even::<2>(outward, first, row),
            Some((first, 4)) => add_even::<4>(outward, first, row),
            Some((first, 8)) => add_even::<8>(outward, first, row),
            _ => {
                for (sum, samples) in row.iter_mut().zip(&self.samples) {
                    sum.add(&outward[samples.start as usize..samples.end as usize]);
                }
            }
        }
    }
}

/// Returns the first sample and the number of samples in each bin, if the bins follow each other
/// without gaps and all but the last one with samples have the same size; otherwise `None`.
fn even_steps(bins: &[Range<u32>]) -> Option<(usize, usize)> {
    let first = bins.first()?;
    let (step, mut next) = (first.len(), first.start);
    for bin in bins.iter().filter(|bin| !bin.is_empty()) {
        let is_in_step = bin.start == next && bin.len() <= step;
        if !is_in_step || !((next - first.start) as usize).is_multiple_of(step) {
            return None;
        }
        next = bin.end;
    }
    Some((first.start as usize, step))
}

fn add_even<const STEP: usize>(outward: &[u8], first: usize, row: &mut [Sum]) {
    let (whole, rest) = outward.get(first..).unwrap_or_default().as_chunks::<STEP>();
    for (sum, samples) in row.iter_mut().zip(whole) {
        sum.add(samples);
    }
    if let Some(sum) = row.get_mut(whole.len()).filter(|_| !rest.is_empty()) {
        sum.add(rest);
    }
}

/// Returns the samples whose centres lie between two ranges, metres. If there are none, because a
/// bin is narrower than a sample, returns the sample at the middle of the bin.
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
    #[inline]
    fn add(&mut self, samples: &[u8]) {
        self.total += u64::from(samples.iter().map(|&sample| u32::from(sample)).sum::<u32>());
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

/// Returns the texels of one side, row by row: one row for each `level.pings()` of `pings`, and
/// `width` texels outward from `first_bin`, which is counted in bins of the finest level. The last
/// row covers fewer pings when their number is no multiple of `level.pings()`.
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
    let mut bins = Bins { scale: None, samples: vec![0..0; width], even: None };
    let mut outward = Vec::new();
    let mut texels = Vec::with_capacity(width * pings.len().div_ceil(level.pings()));
    let mut row = vec![Sum::default(); width];
    for first in pings.clone().step_by(level.pings()) {
        row.fill(Sum::default());
        for ping in first..(first + level.pings()).min(pings.end) {
            let span = survey.span(ping, side).filter(|span| is_usable(span));
            let (Some(span), Some(samples)) = (span, survey.samples(ping, side)) else {
                continue;
            };
            bins.fit(span, first_bin_m, bin_m);
            samples.copy_outward(&mut outward);
            bins.add(&outward, &mut row);
        }
        texels.extend(row.iter().map(Sum::texel));
    }
    texels
}

/// Store in chunks of `TILE` rows, each of one side and `TILE * 16` pings over the whole range
/// axis.
pub(super) struct Coarse {
    level: Level,
    width: usize,
    /// Chunks of port and starboard of each stretch that is built so far.
    chunks: Vec<[Vec<[u8; 2]>; 2]>,
    chunk_count: usize,
}

impl Coarse {
    /// Creates an empty store.
    pub(super) fn new(axis: &RangeAxis) -> Self {
        let level = axis.store;
        Self {
            level,
            width: (axis.bins as usize).div_ceil(level.bins()),
            chunks: Vec::new(),
            chunk_count: axis.pings.div_ceil(TILE * level.pings()),
        }
    }

    /// Adapts the store to a longer log: stretches that reach beyond the unchanged pings will be
    /// built again.
    pub(super) fn grow(&mut self, axis: &RangeAxis, unchanged: usize) {
        let stretch = TILE * self.level.pings();
        self.chunks.truncate(unchanged / stretch);
        self.chunk_count = axis.pings.div_ceil(stretch);
    }

    /// Returns true if the whole store is built.
    pub(super) fn is_complete(&self) -> bool {
        self.chunks.len() == self.chunk_count
    }

    /// Returns the share of the store that is built, 0 to [`WaterfallTile::COMPLETE`].
    pub(super) fn completeness(&self) -> u8 {
        let whole = self.chunk_count.max(1);
        (self.chunks.len() * usize::from(WaterfallTile::COMPLETE) / whole) as u8
    }

    /// Builds the first stretch that is missing, if any.
    pub(super) fn build_next(&mut self, survey: &Survey, axis: &RangeAxis) {
        if self.is_complete() {
            return;
        }
        let first = self.chunks.len() * TILE * self.level.pings();
        let pings = first..(first + TILE * self.level.pings()).min(axis.pings);
        self.chunks
            .push(Side::BOTH.map(|side| {
                resample(survey, axis, side, self.level, pings.clone(), 0, self.width)
            }));
    }

    /// Returns a tile of the level of the store or a coarser one, from the stretches that are
    /// built; its completeness is the share of the store that existed.
    pub(super) fn tile(&self, axis: &RangeAxis, key: WaterfallTileKey) -> WaterfallTile {
        let (width, height) = size(axis, key);
        let step = Level {
            along: key.level.along - self.level.along,
            across: key.level.across - self.level.across,
        };
        let first_row = key.first_ping() / self.level.pings();
        let first_column = key.first_bin() / self.level.bins();
        let mut texels = Vec::with_capacity(width * height);
        let mut sums = vec![Mean::default(); width];
        for row in 0..height {
            sums.fill(Mean::default());
            let from = first_row + row * step.pings();
            for stored in from..from + step.pings() {
                let stored = self.row(key.side, stored);
                let stored = stored.get(first_column..).unwrap_or_default();
                for (sum, texels) in sums.iter_mut().zip(stored.chunks(step.bins())) {
                    texels.iter().for_each(|&texel| sum.add(texel));
                }
            }
            texels.extend(sums.iter().map(Mean::texel));
        }
        WaterfallTile { key, width, height, texels, completeness: self.completeness() }
    }

    /// Returns a row of the store; empty beyond the survey and where it is not built.
    fn row(&self, side: Side, row: usize) -> &[[u8; 2]] {
        let chunk = self.chunks.get(row / TILE);
        let texels = chunk.map_or(&[][..], |sides| &sides[side as usize]);
        let start = row % TILE * self.width;
        texels.get(start..start + self.width).unwrap_or_default()
    }
}

/// Returns the size of the part of a tile that the survey fills, texels: width over range, height
/// over pings.
pub(super) fn size(axis: &RangeAxis, key: WaterfallTileKey) -> (usize, usize) {
    let left = |extent: usize, first: usize, step: usize| {
        extent.saturating_sub(first).div_ceil(step).min(TILE)
    };
    (
        left(axis.bins as usize, key.first_bin(), key.level.bins()),
        left(axis.pings, key.first_ping(), key.level.pings()),
    )
}

/// Mean of means and maximum of maxima over the texels that have data.
#[derive(Clone, Copy, Default)]
struct Mean {
    total: u32,
    count: u32,
    max: u8,
}

impl Mean {
    fn add(&mut self, [mean, max]: [u8; 2]) {
        self.total += u32::from(mean);
        self.count += u32::from(max > 0);
        self.max = self.max.max(max);
    }

    fn texel(&self) -> [u8; 2] {
        let mean = (self.total + self.count / 2).checked_div(self.count);
        [mean.unwrap_or(0) as u8, self.max]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::waterfall::testing::{even, span, survey};

    fn level(along: u8, across: u8) -> Level {
        Level { along, across }
    }

    /// Computes mean and maximum of a block of samples, one sample at a time.
    fn block(survey: &Survey, side: Side, pings: Range<usize>, samples: Range<usize>) -> [u8; 2] {
        let (mut total, mut count, mut max) = (0.0, 0.0, 0);
        for ping in pings {
            let echoes = survey.samples(ping, side).expect("a recorded side");
            for sample in samples.start..samples.end.min(echoes.len()) {
                total += f64::from(echoes.get(sample));
                count += 1.0;
                max = max.max(echoes.get(sample));
            }
        }
        [((total / count) + 0.5).floor().max(1.0) as u8, max.max(1)]
    }

    #[test]
    fn texels_are_mean_and_maximum_of_their_samples() {
        let survey = even(37, 50);
        let axis = RangeAxis::of(&survey).expect("an axis");
        assert_eq!((axis.bins, axis.pings), (50, 37));
        for (level, width) in [(level(0, 0), 50), (level(2, 1), 25), (level(1, 3), 7)] {
            for side in Side::BOTH {
                let texels = resample(&survey, &axis, side, level, 0..37, 0, width);
                for (index, texel) in texels.iter().enumerate() {
                    let (row, column) = (index / width, index % width);
                    let pings = row * level.pings()..((row + 1) * level.pings()).min(37);
                    let samples = column * level.bins()..(column + 1) * level.bins();
                    assert_eq!(*texel, block(&survey, side, pings, samples), "{row} {column}");
                }
            }
        }
    }

    #[test]
    fn a_target_stays_at_its_metres_where_range_and_sample_count_change() {
        // Each ping has a bright sample at 5 m; the pings have 0-10 m in 100, 0-40 m in 100 and
        // 0-20 m in 640 samples.
        let scales = [(100_u32, 10.0_f32), (100, 40.0), (640, 20.0)];
        let (mut bytes, mut spans) = (Vec::new(), Vec::new());
        for (count, far_m) in scales {
            let samples = span(bytes.len(), count, far_m);
            let target = samples.sample_at(5.01) as usize;
            bytes.extend((0..count as usize).map(|index| if index == target { 200 } else { 10 }));
            spans.push([Some(samples), None]);
        }
        let survey = survey(bytes, spans);
        let axis = RangeAxis::of(&survey).expect("an axis");
        assert_eq!(axis.bins, 1280);
        let width = axis.bins as usize;
        let texels = resample(&survey, &axis, Side::Port, level(0, 0), 0..3, 0, width);
        let bright = (5.01 / axis.bin_m) as usize;
        for (row, (_, far_m)) in texels.chunks(width).zip(scales) {
            assert_eq!(row[bright], [200, 200], "target at 5.01 m of {far_m} m");
            let covered = (f64::from(far_m) / axis.bin_m).round() as usize;
            assert!(row[..covered].iter().all(|texel| texel[1] > 0), "{far_m} m");
            assert!(row[covered..].iter().all(|texel| *texel == [0, 0]), "{far_m} m");
        }
        let starboard = resample(&survey, &axis, Side::Starboard, level(0, 0), 0..3, 0, width);
        assert!(starboard.iter().all(|texel| *texel == [0, 0]), "nothing was recorded there");
    }

    #[test]
    fn damaged_spans_are_left_out() {
        let mut spans = vec![[Some(span(0, 50, 10.0)), None]];
        for (far_m, near_m) in [(f32::NAN, 0.0), (1e9, 0.0), (2.0, 3.0), (5.0, f32::NAN)] {
            let damaged = SideSpan { near_m, ..span(0, 50, far_m) };
            spans.push([Some(damaged), None]);
        }
        spans.push([Some(span(40, 50, 10.0)), None]); // beyond the bytes
        let survey = survey(vec![9; 50], spans);
        let axis = RangeAxis::of(&survey).expect("an axis");
        assert_eq!((axis.bins, axis.far_m), (50, 10.0));
        let texels = resample(&survey, &axis, Side::Port, level(0, 0), 0..6, 0, 50);
        assert!(texels[..50].iter().all(|texel| *texel == [9, 9]));
        assert!(texels[50..].iter().all(|texel| *texel == [0, 0]));
    }

    fn complete(survey: &Survey) -> (RangeAxis, Coarse) {
        let axis = RangeAxis::of(survey).expect("an axis");
        let mut coarse = Coarse::new(&axis);
        while !coarse.is_complete() {
            coarse.build_next(survey, &axis);
        }
        (axis, coarse)
    }

    #[test]
    fn tiles_from_the_store_equal_those_from_the_samples() {
        // A little more than two chunks of the store, with full texels, so that a mean of means is
        // the mean.
        let survey = even(18_000, 200);
        let (axis, coarse) = complete(&survey);
        for (along, across) in [(4, 3), (5, 3), (6, 5)] {
            let level = Level { along, across };
            for column in 0..2 {
                let key = WaterfallTileKey::at_boat(Side::Starboard, [along, across], column);
                let stored = coarse.tile(&axis, key);
                let pings = key.first_ping().min(axis.pings)
                    ..(key.first_ping() + stored.height * level.pings()).min(axis.pings);
                let direct = resample(&survey, &axis, key.side, level, pings, 0, stored.width);
                assert_eq!(stored.texels.len(), direct.len());
                for (stored, direct) in stored.texels.iter().zip(&direct) {
                    assert_eq!(stored[1], direct[1], "maxima are exact");
                    assert!(stored[0].abs_diff(direct[0]) <= 1, "{stored:?} {direct:?}");
                }
            }
        }
    }

    #[test]
    fn the_store_is_small() {
        let (_, coarse) = complete(&even(5_000, 400));
        let bytes: usize = coarse.chunks.iter().flatten().map(|side| side.len() * 2).sum();
        assert!(bytes * 40 <= 5_000 * 800, "{bytes} bytes");
    }
}
