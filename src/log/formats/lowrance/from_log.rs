//! Writes a log of any format as SL2: side-scan, channels that look down, depths and fixes.
//!
//! SL2 has one byte a sample, whole metres of Mercator and whole milliseconds (`write`).

use super::Lowrance;
use super::write::{
    COMPOSITE, Sl2Frame, Sl2Writer, WrittenFix, frequency_code, usual_frequency_khz,
};
use crate::formats::clock::UNIX_S;
use crate::formats::log_writer::{LogToWrite, LogWriter, Recorded};
use crate::support::geo::lowrance_mercator;
use crate::support::progress::Progress;
use crate::survey::{ChannelKind, Encoding, SidePing, SideSpan, Survey};
use std::f64::consts::TAU;
use std::io::{self, Write};

/// Channel numbers of separate sides, port first.
const SIDES: [u16; 2] = [3, 4];

impl LogWriter for Lowrance {
    fn write(
        &self,
        log: &LogToWrite<'_>,
        out: &mut dyn Write,
        progress: &Progress,
    ) -> io::Result<Vec<String>> {
        let survey = log.survey;
        if survey.track.projected.as_ref().is_some_and(|metres| metres.system.is_none()) {
            return Err(io::Error::other(
                "its positions are metres of a system that is not named, and SL2 holds degrees; set source.crs to its EPSG number",
            ));
        }
        let start_s = survey.start_unix_s.filter(|start_s| *start_s >= f64::from(UNIX_S.start));
        let mut frames = Frames {
            log,
            is_composite: survey.side_scan.iter().all(is_symmetric),
            after_start_s: start_s.map_or(0.0, f64::fract),
            last_place: None,
        };
        let records = log.records();
        progress.start(records.len() as u64);
        let mut writer = Sl2Writer::new(out, start_s.unwrap_or_default() as u32, None)?;
        for record in &records {
            progress.check().map_err(io::Error::other)?;
            for frame in frames.of(record) {
                writer.push(&frame)?;
            }
            progress.advance(1);
        }
        Ok(losses(survey, start_s))
    }
}

/// Lists data of the log that SL2 cannot store, in a sentence each.
fn losses(survey: &Survey, start_s: Option<f64>) -> Vec<String> {
    let mut losses = Vec::new();
    if survey.source.format.contains("SL2") || survey.source.format.contains("SL3") {
        return losses;
    }
    if !survey.track.fixes.is_empty() {
        losses.push("SL2 holds positions to a metre; they were rounded".to_owned());
    }
    let spans = survey.side_scan.iter().flat_map(|ping| [ping.port, ping.starboard]);
    if spans.flatten().any(|span| span.encoding != Encoding::U8) {
        losses
            .push("SL2 holds eight bits a sample; the levels are those that are shown".to_owned());
    }
    if start_s.is_none() && survey.start_unix_s.is_some() {
        losses.push("SL2 holds no time before the year 2000; it was left out".to_owned());
    }
    losses
}

/// Returns true if both sides begin at the boat and have the same range and number of samples, as
/// the halves of one frame must.
fn is_symmetric(ping: &SidePing) -> bool {
    let (Some(port), Some(starboard)) = (ping.port, ping.starboard) else {
        return false;
    };
    port.count == starboard.count
        && port.far_m == starboard.far_m
        && port.near_m == 0.0
        && starboard.near_m == 0.0
}

/// Converts records to frames.
struct Frames<'a> {
    log: &'a LogToWrite<'a>,
    /// True if both sides of each ping are written in one frame.
    is_composite: bool,
    /// Seconds from the start time in the file, which is in whole seconds, to the log's time zero.
    after_start_s: f64,
    last_place: Option<[i32; 2]>,
}

impl Frames<'_> {
    fn of(&mut self, record: &Recorded<'_>) -> Vec<Sl2Frame> {
        let time_s = record.time_s();
        match record {
            Recorded::Side(_, ping) if self.is_composite => {
                let far_m = ping.port.map_or(0.0, |span| f64::from(span.far_m));
                let mut bytes = self.levels(ping.port.as_ref());
                bytes.reverse();
                bytes.extend(self.levels(ping.starboard.as_ref()));
                vec![self.frame(COMPOSITE, ChannelKind::Composite, time_s, [-far_m, far_m], bytes)]
            }
            Recorded::Side(_, ping) => {
                let sides =
                    [(ping.port, ChannelKind::Port), (ping.starboard, ChannelKind::Starboard)];
                let spans = SIDES.into_iter().zip(sides);
                let spans =
                    spans.filter_map(|(channel, (span, kind))| Some((channel, span?, kind)));
                let frames =
                    spans.map(|(channel, span, kind)| self.alone(channel, kind, time_s, &span));
                frames.collect()
            }
            Recorded::Down { kind, span, .. } => {
                vec![self.alone(down_channel(*kind), *kind, time_s, span)]
            }
            // A depth is written in the frames at its time; a log without pings has separate frames
            // for depths.
            Recorded::Sounding(..) => {
                let survey = self.log.survey;
                let is_alone = survey.side_scan.is_empty() && survey.echograms.is_empty();
                let frame = is_alone.then(|| {
                    let kind = survey.sounding_channel.unwrap_or(ChannelKind::Primary);
                    self.frame(down_channel(kind), kind, time_s, [0.0; 2], Vec::new())
                });
                frame.into_iter().collect()
            }
        }
    }

    fn alone(&mut self, channel: u16, kind: ChannelKind, time_s: f64, span: &SideSpan) -> Sl2Frame {
        let range_m = [span.near_m, span.far_m].map(f64::from);
        let bytes = self.levels(Some(span));
        self.frame(channel, kind, time_s, range_m, bytes)
    }

    /// Returns the echo levels from the boat outward; none for samples outside the file.
    fn levels(&self, span: Option<&SideSpan>) -> Vec<u8> {
        let mut levels = Vec::new();
        if let Some(samples) = span.and_then(|span| self.log.survey.samples_of(span)) {
            samples.copy_outward(&mut levels);
        }
        levels
    }

    fn frame(
        &mut self,
        channel: u16,
        kind: ChannelKind,
        time_s: f64,
        range_m: [f64; 2],
        bytes: Vec<u8>,
    ) -> Sl2Frame {
        let fix = self.fix(time_s);
        let fresh = fix.mercator != [0; 2] && self.last_place != Some(fix.mercator);
        self.last_place = Some(fix.mercator);
        let depth_m = self.log.depth_m(time_s);
        let channels = &self.log.survey.channels;
        let recorded = channels.iter().find(|channel| channel.kind == kind);
        let khz = recorded.and_then(|channel| channel.frequency_khz);
        Sl2Frame {
            channel,
            frequency: frequency_code(khz.unwrap_or_else(|| usual_frequency_khz(channel))),
            range_m,
            depth_m: f64::from(depth_m).max(0.0),
            milliseconds: ((time_s + self.after_start_s) * 1e3).round() as i32,
            fix,
            fresh,
            bytes,
        }
    }

    /// Returns the fix that is valid at a time; course and speed are those of the fitted track
    /// where none were recorded.
    fn fix(&self, time_s: f64) -> WrittenFix {
        let fix = self.log.fix(time_s);
        let place = self.log.place(time_s);
        let or_fitted = |recorded: Option<f32>, fitted: Option<f64>| {
            let known = [recorded.map(f64::from), fitted];
            let mut known = known.into_iter().flatten();
            known.find(|value| value.is_finite()).unwrap_or_default()
        };
        let course_rad =
            or_fitted(fix.map(|fix| fix.cog_rad), place.map(|place| place.heading_rad));
        WrittenFix {
            mercator: fix.map_or([0; 2], |fix| {
                lowrance_mercator(fix.position).map(|metres| metres.round() as i32)
            }),
            course_rad: course_rad.rem_euclid(TAU),
            speed_mps: or_fitted(fix.map(|fix| fix.speed_mps), place.map(|place| place.speed_mps)),
            compass_rad: fix.map(|fix| f64::from(fix.compass_rad)).filter(|rad| rad.is_finite()),
        }
    }
}

fn down_channel(kind: ChannelKind) -> u16 {
    match kind {
        ChannelKind::Secondary => 1,
        ChannelKind::DownScan => 2,
        _ => 0,
    }
}
