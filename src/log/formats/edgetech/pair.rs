//! Sorts the pings of a sonar's subsystems into pairs of a port and a starboard channel, chooses
//! the pair that is shown, and sets the scale of the samples.

use super::trace::Trace;
use crate::formats::collected::{Collected, CollectedPair, HalfPing};
use crate::survey::{Encoding, LEVEL_BITS, Side, SideSpan, Survey};
use std::collections::BTreeMap;

/// Smallest share of the most pings of any subsystem that a subsystem of higher frequency needs to
/// be preferred.
const ENOUGH_PINGS: f64 = 0.9;
/// About how many pings are used to find the scale.
const PINGS_LOOKED_AT: usize = 200;
/// Share of the samples that may be clipped at the highest level.
const CLIPPED_SHARE: f64 = 0.001;
/// Largest amount of a plausible weighting factor; larger ones are damage: 2^-40 volts are no
/// signal.
const HEAVIEST: u16 = 40;

/// One side of a ping.
#[derive(Clone, Copy, Debug)]
pub(super) struct Half {
    /// Side of the boat.
    pub(super) side: Side,
    /// Subsystem of the ping.
    pub(super) subsystem: u8,
    /// Weighting factor of the ping.
    pub(super) weight: i16,
    /// Samples of this side, on a scale that is not set yet.
    pub(super) half: HalfPing,
}

/// Number of pings and frequency of a subsystem.
#[derive(Clone, Copy, Debug, Default)]
struct Subsystem {
    pings: usize,
    frequency_khz: f32,
}

/// Collects the sides of all subsystems.
#[derive(Debug, Default)]
pub(super) struct Pairs {
    halves: Vec<Half>,
    subsystems: BTreeMap<u8, Subsystem>,
    /// Choices that were made for the log before, where its tail is read; the shown subsystem comes
    /// first.
    known: Vec<Chosen>,
}

/// A subsystem, and the number of low bits that are dropped from a sample of weight 0; `None` where
/// unknown.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Chosen {
    subsystem: u8,
    dropped_bits: Option<i32>,
}

impl Pairs {
    /// Creates a collection that keeps the choices made for a log.
    pub(super) fn like(bytes: &[u8], log: &Survey) -> Self {
        let chosen = |span: SideSpan| {
            let trace = Trace::of_span(bytes, &span)?;
            let step = step(span.encoding).filter(|step| *step > 0);
            let dropped = |step: u32| LEVEL_BITS as i32 - step.ilog2() as i32;
            Some(Chosen {
                subsystem: trace.subsystem,
                dropped_bits: step.map(|step| dropped(step) - i32::from(trace.weight)),
            })
        };
        Self { known: log.last_spans().filter_map(chosen).collect(), ..Self::default() }
    }

    /// Adds one side of a ping.
    pub(super) fn keep(&mut self, half: Half, frequency_khz: Option<f32>) {
        let subsystem = self.subsystems.entry(half.subsystem).or_default();
        subsystem.pings += 1;
        subsystem.frequency_khz = frequency_khz.unwrap_or(subsystem.frequency_khz);
        self.halves.push(half);
    }

    /// Adds a pair for each subsystem to the log, each on one scale; the shown pair comes first.
    pub(super) fn finish(self, bytes: &[u8], log: &mut Collected) {
        let shown = self.known.first().map(|known| known.subsystem);
        let Some(shown) = shown.or_else(|| choose(&self.subsystems)) else {
            return;
        };
        let others = self.subsystems.keys().copied().filter(|number| *number != shown);
        for subsystem in std::iter::once(shown).chain(others) {
            let halves = self.halves.iter().copied();
            let halves: Vec<Half> = halves.filter(|half| half.subsystem == subsystem).collect();
            let known = self.known.iter().find(|known| known.subsystem == subsystem);
            let dropped_bits = known.and_then(|known| known.dropped_bits);
            let dropped_bits = dropped_bits.unwrap_or_else(|| bits_to_drop(bytes, &halves));
            let seen = self.subsystems.get(&subsystem);
            let mut pair = CollectedPair {
                name: name(subsystem),
                frequency_khz: seen.map(|seen| seen.frequency_khz).filter(|khz| *khz > 0.0),
                port: Vec::new(),
                starboard: Vec::new(),
            };
            for half in halves {
                let shift = dropped_bits + i32::from(half.weight);
                let mut ping = half.half;
                set_step(&mut ping.span.encoding, step_of_shift(shift));
                match half.side {
                    Side::Port => pair.port.push(ping),
                    Side::Starboard => pair.starboard.push(ping),
                }
            }
            log.pairs.push(pair);
        }
    }
}

/// Returns the name of a subsystem for the user.
pub(super) fn name(subsystem: u8) -> String {
    let what = match subsystem {
        0 => "sub-bottom",
        20 | 70 => "low frequency",
        21 | 71 => "high frequency",
        22 | 72 => "very high frequency",
        40..=42 => "bathymetry",
        _ => return format!("subsystem {subsystem}"),
    };
    format!("{what} (subsystem {subsystem})")
}

/// Returns the subsystem of the highest frequency among those that have nearly the most pings.
fn choose(subsystems: &BTreeMap<u8, Subsystem>) -> Option<u8> {
    let most = subsystems.values().map(|subsystem| subsystem.pings).max()?;
    let enough = |subsystem: &Subsystem| subsystem.pings as f64 >= ENOUGH_PINGS * most as f64;
    let candidates = subsystems.iter().filter(|(_, subsystem)| enough(subsystem));
    let (chosen, _) =
        candidates.max_by(|(_, a), (_, b)| a.frequency_khz.total_cmp(&b.frequency_khz))?;
    Some(*chosen)
}

/// Returns the number of low bits to drop from a sample, less its weight, so that nearly all
/// samples of all pings fit a level on one scale. No low bits are added to the ping with the
/// highest weight.
fn bits_to_drop(bytes: &[u8], halves: &[Half]) -> i32 {
    let mut histogram: BTreeMap<i32, u64> = BTreeMap::new();
    for half in halves.iter().step_by(halves.len() / PINGS_LOOKED_AT + 1) {
        let bits = stored_bits(bytes, &half.half.span);
        for (bits, count) in bits.into_iter().enumerate().skip(1) {
            *histogram.entry(bits as i32 - i32::from(half.weight)).or_default() += count;
        }
    }
    let total: u64 = histogram.values().sum();
    let mut beyond = 0;
    let highest = histogram.iter().rev().find(|(_, count)| {
        beyond += **count;
        beyond as f64 > CLIPPED_SHARE * total as f64
    });
    let finest = halves.iter().map(|half| i32::from(half.weight)).max();
    let finest = finest.unwrap_or(0);
    highest.map_or(-finest, |(highest, _)| (highest - 8).max(-finest))
}

/// Returns the number of samples of a span by the number of bits that they take.
fn stored_bits(bytes: &[u8], span: &SideSpan) -> [u64; 18] {
    let mut counts = [0; 18];
    for sample in span.stored(bytes).chunks_exact(span.encoding.width()) {
        let magnitude = match *sample {
            [a, b] => u32::from(u16::from_le_bytes([a, b])),
            [a, b, c, d] => {
                let [re, im] = [[a, b], [c, d]].map(|part| f32::from(i16::from_le_bytes(part)));
                re.hypot(im) as u32
            }
            _ => 0,
        };
        counts[(u32::BITS - magnitude.leading_zeros()) as usize] += 1;
    }
    counts
}

/// Returns true if a weighting factor is plausible.
pub(super) fn is_weight(weight: i16) -> bool {
    weight.unsigned_abs() <= HEAVIEST
}

/// Returns the step of a scale on which `shift` low bits are dropped, or added where it is
/// negative.
fn step_of_shift(shift: i32) -> u32 {
    let exponent = LEVEL_BITS as i32 - shift;
    u32::try_from(exponent.min(31)).map_or(0, |exponent| 1 << exponent)
}

fn step(encoding: Encoding) -> Option<u32> {
    match encoding {
        Encoding::ScaledU16 { step, .. } | Encoding::ScaledComplex { step } => Some(step),
        _ => None,
    }
}

fn set_step(encoding: &mut Encoding, to: u32) {
    match encoding {
        Encoding::ScaledU16 { step, .. } | Encoding::ScaledComplex { step } => *step = to,
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(subsystems: &[(u8, usize, f32)]) -> Option<u8> {
        let entry = |&(number, pings, frequency_khz): &(u8, usize, f32)| {
            let subsystem = Subsystem { pings, frequency_khz };
            (number, subsystem)
        };
        choose(&subsystems.iter().map(entry).collect())
    }

    #[test]
    fn the_higher_frequency_is_shown_unless_it_has_fewer_pings() {
        assert_eq!(of(&[]), None);
        assert_eq!(of(&[(20, 100, 120.0), (21, 99, 410.0)]), Some(21));
        assert_eq!(of(&[(20, 100, 120.0), (21, 50, 410.0)]), Some(20));
        assert_eq!(of(&[(20, 100, 0.0), (21, 100, 0.0)]), Some(21));
    }

    #[test]
    fn steps_are_powers_of_two() {
        assert!(is_weight(-40) && !is_weight(i16::MIN));
        assert_eq!(step_of_shift(0), 1 << LEVEL_BITS);
        assert_eq!(step_of_shift(4), 1 << (LEVEL_BITS - 4));
        assert_eq!(step_of_shift(-4), 1 << (LEVEL_BITS + 4));
        assert_eq!([step_of_shift(21), step_of_shift(-99)], [0, 1 << 31]);
    }
}
