//! Data of a log as a reader hands them over, before they become a
//! [`Survey`](crate::survey::Survey): channels apart, in file order.

use super::log_format::Reading;
use super::report::{WarningKind, WarningReport};
use crate::support::geo::LonLat;
use crate::survey::{
    Bytes, Channel, ChannelKind, Echogram, EchogramPing, Fix, ProjectedTrack, RangeSource,
    SidePing, SideSpan, Sounding, Source, SwathPing,
};
use std::sync::Arc;

/// Depths beyond this are damage: the deepest sea is 11 km.
const DEEPEST_M: f32 = 12_000.0;
/// Ranges beyond this are damage: no side-scan sees 5 km.
const FARTHEST_M: f32 = 5_000.0;

/// Ranges shorter than this are damage: not even a bucket is a tenth of a metre deep.
const NEAREST_M: f32 = 0.1;

/// One side of one ping.
#[derive(Clone, Copy, Debug)]
pub(super) struct HalfPing {
    /// Seconds after the log's time zero.
    pub(super) time_s: f64,
    /// Its samples.
    pub(super) span: SideSpan,
}

/// A pair of side-scan channels, where a recorder has several.
#[derive(Debug)]
pub(super) struct CollectedPair {
    /// The recorder's name for it, the same whenever the log is read.
    pub(super) name: String,
    /// Frequency where it is stated.
    pub(super) frequency_khz: Option<f32>,
    /// Its port halves.
    pub(super) port: Vec<HalfPing>,
    /// Its starboard halves.
    pub(super) starboard: Vec<HalfPing>,
}

/// Properties of a ping that are counted for its channel.
#[derive(Clone, Copy, Debug)]
pub(super) struct Counted {
    /// Index of its file, and where its record ends there.
    pub(super) record: (usize, usize),
    /// Seconds after the log's time zero.
    pub(super) time_s: f64,
    /// Samples of one side.
    pub(super) samples: usize,
    /// Near and far limit, where the recorder states them.
    pub(super) range_m: Option<(f32, f32)>,
}

/// A log as read.
#[derive(Debug)]
pub(super) struct Collected {
    /// The files.
    pub(super) source: Source,
    /// Their bytes.
    pub(super) bytes: Vec<Bytes>,
    /// Unix seconds of the log's time zero.
    pub(super) start_unix_s: Option<f64>,
    /// True where the records have times; else they are assumed.
    pub(super) has_times: bool,
    /// Summary of each channel so far, under its number.
    pub(super) channels: Vec<(u16, Channel)>,
    /// Side-scan pings whose two sides came together.
    pub(super) composite: Vec<SidePing>,
    /// Port halves that came alone.
    pub(super) port: Vec<HalfPing>,
    /// Starboard halves that came alone.
    pub(super) starboard: Vec<HalfPing>,
    /// Pairs of side-scan channels in place of `port` and `starboard`, the one that is shown first.
    pub(super) pairs: Vec<CollectedPair>,
    /// Pings of channels that look down.
    pub(super) echograms: Vec<Echogram>,
    /// Depths by the channel that carried them.
    pub(super) depths: Vec<(ChannelKind, Vec<Sounding>)>,
    /// Depths across the track.
    pub(super) swath: Vec<SwathPing>,
    /// Positions.
    pub(super) fixes: Vec<Fix>,
    /// System of the positions, where they are metres of a system that the log does not name.
    pub(super) projected: Option<ProjectedTrack>,
    /// Source of the slant ranges.
    pub(super) range_source: RangeSource,
    /// Warnings about the log.
    pub(super) report: WarningReport,
    /// Records that end here or before, one entry a file, were counted when the log was shorter.
    pub(super) counted_to: Vec<u64>,
}

impl Collected {
    /// An empty log.
    pub(super) fn new(source: Source, bytes: Vec<Bytes>, reading: &Reading<'_>) -> Self {
        Self {
            source,
            bytes,
            start_unix_s: None,
            has_times: true,
            channels: Vec::new(),
            composite: Vec::new(),
            port: Vec::new(),
            starboard: Vec::new(),
            pairs: Vec::new(),
            echograms: Vec::new(),
            depths: Vec::new(),
            swath: Vec::new(),
            fixes: Vec::new(),
            projected: None,
            range_source: RangeSource::default(),
            report: WarningReport::default(),
            counted_to: reading.counted_to(),
        }
    }

    /// Counts a ping of the channel that the recorder (or the order of the files) gives this
    /// number.
    pub(super) fn count(&mut self, number: u16, ping: Counted) {
        let (file, end) = ping.record;
        if self.counted_to.get(file).is_some_and(|known| end as u64 <= *known) {
            return;
        }
        let Some((_, channel)) = self.channels.iter_mut().find(|(known, _)| *known == number)
        else {
            return;
        };
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

    /// Returns true if a channel of this number was introduced.
    pub(super) fn knows(&self, number: u16) -> bool {
        self.channels.iter().any(|(known, _)| *known == number)
    }

    /// Introduces a channel before its first ping is counted.
    pub(super) fn introduce(
        &mut self,
        number: u16,
        kind: ChannelKind,
        recorder_name: String,
        frequency_khz: Option<f32>,
    ) {
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
    }

    /// Keeps a depth if it is one: recorders write 0 where there is none.
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

    /// Keeps a ping of a channel that looks down, if it can hold a picture; says so where it
    /// cannot.
    pub(super) fn add_echogram(&mut self, kind: ChannelKind, time_s: f64, span: SideSpan) {
        let looks_down =
            matches!(kind, ChannelKind::Primary | ChannelKind::Secondary | ChannelKind::DownScan);
        if !looks_down {
            return;
        }
        if !is_sound(&span) {
            self.report_no_picture(kind, &span);
            return;
        }
        let ping = EchogramPing { time_s, span };
        match self.echograms.iter_mut().find(|one| one.kind == kind) {
            Some(echogram) => Arc::make_mut(&mut echogram.pings).push(ping),
            None => self.echograms.push(Echogram { kind, pings: Arc::new(vec![ping]) }),
        }
    }

    /// Says that a ping holds no picture.
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

    /// Keeps a fix if it is one. Channels that ping together carry the same fix: it is kept once.
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

/// Returns true if a span can hold a picture: it has samples, and a range that a sonar can have.
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
