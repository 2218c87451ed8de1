//! What is found of a whole log before any part of it is used: its chunks of pings, how its levels count, and where it ran over weed.

use super::echoes::{LogEchoes, PingPlace};
use super::level_scale::level_scale;
use super::weed::is_weed;
use crate::progress::{Cancelled, Progress};
use std::ops::Range;

/// Pings of a chunk.
const CHUNK_PINGS: usize = 4;
/// Ranges that differ by less than this share count as one setting of the recorder.
const SAME_RANGE: f64 = 0.02;
/// A longer pause parts chunks, seconds.
const LONGEST_PAUSE_S: f64 = 0.5;

/// Pings in a row that pieces are made of.
#[derive(Clone, Debug, PartialEq)]
pub struct Chunk {
    /// Which chunk of its log.
    pub number: u32,
    /// Its pings.
    pub pings: Range<usize>,
    /// Which range setting of the recorder: the length of a sample in steps of [`SAME_RANGE`], the same whatever the recorder rounds.
    pub range_setting: i32,
}

/// A chunk among those of all logs, in the order of the logs and of time.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct ChunkId {
    /// The place of its log among all.
    pub log: u32,
    /// Which chunk of its log.
    pub number: u32,
}

impl ChunkId {
    /// The chunk so many later in its log, or earlier; `None` before the first.
    pub fn later(self, by: i32) -> Option<Self> {
        let number = self.number.checked_add_signed(by)?;
        Some(Self { number, ..self })
    }
}

/// A log whose echoes can be used, all of it or a part.
#[derive(Clone)]
pub struct LaidOutLog<'a> {
    /// Its echoes.
    pub echoes: LogEchoes<'a>,
    /// Its chunks, in order.
    pub chunks: Vec<Chunk>,
    /// Natural logarithm of power for a step of its levels; `None` where they are none of decibels.
    pub ln_per_level: Option<f64>,
    /// Whether each ping is in a stretch of weed.
    pub is_weed: Vec<bool>,
}

impl<'a> LaidOutLog<'a> {
    /// Of a whole log.
    ///
    /// # Errors
    /// When the work was cancelled.
    pub fn new(echoes: LogEchoes<'a>, progress: &Progress) -> Result<Self, Cancelled> {
        Ok(Self {
            chunks: chunks(&echoes.pings),
            ln_per_level: level_scale(&echoes, progress)?,
            is_weed: is_weed(&echoes),
            echoes,
        })
    }
}

fn chunks(pings: &[PingPlace]) -> Vec<Chunk> {
    let mut found: Vec<Chunk> = Vec::new();
    let mut last: Option<(f64, i32)> = None;
    for (ping, place) in pings.iter().enumerate() {
        let setting = range_setting(place);
        let goes_on = last.is_some_and(|(time_s, before)| {
            before == setting && place.time_s - time_s <= LONGEST_PAUSE_S
        });
        last = Some((place.time_s, setting));
        match found.last_mut() {
            Some(chunk) if goes_on && chunk.pings.len() < CHUNK_PINGS => chunk.pings.end += 1,
            _ => found.push(Chunk {
                number: found.len() as u32,
                pings: ping..ping + 1,
                range_setting: setting,
            }),
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
        let side = SideEchoes {
            near_m: 0.0,
            step_m,
            first_return: f64::NAN,
            above_bottom: false,
        };
        PingPlace {
            time_s,
            place_m: [0.0; 2],
            starboard: [1.0, 0.0],
            transducer_m: 0.0,
            sides: [side; 2],
        }
    }

    #[test]
    fn chunks_end_at_pauses_and_where_the_range_changes() {
        let mut pings: Vec<PingPlace> = (0..6).map(|at| ping(0.1 * f64::from(at), 0.01)).collect();
        pings.push(ping(0.6, 0.02));
        pings.push(ping(0.7, 0.02001));
        pings.push(ping(2.0, 0.02));
        let found = chunks(&pings);
        let spans: Vec<Range<usize>> = found.iter().map(|chunk| chunk.pings.clone()).collect();
        assert_eq!(spans, [0..4, 4..6, 6..8, 8..9]);
        assert_ne!(found[1].range_setting, found[2].range_setting);
        assert_eq!(found[2].range_setting, found[3].range_setting);
        assert_eq!(found[3].number, 3);
    }
}
