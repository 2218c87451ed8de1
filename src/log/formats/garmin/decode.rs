//! Decodes records of an RSD file to pings, depths and fixes in SI units. The samples of the pings
//! become sides of the side-scan and echograms of channels that look down.

use super::FileHeader;
use super::channels::{self, SeenChannel, UNNUMBERED};
use super::record::{Ping, RecordBody, RecordHeader, next_record};
use crate::formats::clock::{Clock, ClockVerdict};
use crate::formats::collected::{Collected, Counted, HalfPing, WarningKind, is_range, is_sound};
use crate::formats::xtf::shift_to_fit;
use crate::support::geo::LonLat;
use crate::survey::{ChannelKind, Encoding, Fix, SideSpan, Survey};
use std::sync::Arc;

/// Most channels of a log; more channels are damage.
const MOST_CHANNELS: usize = 64;
/// Units of a stored position in a full circle.
const UNITS_A_CIRCLE: f64 = 4_294_967_296.0;
/// Records at the beginning of a file from which the encoding of depths is determined.
const RECORDS_LOOKED_AT: usize = 512;
/// Most bytes after the first record that are searched for these records.
const HEAD: usize = 1 << 22;
/// Share of odd ranges up to which they count as damage; a larger share means unsigned integers.
const DAMAGED_SHARE: f64 = 0.125;

/// Encoding of a depth: millimetres as a signed integer, or as an unsigned one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum DepthEncoding {
    /// Twice the value where it is not negative, else twice its amount less one ("zig-zag"), as the
    /// format's descriptions state.
    #[default]
    Signed,
    /// The value itself. PINGVerter reports files with this encoding.
    Unsigned,
}

impl DepthEncoding {
    /// Determines the encoding from the far ranges of the first records: ranges are not negative,
    /// so that a signed one is stored as an even number.
    fn of_head(bytes: &[u8], first_record: usize) -> Self {
        let head = &bytes[..bytes.len().min(first_record.saturating_add(HEAD))];
        let (mut at, mut ranges, mut odd) = (first_record, 0_usize, 0_usize);
        for _ in 0..RECORDS_LOOKED_AT {
            let found = next_record(head, at, head.len());
            let header = found.and_then(|found| RecordHeader::read(head, found));
            let Some(header) = header else { break };
            let body = RecordBody::read(head, &header);
            if let Some(far) = body.and_then(|body| body.range[1]) {
                ranges += 1;
                odd += far as usize & 1;
            }
            at = header.body;
        }
        if odd as f64 > DAMAGED_SHARE * ranges as f64 {
            DepthEncoding::Unsigned
        } else {
            DepthEncoding::Signed
        }
    }

    /// Returns a stored depth in metres.
    fn metres(self, stored: u32) -> f32 {
        let millimetres = match self {
            DepthEncoding::Signed => {
                let amount = i64::from(stored >> 1);
                if stored & 1 == 0 { amount } else { -amount - 1 }
            }
            DepthEncoding::Unsigned => i64::from(stored),
        };
        (millimetres as f64 / 1000.0) as f32
    }
}

/// Collects pings, two records behind the walk so that damaged times are recognised. The kind of a
/// channel is only known after all of its pings.
pub(super) struct Reader<'a> {
    bytes: &'a [u8],
    header: FileHeader,
    depths: DepthEncoding,
    clock: Clock<Ping>,
    pings: Vec<(f64, Ping)>,
    channels: Vec<SeenChannel>,
}

impl<'a> Reader<'a> {
    /// Creates a reader of a file whose records begin at `first_record`.
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

    /// Decodes the next record of the file.
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
                let time = format!("a record's time ({:.1} s)", f64::from(ping.time_ms) / 1000.0);
                log.report.odd_time(0, ping.offset, &time);
            }
        }
    }

    fn keep(&mut self, log: &mut Collected, ping: Ping, time_s: f64) {
        let mut known = self.channels.iter();
        let place = known.position(|channel| channel.number == ping.channel);
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

    /// Determines the kinds of the channels and adds all pings, depths and fixes to the log.
    /// `known` is the log as it was read before, where this is its tail.
    pub(super) fn finish(mut self, log: &mut Collected, known: Option<&Survey>) {
        while let Some(verdict) = self.clock.next() {
            self.settle(log, verdict);
        }
        log.report.set_back(self.clock.set_back_s);
        log.start_unix_s = self.header.start_unix_s;
        if self.depths == DepthEncoding::Unsigned && !self.pings.is_empty() {
            log.report.log("depths and ranges of this file are stored as unsigned integers, which few files do; compare a depth with what the unit showed");
        }
        let kinds = channels::kinds(&self.channels, &self.header, known, &log.report);
        for (time_s, ping) in &self.pings {
            let (time_s, kind) = (*time_s, kinds[&ping.channel]);
            let range_m = range_m(ping, self.depths);
            let counted = Counted {
                record: (0, ping.end),
                time_s,
                samples: ping.body.stated_samples as usize,
                range_m,
            };
            log.count(ping.channel, counted, || {
                let name = SeenChannel::name(ping.channel);
                (kind, name, self.header.frequency_khz(ping.channel))
            });
            if let Some(stored) = ping.body.bottom {
                log.add_depth(kind, time_s, self.depths.metres(stored));
            }
            if let Some(fix) = fix(ping, time_s) {
                log.add_fix(fix);
            }
            keep(log, kind, ping, (time_s, range_m));
        }
        choose_levels(self.bytes, log, known);
    }
}

/// Returns the number of a record's channel: from its body, else from its header; for records
/// without a number, a number made of the beam. `None` where the number is not plausible.
fn number(header: &RecordHeader, body: &RecordBody) -> Option<u16> {
    match body.channel.or(header.channel) {
        Some(stated) => u16::try_from(stated).ok().filter(|number| *number < UNNUMBERED),
        None => Some(UNNUMBERED + body.beam.unwrap_or(0).min(9) as u16),
    }
}

/// Returns the position of a ping; `None` where it has none. The format has no course, no heading
/// and no speed.
fn fix(ping: &Ping, time_s: f64) -> Option<Fix> {
    let place = ping.body.place.filter(|place| *place != [0, 0])?;
    let [lat_deg, lon_deg] = place.map(|units| f64::from(units) * (360.0 / UNITS_A_CIRCLE));
    Some(Fix::at(time_s, LonLat { lon_deg, lat_deg }))
}

/// Returns the near and far limit of a ping's samples, metres; `None` where they are missing or not
/// plausible.
fn range_m(ping: &Ping, depths: DepthEncoding) -> Option<(f32, f32)> {
    let [near, far] = ping.body.range.map(|stored| stored.map(|stored| depths.metres(stored)));
    let (near_m, far_m) = (near.unwrap_or(0.0), far?);
    is_range(near_m, far_m).then_some((near_m, far_m))
}

/// Adds the samples of a ping to the log; warns where they cannot be shown as a picture.
fn keep(
    log: &mut Collected,
    kind: ChannelKind,
    ping: &Ping,
    (time_s, range_m): (f64, Option<(f32, f32)>),
) {
    if matches!(kind, ChannelKind::Other(_)) || ping.body.stated_samples == 0 {
        return;
    }
    let (near_m, far_m) = range_m.unwrap_or((0.0, 0.0));
    let span = ping.body.samples.map(|samples| SideSpan {
        encoding: if samples.is_wide { Encoding::U16 { shift: 0 } } else { Encoding::U8 },
        offset: samples.offset as u64,
        // Other readers, too, show the first sample of both sides at the transducer.
        ..SideSpan::of_bytes(samples.count, [near_m, far_m])
    });
    let Some(span) = span else {
        let text = format!(
            "a ping says that it has {} samples, which do not lie in its record; it has no picture",
            ping.body.stated_samples
        );
        log.report.at(WarningKind::Frame, 0, ping.offset, text);
        return;
    };
    if !is_sound(&span) {
        let text = format!(
            "a ping has {} samples over no range that can be, which is no picture; it was dropped",
            span.count
        );
        log.report.at(WarningKind::Value, 0, ping.offset, text);
        return;
    }
    match kind {
        ChannelKind::Port => log.port.push(HalfPing { time_s, span }),
        ChannelKind::Starboard => log.starboard.push(HalfPing { time_s, span }),
        _ => log.add_echogram(kind, time_s, span),
    }
}

/// Chooses which eight bits of 16-bit samples are shown: the same for both sides, and the same for
/// all pings of a channel that looks down. For the tail of a log, echograms keep the choice of the
/// log before.
fn choose_levels(bytes: &[u8], log: &mut Collected, known: Option<&Survey>) {
    let sides = log.port.iter_mut().chain(&mut log.starboard);
    show_alike(bytes, sides.map(|half| &mut half.span), None);
    for echogram in &mut log.echograms {
        let kind = echogram.kind;
        let mut before = known.into_iter().flat_map(|known| &known.echograms);
        let before = before.find(|echogram| echogram.kind == kind);
        let mut before = before.into_iter().flat_map(|echogram| echogram.pings.iter().rev());
        let chosen = before.find_map(|ping| shift(&ping.span));
        let pings = Arc::make_mut(&mut echogram.pings);
        show_alike(bytes, pings.iter_mut().map(|ping| &mut ping.span), chosen);
    }
}

fn shift(span: &SideSpan) -> Option<u8> {
    match span.encoding {
        Encoding::U16 { shift } => Some(shift),
        _ => None,
    }
}

fn show_alike<'a>(bytes: &[u8], spans: impl Iterator<Item = &'a mut SideSpan>, chosen: Option<u8>) {
    let wide: Vec<&mut SideSpan> = spans.filter(|span| shift(span).is_some()).collect();
    let fitting = chosen.unwrap_or_else(|| {
        let wide: Vec<&SideSpan> = wide.iter().map(|span| &**span).collect();
        shift_to_fit(bytes, &wide)
    });
    for span in wide {
        span.encoding = Encoding::U16 { shift: fitting };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn depths_of_both_kinds_become_metres() {
        let signed = |stored| DepthEncoding::Signed.metres(stored);
        assert_eq!([0, 1, 2, 16_000].map(signed), [0.0, -0.001, 0.001, 8.0]);
        assert_eq!(signed(u32::MAX), -2_147_483.8);
        assert_eq!(DepthEncoding::Unsigned.metres(16_001), 16.001);
    }
}
