//! Writes a log of any format as XTF: one pair of side-scan channels, and the sonar's altitude,
//! position, speed and heading of each ping.
//!
//! The fields are those that Triton's description calls mandatory (`raw`). Without a compass, each
//! ping has the heading of the fitted track, because other programs need it to place samples; the
//! note in the file header records this, and the reader ignores these headings ([`Provenance`]).

use super::HEADER_BLOCK;
use super::Xtf;
use super::channels;
use super::navigation::DEGREES;
use super::raw::{
    ChannelInfo, FileHeader, MAGIC, PacketHeader, PacketTime, PingChannel, PingHeader,
};
use crate::formats::log_writer::{LogToWrite, LogWriter};
use crate::support::calendar::moment;
use crate::support::geo::MPS_PER_KNOT;
use crate::support::progress::Progress;
use crate::survey::{
    ChannelKind, Encoding, Fix, ProjectedTrack, RangeSource, SampleOrder, Side, SidePing, SideSpan,
    Survey, nearest_in_time,
};
use bytemuck::Zeroable as _;
use chrono::{Datelike as _, Timelike as _};
use std::collections::BTreeMap;
use std::f32::consts::TAU;
use std::io::{self, Write};

/// Words in the note of the file header for logs without a compass.
const TRACK_HEADINGS: &str = "headings of the track";
/// Words in the note for the slant ranges of a fish-finder.
const FISH_FINDER: &str = "ranges of a fish-finder";
/// Words in the note for estimated slant ranges.
const ESTIMATED: &str = "ranges by the transducer's size";
/// Name of the program, cut to eight letters.
const PROGRAM: &[u8; 8] = b"Bathysco";
/// Packets are padded to a multiple of this number of bytes.
const PADDED_TO: usize = 64;
/// Most samples that a recorder plausibly leaves out before its first one.
const MOST_SKIPPED: f64 = 1e6;
/// Speed of sound that fish-finders use for ranges, metres a second.
const SOUND_MPS: f32 = 1500.0;

/// Properties of the pings that the header of a file written by Bathyscope states. For other files
/// the defaults apply.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Provenance {
    /// True if headings are those of the track.
    pub(super) has_track_headings: bool,
    /// Source of the slant ranges.
    pub(super) range_source: RangeSource,
    /// True if each recorded depth is the second altitude of one ping; the first altitudes repeat
    /// it.
    pub(super) has_depths_once: bool,
}

impl Provenance {
    /// Reads the properties from the note of the header.
    pub(super) fn of(header: &FileHeader) -> Self {
        let note = channels::text(&header.note).filter(|_| header.program == *PROGRAM);
        let says = |text: &str| note.as_ref().is_some_and(|note| note.contains(text));
        let sources = [(ESTIMATED, RangeSource::Estimated), (FISH_FINDER, RangeSource::FishFinder)];
        let source = sources.into_iter().find(|(text, _)| says(text));
        Self {
            has_track_headings: says(TRACK_HEADINGS),
            range_source: source.map_or(RangeSource::SurveyRecorder, |(_, source)| source),
            has_depths_once: header.program == *PROGRAM,
        }
    }
}

impl LogWriter for Xtf {
    fn write(
        &self,
        log: &LogToWrite<'_>,
        out: &mut dyn Write,
        progress: &Progress,
    ) -> io::Result<Vec<String>> {
        let survey = log.survey;
        if survey.side_scan.is_empty() {
            return Err(io::Error::other(
                "it holds no side-scan, which XTF is for; write CSV or GPX",
            ));
        }
        let writer = XtfWriter::new(log);
        out.write_all(&writer.header())?;
        progress.start(survey.side_scan.len() as u64);
        let mut packet = Vec::new();
        for (number, ping) in survey.side_scan.iter().enumerate() {
            progress.check().map_err(io::Error::other)?;
            writer.ping(number, ping, &mut packet);
            out.write_all(&packet)?;
            progress.advance(1);
        }
        Ok(losses(survey))
    }
}

/// Lists data of the log that an XTF of this kind cannot store, in a sentence each.
fn losses(survey: &Survey) -> Vec<String> {
    let mut losses = Vec::new();
    if !survey.echograms.is_empty() {
        losses.push(
            "XTF is written with the side-scan alone; channels that look down were left out"
                .to_owned(),
        );
    }
    if survey.start_unix_s.is_none() {
        losses.push("the log names no date; its pings are dated from 1 January 1970 on".to_owned());
    }
    losses
}

/// A log during writing.
struct XtfWriter<'a> {
    log: &'a LogToWrite<'a>,
    /// True if a compass was recorded.
    has_compass: bool,
    /// Bytes of a sample.
    width: usize,
    /// Recorded depths, metres, by the ping that is nearest in time.
    depths_m: BTreeMap<usize, f32>,
}

impl<'a> XtfWriter<'a> {
    fn new(log: &'a LogToWrite<'a>) -> Self {
        let survey = log.survey;
        let spans = survey.side_scan.iter().flat_map(|ping| [ping.port, ping.starboard]);
        let depths_m = survey.soundings.iter().filter_map(|sounding| {
            let ping = nearest_in_time(&survey.side_scan, sounding.time_s, |ping| ping.time_s)?;
            Some((ping, sounding.depth_m))
        });
        let is_wide = spans.flatten().any(|span| span.encoding != Encoding::U8);
        Self {
            log,
            has_compass: survey.track.fixes.iter().any(|fix| fix.compass_rad.is_finite()),
            width: if is_wide { 2 } else { 1 },
            depths_m: depths_m.collect(),
        }
    }

    /// Returns the projection of positions in metres whose coordinate system is not known; `None`
    /// otherwise.
    fn metres(&self) -> Option<&ProjectedTrack> {
        let projected = self.log.survey.track.projected.as_ref();
        projected.filter(|metres| metres.system.is_none())
    }

    /// Returns the file header with its two channels.
    fn header(&self) -> Vec<u8> {
        let mut header = FileHeader {
            file_format: 0x7B,
            system_type: 1,
            program: *PROGRAM,
            nav_units: self.metres().map_or(DEGREES, |_| 0),
            sonar_channels: 2,
            ..FileHeader::zeroed()
        };
        let source = &self.log.survey.source;
        let sonar = if source.device.is_empty() { &source.format } else { &source.device };
        put_text(&mut header.sonar_name, sonar.as_bytes());
        let ranges = match self.log.survey.range_source {
            RangeSource::FishFinder => Some(FISH_FINDER),
            RangeSource::Estimated => Some(ESTIMATED),
            RangeSource::SurveyRecorder => None,
        };
        let headings = (!self.has_compass).then_some(TRACK_HEADINGS);
        let said: Vec<&str> = ranges.into_iter().chain(headings).collect();
        put_text(&mut header.note, said.join("; ").as_bytes());
        let mut bytes = bytemuck::bytes_of(&header).to_vec();
        for side in Side::BOTH {
            bytes.extend_from_slice(bytemuck::bytes_of(&self.channel(side)));
        }
        bytes.resize(HEADER_BLOCK, 0);
        bytes
    }

    fn channel(&self, side: Side) -> ChannelInfo {
        let mut info = ChannelInfo {
            kind: 1 + side as u8,
            number: side as u8,
            correction: 1,
            unipolar: 1,
            bytes_per_sample: self.width as u16,
            volt_scale: 5.0,
            frequency_khz: self.frequency_khz(side).unwrap_or_default(),
            ..ChannelInfo::zeroed()
        };
        put_text(&mut info.name, side.name().as_bytes());
        info
    }

    fn frequency_khz(&self, side: Side) -> Option<f32> {
        let channels = self.log.survey.channels.iter();
        let mut shown = channels
            .filter(|channel| [side.into(), ChannelKind::Composite].contains(&channel.kind));
        shown.find_map(|channel| channel.frequency_khz)
    }

    /// Replaces `packet` by the packet of one ping with its sides.
    fn ping(&self, number: usize, ping: &SidePing, packet: &mut Vec<u8>) {
        packet.clear();
        packet.resize(size_of::<PingHeader>(), 0);
        let mut channels = 0;
        for side in Side::BOTH {
            let written = ping.side(side).and_then(|span| self.side(side, span, packet));
            channels += u16::from(written.is_some());
        }
        packet.resize(packet.len().next_multiple_of(PADDED_TO), 0);
        let header = PingHeader {
            packet: PacketHeader {
                magic: MAGIC,
                channels,
                size: packet.len() as u32,
                ..PacketHeader::zeroed()
            },
            ping_number: number as u32,
            sound_velocity_mps: SOUND_MPS / 2.0,
            sensor_aux_altitude_m: self.depths_m.get(&number).copied().unwrap_or_default(),
            sensor_altitude_m: if ping.depth_m > 0.0 { ping.depth_m } else { 0.0 },
            ..self.place(ping.time_s)
        };
        packet[..size_of::<PingHeader>()].copy_from_slice(bytemuck::bytes_of(&header));
    }

    /// Returns a ping header with the fields of time, position, speed and heading.
    fn place(&self, time_s: f64) -> PingHeader {
        let start_s = self.log.survey.start_unix_s.unwrap_or_default();
        let now = moment(((start_s + time_s) * 1e3).round() / 1e3 + 1e-6);
        let fix = self.log.fix(time_s);
        let [x, y] = fix.map_or([0.0; 2], |fix| self.position(fix));
        let fitted = self.log.place(time_s);
        let known = |recorded: Option<f32>, fitted: Option<f64>| {
            let mut known = [recorded, fitted.map(|value| value as f32)].into_iter().flatten();
            known.find(|value| value.is_finite()).unwrap_or_default()
        };
        let speed_kn = known(fix.map(|fix| fix.speed_mps), fitted.map(|place| place.speed_mps))
            / MPS_PER_KNOT as f32;
        let fitted_rad = fitted.map(|place| place.heading_rad);
        let compass_rad = fix.map(|fix| fix.compass_rad);
        let heading_rad = known(compass_rad, fitted_rad.filter(|_| !self.has_compass));
        let heading_deg = heading_rad.rem_euclid(TAU).to_degrees();
        PingHeader {
            time: PacketTime {
                year: now.year() as u16,
                month: now.month() as u8,
                day: now.day() as u8,
                hour: now.hour() as u8,
                minute: now.minute() as u8,
                second: now.second() as u8,
            },
            hundredths: (now.nanosecond() / 10_000_000) as u8,
            attitude_time_ms: now.num_seconds_from_midnight() * 1000 + now.nanosecond() / 1_000_000,
            ship_speed_kn: speed_kn,
            sensor_speed_kn: speed_kn,
            ship_gyro_deg: heading_deg,
            sensor_heading_deg: heading_deg,
            ship_x: x,
            ship_y: y,
            sensor_x: x,
            sensor_y: y,
            ..PingHeader::zeroed()
        }
    }

    /// Returns longitude and latitude, degrees; easting and northing where the coordinate system is
    /// not known.
    fn position(&self, fix: &Fix) -> [f64; 2] {
        match self.metres() {
            Some(metres) => {
                let [x, y] = ProjectedTrack::frame().to_enu(fix.position);
                [metres.origin_m[0] + x, metres.origin_m[1] + y]
            }
            None => [fix.position.lon_deg, fix.position.lat_deg],
        }
    }

    /// Adds the header and the samples of a side to the packet. Ranges begin at the boat in XTF:
    /// samples that a recorder left out before its first one are filled with zeros. `None` where
    /// the samples are outside the log.
    fn side(&self, side: Side, span: &SideSpan, packet: &mut Vec<u8>) -> Option<()> {
        let samples = self.log.survey.samples_of(span)?;
        let skipped = f64::from(span.near_m) / span.metres_per_sample();
        let skipped = (0.0..MOST_SKIPPED).contains(&skipped).then_some(skipped)?;
        let skipped = skipped.round() as usize;
        let count = skipped + samples.len();
        let header = PingChannel {
            channel: side as u16,
            slant_range_m: span.far_m,
            time_duration_s: 2.0 * span.far_m / SOUND_MPS,
            frequency_khz: self.frequency_khz(side).unwrap_or_default() as u16,
            samples: count as u32,
            ..PingChannel::zeroed()
        };
        packet.extend_from_slice(bytemuck::bytes_of(&header));
        for stored in 0..count {
            let outward = match channels::order(side.into()) {
                SampleOrder::FarToNear => count - 1 - stored,
                SampleOrder::NearToFar => stored,
            };
            let sample = outward.checked_sub(skipped);
            let value = sample.map_or(0, |sample| samples.wide(sample));
            packet.extend_from_slice(&value.to_le_bytes()[..self.width]);
        }
        Some(())
    }
}

fn put_text(field: &mut [u8], text: &[u8]) {
    // The last byte remains zero.
    let count = text.len().min(field.len() - 1);
    field[..count].copy_from_slice(&text[..count]);
}
