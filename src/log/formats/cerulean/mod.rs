//! Reads Cerulean svlog files, which SonarView records from Omniscan 450 side-scan sonars, as on
//! boats of Blue Robotics.
//!
//! In: the bytes of a recording. Out: a collected log.
//!
//! A file is a sequence of packets of the Ping protocol, all numbers little-endian: `BR`, u16 bytes
//! of the payload, u16 packet id, u8 source device, u8 destination device, the payload, u16 sum of
//! all bytes before. Packet 2198 is a profile, the ping of one transducer; `packet` reads packets,
//! profiles and positions. A profile has 52 bytes, then u16 samples from near to far, scaled
//! between the lowest and the highest decibels of that ping. Packet 10 is a description of the
//! session in JSON with the time when recording began, 109 a NMEA sentence, 150 a MAVLink message
//! in JSON, of which `GLOBAL_POSITION_INT` has a position. No packet has the depth.
//!
//! The sign of the transducer's heading gives the side: negative is port. Where the heading is 0,
//! the channel number of a profile gives the side, 0 for port and 1 for starboard. Boats with one
//! transducer, or with two transducers on separate computers, use the number 0 for all channels; a
//! heading that contradicts the number is therefore preferred, with a warning. The milliseconds of
//! both transducers are assumed to start at the same moment, as in BlueBoat-SideScanSonar; a
//! warning states where this cannot be true. Packets of one transducer may come in a row before
//! those of the other, so that each channel is in time order but the file is not. NMEA and MAVLink
//! have clocks of their own; `packet` gives their positions the times of the profiles around
//! them. The time when recording began is assigned to the first profile after the session packet,
//! to about a second.
//!
//! Sources: the Ping protocol's definitions (`omniscan450.json`, `common.json` of
//! bluerobotics/ping-protocol), Cerulean's description of its packets and of the Omniscan 450's
//! interface, and the readers PINGVerter 2.1.7, GeoHammer and BlueBoat-SideScanSonar; the order of
//! packets, the sides and the clocks are as BlueBoat-SideScanSonar measured them on 18 real logs.
//! Differences from PINGVerter: the range ends at start plus length, as the protocol states, and
//! the clock of the sonar may differ from the clock of the computer. No real file was at hand: the
//! reader is checked with generated files, from which PINGVerter reads the same.

mod packet;
#[cfg(test)]
mod tests;

use super::clock::{Clock, ClockVerdict};
use super::collected::{Collected, Counted, HalfPing, WarningKind, is_sound};
use super::log_format::{FileSource, LogFormat, ReadRecording, Reading};
use super::{OpenError, Opened, assemble};
use crate::support::calendar::unix_from_iso;
use crate::support::progress::Progress;
use crate::support::statistics::upper_median;
use crate::survey::{Encoding, LEVEL_BITS, RangeSource, Side, SidePing, SideSpan, Survey};
use packet::{FORMAT, Navigation, Packet, Profile, ReceivedPosition};
use std::collections::BTreeMap;

const NAME: &str = "Cerulean svlog";
/// Bytes searched for packets where the beginning of a file is damaged.
const SEARCHED_FOR_PACKETS: usize = 1 << 20;
/// Most markers that are tried as the start of a packet before a file counts as another format.
const MOST_TRIES: usize = 16;
/// Id of the packet that describes a session.
const SESSION: u16 = 10;
/// Longest time between profiles that are next to each other in a file, seconds: in real logs,
/// packets of one side wait for 3 s at most.
const MOST_APART_S: f64 = 10.0;
/// Bytes of a file for each position that is kept: a hostile file may consist of NMEA sentences
/// only.
const BYTES_A_POSITION: usize = 128;
/// About how many pings are used to find the scale.
const PINGS_LOOKED_AT: usize = 200;
/// Share of the samples that may be clipped at either end.
const CLIPPED_SHARE: f64 = 0.001;
/// Lowest decibels that are counted; the highest are its opposite.
const LEAST_DB: i32 = -400;
/// One level in the units of [`Encoding::ScaledU16`].
const LEVEL: f64 = (1_u32 << LEVEL_BITS) as f64;

/// Reader of the format.
pub(super) struct Cerulean;

impl LogFormat for Cerulean {
    fn recognise(&self, _files: &FileSource, opened: &Opened) -> Option<ReadRecording> {
        let opened = is_log(&opened.bytes).then(|| opened.clone())?;
        Some(Box::new(move |reading, progress| read(&opened, reading, progress)))
    }
}

/// Recognises a file by a packet whose checksum is right and that another packet follows.
fn is_log(bytes: &[u8]) -> bool {
    let next = |from: usize| FORMAT.next(bytes, from, SEARCHED_FOR_PACKETS);
    let mut starts = std::iter::successors(next(0), |at| next(at + 1)).take(MOST_TRIES);
    starts.any(|at| Packet::at(bytes, at).is_some_and(|packet| packet.is_sound()))
}

/// Reads a file that [`is_log`] recognised.
///
/// # Errors
/// When the file contains no profile, or the user cancelled the reading.
fn read(opened: &Opened, reading: &Reading<'_>, progress: &Progress) -> Result<Survey, OpenError> {
    let bytes = &opened.bytes;
    let mut log = Collected::new(&[opened], NAME, reading);
    log.source.device = "Omniscan 450".to_owned();
    let mut reader = Reader::new(bytes, reading);
    let tail = reading.from(0).filter(|_| reader.zero_ms.is_some());
    FORMAT.read(bytes, (0, tail), &mut log, (reading, progress), |log, packet| {
        reader.take(log, packet.start);
    })?;
    reader.finish(&mut log);
    if log.channels.is_empty() {
        return Err(opened.unsupported(format!(
            "this svlog holds no side-scan profile of an Omniscan 450 in its {} bytes, only {}; open the log that was recorded with one",
            bytes.len(),
            reader.summary()
        )));
    }
    Ok(assemble::assemble(log, reading))
}

/// A profile, its offset in the file, and the positions that were read after the profile before it.
type Record = (Profile, usize, Vec<ReceivedPosition>);

/// Decodes packets and collects sides and fixes.
#[derive(Default)]
struct Reader<'a> {
    bytes: &'a [u8],
    /// One clock for each side: packets of one side may come in a row before those of the other.
    clocks: [Clock<Record>; 2],
    /// Milliseconds of the sonar's clock at the log's time zero; only if it is known, a tail can be
    /// read without the rest.
    zero_ms: Option<f64>,
    scale: Option<Scale>,
    navigation: Navigation,
    /// Positions after the last profile.
    waiting: Vec<ReceivedPosition>,
    positions_left: usize,
    /// Unix seconds when recording began; `None` again after the first profile was timed with it.
    began_unix_s: Option<f64>,
    /// Time of the last profile of each side, and the times by which port was ahead of starboard,
    /// both in seconds.
    last_s: [Option<f64>; 2],
    port_ahead_s: Vec<f64>,
    start_unix_s: Option<f64>,
    halves: [Vec<(HalfPing, [f32; 2])>; 2],
    /// Number of packets that are no profiles, by id.
    others: BTreeMap<u16, usize>,
    /// Number of pings whose channel number contradicts the heading of the transducer.
    contradicted: usize,
}

impl<'a> Reader<'a> {
    /// Creates a reader of this file; for the tail of a log, with the time zero and the scale of
    /// the log before.
    fn new(bytes: &'a [u8], reading: &Reading<'_>) -> Self {
        let known = reading.known().filter(|_| reading.from(0).is_some());
        let pings = known.map_or(&[][..], |known| &known.side_scan);
        let zero_ms = pings.iter().rev().find_map(|ping| {
            let profile = Profile::of_span(bytes, &ping.port.or(ping.starboard)?)?;
            Some((f64::from(profile.time_ms) - ping.time_s * 1000.0).round())
        });
        Self {
            bytes,
            zero_ms,
            scale: Scale::of_log(bytes, pings),
            positions_left: bytes.len() / BYTES_A_POSITION,
            ..Self::default()
        }
    }

    /// Decodes the packet at an offset.
    fn take(&mut self, log: &mut Collected, at: usize) {
        let Some(packet) = Packet::at(self.bytes, at) else {
            return;
        };
        if !packet.is_sound() {
            let text = format!(
                "the sum of a packet's bytes is not what it says (id {}); it was dropped",
                packet.id
            );
            log.report.at(WarningKind::Frame, 0, at, text);
            return;
        }
        if let Some(profile) = Profile::of(&packet) {
            let record = (profile, at, std::mem::take(&mut self.waiting));
            let time_s = f64::from(profile.time_ms) / 1000.0;
            self.last_s[profile.side() as usize] = Some(time_s);
            if let [Some(port_s), Some(starboard_s)] = self.last_s {
                self.port_ahead_s.push(port_s - starboard_s);
            }
            if let Some(verdict) = self.clocks[profile.side() as usize].push(time_s, record) {
                self.settle(log, verdict);
            }
            return;
        }
        *self.others.entry(packet.id).or_default() += 1;
        let position = self.navigation.take(packet.id, packet.payload);
        let position = position.filter(|_| self.positions_left > 0);
        self.positions_left -= usize::from(position.is_some());
        self.waiting.extend(position);
        if packet.id == SESSION && self.began_unix_s.is_none() && self.start_unix_s.is_none() {
            self.began_unix_s = began_unix_s(packet.payload);
        }
    }

    /// Processes the profiles that still wait for a verdict of the clock, puts all samples on one
    /// scale and adds the results to the log.
    fn finish(&mut self, log: &mut Collected) {
        let mut set_back_s = 0.0_f64;
        for side in Side::BOTH {
            while let Some(verdict) = self.clocks[side as usize].next() {
                self.settle(log, verdict);
            }
            set_back_s = set_back_s.max(self.clocks[side as usize].set_back_s);
        }
        log.report.set_back(set_back_s);
        let ahead_s = upper_median(&mut self.port_ahead_s, f64::total_cmp);
        if let Some(ahead_s) = ahead_s.filter(|ahead_s| ahead_s.abs() > MOST_APART_S) {
            log.report.log(format!(
                "the clock of the port transducer is {ahead_s:.1} s ahead of the starboard one's: they were switched on one after the other, and the sides do not belong together in time"
            ));
        }
        log.start_unix_s = self.start_unix_s;
        log.range_source = RangeSource::SurveyRecorder;
        for fix in std::mem::take(&mut self.navigation).fixes() {
            log.add_fix(fix);
        }
        let halves = std::mem::take(&mut self.halves);
        let spans = halves.iter().flatten();
        let spans: Vec<_> = spans.map(|(half, power_db)| (half.span, *power_db)).collect();
        let scale = self.scale;
        let scale = scale.unwrap_or_else(|| Scale::fitting(self.bytes, &spans));
        let [port, starboard] = halves.map(|halves| {
            let each = halves.into_iter().map(|(mut half, power_db)| {
                half.span.encoding = scale.encoding(power_db);
                half
            });
            each.collect::<Vec<HalfPing>>()
        });
        log.port = port;
        log.starboard = starboard;
        if self.contradicted > 0 {
            log.report.log(format!(
                "the channel number of {} pings stands for the other side than that which their transducer's heading tells; the heading is believed: exchange the sides (mounting.swap_sides) if the picture is mirrored",
                self.contradicted
            ));
        }
        let others: usize = self.others.values().sum();
        if others > 0 {
            log.report.log(format!("{others} packets that are no pings were skipped"));
        }
    }

    /// Describes the packets that are no profiles, with their number by id.
    fn summary(&self) -> String {
        let mut counts: Vec<(u16, usize)> = self.others.iter().map(|(&a, &b)| (a, b)).collect();
        counts.sort_by_key(|&(_, count)| std::cmp::Reverse(count));
        let each = counts.iter().map(|(id, count)| format!("{count} packets with the id {id}"));
        if counts.is_empty() {
            "damaged packets".to_owned()
        } else {
            each.collect::<Vec<String>>().join(", ")
        }
    }

    fn settle(&mut self, log: &mut Collected, verdict: ClockVerdict<Record>) {
        match verdict {
            ClockVerdict::Sound { record: (profile, at, positions), time_s } => {
                let now_ms = (time_s * 1000.0).round();
                let time_s = (now_ms - *self.zero_ms.get_or_insert(now_ms)) / 1000.0;
                if let Some(began_unix_s) = self.began_unix_s.take() {
                    self.start_unix_s = Some(began_unix_s - time_s);
                }
                for position in positions {
                    self.navigation.place(position, time_s, profile.vehicle_deg);
                }
                self.keep(log, &profile, at, time_s);
            }
            ClockVerdict::Damaged((_, at, _)) => log.report.odd_time(0, at, "a profile's time"),
        }
    }

    fn keep(&mut self, log: &mut Collected, profile: &Profile, at: usize, time_s: f64) {
        let side = profile.side();
        self.contradicted += usize::from(profile.channel_side().is_some_and(|other| other != side));
        let number = side as u16;
        let [near_m, far_m] = profile.range_m;
        let counted = Counted {
            record: (0, profile.end),
            time_s,
            samples: profile.samples.into(),
            range_m: Some((near_m, far_m)),
        };
        log.count(number, counted, || {
            let name = format!("channel {} of device {}", profile.channel, profile.device);
            (side.into(), name, profile.frequency_khz)
        });
        let span = SideSpan {
            encoding: Encoding::ScaledU16 { base: 0, step: 0 },
            offset: profile.samples_at as u64,
            ..SideSpan::of_bytes(profile.samples.into(), [near_m, far_m])
        };
        if !(profile.has_samples && profile.has_power() && is_sound(&span)) {
            let [least_db, most_db] = profile.power_db;
            let text = format!(
                "a profile has {} samples from {near_m} m to {far_m} m between {least_db} and {most_db} dB, which is no picture; it was dropped",
                profile.samples
            );
            log.report.at(WarningKind::Value, 0, at, text);
            return;
        }
        let half = HalfPing { time_s, span };
        self.halves[side as usize].push((half, profile.power_db));
    }
}

/// Returns the Unix seconds of the timestamp in a session's description; `None` without a valid
/// timestamp.
fn began_unix_s(payload: &[u8]) -> Option<f64> {
    let end = payload.iter().rposition(|byte| *byte != 0)?;
    let session: serde_json::Value = serde_json::from_slice(&payload[..=end]).ok()?;
    unix_from_iso(session.get("timestamp")?.as_str()?)
}

/// Decibels of level 0 and of level 255. Both are whole numbers, so that they can be recovered from
/// the spans of a log.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Scale {
    low_db: i32,
    high_db: i32,
}

impl Scale {
    /// Returns a scale that contains nearly all samples of these spans; each span comes with the
    /// decibels of its sample values 0 and 65535.
    fn fitting(bytes: &[u8], spans: &[(SideSpan, [f32; 2])]) -> Self {
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
    fn of_log(bytes: &[u8], pings: &[SidePing]) -> Option<Self> {
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
    fn encoding(self, [least_db, most_db]: [f32; 2]) -> Encoding {
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
