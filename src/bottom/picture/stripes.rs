//! Computes the stripe filter: a factor for every ping that is brighter or darker than the pings
//! around it.
//!
//! Interference of another sonar, a wave that tilts the boat or a change of the recorder's gain
//! makes a whole ping brighter or darker; the ground does not change from one ping to the next. The
//! level of a ping is the mean of the middle part of its sorted echoes, which an object or a shadow
//! hardly changes. It is scaled to the median of the pings around it, which keeps the edge between
//! two kinds of ground.

use super::PingScales;
use bathyscope_log::support::progress::{Cancelled, Progress};
use bathyscope_log::support::statistics::median_of;
use bathyscope_log::survey::{Side, Survey};
use rayon::prelude::*;

/// Number of pings before and after a ping to whose median level it is scaled.
const HALF_PINGS: usize = 8;
/// Quantiles of the echoes of a ping between which they count for its level.
const MIDDLE: [f64; 2] = [0.2, 0.8];
/// Bounds of the factor.
const FACTORS: [f32; 2] = [0.25, 4.0];
/// Least number of echoes on the ground for which a ping has a level.
const LEAST_ECHOES: usize = 16;
/// Least level in the ratio of levels.
const LEAST_LEVEL: f32 = 0.5;
/// Number of pings between two checks for cancellation.
const CHUNK: usize = 512;

/// Returns the factors that scale the pings of a log to the levels of the pings around them, by
/// side, port first; 1 where nothing was recorded.
///
/// # Errors
/// When the work was cancelled.
pub fn stripe_factors(
    survey: &Survey,
    scales: &PingScales,
    progress: &Progress,
) -> Result<[Vec<f32>; 2], Cancelled> {
    let pings: Vec<usize> = (0..survey.side_scan.len()).collect();
    let side = |side: Side| -> Result<Vec<f32>, Cancelled> {
        let chunks: Result<Vec<Vec<f32>>, Cancelled> = pings
            .par_chunks(CHUNK)
            .map(|chunk| {
                progress.check()?;
                let mut echoes = Vec::new();
                let level = |&ping: &usize| level(survey, scales, side, ping, &mut echoes);
                Ok(chunk.iter().map(level).collect())
            })
            .collect();
        Ok(factors(&chunks?.concat()))
    };
    Ok([side(Side::Port)?, side(Side::Starboard)?])
}

/// Returns the mean of the middle part of the sorted echoes on the ground; NaN for a ping with too
/// few echoes.
fn level(
    survey: &Survey,
    scales: &PingScales,
    side: Side,
    ping: usize,
    echoes: &mut Vec<u8>,
) -> f32 {
    let (Some(span), Some(samples)) = (survey.span(ping, side), survey.samples(ping, side)) else {
        return f32::NAN;
    };
    let scale = scales.at(side, ping);
    let ground_m = scale.recorded_m(f64::from(scale.altitude_m));
    let first = span.sample_at(ground_m).ceil().max(0.0) as usize;
    samples.copy_part_outward(first..samples.len(), echoes);
    middle_mean(echoes)
}

/// Returns the mean of the echoes between two quantiles, computed from counts of the levels; NaN
/// for too few echoes.
fn middle_mean(echoes: &[u8]) -> f32 {
    let mut counts = [0_u32; 256];
    for &echo in echoes {
        counts[usize::from(echo)] += 1;
    }
    let total = echoes.len() as f64;
    if echoes.len() < LEAST_ECHOES {
        return f32::NAN;
    }
    let [from, to] = MIDDLE.map(|share| share * total);
    let (mut below, mut sum) = (0.0, 0.0);
    for (level, &count) in counts.iter().enumerate() {
        let above = below + f64::from(count);
        let count_within = (above.min(to) - below.max(from)).max(0.0);
        sum += count_within * level as f64;
        below = above;
    }
    (sum / (to - from)) as f32
}

/// Returns the factors that scale every level to the median of the levels around it.
fn factors(levels: &[f32]) -> Vec<f32> {
    let factor = |(ping, &level): (usize, &f32)| {
        if level.is_nan() {
            return 1.0;
        }
        let near = ping.saturating_sub(HALF_PINGS)..(ping + HALF_PINGS + 1).min(levels.len());
        let about = levels[near].iter().filter(|level| !level.is_nan());
        let goal = median_of(about.map(|level| f64::from(*level))) as f32;
        (goal.max(LEAST_LEVEL) / level.max(LEAST_LEVEL)).clamp(FACTORS[0], FACTORS[1])
    };
    levels.iter().enumerate().map(factor).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bright_ping_is_brought_down_and_the_edge_of_two_grounds_stays() {
        let levels: Vec<f32> = (0..60)
            .map(|ping| match ping {
                10 => 90.0,
                40 => 20.0,
                0..30 => 30.0,
                _ => 60.0,
            })
            .collect();
        let factors = factors(&levels);
        for (ping, factor) in factors.iter().enumerate() {
            let expected = match ping {
                10 => 30.0 / 90.0,
                40 => 60.0 / 20.0,
                _ => 1.0,
            };
            assert!((factor - expected).abs() < 1e-5, "{ping}: {factor}");
        }
    }

    #[test]
    fn an_object_does_not_move_the_level_of_a_ping() {
        let ground = vec![40_u8; 1000];
        let mut with_object = ground.clone();
        with_object[300..400].fill(250);
        with_object[400..500].fill(0);
        assert_eq!(middle_mean(&ground), 40.0);
        assert_eq!(middle_mean(&with_object), 40.0);
        assert!(middle_mean(&[9; 3]).is_nan());
    }
}
