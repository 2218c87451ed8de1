//! Reads Humminbird DAT and SON files of the 700 to 1100 series, Helix, Solix and Onix.
//!
//! In: the bytes of a recording. Out: a collected log.
//!
//! A recording is `Rec00001.DAT` and, in the folder `Rec00001` beside it, `B000.SON` to `B004.SON`.

pub mod dat;
pub mod ping;

use super::clock::{Clock, ClockVerdict};
use super::collected::{Collected, Counted, HalfPing, is_sound};
use super::log_format::{FileSource, LogFormat, ReadRecording, Reading, has_ending};
use super::walk::Walk;
use super::{OpenError, Opened, assemble};
use crate::support::geo::{LonLat, humminbird_mercator_inverse};
use crate::support::progress::{Cancelled, Progress};
use crate::survey::{ChannelKind, Fix, RangeSource, SideSpan, Survey};
use dat::{Dat, DatFamily, FRESH};
use ping::{PingHeader, byte_order, walk_pings};
use std::f64::consts::PI;
use std::path::{Path, PathBuf};

/// Most SON files of a recording: a survey numbers its files with a byte, and one may be a DAT.
/// Recorders write five.
const MOST_SONS: usize = 255;
/// Length of the side-scan transducer, metres, and the frequency for which the formula of other
/// readers is made, Hz.
const TRANSDUCER_M: f64 = 0.108;
const NOMINAL_HZ: f64 = 455_000.0;

/// Reader of the format.
pub(super) struct Humminbird;

impl LogFormat for Humminbird {
    fn recognise(&self, files: &FileSource, opened: &Opened) -> Option<ReadRecording> {
        sniff(files, opened).map(reader)
    }

    fn recognise_folder(&self, files: &FileSource, folder: &Path) -> Option<ReadRecording> {
        find_in_folder(files, folder).map(reader)
    }

    fn is_recording(&self, files: &FileSource, folder: &Path) -> bool {
        gather(files, folder, folder, None).is_some()
    }
}

fn reader(recording: Recording) -> ReadRecording {
    Box::new(move |reading, progress| read(recording, reading, progress))
}

/// Reads a recording; fails where it has no SON file with a whole ping, or the user cancelled.
fn read(
    recording: Recording,
    reading: &Reading<'_>,
    progress: &Progress,
) -> Result<Survey, OpenError> {
    let dat = recording.dat.as_ref().and_then(|(_, dat)| *dat);
    let format = format_name(dat);
    if recording.sons.is_empty() {
        return Err(OpenError::Broken {
            path: recording.opened,
            format: format.to_owned(),
            what: "no B00n.SON file with pings lies in the folder of the same name; copy that folder from the card too".into(),
        });
    }
    // The DAT file comes first.
    let files: Vec<&Opened> =
        recording.dat.iter().map(|(dat, _)| dat).chain(&recording.sons).collect();
    let mut log = Collected::new(&files, format, reading);
    if let Some(number) = dat.and_then(|dat| dat.sonar) {
        log.source.device = format!("sonar {number}");
    }
    log.start_unix_s = dat.and_then(|dat| dat.start_unix_s).map(f64::from);
    progress.start(recording.sons.iter().map(|son| son.bytes.len() as u64).sum());
    let first_son = log.bytes.len() - recording.sons.len();
    for (index, opened) in recording.sons.iter().enumerate() {
        read_son(opened, first_son + index, dat, &mut log, reading, progress)?;
    }
    if log.channels.is_empty() {
        return Err(OpenError::Broken {
            path: recording.opened,
            format: format.to_owned(),
            what: "its SON files hold no whole ping; copy them from the card again".into(),
        });
    }
    remark(&recording, &mut log);
    Ok(assemble::assemble(log, reading))
}

fn read_son(
    opened: &Opened,
    file: usize,
    dat: Option<Dat>,
    log: &mut Collected,
    reading: &Reading<'_>,
    progress: &Progress,
) -> Result<(), Cancelled> {
    let Some(order) = byte_order(&opened.bytes) else {
        return Ok(());
    };
    let name = opened.path.file_stem().unwrap_or_default().to_string_lossy();
    let mut reader = Reader::new(file, name.into_owned(), dat);
    let walk = Walk { file, ..Walk::new(&opened.bytes, "ping", &log.report, reading, progress) };
    walk_pings(walk, order, reading.from(file), |offset, ping| reader.take(log, offset, ping))?;
    reader.finish(log);
    Ok(())
}

fn remark(recording: &Recording, log: &mut Collected) {
    if recording.others > 0 {
        log.report.log(format!(
            "the folder holds other recordings ({}); open their DAT files one by one",
            recording.others
        ));
    }
    let unknown = "the start time is unknown and fresh water is assumed";
    match &recording.dat {
        None => log.report.log(format!("the DAT file is missing: {unknown}")),
        Some((_, None)) => log.report.log(format!("the DAT file is damaged: {unknown}")),
        Some((_, Some(dat))) => {
            let counts = log.channels.iter().map(|(_, channel)| channel.ping_count);
            let pings: usize = counts.sum();
            if pings < dat.record_count as usize {
                log.report.log(format!(
                    "the DAT file counts {} pings in all channels; {pings} were read",
                    dat.record_count
                ));
            }
        }
    }
    log.range_source = RangeSource::Estimated;
    log.report.log(
        "the recorder does not store the side-scan range; it is estimated from the transducer's size and may be off by some percent until calibrated",
    );
}

fn format_name(dat: Option<Dat>) -> &'static str {
    match dat.map(|dat| dat.family) {
        Some(DatFamily::Solix) => "Humminbird Solix",
        Some(DatFamily::Onix) => "Humminbird Onix",
        _ => "Humminbird",
    }
}

/// The files of a recording.
#[derive(Debug)]
struct Recording {
    /// Path that the user opened.
    opened: PathBuf,
    /// The DAT file, if any, with its content; the content is `None` where the file is damaged.
    dat: Option<(Opened, Option<Dat>)>,
    /// The SON files that contain pings.
    sons: Vec<Opened>,
    /// Number of other recordings in the opened folder.
    others: usize,
}

/// Recognises a DAT or a SON file by its content, and a damaged DAT by the SON files beside it.
fn sniff(files: &FileSource, opened: &Opened) -> Option<Recording> {
    if byte_order(&opened.bytes).is_some() {
        Some(around_son(files, opened))
    } else {
        around_dat(files, opened)
    }
}

/// Returns the recording that a SON file belongs to; at least the file alone.
fn around_son(files: &FileSource, opened: &Opened) -> Recording {
    let path = &opened.path;
    let whole = path.parent().and_then(|folder| gather(files, path, folder, dat_of(files, folder)));
    whole.filter(|recording| recording.sons.iter().any(|son| son.path == *path)).unwrap_or_else(
        || Recording { opened: path.clone(), dat: None, sons: vec![opened.clone()], others: 0 },
    )
}

/// Returns the recording that a DAT file belongs to; its folder of SON files may be missing. `None`
/// where the file is no DAT and has no SON files.
fn around_dat(files: &FileSource, opened: &Opened) -> Option<Recording> {
    let path = &opened.path;
    let folder = path.with_extension("");
    let gathered =
        (folder != *path).then(|| gather(files, path, &folder, Some(path.clone()))).flatten();
    let beside = || {
        let folder = path.parent()?;
        let alone = only_dat(files, folder).is_some_and(|dat| dat == *path);
        alone.then(|| gather(files, path, folder, Some(path.clone())))?
    };
    gathered.or_else(beside).or_else(|| {
        let dat = Dat::parse(&opened.bytes)?;
        Some(Recording {
            opened: path.clone(),
            dat: Some((opened.clone(), Some(dat))),
            sons: Vec::new(),
            others: 0,
        })
    })
}

/// Returns the recording in a folder: the SON files of the folder, or those of the first DAT in it.
fn find_in_folder(files: &FileSource, folder: &Path) -> Option<Recording> {
    gather(files, folder, folder, dat_of(files, folder)).or_else(|| {
        let mut dats = files.children(folder);
        dats.retain(|child| has_ending(child, "dat"));
        let others = dats.len().saturating_sub(1);
        let first = dats
            .into_iter()
            .find_map(|dat| gather(files, folder, &dat.with_extension(""), Some(dat)))?;
        Some(Recording { others, ..first })
    })
}

/// Returns the DAT of a folder of SON files: the DAT beside the folder with its name, else the only
/// DAT in the folder (as in copies of a recording without its folder, for example in the PyHum
/// package).
fn dat_of(files: &FileSource, folder: &Path) -> Option<PathBuf> {
    let is_named = |path: &PathBuf| {
        has_ending(path, "dat")
            && path
                .file_stem()
                .zip(folder.file_name())
                .is_some_and(|(stem, name)| stem.eq_ignore_ascii_case(name))
    };
    let around = folder.parent().map(|parent| files.children(parent)).unwrap_or_default();
    around.into_iter().find(is_named).or_else(|| only_dat(files, folder))
}

/// Returns the DAT in a folder if there is only one.
fn only_dat(files: &FileSource, folder: &Path) -> Option<PathBuf> {
    let mut dats = files.children(folder).into_iter().filter(|path| has_ending(path, "dat"));
    dats.next().filter(|_| dats.next().is_none())
}

/// Collects the SON files in `folder` that contain pings, and a DAT; `None` without such a SON
/// file.
fn gather(
    files: &FileSource,
    opened: &Path,
    folder: &Path,
    dat: Option<PathBuf>,
) -> Option<Recording> {
    let read = |path: PathBuf| {
        let bytes = files.read(&path).ok()?;
        Some(Opened { path, bytes })
    };
    let sons: Vec<Opened> = files
        .children(folder)
        .into_iter()
        .filter(|path| has_ending(path, "son"))
        .filter_map(read)
        .filter(|son| byte_order(&son.bytes).is_some())
        .take(MOST_SONS)
        .collect();
    if sons.is_empty() {
        return None;
    }
    let dat = dat.and_then(read).map(|dat| {
        let content = Dat::parse(&dat.bytes);
        (dat, content)
    });
    Some(Recording { opened: opened.to_owned(), dat, sons, others: 0 })
}

/// Decodes the pings of one SON file.
struct Reader {
    file: usize,
    name: String,
    sample_m: f64,
    clock: Clock<(usize, PingHeader)>,
}

impl Reader {
    /// Creates a reader of the file with this index; `name` (`B002`) gives the beam where a ping
    /// does not.
    fn new(file: usize, name: String, dat: Option<Dat>) -> Self {
        Self {
            file,
            name,
            sample_m: sample_m(dat.and_then(|dat| dat.salinity()).unwrap_or(FRESH)),
            clock: Clock::default(),
        }
    }

    /// Decodes the next ping of the file.
    fn take(&mut self, log: &mut Collected, offset: usize, ping: PingHeader) {
        if let Some(verdict) = self.clock.push(time_s(&ping), (offset, ping)) {
            self.settle(log, verdict);
        }
    }

    /// Processes the pings that still wait for a verdict of the clock.
    fn finish(&mut self, log: &mut Collected) {
        while let Some(verdict) = self.clock.next() {
            self.settle(log, verdict);
        }
        log.report.set_back(self.clock.set_back_s);
    }

    fn settle(&self, log: &mut Collected, verdict: ClockVerdict<(usize, PingHeader)>) {
        match verdict {
            ClockVerdict::Sound { record: (offset, ping), time_s } => {
                self.keep(log, offset, &ping, time_s)
            }
            ClockVerdict::Damaged((offset, ping)) => {
                let time = format!("a ping's time ({:.1} s)", time_s(&ping));
                log.report.odd_time(self.file, offset, &time);
            }
        }
    }

    fn keep(&self, log: &mut Collected, offset: usize, ping: &PingHeader, time_s: f64) {
        let kind = self.channel_kind(ping);
        let span = self.span(offset, ping);
        let is_side = kind.side().is_some();
        let number = self.file as u16;
        let counted = Counted {
            record: (self.file, offset + ping.size()),
            time_s,
            samples: ping.sample_count as usize,
            range_m: is_side.then_some((span.near_m, span.far_m)),
        };
        log.count(number, counted, || {
            let frequency_khz = (ping.frequency_hz > 0).then(|| ping.frequency_hz as f32 / 1000.0);
            (kind, self.name.clone(), frequency_khz)
        });
        log.add_depth(kind, time_s, ping.depth_dm as f32 / 10.0);
        if ping.easting_m != 0 && ping.northing_m != 0 {
            log.add_fix(fix(ping, time_s));
        }
        log.add_echogram(kind, time_s, span);
        if is_side && !is_sound(&span) {
            log.report_no_picture(kind, &span);
        } else if is_side {
            let half = HalfPing { time_s, span };
            match kind {
                ChannelKind::Port => log.port.push(half),
                _ => log.starboard.push(half),
            }
        }
    }

    fn channel_kind(&self, ping: &PingHeader) -> ChannelKind {
        let by_name = || self.name.strip_prefix("B00").and_then(|digit| digit.parse().ok());
        match ping.beam.or_else(by_name) {
            // The high frequency is the one that is used for the bottom lock and for most displays.
            Some(0) => ChannelKind::Secondary,
            Some(1) => ChannelKind::Primary,
            Some(2) => ChannelKind::Port,
            Some(3) => ChannelKind::Starboard,
            Some(4) => ChannelKind::DownScan,
            beam => ChannelKind::Other(beam.map_or(u16::MAX, u16::from)),
        }
    }

    fn span(&self, offset: usize, ping: &PingHeader) -> SideSpan {
        let far_m = (f64::from(ping.sample_count) * self.sample_m) as f32;
        SideSpan {
            file: self.file as u8,
            offset: (offset + ping.header_len) as u64,
            ..SideSpan::of_bytes(ping.sample_count, [0.0, far_m])
        }
    }
}

/// Returns the slant range that one sample covers, metres. The file does not state it; as in PyHum
/// and PING-Mapper, it is computed from the transducer's beam width at 455 kHz and the speed of
/// sound at 10 degrees Celsius (Medwin's simplified formula): `2/pi asin(c / (L f))`; 0.01877 m in
/// fresh water.
fn sample_m(salinity: f64) -> f64 {
    let t = 1.0_f64;
    let sound_mps = 1449.05 + 45.7 * t - 5.21 * t.powi(2)
        + 0.23 * t.powi(3)
        + (1.333 - 0.126 * t + 0.009 * t.powi(2)) * (salinity - 35.0);
    2.0 / PI * (sound_mps / (TRANSDUCER_M * NOMINAL_HZ)).asin()
}

fn fix(ping: &PingHeader, time_s: f64) -> Fix {
    Fix {
        // Without a heading sensor this is the course from GPS, and the file does not state whether
        // there is a sensor.
        cog_rad: if ping.heading_quality > 0 && ping.heading_decideg < 3600 {
            (f32::from(ping.heading_decideg) / 10.0).to_radians()
        } else {
            f32::NAN
        },
        speed_mps: if ping.speed_quality > 0 {
            f32::from(ping.speed_dmps) / 10.0
        } else {
            f32::NAN
        },
        ..Fix::at(time_s, lon_lat(ping.easting_m, ping.northing_m))
    }
}

fn lon_lat(easting_m: i32, northing_m: i32) -> LonLat {
    humminbird_mercator_inverse(f64::from(easting_m), f64::from(northing_m))
}

fn time_s(ping: &PingHeader) -> f64 {
    f64::from(ping.time_ms) / 1000.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scale_and_position_match_the_peers() {
        assert!((sample_m(FRESH) - 0.01877).abs() < 1e-5);
        // The start of the survey by its own notes: 36.877 N, 111.516 W.
        let start = lon_lat(-12_414_199, 4_396_652);
        assert!((start.lat_deg - 36.877).abs() < 0.003, "{start:?}");
        assert!((start.lon_deg + 111.516).abs() < 0.003, "{start:?}");
    }
}
