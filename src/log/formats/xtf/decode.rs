//! Decodes XTF pings to sides, altitudes and fixes in SI units, and collects the side-scan channels
//! of a file in pairs; programs that record two frequencies have two channels of each side.

use super::channels::{self, XtfChannel};
use super::from_log::Provenance;
use super::levels::{self, Stated};
use super::positions::Positions;
use super::raw::{self, FileHeader, PingChannel, PingHeader, record};
use crate::formats::clock::{Clock, ClockVerdict, unix_s};
use crate::formats::collected::{
    Collected, CollectedPair, Counted, HalfPing, WarningKind, is_sound,
};
use crate::survey::{ChannelKind, Side, SidePing, SideSpan, Survey};
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::ops::Range;

/// Packet type of a side-scan ping.
const PING: u8 = 0;
/// Types of sonars whose samples count 2^-weight: those of EdgeTech, and Kongsberg's synthetic
/// aperture sonar.
const WEIGHTED: [u16; 4] = [24, 35, 38, 48];
/// Speed of sound that is assumed where the file states none, metres a second.
const SOUND_MPS: f32 = 1500.0;
/// Plausible speeds of sound in water, metres a second.
const SOUNDS_MPS: Range<f32> = 1300.0..1700.0;

/// Numbers of packets that are no side-scan pings, by type.
#[derive(Clone, Debug, Default)]
pub(super) struct Packets {
    counts: BTreeMap<u8, usize>,
}

impl Packets {
    /// Counts a packet.
    fn count(&mut self, kind: u8) {
        *self.counts.entry(kind).or_default() += 1;
    }

    /// Returns the number of all packets.
    pub(super) fn total(&self) -> usize {
        self.counts.values().sum()
    }

    /// Describes the packets, most first: `120 bathymetry (type 2) and 30 attitude (type 3)
    /// packets`.
    pub(super) fn summary(&self) -> String {
        let mut counts: Vec<(u8, usize)> =
            self.counts.iter().map(|(&kind, &count)| (kind, count)).collect();
        counts.sort_by_key(|&(_, count)| std::cmp::Reverse(count));
        let each = counts.iter().map(|&(kind, count)| match name(kind) {
            Some(name) => format!("{count} {name} (type {kind})"),
            None => format!("{count} of type {kind}"),
        });
        let mut each: Vec<String> = each.collect();
        let last = each.pop().unwrap_or_default();
        if each.is_empty() {
            format!("{last} packets")
        } else {
            format!("{} and {last} packets", each.join(", "))
        }
    }
}

/// Decodes packets and collects sides, altitudes and fixes.
#[derive(Default)]
pub(super) struct Reader<'a> {
    bytes: &'a [u8],
    channels: Vec<XtfChannel>,
    positions: Positions,
    sides: SideChannels,
    clock: Clock<(usize, PingHeader)>,
    /// Unix milliseconds of the first sound ping, which is the log's time zero.
    zero_ms: Option<i64>,
    /// Packets that are no side-scan pings.
    pub(super) others: Packets,
    provenance: Provenance,
    /// Packets among `others` that are not read at all.
    skipped: Packets,
    /// Number of channels of pings whose range was computed with [`SOUND_MPS`].
    assumed_sound: usize,
}

impl<'a> Reader<'a> {
    /// Creates a reader of this file; `known` is the log before, where its tail is read.
    pub(super) fn new(bytes: &'a [u8], header: Option<FileHeader>, known: Option<&Survey>) -> Self {
        let projected = known.and_then(|known| known.track.projected.as_ref());
        let is_weighted = header.is_some_and(|header| WEIGHTED.contains(&{ header.sonar_type }));
        Self {
            bytes,
            channels: channels::list(bytes, header),
            positions: Positions::new(header, projected.map(|projected| projected.origin_m)),
            sides: SideChannels::new(is_weighted),
            provenance: header.map_or_else(Provenance::default, |header| Provenance::of(&header)),
            ..Self::default()
        }
    }

    /// Decodes the packet that begins at an offset.
    pub(super) fn take(&mut self, log: &mut Collected, offset: usize) {
        let Some(packet) = raw::header(self.bytes, offset) else {
            return;
        };
        let ping =
            (packet.kind == PING).then(|| record::<PingHeader>(self.bytes, offset)).flatten();
        let Some(ping) = ping else {
            let set_back_s = self.clock.set_back_s;
            self.others.count(packet.kind);
            if !self.positions.sent.take(self.bytes, offset, &packet, set_back_s) {
                self.skipped.count(packet.kind);
            }
            return;
        };
        let time_s = raw::unix_ms(&ping) as f64 / 1000.0;
        if let Some(verdict) = self.clock.push(time_s, (offset, ping)) {
            self.settle(log, verdict);
        }
    }

    /// Returns a reader of the rest of the file (`bytes`), with the time zero, the origin and the
    /// channels that were found so far, but without collected data.
    pub(super) fn after_head(self, bytes: &'a [u8]) -> Self {
        Self {
            bytes,
            clock: Clock::default(),
            others: Packets::default(),
            skipped: Packets::default(),
            positions: self.positions.after_head(),
            sides: self.sides.after_head(),
            assumed_sound: 0,
            ..self
        }
    }

    /// Processes the pings that still wait for a verdict of the clock; returns true if the log's
    /// time zero is known.
    pub(super) fn knows_zero(&mut self, log: &mut Collected) -> bool {
        while let Some(verdict) = self.clock.next() {
            self.settle(log, verdict);
        }
        self.zero_ms.is_some()
    }

    /// Processes the pings that still wait for a verdict of the clock, adds the results to the log
    /// and warns about what was left out. For the tail of a log, samples get the scales of the log
    /// `known`.
    pub(super) fn finish(&mut self, log: &mut Collected, known: Option<&Survey>) {
        while let Some(verdict) = self.clock.next() {
            self.settle(log, verdict);
        }
        self.sides.finish(self.bytes, log, known);
        self.positions.finish(log, self.zero_ms.unwrap_or(0) as f64 / 1000.0);
        log.start_unix_s = self.zero_ms.and_then(unix_s);
        log.range_source = self.provenance.range_source;
        log.report.set_back(self.clock.set_back_s);
        if self.channels.iter().any(|channel| channel.ground_range) {
            log.report.log("the water column was taken out of this file (ground-range correction): there is no first return in it");
        }
        if self.assumed_sound > 0 {
            log.report.log(format!(
                "{} channels of pings state neither a range nor a speed of sound; their ranges are for {SOUND_MPS} m/s",
                self.assumed_sound
            ));
        }
        if self.skipped.total() > 0 {
            log.report.log(format!(
                "{} that are no side-scan pings were skipped",
                self.skipped.summary()
            ));
        }
    }

    fn settle(&mut self, log: &mut Collected, verdict: ClockVerdict<(usize, PingHeader)>) {
        match verdict {
            ClockVerdict::Sound { record: (offset, ping), time_s } => {
                self.keep(log, offset, &ping, time_s)
            }
            ClockVerdict::Damaged((offset, _)) => log.report.odd_time(0, offset, "a ping's time"),
        }
    }

    fn keep(&mut self, log: &mut Collected, offset: usize, ping: &PingHeader, unix_s: f64) {
        let now_ms = (unix_s * 1000.0).round() as i64;
        let time_s = (now_ms - *self.zero_ms.get_or_insert(now_ms)) as f64 / 1000.0;
        let depth_m = if self.provenance.has_depths_once {
            ping.sensor_aux_altitude_m
        } else {
            ping.sensor_altitude_m
        };
        log.add_depth(ChannelKind::Primary, time_s, depth_m);
        self.positions.add(log, ping, time_s, self.transducer_m());
        let end = offset + ping.packet.size as usize;
        let mut at = offset + size_of::<PingHeader>();
        for _ in 0..ping.packet.channels {
            let first = at + size_of::<PingChannel>();
            let header = record::<PingChannel>(self.bytes, at).filter(|_| first <= end);
            let Some(mut header) = header else { break };
            self.learn_frequency(&header);
            let channel = channel(&self.channels, header.channel);
            if header.samples == 0 {
                header.samples = channel.samples;
            }
            let room = || inferred_width(ping, header.samples);
            let width = channel.width.unwrap_or_else(room);
            let stored = (header.samples as usize).saturating_mul(width);
            if stored == 0 || stored > end - first {
                let text = format!(
                    "channel {} of a ping says that it has {} samples, which do not lie in the ping; it was dropped",
                    { header.channel },
                    { header.samples }
                );
                log.report.at(WarningKind::Frame, 0, at, text);
                break;
            }
            let (range_m, is_assumed) = range_m(ping, &header);
            let recorded = Recorded { header, width, first, time_s, range_m };
            count(log, &channel, &recorded, end);
            self.sides.keep(log, &channel, &recorded);
            self.assumed_sound += usize::from(is_assumed);
            at = first + stored;
        }
    }

    /// Sets the frequency of a channel from a ping, where the file header states none.
    fn learn_frequency(&mut self, header: &PingChannel) {
        let listed = self.channels.get_mut(usize::from(header.channel));
        if let Some(channel) = listed.filter(|channel| channel.frequency_khz.is_none()) {
            let stated = f32::from(header.frequency_khz);
            channel.frequency_khz = Some(stated).filter(|khz| *khz > 0.0);
        }
    }

    /// Returns the offset of the side-scan from the ship's reference point, forward and to
    /// starboard, metres.
    fn transducer_m(&self) -> [f32; 2] {
        let side = self.channels.iter().find(|channel| channel.kind.side().is_some());
        side.map_or([0.0; 2], |channel| channel.offset_m)
    }
}

/// One channel of one ping.
#[derive(Clone, Copy, Debug)]
struct Recorded {
    /// Header of the channel in the ping.
    header: PingChannel,
    /// Bytes of a sample.
    width: usize,
    /// Offset of the first sample in the file.
    first: usize,
    /// Seconds after the log's time zero.
    time_s: f64,
    /// Slant range of the first and of the last sample, metres.
    range_m: [f32; 2],
}

/// A port and a starboard channel of one frequency, or one of them.
#[derive(Debug, Default)]
struct Pair {
    /// Numbers of the port and of the starboard channel.
    channels: [Option<u16>; 2],
    name: String,
    frequency_khz: Option<f32>,
    stated: Stated,
    halves: [Vec<HalfPing>; 2],
}

/// Collects the sides in pairs; the pair whose first ping came first is shown.
#[derive(Debug, Default)]
struct SideChannels {
    pairs: Vec<Pair>,
    is_weighted: bool,
    /// Number of pings that are not read, by bytes of a sample and format.
    unread: BTreeMap<(usize, u8), usize>,
}

impl SideChannels {
    /// Creates a collection without sides. `is_weighted` is true if the sonar's samples count
    /// 2^-weight.
    fn new(is_weighted: bool) -> Self {
        Self { is_weighted, ..Self::default() }
    }

    /// Adds a channel of a ping if it is a side.
    fn keep(&mut self, log: &mut Collected, channel: &XtfChannel, recorded: &Recorded) {
        let Some(side) = channel.kind.side() else { return };
        let Some(encoding) = channel.encoding(recorded.width) else {
            *self.unread.entry((recorded.width, channel.format)).or_default() += 1;
            return;
        };
        let span = SideSpan {
            encoding,
            order: channels::order(channel.kind),
            offset: recorded.first as u64,
            ..SideSpan::of_bytes(recorded.header.samples, recorded.range_m)
        };
        if is_sound(&span) {
            let time_s = recorded.time_s;
            let pair = self.pair(side, recorded.header.channel, channel);
            pair.halves[side as usize].push(HalfPing { time_s, span });
        } else {
            let text = format!(
                "a side of a ping has {} samples over {} m, which is no picture; it was dropped",
                span.count, span.far_m
            );
            log.report.at(WarningKind::Value, 0, recorded.first, text);
        }
    }

    /// Returns the pair of a channel: its own pair, else one that lacks this side and has no other
    /// frequency, else a new pair.
    fn pair(&mut self, side: Side, number: u16, channel: &XtfChannel) -> &mut Pair {
        let of_side = |pair: &Pair| pair.channels[side as usize];
        let known = self.pairs.iter().position(|pair| of_side(pair) == Some(number));
        let is_partner = |pair: &Pair| {
            let both = pair.frequency_khz.zip(channel.frequency_khz);
            of_side(pair).is_none() && both.is_none_or(|(one, other)| one == other)
        };
        let partner = || self.pairs.iter().position(is_partner);
        let index = known.or_else(partner).unwrap_or(self.pairs.len());
        if index == self.pairs.len() {
            let is_taken = self.pairs.iter().any(|pair| pair.name == channel.name);
            let name = if is_taken {
                format!("{}, channel {number}", channel.name)
            } else {
                channel.name.clone()
            };
            self.pairs.push(Pair { name, ..Pair::default() });
        }
        let pair = &mut self.pairs[index];
        pair.channels[side as usize] = Some(number);
        pair.frequency_khz = pair.frequency_khz.or(channel.frequency_khz);
        pair.stated = Stated {
            is_polar: pair.stated.is_polar || channel.is_polar,
            is_legacy: channel.format == 0,
            is_weighted: self.is_weighted,
        };
        pair
    }

    /// Returns the same pairs of channels without collected pings.
    fn after_head(mut self) -> Self {
        for pair in &mut self.pairs {
            pair.halves = Default::default();
        }
        self.unread.clear();
        self
    }

    /// Adds the pairs to the log with their scales, for the tail of a log those of the log `known`,
    /// and warns about pings that are not read.
    fn finish(&mut self, bytes: &[u8], log: &mut Collected, known: Option<&Survey>) {
        for mut pair in std::mem::take(&mut self.pairs) {
            let halves = pair.halves.iter_mut().flatten();
            let mut spans: Vec<&mut SideSpan> = halves.map(|half| &mut half.span).collect();
            let known = known.and_then(|known| last_span(known, &pair.name));
            levels::fit(bytes, &mut spans, pair.stated, known);
            let [port, starboard] = pair.halves;
            log.pairs.push(CollectedPair {
                name: pair.name,
                frequency_khz: pair.frequency_khz,
                port,
                starboard,
            });
        }
        for ((width, format), pings) in &self.unread {
            log.report.log(format!(
                "{pings} pings hold samples of {width} bytes (format {format}), which are not read; export them with 1, 2 or 4 bytes"
            ));
        }
    }
}

/// Returns the last span of the pair with this name, or of the shown side-scan.
fn last_span(known: &Survey, name: &str) -> Option<SideSpan> {
    let pair = known.pairs.iter().find(|pair| pair.name == name);
    let pings: &[SidePing] = pair.map_or(&known.side_scan, |pair| &pair.side_scan);
    pings.iter().rev().find_map(|ping| ping.port.or(ping.starboard))
}

/// Returns a channel as the file header describes it, or a guess.
fn channel(channels: &[XtfChannel], index: u16) -> Cow<'_, XtfChannel> {
    let listed = channels.get(usize::from(index));
    listed.map_or_else(|| Cow::Owned(channels::guess(index)), Cow::Borrowed)
}

/// Returns the slant range of the first and of the last sample of a channel, metres, and whether
/// the speed of sound was assumed.
fn range_m(ping: &PingHeader, header: &PingChannel) -> ([f32; 2], bool) {
    let [slant_m, ground_m] = [header.slant_range_m, header.ground_range_m];
    if slant_m > 0.0 {
        return ([0.0, slant_m], false);
    }
    let [delay_s, duration_s] = [header.time_delay_s, header.time_duration_s];
    let has_duration = duration_s > 0.0;
    if !has_duration && ground_m > 0.0 {
        return ([0.0, ground_m], false);
    }
    // Isis writes half of the speed, for the two-way travel time.
    let speeds_mps =
        [2.0 * ping.sound_velocity_mps, ping.sound_velocity_mps, ping.computed_sound_velocity_mps];
    let stated = speeds_mps.into_iter().find(|mps| SOUNDS_MPS.contains(mps));
    let half_mps = stated.unwrap_or(SOUND_MPS) / 2.0;
    let delay_s = if delay_s > 0.0 { delay_s } else { 0.0 };
    let range_m = [delay_s, delay_s + duration_s].map(|time_s| time_s * half_mps);
    (range_m, stated.is_none())
}

fn count(log: &mut Collected, channel: &XtfChannel, recorded: &Recorded, end: usize) {
    let number = recorded.header.channel;
    let counted = Counted {
        record: (0, end),
        time_s: recorded.time_s,
        samples: recorded.header.samples as usize,
        range_m: Some(recorded.range_m.into()),
    };
    log.count(number, counted, || (channel.kind, channel.name.clone(), channel.frequency_khz));
}

/// Returns the bytes of a sample where the file header does not state them, from the size of the
/// packet.
fn inferred_width(ping: &PingHeader, samples: u32) -> usize {
    let channels = usize::from(ping.packet.channels).max(1);
    let headers = size_of::<PingHeader>() + channels * size_of::<PingChannel>();
    let room = (ping.packet.size as usize).saturating_sub(headers) / channels;
    match room / (samples as usize).max(1) {
        0 | 1 => 1,
        2 | 3 => 2,
        _ => 4,
    }
}

/// Returns the name of a type in Triton's list of packet types; `None` for vendors' own types.
fn name(kind: u8) -> Option<&'static str> {
    match kind {
        0 => Some("damaged side-scan"),
        1 => Some("note"),
        2 | 9 | 10 | 14 | 17 | 18 | 22 | 25 | 26 | 28 | 60 | 61 | 65 => Some("bathymetry"),
        3 => Some("attitude"),
        6 => Some("serial"),
        20 => Some("GPS"),
        23 | 84 => Some("gyro"),
        42 | 107 => Some("navigation"),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn packets_are_listed_by_kind_the_most_frequent_first() {
        let mut packets = Packets::default();
        packets.count(3);
        assert_eq!(packets.summary(), "1 attitude (type 3) packets");
        for kind in [2, 2, 2, 199, 199] {
            packets.count(kind);
        }
        assert_eq!(packets.total(), 6);
        assert_eq!(
            packets.summary(),
            "3 bathymetry (type 2), 2 of type 199 and 1 attitude (type 3) packets"
        );
    }
}
