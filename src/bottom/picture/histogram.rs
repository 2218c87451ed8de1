//! Counts the levels in a log's picture, and chooses the levels that are shown as black and white.

use super::Tone;
use super::log_picture::LogPicture;
use crate::waterfall::Levels;

/// Bars that a histogram is drawn with.
pub(super) const HISTOGRAM_BARS: usize = 128;
/// Bins that quantiles are counted in; of bytes as recorded each has one.
const BINS: usize = 2048;
/// The levels reach to where this share of the echoes lies below, and beyond it by this factor.
const REACHED_SHARE: f64 = 0.999;
const BEYOND: f32 = 1.3;
/// Least level that a histogram reaches to.
const LEAST_REACH: f32 = 64.0;

/// The levels of a log's echoes after gain, stripe filter and balance.
#[derive(Clone, Debug, PartialEq)]
pub struct LevelHistogram {
    /// Echoes in each of [`HISTOGRAM_BARS`] steps from 0 to `reach`.
    pub bars: Vec<u32>,
    /// The level where the last bar ends; 255 is the largest byte.
    pub reach: f32,
    /// Levels that suit the log.
    pub automatic: Levels,
}

impl LevelHistogram {
    /// Creates the histogram of the echoes of a log, shown with some tone.
    pub fn of(picture: &LogPicture, tone: &Tone) -> Self {
        let levels: Vec<f32> = picture.levels(tone).collect();
        if tone.is_plain() {
            let mut plain = Self::with_bins(&levels, 256, 256.0, picture.has_bottom());
            plain.automatic.white = plain.automatic.white.min(1.0);
            return plain;
        }
        let mut sorted = levels.clone();
        let reach = reach(&mut sorted);
        Self::with_bins(&levels, BINS, reach, picture.has_bottom())
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

/// Returns the level where a histogram ends: beyond what nearly all levels lie below.
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

    #[test]
    fn automatic_levels_are_percentiles_whatever_the_bins() {
        // Levels 0 to 199.98, evenly.
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
