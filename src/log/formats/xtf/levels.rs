//! Determines the scale on which the samples of a whole file become levels.

use super::raw::{PingChannel, record};
use crate::survey::{Encoding, NumberKind, SideSpan};
use std::ops::Range;

/// About how many pings are used to find the type and the size of the samples.
const PINGS_LOOKED_AT: usize = 200;
/// Share of the samples that may be clipped when low bits are dropped.
const CLIPPED_SHARE: f64 = 0.001;
/// Bits of a level.
const LEVEL: i32 = 8;
/// Largest share of the numbers that may have no counterpart of the same magnitude and the other
/// sign, for the numbers to count as signed.
const MOST_ONE_SIDED: f64 = 0.3;
/// Largest share of signed numbers that may be louder than half of the largest storable magnitude.
const MOST_LOUD: f64 = 0.1;
/// Range of floating-point samples, and the smallest share of samples in it for them to count as
/// floating point. Whole numbers of less than 29 bits are below the range.
const FLOATING: Range<f64> = 1e-12..1e12;
const FLOATING_SHARE: f64 = 0.99;
/// Number of powers of two that are counted, for all numbers of 64 bits with any weight, beginning
/// at minus [`LEAST`].
const MAGNITUDES: usize = 2200;
const LEAST: i32 = 1100;
/// Largest amount of a plausible weight; larger ones are damage: 2^-40 volts are no signal.
const HEAVIEST: i16 = 40;

/// Properties of all samples of a file that its headers state.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Stated {
    /// True if samples may be signed.
    pub(super) is_polar: bool,
    /// True if only the bytes of a sample are stated, not its format.
    pub(super) is_legacy: bool,
    /// True if samples count 2^-weight, by the weight in the header of their ping.
    pub(super) is_weighted: bool,
}

/// Sets the scale of all spans, one scale for each kind of numbers; in the tail of a log, the scale
/// of the log, of which `known` is a span.
pub(super) fn fit(
    bytes: &[u8],
    spans: &mut [&mut SideSpan],
    stated: Stated,
    known: Option<SideSpan>,
) {
    let mut kinds: Vec<NumberKind> = Vec::new();
    for span in &*spans {
        let (kind, _) = number(span.encoding);
        if !kinds.contains(&kind) {
            kinds.push(kind);
        }
    }
    for stored in kinds {
        let alike = spans.iter_mut();
        let alike = alike.filter(|span| number(span.encoding).0 == stored);
        let mut alike: Vec<&mut SideSpan> = alike.map(|span| &mut **span).collect();
        let known = known.filter(|known| known.encoding.width() == stored.width());
        fit_alike(bytes, &mut alike, (stored, stated), known);
    }
}

/// Sets the scale of spans with the same stored kind of numbers.
fn fit_alike(
    bytes: &[u8],
    spans: &mut [&mut SideSpan],
    (stored, stated): (NumberKind, Stated),
    known: Option<SideSpan>,
) {
    let weight = |span: &SideSpan| if stated.is_weighted { weight(bytes, span) } else { 0 };
    // The exponent applies to samples of weight 0.
    let (kind, exponent) = match known {
        Some(known) => {
            let (kind, exponent) = number(known.encoding);
            (kind, i32::from(exponent) + weight(&known))
        }
        None => {
            let spans: Vec<&SideSpan> = spans.iter().map(|span| &**span).collect();
            let kind = meant(bytes, &spans, stored, stated);
            let bits = bits_to_fit(bytes, &spans, kind, weight);
            // For whole numbers, no low bits are added to the ping with the highest weight.
            let finest = spans.iter().map(|span| weight(span)).max().unwrap_or(0);
            let exponent = match kind {
                NumberKind::F32 | NumberKind::IbmF32 => LEVEL - bits,
                _ => (LEVEL - bits).min(finest),
            };
            (kind, exponent)
        }
    };
    for span in spans {
        let exponent = i16::try_from(exponent - weight(span)).unwrap_or(0);
        span.encoding = match (kind, u8::try_from(-exponent)) {
            (NumberKind::U8, Ok(0)) => Encoding::U8,
            // When a log grows, all of these spans get one shift.
            (NumberKind::U16, Ok(shift)) if !stated.is_weighted => Encoding::U16 { shift },
            _ => Encoding::Number { kind, exponent },
        };
    }
}

/// Returns the kind of numbers of an encoding, and the exponent of 2 that converts them to levels.
fn number(encoding: Encoding) -> (NumberKind, i16) {
    match encoding {
        Encoding::U16 { shift } => (NumberKind::U16, -i16::from(shift)),
        Encoding::Number { kind, exponent } => (kind, exponent),
        _ => (NumberKind::U8, 0),
    }
}

/// Returns the actual kind of the stored numbers, by the samples themselves where the headers are
/// ambiguous.
fn meant(bytes: &[u8], spans: &[&SideSpan], stored: NumberKind, stated: Stated) -> NumberKind {
    let signed = match stored {
        NumberKind::U8 => NumberKind::I8,
        NumberKind::U16 => NumberKind::I16,
        NumberKind::U32 => NumberKind::I32,
        floating => return floating,
    };
    if stored == NumberKind::U32 && stated.is_legacy && are_floating(bytes, spans) {
        return NumberKind::F32;
    }
    if stated.is_polar && have_signs(bytes, spans, stored) { signed } else { stored }
}

/// Returns true if four bytes are plausible as floating point, which whole numbers of usual size
/// are not.
fn are_floating(bytes: &[u8], spans: &[&SideSpan]) -> bool {
    let values = looked_at(spans).flat_map(|span| magnitudes(bytes, span, NumberKind::F32));
    let (mut plausible, mut all) = (0_u64, 0_u64);
    for value in values.filter(|value| *value != 0.0) {
        all += 1;
        plausible += u64::from(FLOATING.contains(&value));
    }
    all > 0 && plausible as f64 >= FLOATING_SHARE * all as f64
}

/// Returns true if whole numbers are distributed around 0 when the highest bit is read as a sign.
/// Many files state that their samples may be signed although none are.
fn have_signs(bytes: &[u8], spans: &[&SideSpan], stored: NumberKind) -> bool {
    let end = f64::powi(2.0, 8 * stored.width() as i32);
    let mut more_positive = vec![0_i64; MAGNITUDES];
    let (mut all, mut loud) = (0_u64, 0_u64);
    let values = looked_at(spans).flat_map(|span| magnitudes(bytes, span, stored));
    for value in values.filter(|value| *value > 0.0) {
        let is_positive = value < end / 2.0;
        let magnitude = if is_positive { value } else { end - value };
        more_positive[place(bits(magnitude))] += if is_positive { 1 } else { -1 };
        all += 1;
        loud += u64::from(magnitude >= end / 4.0);
    }
    let one_sided: u64 = more_positive.iter().map(|more| more.unsigned_abs()).sum();
    all > 0
        && one_sided as f64 <= MOST_ONE_SIDED * all as f64
        && loud as f64 <= MOST_LOUD * all as f64
}

/// Returns the number of low bits to drop so that nearly all samples fit a byte. All samples must
/// have 16 bits, or all 32.
pub(in crate::formats) fn shift_to_fit(bytes: &[u8], spans: &[&SideSpan]) -> u8 {
    let kind = match spans.first().map(|span| span.encoding.width()) {
        Some(4) => NumberKind::U32,
        _ => NumberKind::U16,
    };
    let bits = bits_to_fit(bytes, spans, kind, |_| 0);
    u8::try_from(bits - LEVEL).unwrap_or(0)
}

/// Returns the power of two below which nearly all magnitudes are, scaled to weight 0; 0 where all
/// are zeros.
fn bits_to_fit(
    bytes: &[u8],
    spans: &[&SideSpan],
    kind: NumberKind,
    weight: impl Fn(&SideSpan) -> i32,
) -> i32 {
    let mut histogram = vec![0_u64; MAGNITUDES];
    let mut total = 0_u64;
    for span in looked_at(spans) {
        let weight = weight(span);
        for value in magnitudes(bytes, span, kind).filter(|value| value.is_finite()) {
            total += 1;
            if value > 0.0 {
                histogram[place(bits(value) - weight)] += 1;
            }
        }
    }
    let mut beyond = 0;
    let highest = histogram.iter().rposition(|count| {
        beyond += count;
        beyond as f64 > CLIPPED_SHARE * total as f64
    });
    highest.map_or(0, |place| place as i32 - LEAST)
}

/// Returns the index in a histogram at which a power of two is counted.
fn place(bits: i32) -> usize {
    usize::try_from(bits + LEAST).map_or(0, |place| place.min(MAGNITUDES - 1))
}

/// Returns the exponent of the lowest power of two that is greater than a number above 0.
fn bits(value: f64) -> i32 {
    ((value.to_bits() >> 52) & 0x7FF) as i32 - 1022
}

/// Returns some of the spans, evenly spread over all.
fn looked_at<'a>(spans: &'a [&'a SideSpan]) -> impl Iterator<Item = &'a SideSpan> {
    let step = spans.len() / PINGS_LOOKED_AT + 1;
    spans.iter().copied().step_by(step)
}

/// Returns the magnitudes of the numbers of a span.
fn magnitudes<'a>(
    bytes: &'a [u8],
    span: &SideSpan,
    kind: NumberKind,
) -> impl Iterator<Item = f64> + use<'a> {
    let start = usize::try_from(span.offset).unwrap_or(usize::MAX);
    let end = start.saturating_add((span.count as usize).saturating_mul(kind.width()));
    let stored = bytes.get(start..end).unwrap_or_default();
    let numbers = stored.chunks_exact(kind.width());
    numbers.map(move |number| kind.magnitude(number))
}

/// Returns the weight in the header before the samples of a span; 0 where it is missing or not
/// plausible.
fn weight(bytes: &[u8], span: &SideSpan) -> i32 {
    let samples = usize::try_from(span.offset).ok();
    let header = samples.and_then(|at| at.checked_sub(size_of::<PingChannel>()));
    let header = header.and_then(|at| record::<PingChannel>(bytes, at));
    let weight = header.map_or(0, |header| header.weight);
    if weight.unsigned_abs() <= HEAVIEST.unsigned_abs() { i32::from(weight) } else { 0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the encoding that a span of these numbers gets.
    fn fitted(stored: NumberKind, numbers: &[u8], stated: Stated) -> Encoding {
        let mut span = SideSpan {
            encoding: Encoding::Number { kind: stored, exponent: 0 },
            ..SideSpan::of_bytes((numbers.len() / stored.width()) as u32, [0.0, 1.0])
        };
        fit(numbers, &mut [&mut span], stated, None);
        span.encoding
    }

    fn le<const N: usize>(numbers: impl Iterator<Item = [u8; N]>) -> Vec<u8> {
        numbers.flatten().collect()
    }

    #[test]
    fn nearly_all_samples_fit_a_level() {
        let legacy = Stated { is_legacy: true, ..Stated::default() };
        let bytes: Vec<u8> = (0..=255).collect();
        assert_eq!(fitted(NumberKind::U8, &bytes, legacy), Encoding::U8);
        let pairs = le((0..4000_u16).map(u16::to_le_bytes));
        let shifted = Encoding::U16 { shift: 4 };
        assert_eq!(fitted(NumberKind::U16, &pairs, legacy), shifted);
        let number = |kind, exponent| Encoding::Number { kind, exponent };
        let words = le((0..2000_u32).map(|value| (value << 12).to_le_bytes()));
        let dropped = number(NumberKind::U32, -15);
        assert_eq!(fitted(NumberKind::U32, &words, legacy), dropped);
        // A few spikes, infinity and NaN do not darken the rest.
        let mut floats: Vec<f32> = (0..4000).map(|value| value as f32 / 4000.0).collect();
        floats.extend([1e30, 1e30, f32::INFINITY, f32::NAN]);
        let floats = le(floats.into_iter().map(f32::to_le_bytes));
        for stored in [NumberKind::F32, NumberKind::U32] {
            let fitted = fitted(stored, &floats, legacy);
            assert_eq!(fitted, number(NumberKind::F32, 8));
        }
    }

    #[test]
    fn only_samples_around_zero_have_a_sign() {
        let polar = Stated { is_polar: true, ..Stated::default() };
        let wave = |at: i16| (f64::from(at).sin() * f64::from(at)) as i16;
        let pairs = le((0..4000).map(|at| wave(at).to_le_bytes()));
        let signed = Encoding::Number { kind: NumberKind::I16, exponent: -4 };
        assert_eq!(fitted(NumberKind::U16, &pairs, polar), signed);
        // Without the flag, with numbers of one sign, or with equally frequent magnitudes, they are
        // unsigned.
        let is_unsigned = |numbers: &[u8], stated| {
            matches!(fitted(NumberKind::U16, numbers, stated), Encoding::U16 { .. })
        };
        assert!(is_unsigned(&pairs, Stated::default()));
        let low = le((0..4000_u16).map(u16::to_le_bytes));
        assert!(is_unsigned(&low, polar));
        let all = le((0..=u16::MAX).map(u16::to_le_bytes));
        assert!(is_unsigned(&all, polar));
        // A bright picture with saturated samples.
        let bytes: Vec<u8> = (0..4000).map(|at| [30, 60, 200, 255][at % 4]).collect();
        assert_eq!(fitted(NumberKind::U8, &bytes, polar), Encoding::U8);
    }
}
