//! Determines the law by which a recorder writes an echo: as decibels, or as a power of its
//! intensity.
//!
//! Where many scatterers share a sample, its intensity is exponentially distributed whatever its
//! mean (speckle). The spread of the levels in a small window therefore determines the law: with
//! decibels the spread is the same everywhere, with a power (an amplitude is the power 1/2) it is
//! in proportion to the level. Noise changes the lower half of the spread, so the upper half is
//! measured.
//!
//! Neighbouring samples are alike for one of two reasons: the pulse is longer than a sample, which
//! does not change the spread, or the recorder smooths its levels, which makes the spread smaller
//! and more symmetric. The reason is chosen whose spread has the shape that is found.

use super::echoes::LogEchoes;
use crate::sparse::Normal;
use bathyscope_log::support::progress::{Cancelled, Progress};
use bathyscope_log::support::statistics::{median_of, quantile, sorted};
use bathyscope_log::survey::Side;
use serde::{Deserialize, Serialize};

/// Numbers of pings and of samples in a window.
const PINGS: usize = 3;
const SAMPLES: usize = 15;
/// Multiples of the first return at which windows begin and end: on the bed, and before the echo is
/// lost in noise.
const FROM_FIRST_RETURN: [f64; 2] = [1.2, 1.7];
/// Largest number of groups of pings that are read.
const MOST_GROUPS: usize = 2_000;
/// Share of clipped samples above which a window is left out.
const MOST_CLIPPED: f64 = 0.03;
/// Least number of windows that determine a law.
const LEAST_WINDOWS: usize = 120;
/// Number of bins that the windows are divided into, sorted by their mean.
const BINS: usize = 12;
/// Slope of the logarithm of the spread over that of the mean below which levels count as decibels;
/// the slope of a power is 1.
const MOST_SLOPE_OF_DECIBELS: f64 = 0.3;
/// Number of simulated means from which the spread of smoothed levels is computed.
const DRAWN: usize = 20_000;
/// Bounds of the search for the exponent of a power.
const EXPONENTS: [f64; 2] = [0.02, 2.0];
/// Number of samples alike in a row below which samples count as independent.
const LEAST_GRAIN: f64 = 1.3;
/// Largest lag at which samples may be correlated.
const LAGS: usize = 12;
/// Least correlation that is not chance.
const LEAST_CORRELATION: f64 = 0.03;
/// Largest difference of the laws of one recorder, natural logarithm of their ratio.
const SAME_LAW: f64 = 0.15;
/// Least level that a logarithm is taken of, since 0 has none.
const LEAST_LEVEL: f64 = 0.05;

/// Law that converts the levels of a log into logarithms of power.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Law {
    /// Quantity that the recorder writes.
    pub kind: LawKind,
    /// Number of samples in a row that count as one independent sample: those in a pulse. Smoothing
    /// does not change it.
    pub grain_samples: f64,
    /// Highest level in the sampled pings of a log: the recorder cannot distinguish stronger
    /// echoes.
    pub most_level: u8,
}

/// Quantity that a recorder writes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum LawKind {
    /// Decibels: the natural logarithm of power that one step of the level represents.
    Decibels(f64),
    /// A power of the intensity: its exponent.
    Power(f64),
}

impl Law {
    /// Returns the natural logarithm of power, except for a constant, of every level. For a power
    /// it is the mean over the values that a level represents.
    pub fn table(&self) -> [f32; 256] {
        std::array::from_fn(|level| {
            let level = level as f64;
            (match self.kind {
                LawKind::Decibels(ln_per_level) => level * ln_per_level,
                LawKind::Power(exponent) => mean_ln(level - 0.5, level + 0.5) / exponent,
            }) as f32
        })
    }
}

/// Returns for each log the index of the first log of the same recorder: the first with about the
/// same law.
pub(super) fn recorders(laws: impl Iterator<Item = Option<Law>>) -> Vec<u32> {
    let mut found: Vec<(u32, Option<Law>)> = Vec::new();
    for (number, law) in (0..).zip(laws) {
        let is_like = |other: &Law| law.is_some_and(|law| law.kind.is_like(other.kind));
        let before = found.iter().find(|(_, law)| law.as_ref().is_some_and(is_like));
        found.push(before.copied().unwrap_or((number, law)));
    }
    found.into_iter().map(|(first, _)| first).collect()
}

impl LawKind {
    fn is_like(self, other: Self) -> bool {
        let near = |a: f64, b: f64| (a / b).ln().abs() < SAME_LAW;
        match (self, other) {
            (Self::Decibels(a), Self::Decibels(b)) | (Self::Power(a), Self::Power(b)) => near(a, b),
            _ => false,
        }
    }
}

/// Returns the mean of `ln max(x, LEAST_LEVEL)` between two values.
fn mean_ln(from: f64, to: f64) -> f64 {
    let antiderivative = |x: f64| x * x.ln() - x;
    let start = from.max(LEAST_LEVEL);
    let below = (start - from).max(0.0);
    (antiderivative(to) - antiderivative(start) + below * LEAST_LEVEL.ln()) / (to - from)
}

/// Levels of a window less their mean, and the mean.
struct LevelWindow {
    mean: f64,
    about: Vec<f64>,
}

/// Determines the law of a log; `None` where its echoes do not determine it.
///
/// # Errors
/// When the work was cancelled.
pub(super) fn law_of(log: &LogEchoes<'_>, progress: &Progress) -> Result<Option<Law>, Cancelled> {
    let groups = log.pings.len() / PINGS;
    let mut windows = Vec::new();
    let mut lags = Lags::default();
    let mut levels: [Vec<u8>; PINGS] = Default::default();
    let most_level = most_level(log);
    for group in (0..groups).step_by(groups.div_ceil(MOST_GROUPS).max(1)) {
        progress.check()?;
        for side in Side::BOTH {
            let first = group * PINGS;
            let first_return = log.pings[first].side(side).first_return;
            if !first_return.is_finite() {
                continue;
            }
            let mut count = usize::MAX;
            for (ping, levels) in levels.iter_mut().enumerate() {
                log.read(first + ping, side, levels);
                count = count.min(levels.len());
            }
            let [from, to] = FROM_FIRST_RETURN
                .map(|times| ((first_return.max(1.0) * times) as usize).min(count));
            for start in (from..to.saturating_sub(SAMPLES)).step_by(SAMPLES) {
                let rows = levels.each_ref().map(|row| &row[start..start + SAMPLES]);
                windows.extend(window(&rows, most_level));
            }
            lags.add(&levels[0][from..to], most_level);
        }
    }
    let alike = lags.alike_samples();
    Ok(LevelSpread::of(windows).and_then(|spread| spread.kind(alike)).map(|(kind, smoothed)| Law {
        kind,
        grain_samples: alike / smoothed as f64,
        most_level,
    }))
}

/// Returns the highest level in some pings of a log.
fn most_level(log: &LogEchoes<'_>) -> u8 {
    let mut most = 1;
    let mut levels = Vec::new();
    let step = log.pings.len().div_ceil(MOST_GROUPS).max(1);
    for ping in (0..log.pings.len()).step_by(step) {
        for side in Side::BOTH {
            let first_return = log.pings[ping].side(side).first_return;
            if first_return.is_finite() && log.read(ping, side, &mut levels) {
                // Nearer samples hold the ring-down of the transducer.
                let beyond = levels.iter().skip((1.1 * first_return.max(0.0)) as usize);
                most = most.max(beyond.copied().max().unwrap_or(0));
            }
        }
    }
    most
}

fn window(rows: &[&[u8]; PINGS], most_level: u8) -> Option<LevelWindow> {
    let values = || rows.iter().flat_map(|row| row.iter().copied());
    let count = (PINGS * SAMPLES) as f64;
    let clipped = values().filter(|level| *level == 0 || *level >= most_level);
    if clipped.count() as f64 > MOST_CLIPPED * count {
        return None;
    }
    let mean = values().map(f64::from).sum::<f64>() / count;
    (mean > 0.0).then(|| LevelWindow {
        mean,
        about: values().map(|level| f64::from(level) - mean).collect(),
    })
}

/// Spread of the levels in windows.
struct LevelSpread {
    /// Slope of the logarithm of the spread over that of the mean.
    slope: f64,
    /// Levels at 10, 50 and 90 %, less their mean, and the mean, of each bin in the brighter half
    /// of the windows, where noise matters less.
    bright: Vec<[f64; 4]>,
}

impl LevelSpread {
    fn of(mut windows: Vec<LevelWindow>) -> Option<Self> {
        if windows.len() < LEAST_WINDOWS {
            return None;
        }
        windows.sort_by(|a, b| a.mean.total_cmp(&b.mean));
        let bins: Vec<[f64; 4]> = windows
            .chunks(windows.len().div_ceil(BINS))
            .map(|bin| {
                let mean = bin.iter().map(|window| window.mean).sum::<f64>() / bin.len() as f64;
                let about = sorted(bin.iter().flat_map(|window| window.about.iter().copied()));
                let [low, middle, high] = [0.1, 0.5, 0.9].map(|share| quantile(&about, share));
                [low, middle, high, mean]
            })
            .collect();
        let slope =
            slope_of_logs(bins.iter().map(|[_, middle, high, mean]| (*mean, high - middle)))?;
        let bright = bins[bins.len() / 2..].to_vec();
        Some(Self { slope, bright })
    }

    /// Returns the median of a function over the bins of brighter windows.
    fn usual(&self, of: impl Fn(&[f64; 4]) -> f64) -> f64 {
        median_of(self.bright.iter().map(of))
    }

    /// Returns the quantity that the recorder writes, and the number of samples that it smooths
    /// over; `alike` is the number of samples in a row that are alike. `None` where it cannot be
    /// determined.
    fn kind(&self, alike: f64) -> Option<(LawKind, usize)> {
        let shape = self.usual(|[low, middle, high, _]| (high - middle) / (middle - low));
        let smoothed = (alike.round() as usize).clamp(1, LAGS);
        let by_pulse = self.kind_smoothed(1)?;
        if alike < LEAST_GRAIN || smoothed == 1 {
            return Some((by_pulse.0, 1));
        }
        let by_smoothing = self.kind_smoothed(smoothed)?;
        if (by_smoothing.1 - shape).abs() < (by_pulse.1 - shape).abs() {
            Some((by_smoothing.0, smoothed))
        } else {
            Some((by_pulse.0, 1))
        }
    }

    /// Returns the quantity that the recorder writes if it smooths over this number of samples, and
    /// the shape of the spread that would follow.
    fn kind_smoothed(&self, smoothed: usize) -> Option<(LawKind, f64)> {
        let shape = |[low, middle, high]: [f64; 3]| (high - middle) / (middle - low);
        if self.slope < MOST_SLOPE_OF_DECIBELS {
            let spread = self.usual(|[_, middle, high, _]| high - middle);
            let drawn = drawn(smoothed, f64::ln);
            let ln_per_level = (drawn[2] - drawn[1]) / spread;
            return (ln_per_level.is_finite() && ln_per_level > 0.0)
                .then_some((LawKind::Decibels(ln_per_level), shape(drawn)));
        }
        let spread = self.usual(|[_, middle, high, mean]| ((mean + high) / (mean + middle)).ln());
        let [mut least, mut most] = EXPONENTS;
        // The spread grows with the exponent.
        for _ in 0..16 {
            let exponent = (least * most).sqrt();
            let [_, middle, high] = drawn(smoothed, |power| power.powf(exponent));
            if (high / middle).ln() < spread { least = exponent } else { most = exponent }
        }
        let exponent = (least * most).sqrt();
        let is_bounded = exponent > 1.1 * EXPONENTS[0] && exponent < 0.9 * EXPONENTS[1];
        is_bounded.then(|| {
            (LawKind::Power(exponent), shape(drawn(smoothed, |power| power.powf(exponent))))
        })
    }
}

/// Returns the quantiles at 10, 50 and 90 % of simulated means of `smoothed` levels; `level`
/// converts a power, which is exponentially distributed, into a level.
fn drawn(smoothed: usize, level: impl Fn(f64) -> f64) -> [f64; 3] {
    let mut normal = Normal::new(3);
    let mut draw_level = || level(0.5 * (normal.draw().powi(2) + normal.draw().powi(2)));
    let mean = |_| (0..smoothed).map(|_| draw_level()).sum::<f64>() / smoothed as f64;
    let means = sorted((0..DRAWN).map(mean));
    [0.1, 0.5, 0.9].map(|share| quantile(&means, share))
}

/// Returns the least-squares slope of `ln y` over `ln x`; `None` where a number is not positive.
fn slope_of_logs(points: impl Iterator<Item = (f64, f64)>) -> Option<f64> {
    let logs: Vec<(f64, f64)> = points.map(|(x, y)| (x.ln(), y.ln())).collect();
    let count = logs.len() as f64;
    let (x_mean, y_mean) =
        logs.iter().fold((0.0, 0.0), |(x, y), point| (x + point.0 / count, y + point.1 / count));
    let (xx, xy) = logs.iter().fold((0.0, 0.0), |(xx, xy), (x, y)| {
        (xx + (x - x_mean).powi(2), xy + (x - x_mean) * (y - y_mean))
    });
    // Where all windows are equally bright, a power cannot be distinguished from decibels, which
    // most recorders write.
    let slope = if xx < 1e-4 * count { 0.0 } else { xy / xx };
    slope.is_finite().then_some(slope)
}

/// Sums and counts of products of levels, by their distance in samples.
#[derive(Default)]
struct Lags {
    products: [f64; LAGS + 1],
    counts: [f64; LAGS + 1],
}

impl Lags {
    fn add(&mut self, row: &[u8], most_level: u8) {
        // Over a long row the trend would count as correlation: it is subtracted part by part.
        for part in row.chunks_exact(4 * LAGS) {
            if part.iter().any(|level| *level == 0 || *level >= most_level) {
                continue;
            }
            let count = part.len() as f64;
            let middle = 0.5 * (count - 1.0);
            let mean = part.iter().map(|level| f64::from(*level)).sum::<f64>() / count;
            let along = |(at, level): (usize, &u8)| (at as f64 - middle) * f64::from(*level);
            let slope = part.iter().enumerate().map(along).sum::<f64>()
                / (count * (count * count - 1.0) / 12.0);
            let about: Vec<f64> = part
                .iter()
                .enumerate()
                .map(|(at, level)| f64::from(*level) - mean - slope * (at as f64 - middle))
                .collect();
            for lag in 0..=LAGS {
                let pairs = about.iter().zip(&about[lag..]);
                self.products[lag] += pairs.map(|(a, b)| a * b).sum::<f64>();
                self.counts[lag] += count - lag as f64;
            }
        }
    }

    /// Returns the number of samples in a row that are alike: `1 + 2 (sum of the correlations up to
    /// the first that is chance)`.
    fn alike_samples(&self) -> f64 {
        let covariance = |lag: usize| self.products[lag] / self.counts[lag];
        let correlations = (1..=LAGS).map(|lag| covariance(lag) / covariance(0));
        let sum: f64 =
            correlations.take_while(|correlation| *correlation > LEAST_CORRELATION).sum();
        1.0 + 2.0 * sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Simulates windows of a recorder over a bed that becomes brighter from one window to the
    /// next; `level` converts a power into the level that is written.
    fn windows(smoothed: usize, level: impl Fn(f64) -> f64) -> Vec<LevelWindow> {
        let mut normal = Normal::new(5);
        let window = |index: usize| {
            let brightness = (index as f64 / 200.0).exp();
            let mut draw_level =
                || level(0.5 * brightness * (normal.draw().powi(2) + normal.draw().powi(2)));
            let mut row = || -> Vec<f64> {
                let sharp: Vec<f64> = (0..SAMPLES + smoothed).map(|_| draw_level()).collect();
                let sums = sharp.windows(smoothed).take(SAMPLES);
                sums.map(|some| some.iter().sum::<f64>() / smoothed as f64).collect()
            };
            let levels: Vec<f64> = (0..PINGS).flat_map(|_| row()).collect();
            let mean = levels.iter().sum::<f64>() / levels.len() as f64;
            LevelWindow { mean, about: levels.into_iter().map(|level| level - mean).collect() }
        };
        (0..600).map(window).collect()
    }

    fn kind(windows: Vec<LevelWindow>, alike: f64) -> (LawKind, usize) {
        LevelSpread::of(windows).unwrap().kind(alike).unwrap()
    }

    #[test]
    fn decibels_and_powers_are_told_apart_smoothed_or_not() {
        let decibels = |power: f64| 60.0 + 15.0 * power.ln();
        for smoothed in [1, 4] {
            let (found, over) = kind(windows(smoothed, decibels), smoothed as f64);
            let LawKind::Decibels(ln_per_level) = found else {
                panic!("{found:?}");
            };
            assert_eq!(over, smoothed);
            assert!((15.0 * ln_per_level - 1.0).abs() < 0.05, "{ln_per_level}");
            for exponent in [0.5, 0.25] {
                let level = |power: f64| 40.0 * power.powf(exponent);
                let (found, over) = kind(windows(smoothed, level), smoothed as f64);
                let LawKind::Power(found) = found else {
                    panic!("{found:?}");
                };
                assert_eq!(over, smoothed);
                assert!((found / exponent - 1.0).abs() < 0.1, "{found}");
            }
        }
    }

    #[test]
    fn logs_of_about_one_law_are_one_recorder_s() {
        let law = |kind| Some(Law { kind, grain_samples: 1.0, most_level: 255 });
        let laws = [
            None,
            law(LawKind::Decibels(0.06)),
            law(LawKind::Power(0.5)),
            law(LawKind::Decibels(0.063)),
            None,
            law(LawKind::Power(0.25)),
            law(LawKind::Power(0.52)),
        ];
        assert_eq!(recorders(laws.into_iter()), [0, 1, 2, 1, 4, 5, 2]);
    }

    #[test]
    fn a_long_pulse_is_no_smoothing_and_too_few_windows_tell_nothing() {
        let decibels = |power: f64| 60.0 + 15.0 * power.ln();
        let (_, over) = kind(windows(1, decibels), 4.0);
        assert_eq!(over, 1);
        assert!(LevelSpread::of(windows(1, decibels).split_off(500)).is_none());
    }

    #[test]
    fn the_level_of_a_power_is_the_mean_over_what_it_stands_for() {
        let law = Law { kind: LawKind::Power(0.5), grain_samples: 1.0, most_level: 255 };
        let table = law.table();
        let steps = 10_000;
        let mean = |level: f64| {
            let at = |step: i32| level - 0.5 + (f64::from(step) + 0.5) / f64::from(steps);
            let sum: f64 = (0..steps).map(|step| at(step).max(LEAST_LEVEL).ln()).sum();
            sum / f64::from(steps) / 0.5
        };
        for level in [0_u8, 1, 7, 100] {
            let expected = mean(f64::from(level));
            assert!((f64::from(table[usize::from(level)]) - expected).abs() < 1e-3, "{level}");
        }
    }
}
