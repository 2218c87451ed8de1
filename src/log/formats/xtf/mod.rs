//! Reads and writes XTF, the exchange format of survey software.
//!
//! In: the bytes of a recording. Out: a collected log.
//!
//! A file header of 1024 bytes or a multiple of that lists the channels; a sequence of packets
//! follows, which `raw` describes. A packet of type 0 is a ping: its header, then for each channel
//! a header and samples. Samples have 1, 2 or 4 bytes and may be floating point; `levels` finds one
//! scale for all of them. Many headers wrongly state that samples are signed, so the samples
//! themselves decide whether they are. Formats 1, 2, 3, 5 and 8 of samples came with revision 41;
//! before, only the bytes of a sample are stated. Weights scale the samples of EdgeTech's sonars
//! and of Kongsberg's synthetic aperture sonar, for which they are mandatory in the specification;
//! gain codes scale nothing.
//!
//! A ping states the positions of the sonar and of the ship. Isis, the program that the format
//! comes from, writes the same position for both while a layback is set, and moves it back along
//! the heading of the sonar when it uses the file; other programs write the sonar's own position.
//! `positions` distinguishes the two by the distance between the positions. Packets 42 and 107 are
//! positions, 23 and 84 headings, 3 attitude with a heading.
//!
//! `multibeam` reads the depths of a multibeam sonar in the same file, for comparison.
//!
//! Sources: Triton's "eXtended Triton Format" in its revisions 14 to 42, its header file `xtf.h` of
//! 1998, and the public readers that cite them: `pyxtf` 1.5, `libxtf`, `stdlibXtf`, MB-System
//! (`mbf_xtfr8101.h`). Differences from `pyxtf`: that reader treats all whole numbers as unsigned,
//! and reads the ten thousandths of a second in packet 107 as millionths.

mod channels;
mod decode;
mod from_log;
mod levels;
mod multibeam;
mod navigation;
mod positions;
pub mod raw;
#[cfg(test)]
mod tests;

use super::log_format::{FileSource, LogFormat, ReadRecording, Reading};
use super::walk::Walk;
use super::{OpenError, Opened, assemble, collected::Collected};
use crate::support::progress::{Cancelled, Progress};
use crate::survey::Survey;
pub(super) use levels::shift_to_fit;
pub(super) use multibeam::read_multibeam;
use raw::{FileHeader, PACKETS, record};

/// The length of the file header is a multiple of this, bytes: 1024 bytes for up to six channels.
const HEADER_BLOCK: usize = 1024;
/// Bytes searched for packets where the file header is damaged.
const SEARCHED_FOR_PACKETS: usize = 1 << 20;
/// Bytes at the beginning of a file that are read before its tail: enough for the first pings of
/// most files.
const HEAD: usize = 1 << 18;
const FORMAT: &str = "XTF";

/// Reader of the format.
pub(super) struct Xtf;

impl LogFormat for Xtf {
    fn recognise(&self, _files: &FileSource, opened: &Opened) -> Option<ReadRecording> {
        let found = sniff(&opened.bytes)?;
        let opened = opened.clone();
        Some(Box::new(move |reading, progress| read(&opened, found, reading, progress)))
    }
}

/// Header of a recognised file, and offset of its first packet.
#[derive(Clone, Copy, Debug)]
struct XtfStart {
    header: Option<FileHeader>,
    first_packet: usize,
}

/// Recognises a file by its header, or by its packets where the header is damaged.
fn sniff(bytes: &[u8]) -> Option<XtfStart> {
    let header: Option<FileHeader> = record(bytes, 0).filter(is_header);
    let header_len = header.map_or(0, |header| {
        let channels = usize::from(header.sonar_channels) + usize::from(header.bathymetry_channels);
        (256 + 128 * channels).next_multiple_of(HEADER_BLOCK)
    });
    let searched = header_len..header_len + SEARCHED_FOR_PACKETS;
    let first_packet = if header.is_some() && raw::header(bytes, header_len).is_some() {
        Some(header_len)
    } else {
        PACKETS.next(bytes, searched.start, searched.end)
    };
    (header.is_some() || first_packet.is_some()).then(|| XtfStart {
        header,
        first_packet: first_packet.unwrap_or(header_len.min(bytes.len())),
    })
}

/// Returns true if these bytes are a plausible file header. 0x7B is also an opening brace, but text
/// has other bytes in place of the small numbers of the header.
fn is_header(header: &FileHeader) -> bool {
    header.file_format == 0x7B
        && header.nav_units <= 3
        && header.sonar_channels <= 64
        && header.bathymetry_channels <= 64
        && header.sonar_channels + header.bathymetry_channels > 0
}

/// Returns the names of the sonar and of the recording program in the header.
fn device_name(header: FileHeader) -> String {
    let mut names = Vec::new();
    for name in [&header.sonar_name[..], &header.program[..]] {
        names.extend(channels::text(name).filter(|name| !names.contains(name)));
    }
    names.join(", ")
}

/// Reads a file that [`sniff`] recognised; fails where it contains no side-scan, or the user
/// cancelled.
fn read(
    opened: &Opened,
    found: XtfStart,
    reading: &Reading<'_>,
    progress: &Progress,
) -> Result<Survey, OpenError> {
    let bytes = &opened.bytes;
    let mut log = Collected::new(&[opened], FORMAT, reading);
    log.source.device = found.header.map_or_else(String::new, device_name);
    if found.header.is_none() {
        log.report
            .log("the file header is damaged; channels and units were inferred from the pings");
    }
    let tail = reading.from(0);
    let mut reader = match tail {
        Some(from) => knowing_head(bytes, &found, (from, reading.known()), progress)?,
        None => decode::Reader::new(bytes, found.header, None),
    };
    let start = (found.first_packet, tail);
    PACKETS.read(bytes, start, &mut log, (reading, progress), |log, packet| {
        reader.take(log, packet.start);
    })?;
    reader.finish(&mut log, reading.known());
    if log.channels.is_empty() && reader.others.total() > 0 {
        return Err(opened.unsupported(format!(
            "this XTF file is whole, but there is no side-scan in it, only {}; open the file that the side-scan was recorded into, or export it with the sonar channels",
            reader.others.summary()
        )));
    }
    if log.channels.is_empty() {
        let what = format!("no side-scan ping in its {} bytes; export the file again", bytes.len());
        return Err(opened.broken(FORMAT, what));
    }
    Ok(assemble::assemble(log, reading))
}

/// Returns a reader that has read the first pings of the file, which give the time zero, the origin
/// of positions in metres and the channels that are shown. Reads only bytes before `from`.
fn knowing_head<'a>(
    bytes: &'a [u8],
    found: &XtfStart,
    (from, known): (usize, Option<&Survey>),
    progress: &Progress,
) -> Result<decode::Reader<'a>, Cancelled> {
    let mut head = HEAD;
    loop {
        let end = from.min(found.first_packet.saturating_add(head));
        let mut reader = decode::Reader::new(&bytes[..end], found.header, known);
        let mut log = Collected::new(&[], FORMAT, &Reading::default());
        let reading = Reading { is_growing: true, tail: None };
        let own = Progress::new();
        let walk = Walk::new(&bytes[..end], PACKETS.noun, &log.report, &reading, &own);
        PACKETS.walk(walk, found.first_packet, |packet| reader.take(&mut log, packet.start))?;
        progress.check()?;
        if reader.knows_zero(&mut log) || end == from {
            return Ok(reader.after_head(bytes));
        }
        head *= 4;
    }
}
