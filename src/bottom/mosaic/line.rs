//! Reads the levels along one side of a ping, at even steps on the ground.

use super::gain::RangeFactors;
use super::layout::MosaicRay;
use super::{Gain, GainTable, MosaicLayout, MosaicSettings};
use crate::vectors::{VectorLoop, vectorised};
use bathyscope_log::support::statistics::ends;
use bathyscope_log::survey::{Side, SideSpan, Survey};
use std::ops::Range;

/// Number of steps of a line in a cell. Between steps a line is linear.
const STEPS: usize = 4;
/// Largest number of pings that a line of a coarse picture is the mean of: more would take more
/// time than their smoothing is worth.
const MOST_AVERAGED: usize = 16;

/// Input and settings that all lines of a picture share.
#[derive(Clone, Copy)]
pub(super) struct LineContext<'a> {
    survey: &'a Survey,
    layout: &'a MosaicLayout,
    /// Gain table; `None` where levels are shown as recorded.
    gain: Option<&'a GainTable>,
    water_column: bool,
    /// Number of steps in a metre on the ground.
    steps_per_m: f64,
}

impl<'a> LineContext<'a> {
    /// Creates the context for cells of `cell_m` metres.
    pub(super) fn new(
        survey: &'a Survey,
        layout: &'a MosaicLayout,
        gain: &'a GainTable,
        settings: &MosaicSettings,
        cell_m: f64,
    ) -> Self {
        Self {
            survey,
            layout,
            gain: (settings.gain == Gain::Empirical).then_some(gain),
            water_column: layout.water_column,
            steps_per_m: STEPS as f64 / cell_m,
        }
    }
}

/// Levels of a part of one side of a ping: each level is the mean over a cell on the ground, and
/// over at least one sample.
pub(super) struct MosaicLine {
    side: Side,
    /// Index of the ping in the layout; `None` while the line is empty.
    of: Option<usize>,
    /// Steps that the line holds, and number of all steps of the ray.
    steps: Range<usize>,
    reach: usize,
    /// Level at each step; NaN where there is no sample.
    levels: Vec<f32>,
    /// Number of steps in a metre on the ground.
    per_m: f64,
    // Buffers, kept to reuse their memory.
    samples: Vec<u8>,
    totals: Vec<u32>,
    by_range: RangeFactors,
    factors: Vec<f32>,
    sums: Vec<f32>,
    edges: Vec<f64>,
    sums_at: Vec<f32>,
}

impl MosaicLine {
    /// Creates an empty line.
    pub(super) fn none(side: Side) -> Self {
        Self {
            side,
            of: None,
            steps: 0..0,
            reach: 0,
            levels: Vec::new(),
            per_m: 0.0,
            samples: Vec::new(),
            totals: Vec::new(),
            by_range: RangeFactors::default(),
            factors: Vec::new(),
            sums: Vec::new(),
            edges: Vec::new(),
            sums_at: Vec::new(),
        }
    }

    /// Returns the level at a distance on the ground; NaN where none is known.
    #[inline(always)]
    pub(super) fn at(&self, ground_m: f64) -> f32 {
        let place = (ground_m * self.per_m - self.steps.start as f64).max(0.0);
        let low = (place as usize).min(self.levels.len().saturating_sub(2));
        match self.levels.get(low..low + 2) {
            Some(&[from, to]) => from + (to - from) * (place - low as f64) as f32,
            _ => f32::NAN,
        }
    }

    /// Ensures that the line holds the part of a side of a ping between the two ground distances
    /// `part_m`. If it does not hold this part yet, the larger part between the distances
    /// `with_margin_m` is read. Returns false when there is nothing to read.
    pub(super) fn read(
        &mut self,
        lines: &LineContext<'_>,
        place: usize,
        ray: &MosaicRay,
        part_m: [f64; 2],
        with_margin_m: [f64; 2],
    ) -> bool {
        let step = |ground_m: f64| (ground_m * lines.steps_per_m).max(0.0);
        let steps = |[from_m, to_m]: [f64; 2], reach: usize| {
            let end = (step(to_m).ceil() as usize).saturating_add(2);
            (step(from_m) as usize).min(reach)..end.min(reach)
        };
        if self.of == Some(place) {
            let part = steps(part_m, self.reach);
            if self.steps.start <= part.start && self.steps.end >= part.end {
                return true;
            }
        }
        self.of = None;
        self.per_m = lines.steps_per_m;
        self.reach = step(ray.shown_m).ceil() as usize + 2;
        self.steps = steps(with_margin_m, self.reach);
        let is_read = vectorised(ReadSteps { line: self, lines, place, ray });
        self.of = is_read.then_some(place);
        is_read
    }

    /// Computes the mean of each cell between its edges; `first` is the sample at which the sums
    /// begin.
    #[inline(always)]
    fn take_means(&mut self, first: f64) {
        let last = (self.sums.len() - 1) as f64;
        let sums = self.sums.as_slice();
        // Each edge belongs to two cells.
        self.sums_at.clear();
        self.sums_at.resize(self.edges.len(), 0.0);
        for (sum, edge) in self.sums_at.iter_mut().zip(&mut self.edges) {
            *edge -= first;
            *sum = sum_at(sums, edge.clamp(0.0, last));
        }
        let edges = self.edges.iter().zip(&self.edges[STEPS..]);
        let sums_at = self.sums_at.iter().zip(&self.sums_at[STEPS..]);
        self.levels.clear();
        self.levels.resize(self.edges.len() - STEPS, f32::NAN);
        for ((level, (&from, &to)), (sum_from, sum_to)) in
            self.levels.iter_mut().zip(edges).zip(sums_at)
        {
            let middle = 0.5 * (from + to);
            *level = if to - from >= 1.0 && middle >= 0.0 && middle <= last {
                (sum_to - sum_from) / (to.min(last) - from.max(0.0)) as f32
            } else {
                mean(sums, from, to)
            };
        }
    }

    /// Normalises and sums some samples outward: `sums[n]` is the sum of the first n. Returns false
    /// when there are none.
    #[inline(always)]
    fn sum_up(
        &mut self,
        lines: &LineContext<'_>,
        place: usize,
        ray: &MosaicRay,
        samples: Range<usize>,
    ) -> bool {
        let count = match lines.layout.ping(place) {
            Some(ping) => self.add_up(lines, ping, lines.layout.stands_for(place), &samples),
            None => 0,
        };
        if count == 0 {
            return false;
        }
        self.factors.clear();
        match lines.gain {
            Some(gain) => {
                let (by_range, factors) = (&mut self.by_range, &mut self.factors);
                gain.factors(self.side, ray, samples.clone(), by_range, factors);
            }
            None => self.factors.resize(samples.len(), 1.0),
        }
        if lines.water_column {
            // The water column is not normalised, since it has no ground.
            let ground = ray.sample_at(ray.altitude_m).max(0.0) as usize;
            let above = ground.saturating_sub(samples.start).min(self.factors.len());
            self.factors[..above].fill(1.0);
        }
        let share = 1.0 / count as f32;
        let length = self.totals.len().min(self.factors.len());
        self.sums.clear();
        self.sums.resize(length + 1, 0.0);
        let levels = self.totals.iter().zip(&self.factors);
        let mut sum = 0.0;
        for (up_to, (&total, factor)) in self.sums[1..].iter_mut().zip(levels) {
            sum += total as f32 * share * factor;
            *up_to = sum;
        }
        length > 0
    }

    /// Adds up some samples of a ping and of those of `around` that were recorded over the same
    /// range. Returns the number of pings that were added.
    fn add_up(
        &mut self,
        lines: &LineContext<'_>,
        ping: usize,
        around: Range<usize>,
        part: &Range<usize>,
    ) -> u32 {
        let survey = lines.survey;
        let own = survey.span(ping, self.side);
        let is_like = |other: usize| {
            let span = survey.span(other, self.side);
            let same = |a: &SideSpan, b: &SideSpan| {
                (a.count, a.near_m, a.far_m) == (b.count, b.near_m, b.far_m)
            };
            own.zip(span).is_some_and(|(own, span)| same(own, span))
        };
        let step = around.len().div_ceil(MOST_AVERAGED).max(1);
        let others = around.step_by(step).filter(|&other| other != ping);
        self.totals.clear();
        let mut count = 0;
        for ping in std::iter::once(ping).chain(others.filter(|&other| is_like(other))) {
            let Some(samples) = survey.samples(ping, self.side) else {
                continue;
            };
            samples.copy_part_outward(part.clone(), &mut self.samples);
            let length = self.samples.len().max(self.totals.len());
            self.totals.resize(length, 0);
            for (total, level) in self.totals.iter_mut().zip(&self.samples) {
                *total += u32::from(*level);
            }
            count += 1;
        }
        count
    }
}

/// Arguments of [`MosaicLine::read`] for the vectorised loop, which returns false when there is
/// nothing to read.
struct ReadSteps<'a> {
    line: &'a mut MosaicLine,
    lines: &'a LineContext<'a>,
    place: usize,
    ray: &'a MosaicRay,
}

impl VectorLoop for ReadSteps<'_> {
    type Output = bool;

    #[inline(always)]
    fn run(self) -> bool {
        let Self { line, lines, place, ray } = self;
        // Places on the ray, in samples, of the edges of all cells whose means are computed.
        line.edges.clear();
        line.edges.resize(line.steps.len() + STEPS, 0.0);
        for (index, edge) in line.edges.iter_mut().enumerate() {
            let step = (line.steps.start + index) as f64 - STEPS as f64 / 2.0;
            *edge = step.max(0.0) / lines.steps_per_m;
        }
        ray.replace_by_samples(&mut line.edges, lines.water_column);
        // Where the bottom rises from under the boat, the nearest sample is not that of the first
        // edge.
        let [low, high] = ends(line.edges.iter().copied());
        let samples =
            (low - 1.0).max(0.0) as usize..((high + 2.0).max(0.0) as usize).min(ray.count);
        if samples.is_empty() || !line.sum_up(lines, place, ray, samples.clone()) {
            return false;
        }
        line.take_means(samples.start as f64);
        true
    }
}

/// Returns the mean of the samples between two places in samples, from their running sums. The mean
/// is over at least one sample; NaN outside.
#[inline(always)]
fn mean(sums: &[f32], from: f64, to: f64) -> f32 {
    let last = (sums.len() - 1) as f64;
    let middle = 0.5 * (from + to);
    let half = (0.5 * (to - from)).max(0.5);
    if middle < 0.0 || middle > last {
        return f32::NAN;
    }
    let (from, to) = ((middle - half).max(0.0), (middle + half).min(last));
    (sum_at(sums, to) - sum_at(sums, from)) / (to - from) as f32
}

/// Returns the sum up to a place in samples, from the running sums.
#[inline(always)]
fn sum_at(sums: &[f32], place: f64) -> f32 {
    let low = (place as usize).min(sums.len() - 2);
    sums[low] + (sums[low + 1] - sums[low]) * (place - low as f64) as f32
}
