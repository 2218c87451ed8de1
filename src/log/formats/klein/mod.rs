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

mod decode;
mod page;
#[cfg(test)]
mod tests;

use super::log_format::{FileSource, LogFormat, ReadRecording, Reading};
use super::{OpenError, Opened, assemble, collected::Collected};
use crate::support::progress::Progress;
use crate::survey::Survey;
use page::{FORMAT, Page};

const NAME: &str = "Klein SDF";
/// Bytes searched for pages where the beginning of a file is damaged.
const SEARCHED_FOR_PAGES: usize = 1 << 20;

/// Reader of the format.
pub(super) struct Klein;

impl LogFormat for Klein {
    fn recognise(&self, _files: &FileSource, opened: &Opened) -> Option<ReadRecording> {
        sniff(&opened.bytes)?;
        let opened = opened.clone();
        Some(Box::new(move |reading, progress| read(&opened, reading, progress)))
    }
}

/// Recognises a file by its first page, or by two pages in a row where the first is damaged;
/// returns the offset of the first whole page.
fn sniff(bytes: &[u8]) -> Option<usize> {
    match Page::at(bytes, 0) {
        Some(_) => Some(0),
        None => FORMAT.next(bytes, 0, SEARCHED_FOR_PAGES),
    }
}

/// Reads a file that [`sniff`] recognised.
///
/// # Errors
/// When the file contains no side-scan that is read, or the user cancelled the reading.
fn read(opened: &Opened, reading: &Reading<'_>, progress: &Progress) -> Result<Survey, OpenError> {
    let bytes = &opened.bytes;
    let mut log = Collected::new(&[opened], NAME, reading);
    let mut reader = decode::Reader::new(bytes, reading);
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
        None => opened.broken(
            NAME,
            format!(
                "no whole page with side-scan in its {} bytes; copy the file again",
                bytes.len()
            ),
        ),
    })
}
