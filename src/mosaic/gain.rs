//! Empirical gain normalisation: the level that the ground has on average, by range and by angle from straight down.
//!
//! What is left of spreading, absorption, the beam's pattern and the recorder's own gain shows as bright and dark bands along
//! the track. The survey itself tells their shape: the mean level over all its pings at the same range and angle, each side for
//! itself. Levels are divided by it. A shadow or an object is rare at any one range and angle, so it hardly moves the mean and
//! keeps its contrast. What is bright in the whole survey is then brought to one level, so that a quiet recorder's mosaic is not
//! black.

use super::Layout;
use crate::progress::{Cancelled, Progress};
use crate::survey::{Side, Survey};
use rayon::prelude::*;

const RANGE_BINS: usize = 48;
const ANGLE_BINS: usize = 45;
const BINS: usize = RANGE_BINS * ANGLE_BINS;
/// Fewest samples that make a mean; a bin with fewer takes the mean at its angle.
const FEWEST: f64 = 400.0;
/// Most pings that are read: more tell nothing new.
const MOST_PINGS: usize = 20_000;
/// Pings a worker sums between two looks at whether the work was cancelled.
const CHUNK: usize = 256;
/// Bounds of the factor: beyond them there is only noise.
const FACTORS: [f32; 2] = [0.25, 4.0];
/// The level that this share of the evened samples lies below, and the bounds of the factor that brings it there.
const BRIGHT_SHARE: f64 = 0.98;
const BRIGHT_LEVEL: f32 = 210.0;
const STRETCHES: [f32; 2] = [0.5, 8.0];
/// Of the pings that make the table, every so many tells what is bright.
const BRIGHT_EVERY: usize = 8;

/// Factors on the recorded levels, by side, range and angle.
#[derive(Clone, Debug, PartialEq)]
pub struct GainTable {
    far_m: f64,
    /// `[side][range bin][angle bin]`.
    factors: [Vec<f32>; 2],
}

/// Sum and count of the levels in each bin.
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
}

/// Place of a range and an angle in the table, counted in bins from the middle of the first.
fn place(far_m: f64, range_m: f64, altitude_m: f64) -> [f64; 2] {
    let angle = (altitude_m / range_m).clamp(0.0, 1.0).acos() / std::f64::consts::FRAC_PI_2;
    [
        range_m / far_m * RANGE_BINS as f64 - 0.5,
        angle * ANGLE_BINS as f64 - 0.5,
    ]
}

/// The bin that a place lies in.
fn bin([range, angle]: [f64; 2]) -> usize {
    let index = |place: f64, count: usize| (place + 0.5).clamp(0.0, (count - 1) as f64) as usize;
    index(range, RANGE_BINS) * ANGLE_BINS + index(angle, ANGLE_BINS)
}

/// Means over the pings that the mosaic shows, at most 20 000 of them, evenly spread.
pub fn gain_table(
    survey: &Survey,
    layout: &Layout,
    progress: &Progress,
) -> Result<GainTable, Cancelled> {
    let far_m = layout.far_m();
    let step = survey.side_scan.len().div_ceil(MOST_PINGS).max(1);
    let pings: Vec<usize> = (0..survey.side_scan.len()).step_by(step).collect();
    progress.start(2 * pings.len() as u64);
    let side_factors = |side: Side| -> Result<Vec<f32>, Cancelled> {
        let sums = pings
            .par_chunks(CHUNK)
            .map(|chunk| {
                progress.check()?;
                progress.advance(chunk.len() as u64);
                let mut sums = Sums::none();
                hear(survey, layout, side, chunk, |level, range_m, altitude_m| {
                    let sum = &mut sums.0[bin(place(far_m, range_m, altitude_m))];
                    *sum = [sum[0] + f64::from(level), sum[1] + 1.0];
                });
                Ok(sums)
            })
            .try_reduce(Sums::none, |a, b| Ok(a.with(b)))?;
        Ok(factors(&sums))
    };
    let mut table = GainTable {
        far_m,
        factors: [side_factors(Side::Port)?, side_factors(Side::Starboard)?],
    };
    progress.check()?;
    let few: Vec<usize> = pings.iter().copied().step_by(BRIGHT_EVERY).collect();
    let stretch = table.stretch(survey, layout, &few);
    for factor in table.factors.iter_mut().flatten() {
        *factor *= stretch;
    }
    Ok(table)
}

/// Calls `tell` with the level, range and altitude of every sample from the ground.
fn hear(
    survey: &Survey,
    layout: &Layout,
    side: Side,
    pings: &[usize],
    mut tell: impl FnMut(u8, f64, f64),
) {
    let mut levels = Vec::new();
    for &ping in pings {
        let (Some(ray), Some(samples)) = (layout.ray(ping, side), survey.samples(ping, side))
        else {
            continue;
        };
        samples.copy_outward(&mut levels);
        for (index, &level) in levels.iter().enumerate() {
            let range_m = ray.range_m(index as f64 + 0.5);
            if range_m > ray.altitude_m {
                tell(level, range_m, ray.altitude_m);
            }
        }
    }
}

/// The whole side's mean over each bin's mean.
fn factors(sums: &Sums) -> Vec<f32> {
    let mean = |sum: [f64; 2]| (sum[1] > 0.0).then(|| sum[0] / sum[1]);
    let total = |bins: &mut dyn Iterator<Item = &[f64; 2]>| {
        bins.fold([0.0; 2], |a, b| [a[0] + b[0], a[1] + b[1]])
    };
    let Some(whole) = mean(total(&mut sums.0.iter())) else {
        return vec![1.0; BINS];
    };
    let by_angle: Vec<Option<f64>> = (0..ANGLE_BINS)
        .map(|angle| mean(total(&mut sums.0.iter().skip(angle).step_by(ANGLE_BINS))))
        .collect();
    let level = |(index, sum): (usize, &[f64; 2])| {
        let own = mean(*sum).filter(|_| sum[1] >= FEWEST);
        let level = own.or(by_angle[index % ANGLE_BINS]).unwrap_or(whole);
        ((whole / level.max(0.5)) as f32).clamp(FACTORS[0], FACTORS[1])
    };
    sums.0.iter().enumerate().map(level).collect()
}

impl GainTable {
    /// The factor that brings what is bright among some pings to one level.
    fn stretch(&self, survey: &Survey, layout: &Layout, pings: &[usize]) -> f32 {
        let mut counts = vec![0_u64; 1024];
        for side in Side::BOTH {
            hear(survey, layout, side, pings, |level, range_m, altitude_m| {
                let evened = f32::from(level) * self.factor(side, range_m, altitude_m);
                counts[(evened as usize).min(1023)] += 1;
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

    /// Factor on a level heard on a side, between the bins linear.
    pub fn factor(&self, side: Side, range_m: f64, altitude_m: f64) -> f32 {
        let table = match side {
            Side::Port => &self.factors[0],
            Side::Starboard => &self.factors[1],
        };
        let [range, angle] = place(self.far_m, range_m, altitude_m);
        let (range, angle) = (
            range.clamp(0.0, (RANGE_BINS - 1) as f64),
            angle.clamp(0.0, (ANGLE_BINS - 1) as f64),
        );
        let (row, column) = (
            (range as usize).min(RANGE_BINS - 2),
            (angle as usize).min(ANGLE_BINS - 2),
        );
        let (down, across) = ((range - row as f64) as f32, (angle - column as f64) as f32);
        let at = |row: usize, column: usize| table[row * ANGLE_BINS + column];
        let upper = at(row, column) * (1.0 - across) + at(row, column + 1) * across;
        let lower = at(row + 1, column) * (1.0 - across) + at(row + 1, column + 1) * across;
        upper * (1.0 - down) + lower * down
    }
}
