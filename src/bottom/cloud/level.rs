//! Level of the echo of a first return.

use bathyscope_log::survey::{Side, Survey};

/// Slant range from the edge of a first return within which its echo is strongest, metres.
const ECHO_M: f64 = 0.2;

/// The greatest level, 0 to 255, within a pulse's length of a first return `sample` samples
/// outward: the pick itself lies on the edge of the echo, where the level says little of the
/// ground. 0 where that side was not recorded.
pub(super) fn echo_level(survey: &Survey, ping: usize, side: Side, sample: f32) -> u8 {
    let level = || {
        let (span, samples) = (survey.span(ping, side)?, survey.samples(ping, side)?);
        let length = (ECHO_M / span.metres_per_sample()).clamp(1.0, f64::from(u16::MAX)) as usize;
        let first = sample.max(0.0) as usize;
        let last = samples.len().min(first.saturating_add(length));
        (first..last).map(|sample| samples.get(sample)).max()
    };
    level().unwrap_or(0)
}
