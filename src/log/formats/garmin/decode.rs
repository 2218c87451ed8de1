//! Decodes records to pings, depths and fixes in SI units.

use super::channels::{self, SeenChannel, UNNUMBERED};
use super::depth::DepthEncoding;
use super::header::FileHeader;
use super::pictures;
use super::record::{Ping, RecordBody, RecordHeader};
use crate::formats::clock::{Clock, ClockVerdict};
use crate::formats::collected::{Collected, Counted};
use crate::formats::report::WarningKind;
use crate::support::geo::LonLat;
use crate::survey::{Fix, Survey};

/// A log has no more channels; a channel beyond them is damage.
const MOST_CHANNELS: usize = 64;
/// Garmin's units of a position in a circle.
const UNITS_A_CIRCLE: f64 = 4_294_967_296.0;

/// Collects pings, a little behind the walk so that a damaged time is seen. What a channel is, only
/// all of its pings tell.
pub(super) struct Reader<'a> {
    bytes: &'a [u8],
    header: FileHeader,
    depths: DepthEncoding,
    clock: Clock<Ping>,
    pings: Vec<(f64, Ping)>,
    channels: Vec<SeenChannel>,
}

impl<'a> Reader<'a> {
    /// A reader of a file whose records begin at `first_record`.
    pub(super) fn new(bytes: &'a [u8], header: FileHeader, first_record: usize) -> Self {
        Self {
            bytes,
            header,
            depths: DepthEncoding::of_head(bytes, first_record),
            clock: Clock::default(),
            pings: Vec::new(),
            channels: Vec::new(),
        }
    }

    /// Takes the next record of the file.
    pub(super) fn take(&mut self, log: &mut Collected, offset: usize, header: &RecordHeader) {
        if header.size == 0 {
            return;
        }
        let body = RecordBody::read(self.bytes, header);
        let channel = body.as_ref().and_then(|body| number(header, body));
        let Some((body, channel)) = body.zip(channel) else {
            let text = "the fields of a record are damaged; it was dropped";
            log.report.at(WarningKind::Frame, 0, offset, text);
            return;
        };
        let ping = Ping { offset, end: header.end(), time_ms: header.time_ms, channel, body };
        if let Some(verdict) = self.clock.push(f64::from(header.time_ms) / 1000.0, ping) {
            self.settle(log, verdict);
        }
    }

    fn settle(&mut self, log: &mut Collected, verdict: ClockVerdict<Ping>) {
        match verdict {
            ClockVerdict::Sound { record, time_s } => self.keep(log, record, time_s),
            ClockVerdict::Damaged(ping) => {
                let text = format!(
                    "a record's time ({:.1} s) fits neither neighbour; its header is damaged and it was dropped",
                    f64::from(ping.time_ms) / 1000.0
                );
                log.report.at(WarningKind::Frame, 0, ping.offset, text);
            }
        }
    }

    fn keep(&mut self, log: &mut Collected, ping: Ping, time_s: f64) {
        let mut known = self.channels.iter();
        let place = known.position(|one| one.number == ping.channel);
        let place = place.unwrap_or(self.channels.len());
        if place == MOST_CHANNELS {
            let text = format!(
                "a record is of channel {}, and {MOST_CHANNELS} others came before it; it was dropped",
                ping.channel
            );
            log.report.at(WarningKind::Value, 0, ping.offset, text);
            return;
        }
        if place == self.channels.len() {
            self.channels.push(SeenChannel::new(ping.channel));
        }
        self.channels[place].add(time_s, &ping.body);
        self.pings.push((time_s, ping));
    }

    /// Gives all pings their meaning. `known` is the log as it was read before, where this is its
    /// tail.
    pub(super) fn finish(mut self, log: &mut Collected, known: Option<&Survey>) {
        while let Some(verdict) = self.clock.next() {
            self.settle(log, verdict);
        }
        log.report.set_back(self.clock.set_back_s());
        log.start_unix_s = self.header.start_unix_s;
        if self.depths == DepthEncoding::Unsigned && !self.pings.is_empty() {
            log.report.log("depths and ranges of this file are stored as unsigned integers, which few files do; compare a depth with what the unit showed");
        }
        let kinds = channels::kinds(&self.channels, &self.header, known, &log.report);
        for channel in &self.channels {
            let number = channel.number;
            let frequency_khz = self.header.frequency_khz(number);
            let name = SeenChannel::name(number);
            log.introduce(number, kinds[&number], name, frequency_khz);
        }
        for (time_s, ping) in &self.pings {
            let (time_s, kind) = (*time_s, kinds[&ping.channel]);
            let range_m = pictures::range_m(ping, self.depths);
            let counted = Counted {
                record: (0, ping.end),
                time_s,
                samples: ping.body.stated_samples as usize,
                range_m,
            };
            log.count(ping.channel, counted);
            if let Some(stored) = ping.body.bottom {
                log.add_depth(kind, time_s, self.depths.metres(stored));
            }
            if let Some(fix) = fix(ping, time_s) {
                log.add_fix(fix);
            }
            pictures::keep(log, kind, ping, (time_s, range_m));
        }
        pictures::choose_levels(self.bytes, log, known);
    }
}

/// The number of a record's channel: that of its body, else that of its header; some records have
/// none, and a beam only. `None` where it cannot be.
fn number(header: &RecordHeader, body: &RecordBody) -> Option<u16> {
    match body.channel.or(header.channel) {
        Some(stated) => u16::try_from(stated).ok().filter(|number| *number < UNNUMBERED),
        None => Some(UNNUMBERED + body.beam.unwrap_or(0).min(9) as u16),
    }
}

/// The position of a ping. The format has no course, no heading and no speed.
fn fix(ping: &Ping, time_s: f64) -> Option<Fix> {
    let place = ping.body.place.filter(|place| *place != [0, 0])?;
    let [lat_deg, lon_deg] = place.map(|units| f64::from(units) * (360.0 / UNITS_A_CIRCLE));
    Some(Fix {
        time_s,
        position: LonLat { lon_deg, lat_deg },
        cog_rad: f32::NAN,
        compass_rad: f32::NAN,
        speed_mps: f32::NAN,
    })
}
