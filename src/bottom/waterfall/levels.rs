//! Chooses the echo levels of a survey that are shown as black and white.

use super::axis::is_usable;
use bathyscope_log::survey::{Side, SideScanState, SideSpan, Survey};

/// Largest number of pings that are read, evenly spread over the survey: enough for stable
/// quantiles, few enough to be read at once.
pub(crate) const MOST_SAMPLED_PINGS: usize = 256;
/// Share of each side next to the boat that is left out: there the transmit pulse rings, which
/// holds no information about the bottom.
const NEAR_SHARE: f64 = 0.1;
/// Share of the echoes that are at or below black.
const BLACK_QUANTILE: f64 = 0.01;
/// Share of the echoes that are at or below [`WHITE_REACH`].
const WHITE_QUANTILE: f64 = 0.99;
/// Brightness at which the white quantile is shown; brighter echoes keep their differences.
const WHITE_REACH: f64 = 0.9;
/// Least level of white, so that the noise of a log with hardly any echoes is not amplified.
const LEAST_WHITE: f64 = 32.0;

/// Echo levels shown as 0 and as 1, as shares of the largest byte. They depend on the survey, not
/// on the visible part of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Levels {
    /// Level shown as 0.
    pub black: f32,
    /// Level shown as 1; above `black`.
    pub white: f32,
}

impl Levels {
    /// Levels of bytes as recorded: 0 is black, 255 is white.
    pub const RECORDED: Self = Self { black: 0.0, white: 1.0 };

    /// Returns the levels at which the echoes of a survey use the whole range of colours: the 1st
    /// and 99th percentile of the echoes of up to 256 pings, away from the transmit pulse, with a
    /// little headroom. The same survey always gives the same levels. Noise without a bottom stays
    /// as recorded: amplified, it would look like a picture.
    pub fn of(survey: &Survey) -> Self {
        if survey.side_scan_state != SideScanState::Usable {
            return Self::RECORDED;
        }
        let Self { black, white } = Self::of_counts(&histogram(survey), 1.0);
        Self { black, white: white.min(1.0) }
    }

    /// Returns the levels at which echoes use the whole range of colours; `counts` are their
    /// numbers in bins of `step`, from 0.
    pub(crate) fn of_counts(counts: &[u64], step: f32) -> Self {
        let [Some(low), Some(high)] =
            [BLACK_QUANTILE, WHITE_QUANTILE].map(|share| quantile(counts, share))
        else {
            return Self::RECORDED;
        };
        let level = |bin: usize| bin as f64 * f64::from(step);
        let white = (level(high) / WHITE_REACH).max(LEAST_WHITE);
        // Black is at most half of white, so that a survey of a single grey is shown grey, not
        // black.
        let black = level(low).min(white / 2.0);
        Self { black: (black / 255.0) as f32, white: (white / 255.0) as f32 }
    }
}

/// Returns the first sample of a side beyond the transmit pulse; `None` where the span cannot be
/// drawn.
pub(crate) fn beyond_pulse(span: &SideSpan) -> Option<usize> {
    is_usable(span).then_some((f64::from(span.count) * NEAR_SHARE) as usize)
}

/// Counts the echoes of each byte value.
fn histogram(survey: &Survey) -> [u64; 256] {
    let mut counts = [0; 256];
    let mut outward = Vec::new();
    let step = survey.side_scan.len().div_ceil(MOST_SAMPLED_PINGS).max(1);
    for ping in (0..survey.side_scan.len()).step_by(step) {
        for side in Side::BOTH {
            let near = survey.span(ping, side).and_then(beyond_pulse);
            if let Some((near, samples)) = near.zip(survey.samples(ping, side)) {
                samples.copy_outward(&mut outward);
                for &echo in &outward[near..] {
                    counts[usize::from(echo)] += 1;
                }
            }
        }
    }
    counts
}

/// Returns the smallest bin that at least this share of all counted echoes does not exceed; `None`
/// when nothing was counted.
fn quantile(counts: &[u64], share: f64) -> Option<usize> {
    let total: u64 = counts.iter().sum();
    let rank = ((total as f64 * share).ceil() as u64).max(1);
    let mut seen = 0;
    counts.iter().position(|count| {
        seen += count;
        seen >= rank
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::waterfall::testing::{noise, span, survey};

    /// Survey with one side of 1000 samples a ping.
    fn of_pings(pings: usize, sample: impl Fn(usize, usize) -> u8) -> Survey {
        let bytes = (0..pings * 1000).map(|index| sample(index / 1000, index % 1000));
        let spans = (0..pings).map(|ping| [Some(span(ping * 1000, 1000, 20.0)), None]);
        survey(bytes.collect(), spans.collect())
    }

    fn in_bytes(levels: Levels) -> [f32; 2] {
        [levels.black * 255.0, levels.white * 255.0]
    }

    #[test]
    fn quantiles_are_those_of_the_sorted_bytes() {
        let mut bytes = noise(10_007);
        let mut counts = [0; 256];
        bytes.iter().for_each(|&byte| counts[usize::from(byte)] += 1);
        bytes.sort_unstable();
        for share in [0.0, 0.01, 0.25, 0.5, 0.99, 1.0] {
            let rank = ((bytes.len() as f64 * share).ceil() as usize).max(1);
            assert_eq!(quantile(&counts, share), Some(usize::from(bytes[rank - 1])), "{share}");
        }
        assert_eq!(quantile(&[0; 256], 0.5), None);
    }

    #[test]
    fn dim_echoes_fill_the_colours_whatever_the_pulse_does() {
        // Echoes: a pulse of 255 over the nearest tenth, then bytes that rise from 10 to 99 with
        // range.
        let dim = of_pings(40, |_, sample| match sample {
            0..100 => 255,
            _ => (sample / 10) as u8,
        });
        let [black, white] = in_bytes(Levels::of(&dim));
        assert!((black - 10.0).abs() < 1e-3, "{black}");
        assert!((white - 99.0 / 0.9).abs() < 1e-3, "{white}");
    }

    #[test]
    fn loud_grey_and_empty_surveys_keep_their_tone() {
        let loud = of_pings(3, |ping, sample| ((ping * 1000 + sample) % 256) as u8);
        let [black, white] = in_bytes(Levels::of(&loud));
        assert!(black < 6.0 && white == 255.0, "{black} {white}");
        let grey = of_pings(3, |_, _| 60);
        let Levels { black, white } = Levels::of(&grey);
        let shown = (60.0 / 255.0 - black) / (white - black);
        assert!((0.5..0.9).contains(&shown), "{shown}");
        let silent = of_pings(3, |_, _| 1);
        assert_eq!(in_bytes(Levels::of(&silent))[1], 32.0);
        assert_eq!(Levels::of(&of_pings(0, |_, _| 0)), Levels::RECORDED);
        let mut noise = grey;
        noise.side_scan_state = SideScanState::Noise { range_m: 1.5 };
        assert_eq!(Levels::of(&noise), Levels::RECORDED);
    }

    #[test]
    fn a_long_survey_is_judged_from_all_along_it() {
        let half = of_pings(2_000, |ping, _| if ping < 1_000 { 40 } else { 120 });
        let [black, white] = in_bytes(Levels::of(&half));
        assert_eq!((black, white.round()), (40.0, 133.0));
    }
}
