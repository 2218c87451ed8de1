//! Decodes messages of a JSF file to sides, altitudes and fixes in SI units: traces, and the
//! messages with the speed of sound, the sonar's name and positions.

use super::pair::{self, Half, Pairs};
use super::trace::{HEADER, MessageHeader, SOUNDS_MPS, Trace};
use crate::formats::clock::{Clock, ClockVerdict, unix_s};
use crate::formats::collected::{Collected, Counted, HalfPing, WarningKind, is_sound};
use crate::formats::log_format::Reading;
use crate::formats::nmea::{self, Sentence};
use crate::formats::scalar::Fields;
use crate::survey::{ChannelKind, Fix, ProjectedTrack, RangeSource, SideSpan, Survey};
use std::collections::BTreeMap;
use std::ops::Range;

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

/// Decodes messages and collects sides, altitudes and fixes.
#[derive(Default)]
pub(super) struct Reader<'a> {
    bytes: &'a [u8],
    known: Option<&'a Survey>,
    clock: Clock<(Trace, usize)>,
    /// Unix milliseconds of the log's time zero; only if it is known, a tail can be read without
    /// the rest.
    pub(super) zero_ms: Option<i64>,
    /// First position in metres of a projection; `None` until there is one.
    origin_m: Option<[f64; 2]>,
    pairs: Pairs,
    /// Content of the messages that are no traces.
    pub(super) sensors: Sensors,
    last_depth_s: Option<f64>,
    assumed_sound: usize,
    unread: BTreeMap<u16, usize>,
    continued: usize,
}

impl<'a> Reader<'a> {
    /// Creates a reader of this file; for the tail of a log, with the time zero and choices of the
    /// log before.
    pub(super) fn new(bytes: &'a [u8], reading: &Reading<'a>) -> Self {
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
    pub(super) fn take(&mut self, log: &mut Collected, message: Range<usize>) {
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
    pub(super) fn finish(&mut self, log: &mut Collected) {
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
pub(super) struct Sensors {
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
