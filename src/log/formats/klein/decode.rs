//! Decodes pages of a Klein SDF file to sides, altitudes and fixes in SI units.

use super::page::{Band, Channel, Page};
use crate::formats::clock::{Clock, ClockVerdict};
use crate::formats::collected::{Collected, Counted, HalfPing, WarningKind, is_sound};
use crate::formats::log_format::Reading;
use crate::formats::xtf::shift_to_fit;
use crate::survey::{ChannelKind, Encoding, Fix, NumberKind, RangeSource, SideSpan, Survey};
use std::collections::BTreeMap;

/// Decodes pages and collects sides and fixes.
#[derive(Default)]
pub(super) struct Reader<'a> {
    bytes: &'a [u8],
    clock: Clock<usize>,
    /// Unix milliseconds of the log's time zero; only if it is known, a tail can be read without
    /// the rest.
    pub(super) zero_ms: Option<f64>,
    /// Halves by frequency (low, high) and by side (port, starboard).
    halves: [[Vec<HalfPing>; 2]; 2],
    /// Number of pages that are not read, by sonar.
    others: BTreeMap<&'static str, usize>,
}

impl<'a> Reader<'a> {
    /// Creates a reader of this file; for the tail of a log, with the log's time zero.
    pub(super) fn new(bytes: &'a [u8], reading: &Reading<'_>) -> Self {
        let known = reading.known().and_then(|known| known.start_unix_s);
        Self {
            bytes,
            zero_ms: known.map(|start_unix_s| (start_unix_s * 1e3).round()),
            ..Self::default()
        }
    }

    /// Decodes the page whose marker begins at an offset.
    pub(super) fn take(&mut self, log: &mut Collected, at: usize) {
        let Some(page) = Page::at(self.bytes, at) else {
            return;
        };
        if !page.is_known() {
            *self.others.entry(page.sonar()).or_default() += 1;
            return;
        }
        let Some(unix_s) = page.unix_s() else {
            let text = "a page has no date that can be; it was dropped";
            return log.report.at(WarningKind::Value, 0, at, text);
        };
        if let Some(verdict) = self.clock.push(unix_s, at) {
            self.settle(log, verdict);
        }
    }

    /// Processes the pages that still wait for a verdict of the clock, and chooses the frequency
    /// and the scale that are shown.
    pub(super) fn finish(&mut self, log: &mut Collected, known: Option<&Survey>) {
        while let Some(verdict) = self.clock.next() {
            self.settle(log, verdict);
        }
        log.report.set_back(self.clock.set_back_s);
        log.start_unix_s = self.zero_ms.map(|zero_ms| zero_ms / 1e3);
        log.range_source = RangeSource::SurveyRecorder;
        let [low, high] = std::mem::take(&mut self.halves);
        let counts = [&low, &high].map(|[port, starboard]| port.len().max(starboard.len()));
        if counts.iter().all(|count| *count > 0) {
            log.report.log(format!(
                "{} pings of the low frequency are counted but not shown: those of the high one are",
                counts[0]
            ));
        }
        [log.port, log.starboard] = if counts[1] > 0 { high } else { low };
        let halves = || log.port.iter().chain(&log.starboard);
        let spans: Vec<&SideSpan> = halves().map(|half| &half.span).collect();
        // The tail of a log keeps the scale of the log.
        let known = known.and_then(|known| known.last_spans().next());
        let fitting = match known.map(|span| span.encoding) {
            Some(Encoding::U16 { shift }) => shift,
            Some(Encoding::Number { exponent, .. }) => exponent.unsigned_abs() as u8,
            _ => shift_to_fit(self.bytes, &spans),
        };
        for half in log.port.iter_mut().chain(&mut log.starboard) {
            match &mut half.span.encoding {
                // In a file with samples of 16 and of 32 bits, both share one scale.
                Encoding::U16 { shift } => *shift = fitting.min(u16::BITS as u8),
                Encoding::Number { exponent, .. } => *exponent = -i16::from(fitting),
                _ => {}
            }
        }
        if let Some(others) = self.others().filter(|_| !log.channels.is_empty()) {
            log.report.log(format!("{others} were skipped"));
        }
    }

    /// Describes the pages that are not read, as `120 pages of a System 5000`; `None` without such
    /// pages.
    pub(super) fn others(&self) -> Option<String> {
        let each = self.others.iter();
        let each = each.map(|(sonar, count)| format!("{count} pages of a {sonar}"));
        let each: Vec<String> = each.collect();
        (!each.is_empty()).then(|| each.join(" and "))
    }

    fn settle(&mut self, log: &mut Collected, verdict: ClockVerdict<usize>) {
        match verdict {
            ClockVerdict::Sound { record, time_s } => {
                let now_ms = (time_s * 1e3).round();
                let time_s = (now_ms - *self.zero_ms.get_or_insert(now_ms)) / 1e3;
                if let Some(page) = Page::at(self.bytes, record) {
                    self.keep(log, &page, time_s);
                }
            }
            ClockVerdict::Damaged(at) => {
                let text = "a page's time fits neither neighbour; its header is damaged and it was dropped";
                log.report.at(WarningKind::Frame, 0, at, text);
            }
        }
    }

    fn keep(&mut self, log: &mut Collected, page: &Page<'_>, time_s: f64) {
        if log.source.device.is_empty() {
            page.sonar().clone_into(&mut log.source.device);
        }
        log.add_depth(ChannelKind::Primary, time_s, page.altitude_m());
        if let Some(position) = page.position() {
            log.add_fix(Fix {
                compass_rad: page.heading_deg().to_radians(),
                speed_mps: page.speed_mps(),
                ..Fix::at(time_s, position)
            });
        }
        let channels = page.channels();
        if channels.is_empty() {
            let text = "the samples of a page do not lie in it; it was dropped";
            log.report.at(WarningKind::Frame, 0, page.at, text);
        }
        for channel in channels {
            self.keep_channel(log, page, channel, time_s);
        }
    }

    fn keep_channel(
        &mut self,
        log: &mut Collected,
        page: &Page<'_>,
        channel: Channel,
        time_s: f64,
    ) {
        let far_m = page.far_m(channel.count);
        let number = 2 * channel.band as u16 + channel.side as u16;
        let counted = Counted {
            record: (0, page.end),
            time_s,
            samples: channel.count,
            range_m: Some((0.0, far_m)),
        };
        log.count(number, counted, || {
            let kind = [ChannelKind::Port, ChannelKind::Starboard][channel.side];
            let band = match channel.band {
                Band::Low => "low frequency",
                Band::High => "high frequency",
            };
            (kind, band.to_owned(), page.frequency_khz())
        });
        let span = SideSpan {
            encoding: match channel.width {
                2 => Encoding::U16 { shift: 0 },
                _ => Encoding::Number { kind: NumberKind::U32, exponent: 0 },
            },
            offset: channel.first as u64,
            ..SideSpan::of_bytes(channel.count as u32, [0.0, far_m])
        };
        if is_sound(&span) {
            let half = HalfPing { time_s, span };
            self.halves[channel.band as usize][channel.side].push(half);
        } else {
            let text = format!(
                "a side of a page has {} samples over {far_m} m, which is no picture; it was dropped",
                channel.count
            );
            log.report.at(WarningKind::Value, 0, channel.first, text);
        }
    }
}
