//! Computes the empirical gain normalisation: factors from the mean level of the ground, by range
//! and by angle from straight down.
//!
//! Remains of spreading, absorption, the beam's pattern and the recorder's own gain appear as
//! bright and dark bands along the track. Spreading, absorption and time-varied gain depend on the
//! range alone, the beam's pattern and the backscatter of level ground on the angle alone, so the
//! mean level of a side is modelled as the product of two curves. Both are fitted to all pings of
//! the survey at once. At a range and angle that only a few pings reached, the curves come from
//! other pings with this range or this angle; the mean of the few pings alone would remove the
//! objects in them. A shadow or an object is rare at any one range and angle, so it hardly changes
//! a curve and keeps its contrast.
//!
//! Each side has its own curves, since transducers differ, and both sides are scaled to one mean
//! level: ground looks the same to port and to starboard. The brightest levels of the whole survey
//! are then scaled to a fixed level, so that the mosaic of a quiet recorder is not black.

use super::MosaicLayout;
use super::layout::MosaicRay;
use bathyscope_log::support::progress::{Cancelled, Progress};
use bathyscope_log::survey::{Side, Survey};
use rayon::prelude::*;
use std::ops::Range;

const RANGE_BINS: usize = 48;
const ANGLE_BINS: usize = 45;
const BINS: usize = RANGE_BINS * ANGLE_BINS;
/// Weight of the mean of its neighbours for a value of a curve, in samples.
const NEIGHBOURS_COUNT: f64 = 2000.0;
/// Number of rounds in which the two curves are fitted in turn. The change in the last round is far
/// below one level.
const ROUNDS: usize = 60;
/// Least mean level that the goal is divided by.
const LEAST_LEVEL: f64 = 0.5;
/// Largest number of pings that are read: more improve nothing.
const MOST_PINGS: usize = 20_000;
/// Number of pings that a thread sums between two checks for cancellation.
const CHUNK: usize = 256;
/// Bounds of the product of the factors by range and by angle: beyond them there is only noise.
const FACTORS: [f32; 2] = [0.25, 4.0];
/// Share of the normalised samples that are to be below [`BRIGHT_LEVEL`], that level, and the
/// bounds of the factor that scales them to it.
const BRIGHT_SHARE: f64 = 0.98;
const BRIGHT_LEVEL: f32 = 210.0;
const STRETCHES: [f32; 2] = [0.5, 8.0];
/// Step between the pings of the table that determine the bright level.
const BRIGHT_EVERY: usize = 8;

/// Factors on the recorded levels, by side, range and angle.
#[derive(Clone, Debug, PartialEq)]
pub struct GainTable {
    /// Slant range where the curve by range ends, metres.
    pub far_m: f64,
    /// Factor on all levels.
    pub stretch: f32,
    /// Curves of both sides, port first.
    sides: [Curves; 2],
}

/// A factor by range and one by angle, at the middle of each bin.
#[derive(Clone, Debug, PartialEq)]
struct Curves {
    by_range: [f32; RANGE_BINS],
    by_angle: [f32; ANGLE_BINS],
}

/// Sum and count of the levels in each bin of range and angle.
#[derive(Clone)]
struct Sums(Vec<[f64; 2]>);

impl Sums {
    fn none() -> Self {
        Self(vec![[0.0; 2]; BINS])
    }

    fn with(mut self, other: Self) -> Self {
        for (sum, more) in self.0.iter_mut().zip(other.0) {
            *sum = [sum[0] + more[0], sum[1] + more[1]];
        }
        self
    }

    fn total(&self) -> [f64; 2] {
        let add = |a: [f64; 2], b: &[f64; 2]| [a[0] + b[0], a[1] + b[1]];
        self.0.iter().fold([0.0; 2], add)
    }

    /// Adds the samples of a ping on the ground, one run of samples within a bin at a time.
    fn add(&mut self, far_m: f64, ray: &MosaicRay, levels: &[u8]) {
        let mut from = first_beyond(ray, ray.altitude_m).min(levels.len());
        while from < levels.len() {
            let range_m = ray.range_m(from as f64 + 0.5);
            let bin = |place: f64, count: usize| (place as usize).min(count - 1);
            let range = bin(range_m / far_m * RANGE_BINS as f64, RANGE_BINS);
            let angle = bin(obliqueness(range_m, ray.altitude_m) * ANGLE_BINS as f64, ANGLE_BINS);
            let range_end_m = match range + 1 {
                RANGE_BINS => f64::INFINITY,
                next => next as f64 / RANGE_BINS as f64 * far_m,
            };
            let next = (angle + 1) as f64 / ANGLE_BINS as f64;
            let angle_end_m = match angle + 1 {
                ANGLE_BINS => f64::INFINITY,
                _ => ray.altitude_m / (1.0 - next * next),
            };
            let end = first_beyond(ray, range_end_m.min(angle_end_m)).clamp(from + 1, levels.len());
            let sum: u64 = levels[from..end].iter().map(|&level| u64::from(level)).sum();
            let bin = &mut self.0[range * ANGLE_BINS + angle];
            *bin = [bin[0] + sum as f64, bin[1] + (end - from) as f64];
            from = end;
        }
    }
}

/// Returns the first sample whose middle is beyond a range.
#[inline(always)]
fn first_beyond(ray: &MosaicRay, range_m: f64) -> usize {
    (ray.sample_at(range_m) - 0.5).ceil().max(0.0) as usize
}

/// Returns the angle from straight down as `sqrt(1 - cos)`, 0 to 1: nearly in proportion to the
/// angle, without an arc cosine.
#[inline(always)]
fn obliqueness(range_m: f64, altitude_m: f64) -> f64 {
    (1.0 - altitude_m / range_m).max(0.0).sqrt()
}

/// Computes the gain table from the pings that the mosaic shows, at most 20 000 of them, evenly
/// spread.
///
/// # Errors
/// When the work was cancelled.
pub fn gain_table(
    survey: &Survey,
    layout: &MosaicLayout,
    progress: &Progress,
) -> Result<GainTable, Cancelled> {
    let far_m = layout.far_m;
    let step = survey.side_scan.len().div_ceil(MOST_PINGS).max(1);
    let pings: Vec<usize> = (0..survey.side_scan.len()).step_by(step).collect();
    progress.start(2 * pings.len() as u64);
    let sums = |side: Side| -> Result<Sums, Cancelled> {
        let of_chunks = pings.par_chunks(CHUNK).map(|chunk| {
            progress.check()?;
            progress.advance(chunk.len() as u64);
            let mut sums = Sums::none();
            each_ray(survey, layout, side, chunk, |ray, levels| {
                sums.add(far_m, ray, levels);
            });
            Ok(sums)
        });
        of_chunks.try_reduce(Sums::none, |a, b| Ok(a.with(b)))
    };
    let sides = [sums(Side::Port)?, sums(Side::Starboard)?];
    let all = sides.iter().cloned().fold(Sums::none(), Sums::with);
    let [sum, count] = all.total();
    let goal = sum / count.max(1.0);
    let mut table =
        GainTable { far_m, stretch: 1.0, sides: sides.map(|sums| Curves::fitted(&sums, goal)) };
    progress.check()?;
    let few: Vec<usize> = pings.iter().copied().step_by(BRIGHT_EVERY).collect();
    table.stretch = table.stretch(survey, layout, &few);
    Ok(table)
}

/// Calls `take` with each ray of a side and its levels.
fn each_ray(
    survey: &Survey,
    layout: &MosaicLayout,
    side: Side,
    pings: &[usize],
    mut take: impl FnMut(&MosaicRay, &[u8]),
) {
    let mut levels = Vec::new();
    for &ping in pings {
        let ray = layout.ray(ping, side);
        if let (Some(ray), Some(samples)) = (ray, survey.samples(ping, side)) {
            samples.copy_outward(&mut levels);
            take(&ray, &levels);
        }
    }
}

impl Curves {
    /// Fits the factors that scale the mean level at every range and at every angle to `goal`: the
    /// two curves of the levels are fitted in turn, each to the remainder of the other (iterative
    /// proportional fitting).
    fn fitted(sums: &Sums, goal: f64) -> Self {
        let [sum, count] = sums.total();
        let mut by_range = [(sum / count.max(1.0)).max(LEAST_LEVEL); RANGE_BINS];
        let mut by_angle = [1.0; ANGLE_BINS];
        let bin = |range: usize, angle: usize| sums.0[range * ANGLE_BINS + angle];
        for _ in 0..ROUNDS {
            let at_range = |range: usize| {
                let bins = (0..ANGLE_BINS).map(|angle| (bin(range, angle), by_angle[angle]));
                weighed(bins)
            };
            by_range = steadied(by_range, at_range);
            let at_angle = |angle: usize| {
                let bins = (0..RANGE_BINS).map(|range| (bin(range, angle), by_range[range]));
                weighed(bins)
            };
            by_angle = steadied(by_angle, at_angle);
        }
        Self {
            by_range: by_range.map(|level| (goal / level.max(LEAST_LEVEL)) as f32),
            by_angle: by_angle.map(|share| (1.0 / share.max(1e-3)) as f32),
        }
    }
}

/// Sums over the bins of one value of a curve: of the levels, of the levels if this curve were 1
/// (each count times the value of the other curve), and of the counts.
fn weighed(bins: impl Iterator<Item = ([f64; 2], f64)>) -> [f64; 3] {
    bins.fold([0.0; 3], |[sum, expected, all], ([level, count], other)| {
        [sum + level, expected + count * other, all + count]
    })
}

/// Returns the next values of a curve: from its bins, and where these have few samples, mainly from
/// the mean of the values on both sides.
fn steadied<const COUNT: usize>(
    curve: [f64; COUNT],
    at: impl Fn(usize) -> [f64; 3],
) -> [f64; COUNT] {
    let bins: [[f64; 3]; COUNT] = std::array::from_fn(at);
    let [expected, count] =
        (bins.iter()).fold([0.0; 2], |[expected, count], bin| [expected + bin[1], count + bin[2]]);
    if expected <= 0.0 {
        return curve;
    }
    let of_neighbours = NEIGHBOURS_COUNT * expected / count;
    std::array::from_fn(|at| {
        let beside = 0.5 * (curve[at.saturating_sub(1)] + curve[(at + 1).min(COUNT - 1)]);
        let [sum, expected, _] = bins[at];
        (sum + of_neighbours * beside) / (expected + of_neighbours)
    })
}

impl GainTable {
    /// Returns the table with all levels multiplied by a factor.
    #[must_use]
    pub fn brightened(self, factor: f32) -> Self {
        Self { stretch: self.stretch * factor, ..self }
    }

    /// Returns the factor that scales the bright samples of some pings to [`BRIGHT_LEVEL`].
    fn stretch(&self, survey: &Survey, layout: &MosaicLayout, pings: &[usize]) -> f32 {
        let mut counts = vec![0_u64; 1024];
        let mut factors = Vec::new();
        for side in Side::BOTH {
            let mut by_range = RangeFactors::default();
            each_ray(survey, layout, side, pings, |ray, levels| {
                let ground = first_beyond(ray, ray.altitude_m).min(levels.len());
                let samples = ground..levels.len();
                self.factors(side, ray, samples, &mut by_range, &mut factors);
                for (&level, factor) in levels[ground..].iter().zip(&factors) {
                    counts[((f32::from(level) * factor) as usize).min(1023)] += 1;
                }
            });
        }
        let goal = (counts.iter().sum::<u64>() as f64 * BRIGHT_SHARE) as u64;
        let mut below = 0;
        let bright = counts.iter().position(|count| {
            below += count;
            below > goal
        });
        let bright = bright.unwrap_or(BRIGHT_LEVEL as usize).max(1) as f32;
        (BRIGHT_LEVEL / bright).clamp(STRETCHES[0], STRETCHES[1])
    }

    /// Replaces `out` with the factors of some samples of a ray. Samples of the water column have
    /// the factor of straight down. `by_range` keeps the factors by range, which rays of this side
    /// and table share.
    #[inline(always)]
    pub(super) fn factors(
        &self,
        side: Side,
        ray: &MosaicRay,
        samples: Range<usize>,
        by_range: &mut RangeFactors,
        out: &mut Vec<f32>,
    ) {
        let curves = &self.sides[side as usize];
        by_range.reach(&curves.by_range, self.bins_per_m(), ray, samples.end);
        let by_range = &by_range.factors[samples.clone()];
        out.clear();
        out.resize(samples.len(), 0.0);
        let ground = first_beyond(ray, ray.altitude_m).clamp(samples.start, samples.end);
        let straight_down = self.factor_at(side, ray.altitude_m, ray.altitude_m);
        out[..ground - samples.start].fill(straight_down);
        let mut from = ground;
        // Within one piece of the curve, nothing has to be looked up.
        while from < samples.end {
            let angle = angle_place(ray.range_m(from as f64 + 0.5), ray.altitude_m);
            let by_angle = CurvePiece::of(&curves.by_angle, angle);
            let most = (by_angle.end + 0.5) / ANGLE_BINS as f64;
            let end_m = ray.altitude_m / (1.0 - most * most).max(0.0);
            let end = first_beyond(ray, end_m).clamp(from + 1, samples.end);
            let here = from - samples.start..end - samples.start;
            let factors = out[here.clone()].iter_mut().zip(&by_range[here]);
            for (index, (out, by_range)) in factors.enumerate() {
                let range_m = ray.range_m(from as f64 + index as f64 + 0.5);
                let factor = by_range * by_angle.at(angle_place(range_m, ray.altitude_m));
                *out = self.stretch * factor.clamp(FACTORS[0], FACTORS[1]);
            }
            from = end;
        }
    }

    /// Returns the number of bins of the curve by range in a metre.
    fn bins_per_m(&self) -> f64 {
        RANGE_BINS as f64 / self.far_m
    }

    /// Returns the factor at a slant range over ground at an altitude, metres. The water column has
    /// the factor of straight down.
    pub fn factor(&self, side: Side, range_m: f32, altitude_m: f32) -> f32 {
        let altitude_m = f64::from(altitude_m);
        self.factor_at(side, f64::from(range_m).max(altitude_m), altitude_m)
    }

    #[inline(always)]
    fn factor_at(&self, side: Side, range_m: f64, altitude_m: f64) -> f32 {
        let curves = &self.sides[side as usize];
        let at = |curve: &[f32], place: f64| CurvePiece::of(curve, place).at(place);
        let factor = at(&curves.by_range, range_m * self.bins_per_m() - 0.5)
            * at(&curves.by_angle, angle_place(range_m, altitude_m));
        self.stretch * factor.clamp(FACTORS[0], FACTORS[1])
    }

    /// Returns the factors by range and by angle of a side, at the middles of even steps: in slant
    /// range from 0 to [`GainTable::far_m`], and in `sqrt(1 - altitude / range)` from 0 to 1.
    pub fn curves(&self, side: Side) -> (&[f32], &[f32]) {
        let curves = &self.sides[side as usize];
        (&curves.by_range, &curves.by_angle)
    }

    /// Bounds of the product of both curves.
    pub const BOUNDS: [f32; 2] = FACTORS;
    /// Number of values of a curve by range.
    pub const RANGES: usize = RANGE_BINS;
    /// Number of values of a curve by angle.
    pub const ANGLES: usize = ANGLE_BINS;
}

/// Returns the place on the curve by angle, in bins from the middle of the first.
#[inline(always)]
fn angle_place(range_m: f64, altitude_m: f64) -> f64 {
    obliqueness(range_m, altitude_m) * ANGLE_BINS as f64 - 0.5
}

/// Factors by range of the samples of a ray. Rays with the same start and step, as most rays of a
/// line, share them.
#[derive(Default)]
pub(super) struct RangeFactors {
    start_m: f64,
    step_m: f64,
    factors: Vec<f32>,
}

impl RangeFactors {
    /// Replaces the factors with those of a ray, at least `count` of them, unless they are these
    /// already.
    #[inline(always)]
    fn reach(&mut self, curve: &[f32], bins_per_m: f64, ray: &MosaicRay, count: usize) {
        let is_like = (self.start_m, self.step_m) == (ray.start_m, ray.step_m);
        if is_like && self.factors.len() >= count {
            return;
        }
        let count = count.max(ray.count);
        (self.start_m, self.step_m) = (ray.start_m, ray.step_m);
        self.factors.clear();
        self.factors.resize(count, 0.0);
        let place = |sample: usize| ray.range_m(sample as f64 + 0.5) * bins_per_m - 0.5;
        let mut from = 0;
        while from < count {
            let piece = CurvePiece::of(curve, place(from));
            let end = first_beyond(ray, (piece.end + 0.5) / bins_per_m);
            let end = end.clamp(from + 1, count);
            for sample in from..end {
                self.factors[sample] = piece.at(place(sample));
            }
            from = end;
        }
    }
}

/// A curve between the middles of two bins, where it is linear, or beyond its ends, where it is
/// constant.
struct CurvePiece {
    /// Start of the piece; places are in bins from the middle of the first.
    start: f64,
    end: f64,
    value: f32,
    slope: f32,
}

impl CurvePiece {
    /// Returns the piece that holds a place.
    #[inline(always)]
    fn of(curve: &[f32], place: f64) -> Self {
        let last = curve.len() - 1;
        let constant = |value: f32, end: f64| Self { start: 0.0, end, value, slope: 0.0 };
        match place {
            place if place >= last as f64 => constant(curve[last], f64::INFINITY),
            place if place >= 0.0 => {
                let low = (place as usize).min(last - 1);
                Self {
                    start: low as f64,
                    end: (low + 1) as f64,
                    value: curve[low],
                    slope: curve[low + 1] - curve[low],
                }
            }
            // This is also the piece for NaN.
            _ => constant(curve[0], 0.0),
        }
    }

    #[inline(always)]
    fn at(&self, place: f64) -> f32 {
        self.value + self.slope * (place - self.start) as f32
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the mean level at a range and an angle.
    fn level(range: usize, angle: usize) -> f64 {
        100.0 * (1.0 - 0.01 * range as f64) * (1.0 + 0.02 * angle as f64)
    }

    #[test]
    fn a_bin_with_few_samples_takes_what_its_range_and_its_angle_say() {
        let mut sums = Sums::none();
        for range in 0..RANGE_BINS {
            // Each range occurs at some angles, in a band; a few ranges do not occur at all.
            for angle in (range / 2)..(range / 2 + 12).min(ANGLE_BINS) {
                if !(20..23).contains(&range) {
                    let bin = &mut sums.0[range * ANGLE_BINS + angle];
                    *bin = [20_000.0 * level(range, angle), 20_000.0];
                }
            }
        }
        // A boulder in a few pings that are deeper than all others.
        sums.0[30 * ANGLE_BINS + 8] = [100.0 * 3.0 * level(30, 8), 100.0];
        let curves = Curves::fitted(&sums, 100.0);
        let factor = |range: usize, angle: usize| curves.by_range[range] * curves.by_angle[angle];
        for (range, angle) in [(30, 8), (30, 20), (5, 6), (40, 30), (21, 15)] {
            let normalised = f64::from(factor(range, angle)) * level(range, angle);
            assert!((normalised - 100.0).abs() < 5.0, "{range} {angle}: {normalised}");
        }
    }
}
