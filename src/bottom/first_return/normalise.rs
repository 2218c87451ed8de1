//! Computes the normalised intensity as the paper does: the middle is set to zero, then the values
//! are scaled from minimum to maximum of the whole picture. It reads the picture in bytes, or as
//! the published code does: four stored bytes as one little-endian int32.
//!
//! The rows of a composite picture run from far port over the middle to far starboard, and a word
//! takes four neighbours in that order. Outward from the middle, the most significant byte of word
//! `k` is therefore sample `4 k + 3` on starboard and sample `4 k` on port. A word is negative when
//! that byte is 128 or more.

use super::{ImageSettings, SampleMode};
use bathyscope_log::support::progress::{Cancelled, Progress};
use bathyscope_log::survey::{SampleOrder, Samples, Side, SideSpan, Survey};
use rayon::prelude::*;

/// Number of pings in one parallel step.
pub(super) const BLOCK: usize = 512;

/// Scale between recorded and normalised intensity, measured over the whole masked picture.
///
/// `normalised = (value - lowest) / (highest - lowest)`, where a value is a byte, or the signed
/// word of [`SampleMode::Words`]. The middle of the picture (the dead zone) counts as zeros.
#[derive(Clone, Debug, PartialEq)]
pub struct Normalisation {
    /// Meaning of a value of the picture.
    pub samples: SampleMode,
    /// Slant range around the transducer that is set to zero, metres.
    pub dead_zone_m: f64,
    /// Smallest value of the masked picture.
    pub lowest: i32,
    /// Largest value of the masked picture.
    pub highest: i32,
}

impl Normalisation {
    /// Measures the scale in one pass over the whole picture.
    ///
    /// # Errors
    /// When the work was cancelled.
    pub fn measure(
        survey: &Survey,
        image: &ImageSettings,
        dead_zone_m: f64,
        progress: &Progress,
    ) -> Result<Self, Cancelled> {
        let pings = survey.side_scan.len();
        progress.start(pings as u64);
        let extremes = (0..pings.div_ceil(BLOCK))
            .into_par_iter()
            .map(|block| {
                progress.check()?;
                let range = block * BLOCK..pings.min((block + 1) * BLOCK);
                progress.advance(range.len() as u64);
                Ok(range.fold(ValueExtremes::NONE, |all, ping| {
                    all.and(ping_extremes(survey, ping, image.samples, dead_zone_m))
                }))
            })
            .try_reduce(|| ValueExtremes::NONE, |a, b| Ok(a.and(b)))?;
        let ValueExtremes { lowest, highest } = extremes;
        // A picture without a single value is black.
        let (lowest, highest) = if lowest > highest { (0, 0) } else { (lowest, highest) };
        Ok(Self { samples: image.samples, dead_zone_m, lowest, highest })
    }

    /// Returns the scale over this part of a picture and another.
    #[must_use]
    pub fn widened(&self, other: &Self) -> Self {
        // A picture without a single value is black and does not determine a scale.
        let is_black = |scale: &Self| scale.lowest == 0 && scale.highest == 0;
        match (is_black(self), is_black(other)) {
            (true, _) => other.clone(),
            (_, true) => self.clone(),
            _ => Self {
                lowest: self.lowest.min(other.lowest),
                highest: self.highest.max(other.highest),
                ..self.clone()
            },
        }
    }

    /// Returns the smallest value whose normalised intensity reaches `level`; more than every value
    /// when the picture is empty.
    pub(crate) fn raw_level(&self, level: f32) -> i64 {
        let span = i64::from(self.highest) - i64::from(self.lowest);
        if span <= 0 {
            return i64::MAX;
        }
        // A level such as 0.2 is not exact in binary: without the tolerance, a value of exactly 0.2
        // would not reach it.
        let raw = (f64::from(level) - 1e-6) * span as f64;
        i64::from(self.lowest) + raw.ceil() as i64
    }

    /// Returns the normalised intensity of a value, 0 to 1.
    pub(crate) fn normalised(&self, value: i32) -> f32 {
        let span = (i64::from(self.highest) - i64::from(self.lowest)).max(1);
        ((i64::from(value) - i64::from(self.lowest)) as f64 / span as f64) as f32
    }

    /// Returns the normalised intensity of one side of a ping, nearest first, with the dead zone
    /// masked: one value for each sample, or for each word of four samples. Empty where the side
    /// was not recorded.
    pub fn profile(&self, survey: &Survey, ping: usize, side: Side) -> Vec<f32> {
        let span = survey.span(ping, side);
        let Some((span, samples)) = span.zip(survey.samples(ping, side)) else {
            return Vec::new();
        };
        let dead = dead_samples(span, self.dead_zone_m);
        let masked = self.normalised(0);
        match self.samples {
            SampleMode::Bytes => (0..samples.len())
                .map(|index| {
                    if index < dead {
                        masked
                    } else {
                        self.normalised(i32::from(samples.get(index)))
                    }
                })
                .collect(),
            SampleMode::Words => std::iter::repeat_n(masked, dead.div_ceil(WORD))
                .chain(words_outward(samples, side, dead).map(|word| self.normalised(word)))
                .collect(),
        }
    }

    /// Returns a warning where words are negative beyond the dead zone.
    pub fn warning(&self) -> Option<String> {
        (self.lowest < 0).then(|| {
            format!(
                "int32 words are negative beyond the dead zone ({} at the lowest), so that zero echo is scaled to {:.2} \
                 and passes most thresholds; use image.samples = bytes, or a longer first_return.dead_zone_m",
                self.lowest,
                self.normalised(0)
            )
        })
    }
}

/// Returns the index of the first sample beyond the dead zone.
pub(super) fn dead_samples(span: &SideSpan, dead_zone_m: f64) -> usize {
    // A dead zone of exactly n samples must not become n + 1 by rounding.
    let samples = (span.sample_at(dead_zone_m) - 1e-6).ceil();
    // The cast saturates: for a span without length, no sample is searched.
    (samples.max(0.0) as usize).min(span.count as usize)
}

#[derive(Clone, Copy)]
struct ValueExtremes {
    lowest: i32,
    highest: i32,
}

impl ValueExtremes {
    const NONE: Self = Self { lowest: i32::MAX, highest: i32::MIN };

    fn and(self, other: Self) -> Self {
        Self { lowest: self.lowest.min(other.lowest), highest: self.highest.max(other.highest) }
    }

    fn with(self, value: i32) -> Self {
        self.and(Self { lowest: value, highest: value })
    }
}

fn ping_extremes(
    survey: &Survey,
    ping: usize,
    mode: SampleMode,
    dead_zone_m: f64,
) -> ValueExtremes {
    Side::BOTH.into_iter().fold(ValueExtremes::NONE, |extremes, side| {
        let (Some(samples), Some(span)) = (survey.samples(ping, side), survey.span(ping, side))
        else {
            return extremes;
        };
        let dead = dead_samples(span, dead_zone_m);
        let masked = if dead > 0 { extremes.with(0) } else { extremes };
        match mode {
            SampleMode::Bytes => match samples.stored_u8() {
                Some((stored, order)) => {
                    masked.and(byte_extremes(bytes_beyond(stored, order, dead)))
                }
                None => (dead..samples.len())
                    .fold(masked, |all, at| all.with(i32::from(samples.get(at)))),
            },
            SampleMode::Words => {
                words_outward(samples, side, dead).fold(masked, ValueExtremes::with)
            }
        }
    })
}

fn byte_extremes(bytes: &[u8]) -> ValueExtremes {
    if bytes.is_empty() {
        return ValueExtremes::NONE;
    }
    let (lowest, highest) =
        bytes.iter().fold((u8::MAX, u8::MIN), |(low, high), &byte| (low.min(byte), high.max(byte)));
    ValueExtremes { lowest: i32::from(lowest), highest: i32::from(highest) }
}

/// Samples in a word.
pub(super) const WORD: usize = 4;

/// Returns the words of one side that lie completely beyond `dead` samples, nearest first.
pub(super) fn words_outward<'a>(
    samples: Samples<'a>,
    side: Side,
    dead: usize,
) -> impl Iterator<Item = i32> + 'a {
    (dead.div_ceil(WORD)..samples.len() / WORD).map(move |index| word(&samples, side, index))
}

fn word(samples: &Samples, side: Side, index: usize) -> i32 {
    let outward: [u8; WORD] = std::array::from_fn(|byte| samples.get(WORD * index + byte));
    match side {
        Side::Starboard => i32::from_le_bytes(outward),
        Side::Port => i32::from_be_bytes(outward),
    }
}

/// Returns the stored bytes beyond `dead` samples outward, in stored order.
fn bytes_beyond(stored: &[u8], order: SampleOrder, dead: usize) -> &[u8] {
    let dead = dead.min(stored.len());
    match order {
        SampleOrder::NearToFar => &stored[dead..],
        SampleOrder::FarToNear => &stored[..stored.len() - dead],
    }
}
