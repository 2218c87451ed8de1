//! Puts the samples of all pings of a file on one scale of decibels.

use super::packet::Profile;
use crate::survey::{Encoding, LEVEL_BITS, SidePing, SideSpan};

/// About how many pings are used to find the scale.
const PINGS_LOOKED_AT: usize = 200;
/// Share of the samples that may be clipped at either end.
const CLIPPED_SHARE: f64 = 0.001;
/// Lowest decibels that are counted; the highest are its opposite.
const LEAST_DB: i32 = -400;
/// One level in the units of [`Encoding::ScaledU16`].
const LEVEL: f64 = (1_u32 << LEVEL_BITS) as f64;

/// Decibels of level 0 and of level 255. Both are whole numbers, so that they can be recovered from
/// the spans of a log.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Scale {
    low_db: i32,
    high_db: i32,
}

impl Scale {
    /// Returns a scale that contains nearly all samples of these spans; each span comes with the
    /// decibels of its sample values 0 and 65535.
    pub(super) fn fitting(bytes: &[u8], spans: &[(SideSpan, [f32; 2])]) -> Self {
        let mut histogram = [0_u64; 2 * LEAST_DB.unsigned_abs() as usize + 1];
        for (span, power_db) in spans.iter().step_by(spans.len() / PINGS_LOOKED_AT + 1) {
            for value in values(bytes, span) {
                let db = decibels(value, *power_db).floor() as i32;
                let bin = usize::try_from(db - LEAST_DB).ok();
                if let Some(count) = bin.and_then(|bin| histogram.get_mut(bin)) {
                    *count += 1;
                }
            }
        }
        let low = bins_beyond(histogram.iter());
        let above = bins_beyond(histogram.iter().rev());
        let low_db = LEAST_DB + low as i32;
        Self { low_db, high_db: (LEAST_DB + (histogram.len() - above) as i32).max(low_db + 1) }
    }

    /// Returns the scale of the pings of a log; `None` where no ping gives a plausible one.
    pub(super) fn of_log(bytes: &[u8], pings: &[SidePing]) -> Option<Self> {
        let sides = pings.iter().rev().take(PINGS_LOOKED_AT);
        let mut spans = sides.flat_map(|ping| [ping.port, ping.starboard]).flatten();
        spans.find_map(|span| {
            let Encoding::ScaledU16 { base, step } = span.encoding else {
                return None;
            };
            let [least, most] = Profile::of_span(bytes, &span)?.power_db.map(f64::from);
            let db_per_level = (most - least) / (f64::from(step) / LEVEL * 65_535.0);
            let range_db = (255.0 * db_per_level).round();
            let low_db = (least - f64::from(base) / LEVEL * range_db / 255.0).round();
            let is_scale = (1.0..=800.0).contains(&range_db) && low_db.abs() <= 800.0;
            is_scale
                .then_some(Self { low_db: low_db as i32, high_db: low_db as i32 + range_db as i32 })
        })
    }

    /// Returns the encoding on this scale of samples whose values 0 and 65535 have these decibels.
    pub(super) fn encoding(self, [least_db, most_db]: [f32; 2]) -> Encoding {
        let levels_per_db = 255.0 / f64::from(self.high_db - self.low_db);
        let zero_level = (f64::from(least_db) - f64::from(self.low_db)) * levels_per_db;
        let levels = f64::from(most_db - least_db) * levels_per_db / 65_535.0;
        // The casts saturate where a value is out of range.
        Encoding::ScaledU16 {
            base: (zero_level * LEVEL).round() as i32,
            step: (levels * LEVEL).round() as u32,
        }
    }
}

/// Returns the number of bins from one end that together contain no more samples than may be
/// clipped.
fn bins_beyond<'a>(counts: impl Iterator<Item = &'a u64> + Clone) -> usize {
    let clipped = CLIPPED_SHARE * counts.clone().sum::<u64>() as f64;
    let mut beyond = 0;
    let clips = |count: &&u64| {
        beyond += **count;
        beyond as f64 <= clipped
    };
    counts.take_while(clips).count()
}

fn decibels(value: u16, [least_db, most_db]: [f32; 2]) -> f32 {
    least_db + f32::from(value) / 65_535.0 * (most_db - least_db)
}

/// Returns the stored samples of a span.
fn values<'a>(bytes: &'a [u8], span: &SideSpan) -> impl Iterator<Item = u16> + use<'a> {
    let pairs = span.stored(bytes).chunks_exact(2);
    pairs.map(|pair| u16::from_le_bytes([pair[0], pair[1]]))
}
