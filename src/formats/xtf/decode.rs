//! From pings to sides, altitudes and fixes in SI units.

use super::channels::{self, XtfChannel};
use super::date;
use super::from_log::Provenance;
use super::packets::Packets;
use super::place::PositionConverter;
use super::raw::{FileHeader, PingChannel, PingHeader, record};
use super::sides::{Recorded, SideChannels};
use super::walk;
use crate::formats::clock::{Clock, ClockVerdict};
use crate::formats::collected::{Collected, Counted};
use crate::formats::report::WarningKind;
use crate::survey::{ChannelKind, ProjectedTrack, RangeSource};
use std::borrow::Cow;

/// Packet type of a side-scan ping.
const PING: u8 = 0;

/// Decodes pings.
pub(super) struct Reader<'a> {
    bytes: &'a [u8],
    channels: Vec<XtfChannel>,
    places: PositionConverter,
    sides: SideChannels,
    clock: Clock<(usize, PingHeader)>,
    /// Time of the first sound ping: the log's time zero.
    zero_ms: Option<i64>,
    others: Packets,
    range_source: RangeSource,
}

impl<'a> Reader<'a> {
    /// A reader of this file.
    pub(super) fn new(bytes: &'a [u8], header: Option<FileHeader>) -> Self {
        Self {
            bytes,
            channels: channels::list(bytes, header),
            places: PositionConverter::new(header.as_ref()),
            sides: SideChannels::default(),
            clock: Clock::default(),
            zero_ms: None,
            others: Packets::default(),
            range_source: match header
                .is_some_and(|header| Provenance::of(&header).has_fish_finder_ranges)
            {
                true => RangeSource::FishFinder,
                false => RangeSource::SurveyRecorder,
            },
        }
    }

    /// Takes the next packet of the file, which begins at an offset.
    pub(super) fn take(&mut self, log: &mut Collected, offset: usize) {
        let Some(packet) = walk::header(self.bytes, offset) else {
            return;
        };
        let ping = (packet.kind == PING)
            .then(|| record::<PingHeader>(self.bytes, offset))
            .flatten();
        let Some(ping) = ping else {
            self.others.count(packet.kind);
            return;
        };
        let time_s = date::unix_ms(&ping) as f64 / 1000.0;
        if let Some(verdict) = self.clock.push(time_s, (offset, ping)) {
            self.settle(log, verdict);
        }
    }

    /// Goes on elsewhere in the file, knowing its time zero, its origin and the channels that are shown.
    pub(super) fn after_head(self, bytes: &'a [u8]) -> Self {
        Self {
            bytes,
            clock: Clock::default(),
            others: Packets::default(),
            sides: self.sides.after_head(),
            ..self
        }
    }

    /// Gives a verdict on the pings that still wait, and says whether the log's time zero is known.
    pub(super) fn knows_zero(&mut self, log: &mut Collected) -> bool {
        while let Some(verdict) = self.clock.next() {
            self.settle(log, verdict);
        }
        self.zero_ms.is_some()
    }

    /// Takes the pings that still wait for a verdict and says what was left out.
    pub(super) fn finish(&mut self, log: &mut Collected) {
        while let Some(verdict) = self.clock.next() {
            self.settle(log, verdict);
        }
        self.sides.finish(self.bytes, log);
        log.start_unix_s = self.zero_ms.and_then(date::unix_s);
        log.range_source = self.range_source;
        log.report.set_back(self.clock.set_back_s());
        log.projected = self.places.origin_m().map(ProjectedTrack::new);
        if self.channels.iter().any(|channel| channel.ground_range) {
            log.report.log("the water column was taken out of this file (ground-range correction): there is no first return in it");
        }
        let count = self.others.total();
        if count > 0 {
            log.report.log(format!(
                "{count} packets that are no side-scan pings were skipped"
            ));
        }
    }

    /// The packets that are no side-scan pings.
    pub(super) fn others(&self) -> &Packets {
        &self.others
    }

    fn settle(&mut self, log: &mut Collected, verdict: ClockVerdict<(usize, PingHeader)>) {
        match verdict {
            ClockVerdict::Sound {
                record: (offset, ping),
                time_s,
            } => self.keep(log, offset, &ping, time_s),
            ClockVerdict::Damaged((offset, _)) => {
                let text = "a ping's time fits neither neighbour; its header is damaged and it was dropped";
                log.report.at(WarningKind::Frame, 0, offset, text);
            }
        }
    }

    fn keep(&mut self, log: &mut Collected, offset: usize, ping: &PingHeader, unix_s: f64) {
        let now_ms = (unix_s * 1000.0).round() as i64;
        let time_s = (now_ms - *self.zero_ms.get_or_insert(now_ms)) as f64 / 1000.0;
        log.add_depth(ChannelKind::Primary, time_s, ping.sensor_altitude_m);
        if let Some(fix) = self.places.fix(ping, time_s) {
            log.add_fix(fix);
        }
        let end = offset + ping.packet.size as usize;
        let mut at = offset + size_of::<PingHeader>();
        for _ in 0..ping.packet.channels {
            let first = at + size_of::<PingChannel>();
            let header = record::<PingChannel>(self.bytes, at).filter(|_| first <= end);
            let Some(header) = header else { break };
            let channel = self.channel(header.channel);
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
            let recorded = Recorded {
                header,
                kind: channel.kind,
                width,
                first,
                time_s,
            };
            count(log, &channel, &recorded, end);
            self.sides.keep(log, &recorded);
            at = first + stored;
        }
    }

    fn channel(&self, index: u16) -> Cow<'_, XtfChannel> {
        let listed = self.channels.get(usize::from(index));
        listed.map_or_else(|| Cow::Owned(channels::guess(index)), Cow::Borrowed)
    }
}

fn count(log: &mut Collected, channel: &XtfChannel, recorded: &Recorded, end: usize) {
    let number = recorded.header.channel;
    if !log.knows(number) {
        let name = channel.name.clone();
        log.introduce(number, channel.kind, name, channel.frequency_khz);
    }
    let counted = Counted {
        record: (0, end),
        time_s: recorded.time_s,
        samples: recorded.header.samples as usize,
        range_m: Some((0.0, recorded.far_m())),
    };
    log.count(number, counted);
}

/// Bytes a sample where the file header does not say: what the packet has room for.
fn inferred_width(ping: &PingHeader, samples: u32) -> usize {
    let channels = usize::from(ping.packet.channels).max(1);
    let headers = size_of::<PingHeader>() + channels * size_of::<PingChannel>();
    let room = (ping.packet.size as usize).saturating_sub(headers) / channels;
    if room >= 2 * samples as usize { 2 } else { 1 }
}
