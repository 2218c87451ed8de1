//! Computes the data that the picture of one log is shown with, once for its results, and the
//! histogram of its levels, which determines the levels shown as black and white.

use super::{Extremes, PingScales, Tone};
use crate::mosaic::GainTable;
use crate::waterfall::{Levels, MOST_SAMPLED_PINGS, beyond_pulse};
use bathyscope_log::support::progress::{Cancelled, Progress};
use bathyscope_log::survey::{Side, SideScanState, Survey};
use std::ops::Range;
use std::sync::Arc;

/// Largest number of echoes that levels are counted over: enough for stable percentiles, few enough
/// to be counted again while a slider is dragged.
const MOST_ECHOES: usize = 1 << 17;
/// Largest number of pings, evenly spread, that the mean of a row of a tile is taken over: few
/// enough to be read while the row is drawn, however long the log is.
const MOST_PINGS_OF_ROW: usize = 64;
/// Number of bars of a drawn histogram.
const HISTOGRAM_BARS: usize = 128;
/// Number of bins that quantiles are counted in; levels as recorded have one bin for each byte
/// instead.
const BINS: usize = 2048;
/// Share of the echoes below the level that determines the end of a histogram, and factor on this
/// level.
const REACHED_SHARE: f64 = 0.999;
const BEYOND: f32 = 1.3;
/// Least end of a histogram.
const LEAST_REACH: f32 = 64.0;

/// Echo with all values that its shown level depends on.
#[derive(Clone, Copy, Debug)]
struct PictureEcho {
    level: f32,
    side: Side,
    /// Slant range at which gain is computed, metres.
    range_m: f32,
    /// Factor of the gain table.
    gain: f32,
    /// Factor of the stripe filter.
    even: f32,
}

/// Scales, gain and sampled echoes of a log.
#[derive(Debug)]
pub struct LogPicture {
    /// Scales between recorded ranges and calibrated ranges, ping by ping.
    pub scales: Arc<PingScales>,
    /// Smallest and largest values of the scales.
    pub extremes: Extremes,
    /// Gain normalisation; `None` where it was not requested, or nothing is known of the ground.
    pub gain: Option<Arc<GainTable>>,
    /// Calibrated slant range at which time-varied gain is 0 dB, metres: half of the farthest
    /// range.
    pub middle_m: f32,
    /// Factors of the stripe filter, by side, port first; `None` if the filter was not requested.
    factors: Option<[Vec<f32>; 2]>,
    echoes: Vec<PictureEcho>,
    /// True if the side-scan shows the bottom, not only noise.
    has_bottom: bool,
}

impl LogPicture {
    /// Creates the picture of a log; `factors` are those of the stripe filter, if it was requested.
    ///
    /// # Errors
    /// When the work was cancelled.
    pub fn new(
        survey: &Survey,
        scales: Arc<PingScales>,
        gain: Option<Arc<GainTable>>,
        factors: Option<[Vec<f32>; 2]>,
        progress: &Progress,
    ) -> Result<Self, Cancelled> {
        let echoes = echoes(survey, &scales, gain.as_deref(), factors.as_ref(), progress)?;
        let spans = survey.side_scan.iter().enumerate();
        let far_m = spans
            .flat_map(|(ping, recorded)| {
                Side::BOTH.map(|side| {
                    let far_m = recorded.side(side).map(|span| f64::from(span.far_m));
                    far_m.map_or(0.0, |far_m| scales.at(side, ping).slant_m(far_m))
                })
            })
            .filter(|far_m| far_m.is_finite())
            .fold(1.0, f64::max);
        Ok(Self {
            extremes: scales.extremes(),
            scales,
            gain,
            middle_m: (0.5 * far_m) as f32,
            factors,
            echoes,
            has_bottom: survey.side_scan_state == SideScanState::Usable,
        })
    }

    /// Returns the values that normalise a row of a tile: `[altitude, scale, offset, factor of the
    /// stripe filter]` of a side, as the mean over the pings of the row, or over at most
    /// [`MOST_PINGS_OF_ROW`] of them. Beyond the end of the log these are the values of the last
    /// ping; without the filter the factor is 1.
    pub fn row(&self, side: Side, pings: Range<usize>) -> [f32; 4] {
        let scales = self.scales.side(side);
        let factors = self.factors.as_ref().map(|sides| &sides[side as usize]);
        let first = pings.start.min(scales.len().saturating_sub(1));
        let pings = first..pings.end.clamp(first + 1, scales.len().max(first + 1));
        let step = pings.len().div_ceil(MOST_PINGS_OF_ROW);
        let pings = pings.step_by(step);
        let count = pings.len() as f64;
        let sum = pings.fold([0.0; 4], |sum: [f64; 4], ping| {
            let scale = self.scales.at(side, ping);
            let factor = factors.and_then(|factors| factors.get(ping).copied());
            let of_ping = [scale.altitude_m, scale.scale, scale.offset_m, factor.unwrap_or(1.0)];
            std::array::from_fn(|part| sum[part] + f64::from(of_ping[part]))
        });
        sum.map(|part| (part / count) as f32)
    }

    /// Returns the levels of the sampled echoes with some tone; 255 is the largest byte as
    /// recorded.
    pub fn levels(&self, tone: &Tone) -> impl Iterator<Item = f32> {
        self.echoes.iter().map(move |echo| {
            let gain = if tone.is_normalised { echo.gain } else { 1.0 };
            let even = if tone.is_even { echo.even } else { 1.0 };
            echo.level * gain * even * tone.factor(echo.side, echo.range_m, self.middle_m)
        })
    }
}

/// Samples the echoes beyond the transmit pulse in even steps, from pings that are evenly spread
/// over the log.
fn echoes(
    survey: &Survey,
    scales: &PingScales,
    gain: Option<&GainTable>,
    factors: Option<&[Vec<f32>; 2]>,
    progress: &Progress,
) -> Result<Vec<PictureEcho>, Cancelled> {
    let pings = survey.side_scan.len();
    let step = pings.div_ceil(MOST_SAMPLED_PINGS).max(1);
    let spans =
        (0..pings).step_by(step).flat_map(|ping| Side::BOTH.map(|side| survey.span(ping, side)));
    let all: usize = spans.flatten().map(|span| span.count as usize).sum();
    let every = all.div_ceil(MOST_ECHOES).max(1);
    let mut echoes = Vec::new();
    let mut outward = Vec::new();
    for ping in (0..pings).step_by(step) {
        progress.check()?;
        for side in Side::BOTH {
            let (Some(span), Some(samples)) = (survey.span(ping, side), survey.samples(ping, side))
            else {
                continue;
            };
            let Some(first) = beyond_pulse(span) else {
                continue;
            };
            let scale = scales.at(side, ping);
            let even = factors.and_then(|factors| factors[side as usize].get(ping).copied());
            samples.copy_outward(&mut outward);
            let sampled = outward.iter().enumerate().skip(first).step_by(every);
            echoes.extend(sampled.map(|(sample, &level)| {
                let range_m = scale.slant_m(span.range_m(sample as f64 + 0.5));
                let range_m = (range_m as f32).max(scale.altitude_m);
                PictureEcho {
                    level: f32::from(level),
                    side,
                    range_m,
                    gain: gain.map_or(1.0, |gain| gain.factor(side, range_m, scale.altitude_m)),
                    even: even.unwrap_or(1.0),
                }
            }));
        }
    }
    Ok(echoes)
}

/// The levels of a log's echoes after gain, stripe filter and balance.
#[derive(Clone, Debug, PartialEq)]
pub struct LevelHistogram {
    /// Number of echoes in each of [`HISTOGRAM_BARS`] steps from 0 to `reach`.
    pub bars: Vec<u32>,
    /// Level where the last bar ends; 255 is the largest byte.
    pub reach: f32,
    /// Levels that suit the log.
    pub automatic: Levels,
}

impl LevelHistogram {
    /// Creates the histogram of the echoes of a log with some tone.
    pub fn of(picture: &LogPicture, tone: &Tone) -> Self {
        let levels: Vec<f32> = picture.levels(tone).collect();
        if tone.is_plain() {
            let mut plain = Self::with_bins(&levels, 256, 256.0, picture.has_bottom);
            plain.automatic.white = plain.automatic.white.min(1.0);
            return plain;
        }
        let mut sorted = levels.clone();
        let reach = reach(&mut sorted);
        Self::with_bins(&levels, BINS, reach, picture.has_bottom)
    }

    fn with_bins(levels: &[f32], count: usize, reach: f32, has_bottom: bool) -> Self {
        let mut bins = vec![0_u64; count];
        for level in levels {
            let bin = (level / reach * count as f32) as usize;
            bins[bin.min(count - 1)] += 1;
        }
        let automatic = if has_bottom {
            Levels::of_counts(&bins, reach / count as f32)
        } else {
            Levels::RECORDED
        };
        let wide = count / HISTOGRAM_BARS;
        let bar = |bins: &[u64]| u32::try_from(bins.iter().sum::<u64>()).unwrap_or(u32::MAX);
        Self { bars: bins.chunks(wide).map(bar).collect(), reach, automatic }
    }
}

/// Returns the level where a histogram ends: a little above nearly all levels.
fn reach(levels: &mut [f32]) -> f32 {
    if levels.is_empty() {
        return 256.0;
    }
    let rank = ((levels.len() as f64 * REACHED_SHARE) as usize).min(levels.len() - 1);
    let (_, level, _) = levels.select_nth_unstable_by(rank, f32::total_cmp);
    (BEYOND * *level).max(LEAST_REACH)
}

#[cfg(test)]
mod tests {
    use super::*;
    use bathyscope_log::survey::SidePing;

    #[test]
    fn a_row_holds_the_mean_of_its_pings() {
        let ping = SidePing::with_depth(0.0, f32::NAN);
        let survey = Survey::of_pings(vec![ping; 5]);
        // Factors of port rise from ping to ping.
        let factors = [vec![0.0, 1.0, 2.0, 3.0, 4.0], vec![1.0; 5]];
        let of = |scales, factors| {
            LogPicture::new(&survey, Arc::new(scales), None, factors, &Progress::new())
                .expect("a picture")
        };
        let picture = of(PingScales::level(5, 7.0), Some(factors));
        let factor = |pings| picture.row(Side::Port, pings)[3];
        assert_eq!([factor(3..4), factor(0..2), factor(0..4)], [3.0, 0.5, 1.5]);
        // The mean is over the pings that exist; beyond the end, the last ping counts.
        assert_eq!([factor(4..6), factor(4..8), factor(9..10)], [4.0; 3]);
        assert_eq!(picture.row(Side::Starboard, 0..4), [7.0, 1.0, 0.0, 1.0]);
        let plain = of(PingScales::level(5, 7.0), None);
        assert_eq!(plain.row(Side::Port, 1..3), [7.0, 1.0, 0.0, 1.0]);
        let long = Some([(0..1000).map(|ping| ping as f32).collect(), Vec::new()]);
        let mean = of(PingScales::level(1000, 7.0), long).row(Side::Port, 0..1000)[3];
        assert!((mean / 499.5 - 1.0).abs() < 0.02, "{mean}");
        let none = of(PingScales::default(), None);
        assert_eq!(none.row(Side::Port, 3..5), [0.0, 1.0, 0.0, 1.0]);
    }

    #[test]
    fn automatic_levels_are_percentiles_whatever_the_bins() {
        // Evenly spaced levels from 0 to 199.98.
        let levels: Vec<f32> = (0..10_000).map(|index| index as f32 * 0.02).collect();
        let mut sorted = levels.clone();
        let reach = reach(&mut sorted);
        assert!((reach - 1.3 * 199.8).abs() < 0.1, "{reach}");
        let histogram = LevelHistogram::with_bins(&levels, BINS, reach, true);
        let Levels { black, white } = histogram.automatic;
        assert!((black * 255.0 - 2.0).abs() < 0.3, "{}", black * 255.0);
        assert!((white * 255.0 - 198.0 / 0.9).abs() < 0.4, "{}", white * 255.0);
        assert_eq!(histogram.bars.len(), HISTOGRAM_BARS);
        assert_eq!(histogram.bars.iter().sum::<u32>(), 10_000);
        let noise = LevelHistogram::with_bins(&levels, BINS, reach, false);
        assert_eq!(noise.automatic, Levels::RECORDED);
    }
}
