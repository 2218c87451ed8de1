//! Reads Klein SDF files, which SonarPro and the vehicles with Klein's side-scan sonars record.
//!
//! In: the bytes of a recording. Out: a collected log.
//!
//! A file is a sequence of pages, all numbers little-endian: a marker FF FF FF FF, then the page
//! (`page`): u32 bytes of the page without the marker, u32 version, and a header of 256 bytes, of
//! 512 in versions that end with 1 or 2. Versions 3000 and 3001 are the System 3000, 3501 and 3502
//! the low and the high frequency of the 3500 series, 5000 to 5004 the System 5000, 7000 and 7001
//! the System 7000. After the header the System 3000 has u16 samples of port and starboard of the
//! low frequency, then of the high frequency, each after a u16 with their number; the 3500 series
//! has u32 samples of port and of starboard, each after a u32. Both are assumed to be stored from
//! near to far.
//!
//! The ten beams of the System 5000 are not read, because no public source states which of them are
//! on the port side. For the System 7000 only the header is described. The error for such files
//! explains this and what to do.
//!
//! Sources: Klein's "SDF Data Page Definitions Specification" (15300018, Rev 2.05) as the public
//! reader `hydroformats` cites it with the offset of each field, and the readers of OceanScan
//! (`sdf_reader.m`, for Rev 4.8) and of Neptus for the 3500 series. No real file was available.

mod page;
#[cfg(test)]
mod tests;

use super::clock::{Clock, ClockVerdict};
use super::collected::{Collected, Counted, HalfPing, WarningKind, is_sound};
use super::log_format::{FileSource, LogFormat, ReadRecording, Reading};
use super::xtf::shift_to_fit;
use super::{OpenError, Opened, assemble};
use crate::support::progress::Progress;
use crate::survey::{ChannelKind, Encoding, Fix, NumberKind, RangeSource, SideSpan, Survey};
use page::{Band, Channel, FORMAT, Page};
use std::collections::BTreeMap;

const NAME: &str = "Klein SDF";
/// Bytes searched for pages where the beginning of a file is damaged.
const SEARCHED_FOR_PAGES: usize = 1 << 20;

/// Reader of the format.
pub(super) struct Klein;

impl LogFormat for Klein {
    fn recognise(&self, _files: &FileSource, opened: &Opened) -> Option<ReadRecording> {
        let opened = is_log(&opened.bytes).then(|| opened.clone())?;
        Some(Box::new(move |reading, progress| read(&opened, reading, progress)))
    }
}

/// Recognises a file by its first page, or by two pages in a row where the first is damaged.
fn is_log(bytes: &[u8]) -> bool {
    Page::at(bytes, 0).is_some() || FORMAT.next(bytes, 0, SEARCHED_FOR_PAGES).is_some()
}

/// Reads a file that [`is_log`] recognised.
///
/// # Errors
/// When the file contains no side-scan that is read, or the user cancelled the reading.
fn read(opened: &Opened, reading: &Reading<'_>, progress: &Progress) -> Result<Survey, OpenError> {
    let bytes = &opened.bytes;
    let mut log = Collected::new(&[opened], NAME, reading);
    let mut reader = Reader::new(bytes, reading);
    let tail = reading.from(0).filter(|_| reader.zero_ms.is_some());
    FORMAT.read(bytes, (0, tail), &mut log, (reading, progress), |log, page| {
        reader.take(log, page.start);
    })?;
    reader.finish(&mut log, reading.known());
    if !log.channels.is_empty() {
        return Ok(assemble::assemble(log, reading));
    }
    Err(match reader.others() {
        Some(others) => opened.unsupported(format!(
            "this SDF file holds only {others}, and no public source says which of their channels look to port; export XTF from SonarPro and open that"
        )),
        None => {
            let count = bytes.len();
            let what =
                format!("no whole page with side-scan in its {count} bytes; copy the file again");
            opened.broken(NAME, what)
        }
    })
}

/// Decodes pages and collects sides and fixes.
#[derive(Default)]
struct Reader<'a> {
    bytes: &'a [u8],
    clock: Clock<usize>,
    /// Unix milliseconds of the log's time zero; only if it is known, a tail can be read without
    /// the rest.
    zero_ms: Option<f64>,
    /// Halves by frequency (low, high) and by side (port, starboard).
    halves: [[Vec<HalfPing>; 2]; 2],
    /// Number of pages that are not read, by sonar.
    others: BTreeMap<&'static str, usize>,
}

impl<'a> Reader<'a> {
    /// Creates a reader of this file; for the tail of a log, with the log's time zero.
    fn new(bytes: &'a [u8], reading: &Reading<'_>) -> Self {
        let known = reading.known().and_then(|known| known.start_unix_s);
        Self {
            bytes,
            zero_ms: known.map(|start_unix_s| (start_unix_s * 1e3).round()),
            ..Self::default()
        }
    }

    /// Decodes the page whose marker begins at an offset.
    fn take(&mut self, log: &mut Collected, at: usize) {
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
    fn finish(&mut self, log: &mut Collected, known: Option<&Survey>) {
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
    fn others(&self) -> Option<String> {
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
            ClockVerdict::Damaged(at) => log.report.odd_time(0, at, "a page's time"),
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
