//! Reads Humminbird DAT and SON files of the 700 to 1100 series, Helix, Solix and Onix.
//!
//! In: the bytes of a recording. Out: a collected log.
//!
//! A recording is `Rec00001.DAT` and, in the folder `Rec00001` beside it, `B000.SON` to `B004.SON`.

pub mod dat;
mod decode;
pub mod ping;

use super::log_format::{FileSource, LogFormat, ReadRecording, Reading};
use super::walk::Walk;
use super::{OpenError, Opened, assemble, collected::Collected};
use crate::support::progress::{Cancelled, Progress};
use crate::survey::{RangeSource, Survey};
use dat::{Dat, DatFamily};
use ping::{byte_order, walk_pings};
use std::path::{Path, PathBuf};

/// Most SON files of a recording: a survey numbers its files with a byte, and one may be a DAT.
/// Recorders write five.
const MOST_SONS: usize = 255;

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
    let mut reader = decode::Reader::new(file, name.into_owned(), dat);
    let report = log.report.clone();
    let walk = Walk { file, ..Walk::new(&opened.bytes, "ping", &report, reading, progress) };
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
        dats.retain(|child| has_extension(child, "dat"));
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
        has_extension(path, "dat")
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
    let mut dats = files.children(folder).into_iter().filter(|path| has_extension(path, "dat"));
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
        .filter(|path| has_extension(path, "son"))
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

fn has_extension(path: &Path, requested: &str) -> bool {
    path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case(requested))
}
