//! Determines properties of a whole log before any part of it is used: its law, its usable pings in
//! chunks, and their gain.

use super::echoes::{LogEchoes, PingPlace, is_weed};
use super::law::{Law, law_of};
use bathyscope_log::support::progress::{Cancelled, Progress};
use bathyscope_log::support::statistics::median_of;
use bathyscope_log::survey::Side;
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::ops::Range;

/// Largest number of pings in a chunk, and in a stretch with one gain.
const CHUNK_PINGS: usize = 3;
const STRETCH_PINGS: usize = 30;
/// Step of the logarithm of the sample length by which range settings are distinguished.
const SAME_RANGE: f64 = 0.02;
/// Longest pause within a chunk, seconds.
const LONGEST_PAUSE_S: f64 = 0.5;
/// Step between the samples that are compared with the usual levels at their range, and multiple of
/// the first return at which the comparison begins.
const STRIDE: usize = 4;
const FROM_FIRST_RETURN: f64 = 1.2;
/// Number of pings whose median is the gain.
const GAIN_PINGS: usize = 7;
/// Change of the gain over six pings that counts as a step, natural logarithm of power; and number
/// of pings before and after the step that are left out.
const GAIN_STEP: f64 = 1.0;
const BESIDE_STEP: usize = 6;
/// Share of the samples of a ping, and excess over the usual levels, natural logarithm of power: a
/// ping with a larger share above this excess shows another sonar.
const INTERFERENCE: (f64, f32) = (0.02, 3.0);

/// Pings in a row that are averaged.
#[derive(Clone, Debug, PartialEq)]
pub struct PingChunk {
    /// Number of the chunk in its log.
    pub number: u32,
    /// Range of the pings of the chunk, all of them usable.
    pub pings: Range<usize>,
    /// Number of the recorder's range setting: the logarithm of the length of a sample in steps of
    /// [`SAME_RANGE`], so that rounding by the recorder does not change it.
    pub range_setting: i32,
    /// Number of the stretch of the log; a stretch has one gain. Neighbouring stretches without a
    /// step of the gain between them have consecutive numbers.
    pub stretch: u32,
    /// Gain: natural logarithm of power over the usual power.
    pub gain: f64,
}

impl PingChunk {
    /// Returns the chunks with up to `together` of them joined into one where they follow each
    /// other.
    pub(crate) fn joined(chunks: &[Self], together: usize) -> Vec<Self> {
        let mut joined: Vec<Self> = Vec::with_capacity(chunks.len() / together + 1);
        for chunk in chunks {
            match joined.last_mut() {
                Some(last)
                    if chunk.number / together as u32 == last.number / together as u32
                        && (chunk.pings.start, chunk.range_setting, chunk.stretch)
                            == (last.pings.end, last.range_setting, last.stretch) =>
                {
                    last.pings.end = chunk.pings.end;
                }
                _ => joined.push(chunk.clone()),
            }
        }
        joined
    }
}

/// Log whose echoes can be used: the whole log or a part of it.
#[derive(Clone)]
pub struct LaidOutLog<'a> {
    /// Echoes of the log.
    pub echoes: LogEchoes<'a>,
    /// Chunks of usable pings, in order.
    pub chunks: Vec<PingChunk>,
    /// Law of its levels; `None` where too few levels determine it.
    pub law: Option<Law>,
    /// True for each ping in a stretch of weed.
    pub is_weed: Vec<bool>,
}

impl<'a> LaidOutLog<'a> {
    /// Creates the layout of a whole log.
    ///
    /// # Errors
    /// When the work was cancelled.
    pub fn new(echoes: LogEchoes<'a>, progress: &Progress) -> Result<Self, Cancelled> {
        let law = law_of(&echoes, progress)?;
        let is_weed = is_weed(&echoes);
        let chunks = match law {
            Some(law) => {
                let gains = Gains::of(&echoes, &law, progress)?;
                chunks(&echoes.pings, &gains, &is_weed)
            }
            None => Vec::new(),
        };
        Ok(Self { echoes, chunks, law, is_weed })
    }
}

/// Gain of every ping, number of the segment between steps of the gain, and true for usable pings.
struct Gains {
    gain: Vec<f64>,
    segment: Vec<u32>,
    is_usable: Vec<bool>,
}

/// Median logarithm of power at every `STRIDE`th sample, by range setting.
type UsualLevels = BTreeMap<i32, Vec<f32>>;

impl Gains {
    fn of(log: &LogEchoes<'_>, law: &Law, progress: &Progress) -> Result<Self, Cancelled> {
        let ln_power = law.table();
        let usual = usual_levels(log, &ln_power, progress)?;
        let compare = |(ping, place): (usize, &PingPlace)| {
            let usual = usual.get(&range_setting(place)).map_or(&[][..], Vec::as_slice);
            compared(log, ping, &ln_power, usual)
        };
        let each: Vec<(f64, bool)> = log.pings.par_iter().enumerate().map(compare).collect();
        progress.check()?;
        let raw: Vec<f64> = each.iter().map(|(gain, _)| *gain).collect();
        let around = |ping: usize| {
            let from = ping.saturating_sub(GAIN_PINGS / 2);
            usual_gain(&raw[from..(ping + GAIN_PINGS / 2 + 1).min(raw.len())])
        };
        let smooth: Vec<f64> = (0..raw.len()).map(around).collect();
        let mut is_usable: Vec<bool> = each
            .iter()
            .zip(&smooth)
            .map(|((_, is_disturbed), gain)| !is_disturbed && gain.is_finite())
            .collect();
        let mut segment = vec![0_u32; raw.len()];
        for step in steps(&smooth) {
            segment[step..].iter_mut().for_each(|segment| *segment += 1);
            let beside = step.saturating_sub(BESIDE_STEP)..(step + BESIDE_STEP + 1).min(raw.len());
            is_usable[beside].fill(false);
        }
        let mut gain = Vec::with_capacity(raw.len());
        for same in segment.chunk_by(|a, b| a == b) {
            let here = gain.len()..gain.len() + same.len();
            let of_segment = usual_gain(&smooth[here]);
            gain.extend(same.iter().map(|_| of_segment));
        }
        Ok(Self { gain, segment, is_usable })
    }
}

/// Returns the median of the known gains; NaN without any.
fn usual_gain(gains: &[f64]) -> f64 {
    median_of(gains.iter().copied().filter(|gain| gain.is_finite()))
}

/// Returns the pings at which the gain steps: in each run over which it changes by more than
/// [`GAIN_STEP`], the ping with the steepest change.
fn steps(gain: &[f64]) -> Vec<usize> {
    let change = |ping: usize| match (ping.checked_sub(3), gain.get(ping + 3)) {
        (Some(before), Some(behind)) => (behind - gain[before]).abs(),
        _ => 0.0,
    };
    let mut found = Vec::new();
    let mut ping = 0;
    while ping < gain.len() {
        if change(ping) > GAIN_STEP {
            let end = (ping..gain.len())
                .find(|at| change(*at).is_nan() || change(*at) <= GAIN_STEP)
                .unwrap_or(gain.len());
            found.extend((ping..end).max_by(|a, b| change(*a).total_cmp(&change(*b))));
            ping = end;
        }
        ping += 1;
    }
    found
}

/// Returns the median logarithm of power at every `STRIDE`th sample, by range setting; NaN where
/// there is no echo of the bed.
fn usual_levels(
    log: &LogEchoes<'_>,
    ln_power: &[f32; 256],
    progress: &Progress,
) -> Result<UsualLevels, Cancelled> {
    let mut counts: BTreeMap<i32, Vec<[u32; 256]>> = BTreeMap::new();
    let mut levels = Vec::new();
    for (ping, place) in log.pings.iter().enumerate() {
        if ping % 1024 == 0 {
            progress.check()?;
        }
        let of_setting = counts.entry(range_setting(place)).or_default();
        for side in Side::BOTH {
            for at in on_bed(log, ping, side, &mut levels) {
                let place = at / STRIDE;
                if place >= of_setting.len() {
                    of_setting.resize(place + 1, [0; 256]);
                }
                of_setting[place][usize::from(levels[at])] += 1;
            }
        }
    }
    let middle = |counts: &[u32; 256]| {
        let all: u32 = counts.iter().sum();
        let mut below = 0;
        let level = counts.iter().position(|count| {
            below += count;
            2 * below > all
        });
        level.map_or(f32::NAN, |level| ln_power[level])
    };
    let of_setting =
        |(setting, counts): (i32, Vec<[u32; 256]>)| (setting, counts.iter().map(middle).collect());
    Ok(counts.into_iter().map(of_setting).collect())
}

/// Reads a side of a ping, and returns the indices of the samples beyond its first return, in steps
/// of [`STRIDE`].
fn on_bed(
    log: &LogEchoes<'_>,
    ping: usize,
    side: Side,
    levels: &mut Vec<u8>,
) -> impl Iterator<Item = usize> + use<> {
    let first_return = log.pings[ping].side(side).first_return;
    let count =
        if first_return.is_finite() && log.read(ping, side, levels) { levels.len() } else { 0 };
    let from = (FROM_FIRST_RETURN * first_return.max(0.0)) as usize;
    (from.next_multiple_of(STRIDE)..count).step_by(STRIDE)
}

/// Returns the median excess of a ping's levels over the usual ones, NaN without any, and true if
/// another sonar shows in the ping.
fn compared(log: &LogEchoes<'_>, ping: usize, ln_power: &[f32; 256], usual: &[f32]) -> (f64, bool) {
    let mut over: Vec<f32> = Vec::new();
    let mut levels = Vec::new();
    for side in Side::BOTH {
        let places = on_bed(log, ping, side, &mut levels);
        let of_place =
            |at: usize| Some(ln_power[usize::from(levels[at])] - usual.get(at / STRIDE)?);
        over.extend(places.filter_map(of_place).filter(|over| over.is_finite()));
    }
    let Some(middle) = over.len().checked_sub(1).map(|last| last / 2) else {
        return (f64::NAN, false);
    };
    let gain = *over.select_nth_unstable_by(middle, f32::total_cmp).1;
    let (share, limit) = INTERFERENCE;
    let high = over.iter().filter(|over| **over - gain.max(0.0) > limit).count();
    (f64::from(gain), high as f64 > share * over.len() as f64)
}

fn chunks(pings: &[PingPlace], gains: &Gains, is_weed: &[bool]) -> Vec<PingChunk> {
    let mut found: Vec<PingChunk> = Vec::new();
    let mut number = 0;
    for (ping, place) in pings.iter().enumerate() {
        if !(gains.is_usable[ping] && place.is_placed() && !is_weed[ping]) {
            continue;
        }
        let setting = range_setting(place);
        // Neither number ever falls, so their sum changes when one of them does; a step of the gain
        // leaves a number out.
        let stretch = 2 * gains.segment[ping] + (ping / STRETCH_PINGS) as u32;
        let goes_on = |chunk: &PingChunk| {
            chunk.pings.end == ping
                && chunk.pings.len() < CHUNK_PINGS
                && (chunk.range_setting, chunk.stretch) == (setting, stretch)
                && place.time_s - pings[ping - 1].time_s <= LONGEST_PAUSE_S
        };
        match found.last_mut() {
            Some(chunk) if goes_on(chunk) => chunk.pings.end += 1,
            _ => {
                // Unusable pings separate chunks, whose numbers are then not consecutive.
                number = (ping / CHUNK_PINGS).max(number + 1);
                found.push(PingChunk {
                    number: number as u32,
                    pings: ping..ping + 1,
                    range_setting: setting,
                    stretch,
                    gain: gains.gain[ping],
                });
            }
        }
    }
    found
}

fn range_setting(ping: &PingPlace) -> i32 {
    let step_m = ping.sides.map(|side| side.step_m);
    let known = step_m.into_iter().find(|step_m| *step_m > 0.0);
    known.map_or(i32::MIN, |step_m| (step_m.ln() / SAME_RANGE).round() as i32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::swath::SideEchoes;

    fn ping(time_s: f64, step_m: f64) -> PingPlace {
        let side = SideEchoes { near_m: 0.0, step_m, first_return: f64::NAN, above_bottom: false };
        PingPlace {
            time_s,
            place_m: [0.0; 2],
            starboard: [1.0, 0.0],
            transducer_m: 0.0,
            sides: [side; 2],
        }
    }

    #[test]
    fn chunks_end_at_pauses_where_the_range_changes_and_where_the_gain_steps() {
        let mut pings: Vec<PingPlace> = (0..6).map(|at| ping(0.1 * f64::from(at), 0.01)).collect();
        pings.push(ping(0.6, 0.02));
        pings.push(ping(0.7, 0.02001));
        pings.push(ping(2.0, 0.02));
        pings.push(ping(2.1, 0.02));
        let gains = Gains {
            gain: vec![0.0; 10],
            segment: vec![0, 0, 0, 0, 0, 0, 0, 0, 0, 1],
            is_usable: vec![true, true, true, true, false, true, true, true, true, true],
        };
        let found = chunks(&pings, &gains, &[false; 10]);
        let spans: Vec<Range<usize>> = found.iter().map(|chunk| chunk.pings.clone()).collect();
        assert_eq!(spans, [0..3, 3..4, 5..6, 6..8, 8..9, 9..10]);
        assert_ne!(found[2].range_setting, found[3].range_setting);
        assert_eq!(found[3].range_setting, found[4].range_setting);
        assert!(found.is_sorted_by_key(|chunk| chunk.number));
    }

    #[test]
    fn a_gain_steps_where_it_changes_fastest() {
        let gain: Vec<f64> =
            (0..40).map(|ping| if (12..25).contains(&ping) { -1.9 } else { 0.1 }).collect();
        assert_eq!(steps(&gain).len(), 2);
        assert!(steps(&gain)[0].abs_diff(12) <= 3 && steps(&gain)[1].abs_diff(25) <= 3);
        assert!(steps(&[0.0; 30]).is_empty());
    }
}
