//! Echograms of the primary and the down-scan channel: plausible, not physical. Their depth is what
//! matters.

use super::arithmetic::exp;
use super::random::{Random, RandomPurpose};
use bathyscope_log::survey::ChannelKind;

/// The bytes of one echogram column, nearest first, over `range_m` metres with the bottom at
/// `depth_m`.
pub(super) fn echogram(
    kind: ChannelKind,
    samples: usize,
    range_m: f64,
    depth_m: f64,
    seed: u64,
    ping: u64,
) -> Vec<u8> {
    // The traditional sonar has a wide cone and a long pulse, the down-scan with a thin fan and a
    // short one.
    let (stream, onset_m, tail_m, level) = match kind {
        ChannelKind::DownScan => (2 * ping, 0.02, 0.35, 175.0),
        _ => (2 * ping + 1, 0.06, 0.8, 215.0),
    };
    let mut random = Random::new(seed, RandomPurpose::Echogram, stream);
    let bottom = |range: f64, depth: f64| {
        let behind = range - depth;
        let rise = 1.0 / (1.0 + exp(-behind / onset_m));
        rise * exp(-behind.max(0.0) / tail_m)
    };
    (0..samples)
        .map(|index| {
            let range = (index as f64 + 0.5) * range_m / samples as f64;
            let ringing = 255.0 * exp(-range / 0.12);
            let echo = level * bottom(range, depth_m) + 0.35 * level * bottom(range, 2.0 * depth_m);
            let fading = 0.75 + 0.25 * random.exponential().min(2.0);
            let noise = 12.0 * random.exponential();
            (ringing + echo * fading + noise).clamp(0.0, 255.0) as u8
        })
        .collect()
}
