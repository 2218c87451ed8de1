//! How much natural logarithm of power a step of the recorded level is, from the speckle's spread.
//!
//! Where many scatterers share a sample its power is exponentially distributed whatever its mean, so the logarithm has the standard
//! deviation 1.28. A recorder that keeps decibels shows the same spread in levels everywhere, and the step is the one over the other.
//! Neighbouring samples overlap, which lowers the spread in a window a little. A recorder that keeps amplitudes has a spread that grows
//! with the level: there is no step then.

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

/// Mean and standard deviation of the levels in a window.
type Window = [f64; 2];

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
    let squares = window
        .iter()
        .map(|level| (f64::from(*level) - mean).powi(2));
    let sd = (squares.sum::<f64>() / count).sqrt();
    (window.iter().all(fits) && sd > 0.0).then_some([mean, sd])
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
    let scale = SPECKLE_SD * in_window / median(&mut sds);
    scale.is_finite().then_some(scale)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn decibels_have_a_step_and_amplitudes_have_none() {
        let decibels = (0..90).map(|i| [30.0 + f64::from(i) / 2.0, 14.0 + f64::from(i % 3)]);
        let scale = scale_of(decibels.collect()).unwrap();
        assert!((scale - 1.28 * (1.0_f64 - 2.485 / 60.0).sqrt() / 15.0).abs() < 1e-12);
        let amplitudes = (0..90).map(|i| [30.0 + f64::from(i), 0.5 * (30.0 + f64::from(i))]);
        assert_eq!(scale_of(amplitudes.collect()), None);
        assert_eq!(scale_of(vec![[40.0, 15.0]; 10]), None);
    }
}
