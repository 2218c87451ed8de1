//! Reads EdgeTech JSF files, which the side-scan sonars of EdgeTech and their program Discover
//! record.
//!
//! In: the bytes of a recording. Out: a collected log.
//!
//! A file is a sequence of messages, all numbers little-endian. A message has a header of 16 bytes:
//! u16 marker 0x1601, u8 version of the protocol, u8 session, u16 type, u8 command, u8 subsystem,
//! u8 channel, u8 sequence, u16 reserved, i32 bytes that follow. Subsystems 20, 21 and 22 are
//! side-scan of low, high and very high frequency, 70 to 72 the same with more pulses in the water,
//! 0 a sub-bottom profiler, 40 to 42 bathymetry. Channel 0 is port and 1 starboard; both are stored
//! from near to far.
//!
//! Message 80 is a ping of one channel, a trace: 240 bytes (`trace`), then samples of 16 bits.
//! Format 0 is the envelope, one u16 a sample; format 1 the analytic signal, a real and an
//! imaginary i16 a sample. Other formats were recorded before the matched filter, or are not
//! published by EdgeTech, and are not read. A sample counts 2^-w volts, with the weighting factor w
//! of its ping. Message 82 is an older trace with 80 bytes before the same samples. Of the other
//! messages, 182 names the sonar, 2002 is a NMEA sentence, 2060 a pressure sensor, 2080 a Doppler
//! log; the last two give the speed of sound where traces do not state it. The beams of a Doppler
//! log are not used as soundings: whether their ranges are slant or vertical is not stated.
//!
//! Sources: the fields of EdgeTech's "JSF Data File Description" (0023492), as the public readers
//! `sidescantools`, `PINGVerter` 2.1.7 and MB-System (`mbsys_jstar.h`) cite it. Difference from
//! these readers: the fractions that later protocols add to the sample interval (less than 1 ns)
//! and to course and speed are left out. No real file was at hand: the reader is checked with
//! generated files, from which PINGVerter reads the same.

mod pair;
#[cfg(test)]
mod tests;
mod trace;

use super::clock::{Clock, ClockVerdict, unix_s};
use super::collected::{Collected, Counted, HalfPing, WarningKind, is_sound};
use super::log_format::{FileSource, LogFormat, ReadRecording, Reading};
use super::nmea::{self, Sentence};
use super::scalar::Fields;
use super::{OpenError, Opened, assemble};
use crate::support::progress::Progress;
use crate::survey::{ChannelKind, Fix, ProjectedTrack, RangeSource, SideSpan, Survey};
use pair::{Half, Pairs};
use std::collections::BTreeMap;
use std::ops::Range;
use trace::{FORMAT, HEADER, MessageHeader, SOUNDS_MPS, Trace};

const NAME: &str = "EdgeTech JSF";
/// Bytes searched for messages where the beginning of a file is damaged.
const SEARCHED_FOR_MESSAGES: usize = 1 << 20;
/// Highest plausible version of the protocol: 0x12 is the newest that is described.
const NEWEST_VERSION: u8 = 0x40;
/// Speed of sound that is assumed where the file states none, metres a second.
const SOUND_MPS: f64 = 1500.0;
/// Most channels that are listed: no sonar has more, but damaged headers may name more.
const MOST_CHANNELS: usize = 64;
/// Types of messages that are read.
const SYSTEM: u16 = 182;
const NMEA: u16 = 2002;
const PRESSURE: u16 = 2060;
const DOPPLER: u16 = 2080;
/// Longest time of a sentence before or after all traces, seconds; sentences beyond have another
/// clock.
const NMEA_BESIDE_S: f64 = 60.0;
/// Bytes of a file for each position that is kept: a hostile file may consist of NMEA sentences
/// only.
const BYTES_A_SENTENCE: usize = 128;

/// Reader of the format.
pub(super) struct EdgeTech;

impl LogFormat for EdgeTech {
    fn recognise(&self, _files: &FileSource, opened: &Opened) -> Option<ReadRecording> {
        let first = sniff(&opened.bytes)?;
        let opened = opened.clone();
        Some(Box::new(move |reading, progress| read(&opened, first, reading, progress)))
    }
}

/// Recognises a file by its first message, or by two messages in a row where the first is damaged;
/// returns the offset of the first whole message.
fn sniff(bytes: &[u8]) -> Option<usize> {
    let first = MessageHeader::at(bytes, 0);
    if first.is_some_and(|header| header.version <= NEWEST_VERSION && header.kind != 0) {
        return Some(0);
    }
    FORMAT.next(bytes, 0, SEARCHED_FOR_MESSAGES)
}

/// Reads a file that [`sniff`] recognised.
///
/// # Errors
/// When the file contains no side-scan, or the user cancelled the reading.
fn read(
    opened: &Opened,
    first: usize,
    reading: &Reading<'_>,
    progress: &Progress,
) -> Result<Survey, OpenError> {
    let bytes = &opened.bytes;
    let mut log = Collected::new(&[opened], NAME, reading);
    let mut reader = Reader::new(bytes, reading);
    let tail = reading.from(0).filter(|_| reader.zero_ms.is_some());
    FORMAT.read(bytes, (0, tail), &mut log, (reading, progress), |log, message| {
        reader.take(log, message);
    })?;
    reader.finish(&mut log);
    let has_side_scan = log.channels.iter().any(|(_, channel)| channel.kind.side().is_some());
    if !has_side_scan && reader.sensors.total() > 0 {
        return Err(opened.unsupported(format!(
            "this JSF file is whole, but there is no side-scan in it, only {}; open the file that the side-scan was recorded into",
            reader.sensors.summary()
        )));
    }
    if !has_side_scan {
        let what = format!(
            "no side-scan ping in its {} bytes from byte {first} on; copy the file again",
            bytes.len()
        );
        return Err(opened.broken(NAME, what));
    }
    Ok(assemble::assemble(log, reading))
}

/// Decodes messages and collects sides, altitudes and fixes.
#[derive(Default)]
struct Reader<'a> {
    bytes: &'a [u8],
    known: Option<&'a Survey>,
    clock: Clock<(Trace, usize)>,
    /// Unix milliseconds of the log's time zero; only if it is known, a tail can be read without
    /// the rest.
    zero_ms: Option<i64>,
    /// First position in metres of a projection; `None` until there is one.
    origin_m: Option<[f64; 2]>,
    pairs: Pairs,
    /// Content of the messages that are no traces.
    sensors: Sensors,
    last_depth_s: Option<f64>,
    assumed_sound: usize,
    unread: BTreeMap<u16, usize>,
    continued: usize,
}

impl<'a> Reader<'a> {
    /// Creates a reader of this file; for the tail of a log, with the time zero and choices of the
    /// log before.
    fn new(bytes: &'a [u8], reading: &Reading<'a>) -> Self {
        let known = reading.known().filter(|_| reading.from(0).is_some());
        let mut pings = known.into_iter().flat_map(|known| known.side_scan.iter().rev());
        let last = pings.find_map(|ping| Some((ping.time_s, ping.port.or(ping.starboard)?)));
        let zero_ms = last.and_then(|(time_s, span)| {
            let unix_ms = Trace::of_span(bytes, &span)?.unix_ms;
            Some(unix_ms - (time_s * 1000.0).round() as i64)
        });
        // Where the last ping does not give the time zero, the file is read again from the
        // beginning.
        let known = known.filter(|_| zero_ms.is_some());
        let span = last.filter(|_| zero_ms.is_some()).map(|(_, span)| span);
        let projected = known.and_then(|known| known.track.projected.as_ref());
        Self {
            bytes,
            known,
            zero_ms,
            origin_m: projected.map(|projected| projected.origin_m),
            pairs: known.map_or_else(Pairs::default, |known| Pairs::like(bytes, known)),
            sensors: Sensors {
                sound_mps: span.and_then(|span| sound_of(bytes, &span)),
                most_sentences: bytes.len() / BYTES_A_SENTENCE,
                ..Sensors::default()
            },
            ..Self::default()
        }
    }

    /// Decodes the next message of the file.
    fn take(&mut self, log: &mut Collected, message: Range<usize>) {
        if let Some(trace) = Trace::of(self.bytes, message.clone()) {
            let time_s = trace.unix_ms as f64 / 1000.0;
            if let Some(verdict) = self.clock.push(time_s, (trace, message.start)) {
                self.settle(log, verdict);
            }
            return;
        }
        let header = MessageHeader::at(self.bytes, message.start);
        let body = self.bytes.get(message.start + HEADER..message.end);
        if let (Some(header), Some(body)) = (header, body) {
            self.sensors.take(header.kind, body);
        }
    }

    /// Processes the traces that still wait for a verdict of the clock, adds the results to the log
    /// and warns about what was left out.
    fn finish(&mut self, log: &mut Collected) {
        while let Some(verdict) = self.clock.next() {
            self.settle(log, verdict);
        }
        std::mem::take(&mut self.pairs).finish(self.bytes, log);
        log.start_unix_s = self.zero_ms.and_then(unix_s);
        log.range_source = RangeSource::SurveyRecorder;
        log.source.device = match self.known {
            Some(known) => known.source.device.clone(),
            None => self.sensors.device.clone().unwrap_or_default(),
        };
        if log.fixes.is_empty() {
            self.sensors.add_fixes(log, self.zero_ms.unwrap_or(0) as f64 / 1000.0);
        }
        log.projected = self.origin_m.map(ProjectedTrack::new);
        log.report.set_back(self.clock.set_back_s);
        self.remark(log);
    }

    fn remark(&self, log: &Collected) {
        if self.assumed_sound > 0 {
            log.report.log(format!(
                "{} pings state no speed of sound; their ranges are for {SOUND_MPS} m/s",
                self.assumed_sound
            ));
        }
        for (format, pings) in &self.unread {
            log.report.log(format!(
                "{pings} pings hold samples of format {format}, which is not read; record the envelope (0) or the analytic signal (1)"
            ));
        }
        if self.continued > 0 {
            log.report.log(format!(
                "{} traces continue a ping beyond its first packet and were left out",
                self.continued
            ));
        }
        let others = self.sensors.total();
        if others > 0 {
            log.report.log(format!("{others} messages that are no pings were skipped"));
        }
    }

    fn settle(&mut self, log: &mut Collected, verdict: ClockVerdict<(Trace, usize)>) {
        match verdict {
            ClockVerdict::Sound { record: (trace, at), time_s } => {
                self.keep(log, &trace, at, time_s)
            }
            ClockVerdict::Damaged((_, at)) => log.report.odd_time(0, at, "a trace's time"),
        }
    }

    fn keep(&mut self, log: &mut Collected, trace: &Trace, at: usize, unix_s: f64) {
        let now_ms = (unix_s * 1000.0).round() as i64;
        let time_s = (now_ms - *self.zero_ms.get_or_insert(now_ms)) as f64 / 1000.0;
        if self.last_depth_s != Some(time_s) && trace.altitude_m > 0.0 {
            self.last_depth_s = Some(time_s);
            log.add_depth(ChannelKind::Primary, time_s, trace.altitude_m);
        }
        let position = trace.place.and_then(|place| place.position(&mut self.origin_m));
        if let Some(position) = position {
            log.add_fix(Fix {
                time_s,
                position,
                cog_rad: trace.cog_rad,
                compass_rad: trace.heading_rad,
                speed_mps: trace.speed_mps,
            });
        }
        if trace.packet > 1 {
            self.continued += 1;
            return;
        }
        let sound_mps = trace.sound_mps.or(self.sensors.sound_mps);
        let [near_m, far_m] = trace.range_m(sound_mps.unwrap_or(SOUND_MPS));
        let kind = trace.kind();
        let number = trace.number();
        let counted = Counted {
            record: (0, trace.samples_at + trace.room),
            time_s,
            samples: trace.samples as usize,
            range_m: Some((near_m, far_m)),
        };
        let is_listed = log.channels.iter().any(|(known, _)| *known == number);
        if is_listed || log.channels.len() < MOST_CHANNELS {
            log.count(number, counted, || {
                let name = format!("{}, channel {}", pair::name(trace.subsystem), trace.channel);
                (kind, name, trace.frequency_khz)
            });
        }
        let Some(side) = kind.side() else { return };
        let Some(encoding) = trace.encoding() else {
            *self.unread.entry(trace.data_format).or_default() += 1;
            return;
        };
        let span = SideSpan {
            encoding,
            offset: trace.samples_at as u64,
            ..SideSpan::of_bytes(trace.samples, [near_m, far_m])
        };
        let needed = (trace.samples as usize).saturating_mul(encoding.width());
        if needed > trace.room || !is_sound(&span) || !pair::is_weight(trace.weight) {
            let text = format!(
                "a trace has {} samples in {} bytes from {near_m} m to {far_m} m with the weight {}, which is no picture; it was dropped",
                trace.samples, trace.room, trace.weight
            );
            log.report.at(WarningKind::Value, 0, at, text);
            return;
        }
        self.assumed_sound += usize::from(sound_mps.is_none());
        let half = Half {
            side,
            subsystem: trace.subsystem,
            weight: trace.weight,
            half: HalfPing { time_s, span },
        };
        self.pairs.keep(half, trace.frequency_khz);
    }
}

/// Returns the speed of sound that the range of a span was computed with; `None` if implausible.
fn sound_of(bytes: &[u8], span: &SideSpan) -> Option<f64> {
    let trace = Trace::of_span(bytes, span)?;
    let sound_mps = 2.0 * span.metres_per_sample() / trace.interval_s;
    SOUNDS_MPS.contains(&sound_mps).then_some(sound_mps)
}

/// Collects the content of messages other than traces.
#[derive(Debug, Default)]
struct Sensors {
    /// Last speed of sound that a sensor stated, metres a second.
    sound_mps: Option<f64>,
    /// Type of the sonar and number of the vehicle that carries it; `None` where the file names
    /// neither.
    device: Option<String>,
    /// Sentences with their times in Unix seconds.
    sentences: Vec<(f64, Sentence)>,
    /// Number of sentences that a recorder writes between its traces; no more are kept.
    most_sentences: usize,
    counts: BTreeMap<u16, usize>,
}

impl Sensors {
    /// Reads a message that is no trace.
    fn take(&mut self, kind: u16, body: &[u8]) {
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

    /// Returns the number of messages.
    fn total(&self) -> usize {
        self.counts.values().sum()
    }

    /// Returns the number of messages by type, as `40 messages of type 2002, 1 messages of type
    /// 182`.
    fn summary(&self) -> String {
        let mut counts: Vec<(u16, usize)> = self.counts.iter().map(|(&a, &b)| (a, b)).collect();
        counts.sort_by_key(|&(_, count)| std::cmp::Reverse(count));
        let each = counts.iter();
        let each = each.map(|(kind, count)| format!("{count} messages of type {kind}"));
        each.collect::<Vec<String>>().join(", ")
    }

    /// Adds the positions of the sentences, for logs whose traces have none. `zero_s` is the log's
    /// time zero in Unix seconds.
    fn add_fixes(&self, log: &mut Collected, zero_s: f64) {
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
