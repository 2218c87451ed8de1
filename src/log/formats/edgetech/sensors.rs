//! Reads messages other than traces: the speed of sound, the sonar's name and positions.

use crate::formats::collected::Collected;
use crate::formats::nmea::{self, Sentence};
use crate::formats::scalar::Fields;
use crate::survey::Fix;
use std::collections::BTreeMap;

/// Types of messages that are read.
const SYSTEM: u16 = 182;
const NMEA: u16 = 2002;
const PRESSURE: u16 = 2060;
const DOPPLER: u16 = 2080;
/// Plausible speeds of sound in water, metres a second.
pub(super) const SOUNDS_MPS: std::ops::RangeInclusive<f64> = 1300.0..=1700.0;
/// Longest time of a sentence before or after all traces, seconds; sentences beyond have another
/// clock.
const NMEA_BESIDE_S: f64 = 60.0;

/// Bytes of a file for each position that is kept: a hostile file may consist of NMEA sentences
/// only.
const BYTES_A_SENTENCE: usize = 128;

/// Collects the content of messages other than traces.
#[derive(Debug)]
pub(super) struct Sensors {
    sound_mps: Option<f64>,
    device: Option<String>,
    /// Sentences with their times in Unix seconds.
    sentences: Vec<(f64, Sentence)>,
    most_sentences: usize,
    counts: BTreeMap<u16, usize>,
}

impl Sensors {
    /// Creates a collection without messages; `sound_mps` is the speed of sound before the tail of
    /// a log, metres a second. From a file of `byte_count` bytes no more sentences are kept than a
    /// recorder writes between its traces.
    pub(super) fn new(sound_mps: Option<f64>, byte_count: usize) -> Self {
        Self {
            sound_mps,
            device: None,
            sentences: Vec::new(),
            most_sentences: byte_count / BYTES_A_SENTENCE,
            counts: BTreeMap::new(),
        }
    }

    /// Reads a message that is no trace.
    pub(super) fn take(&mut self, kind: u16, body: &[u8]) {
        *self.counts.entry(kind).or_default() += 1;
        let fields = Fields(body);
        // Both messages have flags for valid fields.
        let sound_mps = match kind {
            PRESSURE if fields.u32(24) & 1 << 4 != 0 => f64::from(fields.i32(32)) / 1000.0,
            DOPPLER if fields.u32(12) & 1 << 12 != 0 => f64::from(fields.i16(56)),
            _ => f64::NAN,
        };
        if SOUNDS_MPS.contains(&sound_mps) {
            self.sound_mps = Some(sound_mps);
        }
        match kind {
            NMEA => {
                let unix_s = f64::from(fields.i32(0)) + f64::from(fields.i32(4)) / 1000.0;
                let sentence = body.get(12..).and_then(nmea::sentence);
                let sentence = sentence.filter(|sentence| {
                    sentence.position.is_some() && self.sentences.len() < self.most_sentences
                });
                self.sentences.extend(sentence.map(|sentence| (unix_s, sentence)));
            }
            SYSTEM if self.device.is_none() => {
                let [system, vehicle] = [fields.i32(0), fields.i32(20)];
                self.device = Some(format!("sonar of type {system}, vehicle {vehicle}"));
            }
            _ => {}
        }
    }

    /// Returns the last speed of sound that a sensor stated, metres a second.
    pub(super) fn sound_mps(&self) -> Option<f64> {
        self.sound_mps
    }

    /// Returns the type of the sonar and the number of the vehicle that carries it; empty where the
    /// file names neither.
    pub(super) fn device(&self) -> String {
        self.device.clone().unwrap_or_default()
    }

    /// Returns the number of messages.
    pub(super) fn total(&self) -> usize {
        self.counts.values().sum()
    }

    /// Returns the number of messages by type, as `40 messages of type 2002, 1 messages of type
    /// 182`.
    pub(super) fn summary(&self) -> String {
        let mut counts: Vec<(u16, usize)> = self.counts.iter().map(|(&a, &b)| (a, b)).collect();
        counts.sort_by_key(|&(_, count)| std::cmp::Reverse(count));
        let each = counts.iter();
        let each = each.map(|(kind, count)| format!("{count} messages of type {kind}"));
        each.collect::<Vec<String>>().join(", ")
    }

    /// Adds the positions of the sentences, for logs whose traces have none. `zero_s` is the log's
    /// time zero in Unix seconds.
    pub(super) fn add_fixes(&self, log: &mut Collected, zero_s: f64) {
        let channels = log.channels.iter();
        let spans = channels.filter_map(|(_, channel)| channel.time_span_s);
        let Some((from_s, to_s)) = spans.reduce(|(from, to), (a, b)| (from.min(a), to.max(b)))
        else {
            return;
        };
        for (unix_s, sentence) in &self.sentences {
            let time_s = unix_s - zero_s;
            let is_beside = (from_s - NMEA_BESIDE_S..=to_s + NMEA_BESIDE_S).contains(&time_s);
            if let Some(position) = sentence.position.filter(|_| is_beside) {
                log.add_fix(Fix {
                    time_s,
                    position,
                    cog_rad: sentence.cog_rad,
                    compass_rad: sentence.heading_rad,
                    speed_mps: sentence.speed_mps,
                });
            }
        }
        if !log.fixes.is_empty() {
            log.report.log("the traces hold no position; those of the NMEA sentences are used");
        }
    }
}
