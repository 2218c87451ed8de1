//! How much natural logarithm of power a step of the recorded level is, from the speckle's spread.
//!
//! Where many scatterers share a sample its power is exponentially distributed whatever its mean, so the logarithm has the standard
//! deviation 1.28. A recorder that keeps decibels shows the same spread in levels everywhere, and the step is the one over the other.
//! Neighbouring samples overlap, which lowers the spread in a window a little. A recorder that keeps amplitudes has a spread that grows
//! with the level: there is no step then.
//!
//! A recorder that smooths its levels shows less spread, and a step would be taken for more than it is, which makes the slopes too
//! steep. Smoothing takes the skewness out as well: the logarithm of speckle has rare deep fades of a sample or two and no such peaks. On
//! simulated ponds smoothed over 0, 1, 2 and 4 samples the skewness in a window is -0.65, -0.28, -0.1 and 0.1, and the spread 1, 0.73,
//! 0.54 and 0.38 of the speckle's; the river recording has -0.17.

use super::echoes::LogEchoes;
use crate::progress::{Cancelled, Progress};
use crate::statistics::{median, quantile};
use crate::survey::Side;

/// Standard deviation of the natural logarithm of an exponentially distributed power, `pi / sqrt(6)`.
pub const SPECKLE_SD: f64 = 1.28;
/// Samples that make one independent one.
pub const GRAIN_SAMPLES: f64 = 2.485;
/// Samples in a window whose spread is taken.
const WINDOW: usize = 60;
/// Every so many pings are read.
const EVERY: usize = 7;
/// Windows begin and end at these multiples of the first return's sample: on the ground, and before the signal is lost in noise.
const FROM_FIRST_RETURN: [f64; 2] = [1.15, 2.3];
/// Levels below which a window must lie: the recorder cannot tell stronger echoes apart.
const MOST_LEVEL: u8 = 250;
/// Fewer windows say nothing.
const LEAST_WINDOWS: usize = 30;
/// Greatest exponent `ln sd / ln mean` of a recorder of decibels; amplitudes have 1, decibels 0.
const MOST_EXPONENT: f64 = 0.5;

/// Skewness in a window of levels that nobody smoothed, and what the spread loses for each unit that it is nearer to that of a normal
/// distribution; at most down to the last.
const SKEWNESS: f64 = -0.62;
const LOST_PER_SKEWNESS: f64 = 0.85;
const LEAST_LEFT: f64 = 0.35;

/// Mean and standard deviation of the levels in a window, and the mean cube of their deviations.
type Window = [f64; 3];

/// Natural logarithm of power for a step of the recorded level; `None` where the levels are none of decibels, or too few.
///
/// # Errors
/// When the work was cancelled.
pub fn level_scale(log: &LogEchoes<'_>, progress: &Progress) -> Result<Option<f64>, Cancelled> {
    let mut windows = Vec::new();
    let mut levels = Vec::new();
    for (ping, place) in log.pings.iter().enumerate().step_by(EVERY) {
        progress.check()?;
        for side in Side::BOTH {
            let first_return = place.side(side).first_return;
            if first_return.is_finite() && log.read(ping, side, &mut levels) {
                let first_return = first_return.max(0.0).floor();
                let end = |times: f64| ((first_return * times) as usize).min(levels.len());
                let [from, to] = FROM_FIRST_RETURN.map(end);
                windows.extend(
                    (from..to)
                        .step_by(WINDOW)
                        .filter_map(|from| window(&levels, from)),
                );
            }
        }
    }
    Ok(scale_of(windows))
}

fn window(levels: &[u8], from: usize) -> Option<Window> {
    let window = levels.get(from..from + WINDOW)?;
    let fits = |level: &u8| (1..MOST_LEVEL).contains(level);
    let count = WINDOW as f64;
    let mean = window.iter().map(|level| f64::from(*level)).sum::<f64>() / count;
    let moment = |power: i32| {
        let powers = window
            .iter()
            .map(|level| (f64::from(*level) - mean).powi(power));
        powers.sum::<f64>() / count
    };
    let sd = moment(2).sqrt();
    (window.iter().all(fits) && sd > 0.0).then_some([mean, sd, moment(3)])
}

fn scale_of(mut windows: Vec<Window>) -> Option<f64> {
    if windows.len() < LEAST_WINDOWS {
        return None;
    }
    windows.sort_by(|a, b| a[0].total_cmp(&b[0]));
    // Dark and bright thirds apart: the sorted windows' middle third says nothing of how the spread grows.
    let third = windows.len() / 3;
    let [dark, bright] = [&windows[..third], &windows[windows.len() - third..]].map(|some| {
        let mut sds: Vec<f64> = some.iter().map(|window| window[1]).collect();
        let means: Vec<f64> = some.iter().map(|window| window[0]).collect();
        [quantile(&means, 0.5), median(&mut sds)]
    });
    let exponent = (bright[1] / dark[1]).ln() / (bright[0] / dark[0]).max(1.0 + 1e-9).ln();
    let tells = bright[0] > 1.2 * dark[0];
    if tells && exponent > MOST_EXPONENT {
        return None;
    }
    let mut sds: Vec<f64> = windows.iter().map(|window| window[1]).collect();
    let in_window = (1.0 - GRAIN_SAMPLES / WINDOW as f64).sqrt();
    let scale = SPECKLE_SD * in_window * share_left(&windows) / median(&mut sds);
    scale.is_finite().then_some(scale)
}

/// Share of the speckle's spread that the recorder's smoothing has left.
fn share_left(windows: &[Window]) -> f64 {
    let sum = |of: fn(&Window) -> f64| windows.iter().map(of).sum::<f64>();
    let count = windows.len() as f64;
    let variance = sum(|window| window[1] * window[1]) / count;
    let skewness = sum(|window| window[2]) / count / variance.powf(1.5);
    (1.0 - LOST_PER_SKEWNESS * (skewness - SKEWNESS)).clamp(LEAST_LEFT, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A window of a mean and a spread, as skew as levels that nobody smoothed.
    fn window(mean: f64, sd: f64) -> Window {
        [mean, sd, SKEWNESS * sd.powi(3)]
    }

    #[test]
    fn decibels_have_a_step_and_amplitudes_have_none() {
        let decibels = (0..90).map(|i| window(30.0 + f64::from(i) / 2.0, 15.0));
        let scale = scale_of(decibels.collect()).unwrap();
        assert!((scale - 1.28 * (1.0_f64 - 2.485 / 60.0).sqrt() / 15.0).abs() < 1e-12);
        let amplitudes = (0..90).map(|i| window(30.0 + f64::from(i), 0.5 * (30.0 + f64::from(i))));
        assert_eq!(scale_of(amplitudes.collect()), None);
        assert_eq!(scale_of(vec![window(40.0, 15.0); 10]), None);
    }

    #[test]
    fn levels_that_were_smoothed_have_a_smaller_step_than_their_spread_says() {
        let skew = |skewness: f64| vec![[50.0, 10.0, skewness * 1000.0]; 40];
        let [sharp, smoothed, none] = [-1.0, -0.1, 2.0].map(|of| scale_of(skew(of)).unwrap());
        assert!((smoothed / sharp - (1.0 - 0.85 * 0.52)).abs() < 1e-9);
        assert!((none / sharp - LEAST_LEFT).abs() < 1e-9);
    }
}
