//! Reads Garmin RSD files, which the chartplotters of the ECHOMAP, STRIKER and GPSMAP series
//! record.
//!
//! In: the bytes of a recording. Out: a collected log.
//!
//! Written from descriptions only: no real recording was at hand. The facts are taken from public
//! readers of the format that were made with real recordings: `garmin_class.py` of PINGVerter 2.1.7
//! (C. Bodine, MIT; the reader of PINGMapper) and `readers/rsd.py` of sidescantools. Problems of
//! their users that are tested here: PINGMapper issue 165 and PINGVerter issue 3 (channels without
//! a side, missing positions).
//!
//! A file consists of a header that is padded to 20 480 bytes, and records. All parts are
//! structures of numbered fields ([`varstruct`]); integers are little-endian.
//! - File header: field 0 the number 0xD9264B7C, 5 the unit (its field 2 the model, 3 the seconds
//!   since 31 December 1989 UTC at which the recording began), 6 the channels with their bands in
//!   hertz.
//! - Record: a header (field 0 the number 0xB7E9DA86, 1 the state with the channel, 2 the count of
//!   the ping, 4 the bytes of the body, 5 the milliseconds since the recording began), its
//!   checksum, the body, and a trailer of twelve bytes (0xF98EACBC, the record's length, a
//!   checksum). The first and the last records of a channel have no body.
//! - Body: fields 0 the channel, 1 the depth of the bottom, 3 and 4 the range of the first and the
//!   last sample, all three in millimetres (`decode::DepthEncoding`), 7 the count of samples, 8
//!   whether there is shade, 9 and 10 latitude and longitude in 2^32 to the circle, 11 the water's
//!   temperature, 12 the beam (1 traditional sonar, 2 side-scan to port, 3 to starboard, 4
//!   down-scan), 13 the element, whose field 5 has the tilt to port (negative) or to starboard. The
//!   samples follow, nearest first on both sides, two bytes each.
//!
//! Facts from a single source: one byte of shade a sample follows the samples (sidescantools),
//! depths may be unsigned (PINGVerter), and old units record one byte a sample (notes of another
//! public project).
//!
//! Not read: temperature (a log has no field for it), gain, shade, and checksums, which other
//! readers find wrong in sound records. The format has no course, heading or speed.

mod channels;
mod decode;
mod record;
#[cfg(test)]
mod tests;
mod varstruct;

use super::log_format::{FileSource, LogFormat, ReadRecording, Reading};
use super::scalar::u32_le;
use super::walk::Walk;
use super::{OpenError, Opened, assemble, collected::Collected};
use crate::support::progress::Progress;
use crate::survey::Survey;
use record::{RecordHeader, next_record, walk_records};
use varstruct::{VarStruct, first_item, varuint, whole_varuint};

/// Bytes of the file header with its padding.
const HEADER: usize = 20_480;
/// Bytes searched for records where none follows the header.
const SEARCHED_FOR_RECORDS: usize = 1 << 20;
const FORMAT: &str = "Garmin RSD";
/// Value of field 0 of the file header.
const MAGIC: u32 = 0xD926_4B7C;
/// Unix seconds of 31 December 1989, 0 h UTC, the start of Garmin's times.
const GARMIN_EPOCH_UNIX_S: f64 = 631_065_600.0;
/// Plausible Unix seconds of logs: from the year 2000, before which no unit recorded, to 2100. The
/// values 0 and all ones are outside.
const UNIX_S: std::ops::Range<f64> = 946_684_800.0..4_102_444_800.0;
/// Plausible frequencies of sonars, Hz.
const SONAR_HZ: std::ops::Range<u32> = 1_000..10_000_000;
/// Most channels that are read from the list in the header.
const MOST_CHANNELS: u32 = 64;

/// Reader of the format.
pub(super) struct Garmin;

impl LogFormat for Garmin {
    fn recognise(&self, _files: &FileSource, opened: &Opened) -> Option<ReadRecording> {
        let found = sniff(&opened.bytes)?;
        let opened = opened.clone();
        Some(Box::new(move |reading, progress| read(&opened, found, reading, progress)))
    }
}

/// Fields of the file header.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct FileHeader {
    /// Unix seconds of the start of the recording; `None` where missing or not plausible.
    pub(super) start_unix_s: Option<f64>,
    /// Garmin's number of the unit's model.
    pub(super) product: Option<u32>,
    /// Numbers of channels, each with the middle of its frequency band, kHz.
    pub(super) frequencies: Vec<(u32, f32)>,
}

impl FileHeader {
    /// Reads the header of a file; `None` where the file does not begin with one. Damaged fields
    /// are left empty.
    pub(super) fn read(bytes: &[u8]) -> Option<Self> {
        // The number of fields, the key of field 0 with its length of 4, and the magic number.
        if bytes.get(1) != Some(&4) || u32_le(bytes, 2) != Some(MAGIC) {
            return None;
        }
        let Some(fields) = VarStruct::read(bytes, 0) else {
            return Some(Self::default());
        };
        let file = fields.structure(5);
        let seconds = file.and_then(|file| file.unsigned(3));
        let unix_s = seconds.map(|seconds| GARMIN_EPOCH_UNIX_S + f64::from(seconds));
        Some(Self {
            start_unix_s: unix_s.filter(|unix_s| UNIX_S.contains(unix_s)),
            product: file.and_then(|file| file.unsigned(2)),
            frequencies: fields.bytes(6).map_or_else(Vec::new, frequencies),
        })
    }

    /// Returns the middle of a channel's frequency band, kHz; `None` where the header does not list
    /// it.
    pub(super) fn frequency_khz(&self, channel: u16) -> Option<f32> {
        let mut listed = self.frequencies.iter();
        let found = listed.find(|(id, _)| *id == u32::from(channel));
        found.map(|(_, khz)| *khz)
    }
}

/// Reads the frequencies in the list of channels: a count, then one structure after the other.
fn frequencies(list: &[u8]) -> Vec<(u32, f32)> {
    let Some((count, mut at)) = varuint(list, 0) else {
        return Vec::new();
    };
    let mut found = Vec::new();
    for _ in 0..count.min(MOST_CHANNELS) {
        let Some(channel) = VarStruct::read(list, at) else {
            break;
        };
        at = channel.end;
        let id = channel.bytes(0).and_then(first_item).and_then(whole_varuint);
        let band = channel.bytes(2).and_then(first_item);
        let band = band.and_then(|item| VarStruct::read(item, 0)?.structure(1));
        let middle_khz = band.and_then(|band| Some((hertz(&band, 1)?, hertz(&band, 2)?)));
        let middle_khz = middle_khz.map(|(low, high)| (low as f32 + high as f32) / 2000.0);
        found.extend(id.zip(middle_khz));
    }
    found
}

/// Reads a frequency, Hz. It is four bytes in some files and an integer of seven bits a byte in
/// others, which takes three bytes below 2 MHz.
fn hertz(band: &VarStruct<'_>, number: usize) -> Option<u32> {
    let hertz = match band.bytes(number)?.len() {
        4 => band.unsigned(number),
        _ => band.varuint(number),
    };
    hertz.filter(|hertz| SONAR_HZ.contains(hertz))
}

/// Header of a recognised file, and offset of its first record.
#[derive(Clone, Debug)]
struct RsdStart {
    header: Option<FileHeader>,
    first_record: usize,
}

/// Recognises a file by its header, or by its records where the header is damaged.
fn sniff(bytes: &[u8]) -> Option<RsdStart> {
    let header = FileHeader::read(bytes);
    let first_record = if header.is_some() && RecordHeader::read(bytes, HEADER).is_some() {
        Some(HEADER)
    } else {
        next_record(bytes, 0, SEARCHED_FOR_RECORDS)
    };
    (header.is_some() || first_record.is_some())
        .then(|| RsdStart { header, first_record: first_record.unwrap_or(HEADER.min(bytes.len())) })
}

/// Reads a file that [`sniff`] recognised; fails where it contains no ping, or the user cancelled.
fn read(
    opened: &Opened,
    found: RsdStart,
    reading: &Reading<'_>,
    progress: &Progress,
) -> Result<Survey, OpenError> {
    let bytes = &opened.bytes;
    let mut log = Collected::new(&[opened], FORMAT, reading);
    if let Some(product) = found.header.as_ref().and_then(|header| header.product) {
        log.source.device = format!("Garmin product {product}");
    }
    if found.header.is_none() {
        log.report.log(
            "the file header is damaged; the date is not known, and the records were searched",
        );
    }
    let start = match reading.from(0) {
        Some(from) => next_record(bytes, from, bytes.len()).unwrap_or(bytes.len()),
        None => found.first_record,
    };
    progress.start(bytes.len().saturating_sub(start) as u64);
    let header = found.header.unwrap_or_default();
    let mut reader = decode::Reader::new(bytes, header, found.first_record);
    let walk = Walk::new(bytes, "record", &log.report, reading, progress);
    walk_records(walk, start, |offset, record| reader.take(&mut log, offset, record))?;
    reader.finish(&mut log, reading.known());
    if log.channels.is_empty() {
        let count = bytes.len();
        let what =
            format!("no ping in its {count} bytes; copy the file from the unit's card again");
        return Err(opened.broken(FORMAT, what));
    }
    Ok(assemble::assemble(log, reading))
}
