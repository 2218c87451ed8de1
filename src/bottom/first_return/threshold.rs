//! Finds first returns by the simple threshold, fast enough to follow a slider over any length of
//! log.
//!
//! The first sample that reaches a level is always greater than all samples before it. Such running
//! maxima are few (six to ten of 1400 samples), so they are kept for each side of a ping, and a
//! level is searched among them alone.

use super::confidence::{Gathering, MethodPick};
use super::normalise::{BLOCK, WORD, dead_samples, words_outward};
use super::{FirstReturns, ImageSettings, Method, Normalisation, SampleMode, Settled};
use bathyscope_log::support::progress::{Cancelled, Progress};
use bathyscope_log::survey::{Samples, Side, Survey};
use rayon::prelude::*;

/// Index that finds where any threshold is first reached without reading the picture again.
///
/// An index is built once for a survey, a sample mode and a dead zone. It takes about 3 bytes for
/// each running maximum: some 6 MB for 100 000 pings. Samples beyond the 65 535th of a side are not
/// searched.
#[derive(Clone, Debug)]
pub struct ThresholdIndex {
    normalisation: Normalisation,
    maxima: Maxima,
    /// [`Survey::good_depth_m`] of every ping.
    depths_m: Vec<f32>,
}

#[derive(Clone, Debug)]
enum Maxima {
    Bytes(Staircases<u8>),
    Words(Staircases<i32>),
}

impl ThresholdIndex {
    /// Builds the index in two passes over the picture: one for its normalisation, one for the
    /// running maxima.
    ///
    /// # Errors
    /// When the work was cancelled.
    pub fn build(
        survey: &Survey,
        image: &ImageSettings,
        dead_zone_m: f64,
        progress: &Progress,
    ) -> Result<Self, Cancelled> {
        let normalisation = Normalisation::measure(survey, image, dead_zone_m, progress)?;
        Self::by(survey, image, normalisation, progress)
    }

    /// Builds the index with a known normalisation, in one pass over the picture for the running
    /// maxima.
    pub(super) fn by(
        survey: &Survey,
        image: &ImageSettings,
        normalisation: Normalisation,
        progress: &Progress,
    ) -> Result<Self, Cancelled> {
        let dead_zone_m = normalisation.dead_zone_m;
        let maxima = match image.samples {
            SampleMode::Bytes => {
                Maxima::Bytes(Staircases::collect(survey, dead_zone_m, climb_bytes, progress)?)
            }
            SampleMode::Words => {
                Maxima::Words(Staircases::collect(survey, dead_zone_m, climb_words, progress)?)
            }
        };
        let pings = 0..survey.side_scan.len();
        let depths_m = pings.into_par_iter().map(|ping| survey.good_depth_m(ping));
        Ok(Self { normalisation, maxima, depths_m: depths_m.collect() })
    }

    /// Returns the first sample of each side of each ping, outward, whose normalised intensity
    /// reaches `level`.
    pub(super) fn found(&self, level: f32) -> Settled {
        let levels = ThresholdLevels::new(&self.normalisation, level);
        let side = |side: usize| {
            let pings = (0..self.depths_m.len()).into_par_iter();
            let found = pings.with_min_len(BLOCK).map(|ping| {
                let place = 2 * ping + side;
                match &self.maxima {
                    Maxima::Bytes(steps) => levels.find(steps.of(place)),
                    Maxima::Words(steps) => levels.find(steps.of(place)),
                }
            });
            found.collect()
        };
        Settled { found: [side(0), side(1)], depths_m: self.depths_m.clone() }
    }

    /// Returns the first returns of the whole survey at one threshold. `survey` must be the one
    /// that the index was built from.
    pub fn detect(
        &self,
        survey: &Survey,
        threshold: f32,
        above_bottom_margin_m: f64,
    ) -> FirstReturns {
        let sides = Gathering {
            survey,
            first: 0,
            settled: &self.found(threshold),
            margin_m: above_bottom_margin_m,
            dead_zone_m: self.normalisation.dead_zone_m,
            method: Method::Threshold,
        }
        .picks();
        FirstReturns::of_sides(sides, &self.normalisation)
    }
}

/// Threshold as a value of the picture, with the values of a threshold a tenth lower and a tenth
/// higher, for the confidence.
struct ThresholdLevels {
    level: i64,
    below: i64,
    above: i64,
}

impl ThresholdLevels {
    fn new(normalisation: &Normalisation, level: f32) -> Self {
        Self {
            level: normalisation.raw_level(level),
            below: normalisation.raw_level(level * 0.9),
            above: normalisation.raw_level(level * 1.1),
        }
    }

    fn find<V: Copy + Into<i64>>(&self, (at, values): (&[u16], &[V])) -> MethodPick {
        let first = |level: i64| values.partition_point(|&value| value.into() < level);
        let step = first(self.level);
        let Some(&sample) = at.get(step) else {
            return MethodPick::NONE;
        };
        let sample = f32::from(sample);
        let near = f32::from(at[first(self.below).min(step)]);
        // Where no sample reaches the higher level, twice the distance is used.
        let far = at.get(first(self.above)).map_or(2.0 * sample, |&at| f32::from(at));
        let share = |samples: f32| (samples / sample.max(1.0)).min(1.0);
        MethodPick { sample, signs: [share(sample - near), share(far - sample), 0.0] }
    }
}

/// Running maxima of a block of rows; within a row, sample index and value both rise.
struct Staircase<V> {
    at: Vec<u16>,
    value: Vec<V>,
    /// Buffer for the samples of the current row.
    row: Vec<u8>,
}

impl<V: Copy + PartialOrd> Staircase<V> {
    fn step(&mut self, sample: usize, value: V, highest: &mut Option<V>) {
        if highest.is_none_or(|highest| value > highest)
            && let Ok(at) = u16::try_from(sample)
        {
            *highest = Some(value);
            self.at.push(at);
            self.value.push(value);
        }
    }
}

/// Running maxima of all rows, packed: port, then starboard, of each ping.
#[derive(Clone, Debug)]
struct Staircases<V> {
    starts: Vec<u32>,
    at: Vec<u16>,
    value: Vec<V>,
}

impl<V: Copy + Send + Sync + PartialOrd> Staircases<V> {
    /// Collects the running maxima of a survey: `climb` adds those of the samples of a side, of
    /// which as many as its third argument lie in the dead zone.
    fn collect(
        survey: &Survey,
        dead_zone_m: f64,
        climb: impl Fn(Samples<'_>, Side, usize, &mut Staircase<V>) + Sync,
        progress: &Progress,
    ) -> Result<Self, Cancelled> {
        let pings = survey.side_scan.len();
        progress.start(pings as u64);
        let blocks: Vec<(Vec<u32>, Staircase<V>)> = (0..pings.div_ceil(BLOCK))
            .into_par_iter()
            .map(|block| {
                progress.check()?;
                let range = block * BLOCK..pings.min((block + 1) * BLOCK);
                progress.advance(range.len() as u64);
                let mut stairs = Staircase { at: Vec::new(), value: Vec::new(), row: Vec::new() };
                let mut lengths = Vec::with_capacity(2 * range.len());
                for ping in range {
                    for side in Side::BOTH {
                        let before = stairs.at.len();
                        let recorded = survey.samples(ping, side).zip(survey.span(ping, side));
                        if let Some((samples, span)) = recorded {
                            climb(samples, side, dead_samples(span, dead_zone_m), &mut stairs);
                        }
                        lengths.push((stairs.at.len() - before) as u32);
                    }
                }
                Ok((lengths, stairs))
            })
            .collect::<Result<_, _>>()?;
        Ok(Self::pack(blocks, pings))
    }

    fn pack(blocks: Vec<(Vec<u32>, Staircase<V>)>, pings: usize) -> Self {
        let steps = blocks.iter().map(|(_, stairs)| stairs.at.len()).sum();
        let mut packed = Self {
            starts: Vec::with_capacity(2 * pings + 1),
            at: Vec::with_capacity(steps),
            value: Vec::with_capacity(steps),
        };
        let mut start = 0;
        packed.starts.push(start);
        for (lengths, stairs) in blocks {
            for length in lengths {
                start += length;
                packed.starts.push(start);
            }
            packed.at.extend(stairs.at);
            packed.value.extend(stairs.value);
        }
        packed
    }

    fn of(&self, row: usize) -> (&[u16], &[V]) {
        let (Some(&start), Some(&end)) = (self.starts.get(row), self.starts.get(row + 1)) else {
            return (&[], &[]);
        };
        let steps = start as usize..end as usize;
        (&self.at[steps.clone()], &self.value[steps])
    }
}

/// Number of samples whose maximum is compared first; most groups hold no new maximum.
const STRIDE: usize = 32;

fn climb_bytes(samples: Samples<'_>, _: Side, dead: usize, out: &mut Staircase<u8>) {
    let mut row = std::mem::take(&mut out.row);
    samples.copy_outward(&mut row);
    let mut highest = None;
    for (stride, values) in row[dead.min(row.len())..].chunks(STRIDE).enumerate() {
        let top = values.iter().copied().fold(0, u8::max);
        if highest.is_some_and(|highest| top <= highest) {
            continue;
        }
        for (sample, &value) in (dead + stride * STRIDE..).zip(values) {
            out.step(sample, value, &mut highest);
        }
    }
    out.row = row;
}

fn climb_words(samples: Samples<'_>, side: Side, dead: usize, out: &mut Staircase<i32>) {
    let mut highest = None;
    let first = dead.div_ceil(WORD);
    for (word, value) in (first..).zip(words_outward(samples, side, dead)) {
        out.step(word * WORD, value, &mut highest);
    }
}
