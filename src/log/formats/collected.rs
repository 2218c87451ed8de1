//! Holds the data that a reader collects from a log, before they become a
//! [`Survey`](crate::survey::Survey): channels apart, in file order; and the warnings about the
//! log.

use super::Opened;
use super::log_format::Reading;
use crate::support::geo::LonLat;
use crate::survey::{
    Bytes, Channel, ChannelKind, Echogram, EchogramPing, Fix, ProjectedTrack, RangeSource,
    SidePing, SideSpan, Sounding, Source, SwathPing, Warning,
};
use std::cell::RefCell;
use std::rc::Rc;
use std::sync::Arc;

/// Limit of depths, metres; deeper ones are damage: the deepest sea is 11 km.
const DEEPEST_M: f32 = 12_000.0;
/// Limit of ranges, metres; longer ones are damage: no side-scan sees 5 km.
const FARTHEST_M: f32 = 5_000.0;

/// Shortest range, metres; shorter ones are damage: not even a bucket is a tenth of a metre deep.
const NEAREST_M: f32 = 0.1;
/// Most warnings of a kind that are kept: for a log with ten thousand broken frames, one more
/// sentence with their number is enough.
const KEPT_OF_A_KIND: usize = 20;

/// One side of one ping.
#[derive(Clone, Copy, Debug)]
pub(super) struct HalfPing {
    /// Seconds after the log's time zero.
    pub(super) time_s: f64,
    /// Samples of this side.
    pub(super) span: SideSpan,
}

/// A pair of side-scan channels, where a recorder has several.
#[derive(Debug)]
pub(super) struct CollectedPair {
    /// Recorder's name for the pair; it must not change when the log is read again.
    pub(super) name: String,
    /// Frequency, kHz; `None` where it is not stated.
    pub(super) frequency_khz: Option<f32>,
    /// Port halves of the pair.
    pub(super) port: Vec<HalfPing>,
    /// Starboard halves of the pair.
    pub(super) starboard: Vec<HalfPing>,
}

/// Properties of a ping that are counted for its channel.
#[derive(Clone, Copy, Debug)]
pub(super) struct Counted {
    /// Index of the file of the record, and offset of the record's end in that file.
    pub(super) record: (usize, usize),
    /// Seconds after the log's time zero.
    pub(super) time_s: f64,
    /// Number of samples of one side.
    pub(super) samples: usize,
    /// Near and far limit of the range, metres; `None` where the recorder does not state them.
    pub(super) range_m: Option<(f32, f32)>,
}

/// Data of a log as a reader collected them.
#[derive(Debug, Default)]
pub(super) struct Collected {
    /// Description of the files of the log.
    pub(super) source: Source,
    /// Bytes of the files.
    pub(super) bytes: Vec<Bytes>,
    /// Unix seconds of the log's time zero; `None` where unknown.
    pub(super) start_unix_s: Option<f64>,
    /// True if the records have times; otherwise the times are assumed.
    pub(super) has_times: bool,
    /// Summary of each channel so far, with the number of the channel.
    pub(super) channels: Vec<(u16, Channel)>,
    /// Side-scan pings whose two sides were recorded together.
    pub(super) composite: Vec<SidePing>,
    /// Port halves that were recorded separately.
    pub(super) port: Vec<HalfPing>,
    /// Starboard halves that were recorded separately.
    pub(super) starboard: Vec<HalfPing>,
    /// Pairs of side-scan channels, used instead of `port` and `starboard`; the shown pair comes
    /// first.
    pub(super) pairs: Vec<CollectedPair>,
    /// Pings of channels that look down.
    pub(super) echograms: Vec<Echogram>,
    /// Depths, by the kind of channel that recorded them.
    pub(super) depths: Vec<(ChannelKind, Vec<Sounding>)>,
    /// Depths across the track.
    pub(super) swath: Vec<SwathPing>,
    /// Fixes of the boat.
    pub(super) fixes: Vec<Fix>,
    /// Coordinate system of the positions, where they are metres of a system that the log does not
    /// name.
    pub(super) projected: Option<ProjectedTrack>,
    /// Source of the slant ranges.
    pub(super) range_source: RangeSource,
    /// Warnings about the log.
    pub(super) report: WarningReport,
    /// Offsets in bytes, one for each file: records that end there or before were already counted
    /// when the log was shorter.
    pub(super) counted_to: Vec<u64>,
}

impl Collected {
    /// Creates an empty log of these files, in the format with this name.
    pub(super) fn new(files: &[&Opened], format: &str, reading: &Reading<'_>) -> Self {
        let source = Source {
            files: files.iter().map(|file| file.path.clone()).collect(),
            format: format.to_owned(),
            device: String::new(),
            byte_count: files.iter().map(|file| file.bytes.len() as u64).sum(),
        };
        let bytes = files.iter().map(|file| file.bytes.clone()).collect();
        Self { source, bytes, has_times: true, counted_to: reading.counted_to(), ..Self::default() }
    }

    /// Counts a ping of the channel with this number, which the recorder or the order of the files
    /// gives. At its first ping, `describe` returns the kind of the channel, the recorder's name
    /// for it, and its frequency, kHz.
    pub(super) fn count(
        &mut self,
        number: u16,
        ping: Counted,
        describe: impl FnOnce() -> (ChannelKind, String, Option<f32>),
    ) {
        let known = self.channels.iter().position(|(known, _)| *known == number);
        let index = known.unwrap_or_else(|| {
            let (kind, recorder_name, frequency_khz) = describe();
            let channel = Channel {
                kind,
                recorder_name,
                frequency_khz,
                ping_count: 0,
                time_span_s: None,
                sample_count: (0, 0),
                range_m: None,
            };
            self.channels.push((number, channel));
            self.channels.len() - 1
        });
        let (file, end) = ping.record;
        if self.counted_to.get(file).is_some_and(|known| end as u64 <= *known) {
            return;
        }
        let (_, channel) = &mut self.channels[index];
        let time_s = (ping.time_s, ping.time_s);
        let samples = (ping.samples, ping.samples);
        channel.time_span_s = Some(widen(channel.time_span_s, time_s));
        channel.sample_count =
            widen(Some(channel.sample_count).filter(|_| channel.ping_count > 0), samples);
        channel.ping_count += 1;
        if let Some(range_m) = ping.range_m {
            channel.range_m = Some(widen(channel.range_m, range_m));
        }
    }

    /// Adds a depth if it is plausible: recorders write 0 where there is none.
    pub(super) fn add_depth(&mut self, kind: ChannelKind, time_s: f64, depth_m: f32) {
        if !(depth_m > 0.0 && depth_m < DEEPEST_M) {
            return;
        }
        let sounding = Sounding::new(time_s, depth_m);
        match self.depths.iter_mut().find(|(known, _)| *known == kind) {
            Some((_, soundings)) => soundings.push(sounding),
            None => self.depths.push((kind, vec![sounding])),
        }
    }

    /// Adds a ping of a channel that looks down; warns where the ping cannot be shown as a picture.
    pub(super) fn add_echogram(&mut self, kind: ChannelKind, time_s: f64, span: SideSpan) {
        if !kind.looks_down() {
            return;
        }
        if !is_sound(&span) {
            self.report_no_picture(kind, &span);
            return;
        }
        let ping = EchogramPing { time_s, span };
        match self.echograms.iter_mut().find(|echogram| echogram.kind == kind) {
            Some(echogram) => Arc::make_mut(&mut echogram.pings).push(ping),
            None => self.echograms.push(Echogram { kind, pings: Arc::new(vec![ping]) }),
        }
    }

    /// Adds a warning that a ping cannot be shown as a picture.
    pub(super) fn report_no_picture(&self, kind: ChannelKind, span: &SideSpan) {
        let text = format!(
            "a ping ({}) has {} samples over {} to {} m, which is no picture; it was dropped",
            kind.name(),
            span.count,
            span.near_m,
            span.far_m
        );
        let (file, offset) = (usize::from(span.file), span.offset as usize);
        self.report.at(WarningKind::Value, file, offset, text);
    }

    /// Adds a fix if it is on Earth. Channels that ping together repeat the same fix: it is added
    /// once.
    pub(super) fn add_fix(&mut self, fix: Fix) {
        let LonLat { lon_deg, lat_deg } = fix.position;
        let on_earth = lon_deg.abs() <= 180.0 && lat_deg.abs() < 89.0;
        let is_known = self
            .fixes
            .last()
            .is_some_and(|last| last.time_s == fix.time_s && last.position == fix.position);
        if on_earth && !is_known {
            self.fixes.push(fix);
        }
    }
}

/// Returns true if a span can be shown: it has samples, and a range that a sonar can have.
pub(super) fn is_sound(span: &SideSpan) -> bool {
    span.count > 0 && is_range(span.near_m, span.far_m)
}

/// Returns true if a sonar can have this range.
pub(super) fn is_range(near_m: f32, far_m: f32) -> bool {
    near_m >= 0.0 && far_m - near_m >= NEAREST_M && far_m < FARTHEST_M
}

fn widen<T: PartialOrd + Copy>(span: Option<(T, T)>, by: (T, T)) -> (T, T) {
    span.map_or(by, |(low, high)| {
        (if by.0 < low { by.0 } else { low }, if by.1 > high { by.1 } else { high })
    })
}

/// Kind of a warning; warnings of a kind are counted together beyond `KEPT_OF_A_KIND`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum WarningKind {
    /// Bytes between frames that belong to no frame.
    Gap,
    /// A frame that contradicts itself.
    Frame,
    /// An implausible value in a frame.
    Value,
    /// A remark about the log as a whole.
    Log,
}

impl WarningKind {
    fn plural(self) -> &'static str {
        match self {
            WarningKind::Gap => "gaps between frames",
            WarningKind::Frame => "damaged frames",
            WarningKind::Value => "impossible values",
            WarningKind::Log => "remarks",
        }
    }
}

/// Warnings about one log. Clones share the same report, so that both the walk over the bytes and
/// the decoding can add warnings.
#[derive(Clone, Debug, Default)]
pub(super) struct WarningReport {
    shared: Rc<RefCell<Collection>>,
}

#[derive(Debug, Default)]
struct Collection {
    warnings: Vec<Warning>,
    counts: Vec<(WarningKind, usize)>,
}

impl WarningReport {
    /// Adds a warning about a place: index of the file and offset in bytes.
    pub(super) fn at(
        &self,
        kind: WarningKind,
        file: usize,
        offset: usize,
        text: impl Into<String>,
    ) {
        self.add(kind, Some((file, offset as u64)), text.into());
    }

    /// Adds a warning about the whole log.
    pub(super) fn log(&self, text: impl Into<String>) {
        self.add(WarningKind::Log, None, text.into());
    }

    /// Adds a warning that the recorder's clock was set back by `seconds`, if this is above 0.
    pub(super) fn set_back(&self, seconds: f64) {
        if seconds > 0.0 {
            self.log(format!(
                "the recorder's clock was set back by {seconds:.1} s in the middle; times go on from where they were"
            ));
        }
    }

    /// Adds a warning about a record whose time is impossible; `time` names its time, as `a ping's
    /// time`.
    pub(super) fn odd_time(&self, file: usize, offset: usize, time: &str) {
        let text =
            format!("{time} fits neither neighbour; its header is damaged and it was dropped");
        self.at(WarningKind::Frame, file, offset, text);
    }

    fn add(&self, kind: WarningKind, place: Option<(usize, u64)>, text: String) {
        let Collection { warnings, counts } = &mut *self.shared.borrow_mut();
        let seen = match counts.iter_mut().find(|(known, _)| *known == kind) {
            Some((_, seen)) => {
                *seen += 1;
                *seen
            }
            None => {
                counts.push((kind, 1));
                1
            }
        };
        if seen <= KEPT_OF_A_KIND {
            warnings.push(Warning { place, text });
        }
    }

    /// Removes and returns all warnings: those about the whole log first, then the kept ones in the
    /// order of the bytes, then sentences with the number of those that were not kept.
    pub(super) fn finish(&self) -> Vec<Warning> {
        let Collection { warnings, counts } = self.shared.take();
        let mut sorted = warnings;
        sorted.sort_by_key(|warning| warning.place);
        let more =
            counts.into_iter().filter(|(_, seen)| *seen > KEPT_OF_A_KIND).map(|(kind, seen)| {
                Warning {
                    place: None,
                    text: format!(
                        "{} more {} are not listed",
                        seen - KEPT_OF_A_KIND,
                        kind.plural()
                    ),
                }
            });
        sorted.extend(more);
        sorted
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn many_of_a_kind_are_counted() {
        let report = WarningReport::default();
        for offset in 0..1000 {
            report.at(WarningKind::Gap, 0, offset, "gap");
        }
        report.log("once");
        let warnings = report.finish();
        assert_eq!(warnings.len(), KEPT_OF_A_KIND + 2);
        assert!(warnings.last().is_some_and(|last| last.text.starts_with("980 more gaps")));
    }
}
