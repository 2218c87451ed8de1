//! Reads Humminbird DAT and SON files of the 700 to 1100 series, Helix, Solix and Onix.
//!
//! In: the bytes of a recording. Out: a collected log.

pub mod dat;
mod decode;
pub mod ping;
mod recording;

use super::log_format::{FileSource, LogFormat, ReadRecording, Reading};
use super::walk::Walk;
use super::{OpenError, Opened, assemble, collected::Collected};
use crate::support::progress::{Cancelled, Progress};
use crate::survey::{RangeSource, Source, Survey};
use dat::{Dat, DatFamily};
use ping::{byte_order, walk_pings};
use recording::Recording;
use std::path::Path;

/// Reader of the format.
pub(super) struct Humminbird;

impl LogFormat for Humminbird {
    fn recognise(&self, files: &FileSource, opened: &Opened) -> Option<ReadRecording> {
        recording::sniff(files, opened).map(reader)
    }

    fn recognise_folder(&self, files: &FileSource, folder: &Path) -> Option<ReadRecording> {
        recording::find_in_folder(files, folder).map(reader)
    }

    fn is_recording(&self, files: &FileSource, folder: &Path) -> bool {
        recording::is_recording(files, folder)
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
    let mut log = collect(&recording, format, reading);
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

/// Creates an empty log of the recording's files, the DAT file first.
fn collect(recording: &Recording, format: &str, reading: &Reading<'_>) -> Collected {
    let files: Vec<&Opened> =
        recording.dat.iter().map(|(dat, _)| dat).chain(&recording.sons).collect();
    let sonar = recording.dat.as_ref().and_then(|(_, dat)| (*dat)?.sonar);
    let source = Source {
        files: files.iter().map(|file| file.path.clone()).collect(),
        format: format.to_owned(),
        device: sonar.map_or_else(String::new, |number| format!("sonar {number}")),
        byte_count: files.iter().map(|file| file.bytes.len() as u64).sum(),
    };
    Collected::new(source, files.iter().map(|file| file.bytes.clone()).collect(), reading)
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
    let mut reader = decode::Reader::new(file, name.into_owned(), dat);
    let walk = Walk {
        bytes: &opened.bytes,
        file,
        noun: "ping",
        report: &log.report.clone(),
        is_growing: reading.is_growing,
        progress,
    };
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
