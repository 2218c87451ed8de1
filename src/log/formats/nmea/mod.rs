//! NMEA 0183: logs of its sentences as surveys of depths and a track; and sentences that recorders
//! write into their own logs.
//!
//! In: the bytes of a text log, or one sentence. Out: a collected log, or what the sentence says.
//!
//! A log is lines of text. A sentence begins with `$`, a talker of two letters and a type of three;
//! fields with commas between them follow, then `*` and two hexadecimal digits, the exclusive or of
//! the bytes between `$` and `*`. What stands before the `$` of a line is the logger's: a tag block
//! of NMEA 4.10 (`\s:x,c:1700000000*hh\`), or a time (`lines`). Sentences that begin with `!`, as
//! those of AIS do, are passed over.
//!
//! Read are (`sentence`): depths of DPT (metres below the transducer; the second field is how far
//! the water line is above it, negative how far the keel is below it) and DBT (below the transducer
//! in feet, metres, fathoms); positions of GGA, GNS, RMC and GLL; course and speed of RMC and VTG;
//! headings of HDT and THS (true), HDG and HDM (magnetic, with deviation and variation of HDG and
//! variation of RMC); the date of RMC and ZDA. DBS counts from the water's surface and is taken
//! where there is neither DPT nor DBT. DBK counts from the keel, which no sentence places, and is
//! passed over.
//!
//! A depth has no time of its own (`decode`). Where the logger wrote a time before each sentence,
//! it tells how long after the last position a depth came; else depths between two positions are
//! spread evenly. Times that do not tell a date go on past midnight.
//!
//! Sources: the published descriptions of these sentences in manuals of Simrad (DPT, DBT), NOAA's
//! description of logged DPT (`scs_dpt`, which has the time before the sentence), gpsd's "NMEA
//! Revealed". The reader is compared with pynmea2 on generated logs.

mod decode;
mod lines;
mod sentence;
mod tally;
#[cfg(test)]
mod tests;

pub(super) use sentence::{Sentence, sentence};

use super::log_format::{FileSource, LogFormat, ReadRecording, Reading};
use super::{OpenError, Opened, assemble, collected::Collected};
use crate::support::progress::Progress;
use crate::survey::Survey;
use decode::Reader;
use lines::Lines;
use tally::Tally;

const NAME: &str = "NMEA 0183";
/// Bytes searched for sentences: other sentences than those that are read may come first.
const SEARCHED_FOR_SENTENCES: usize = 1 << 16;
/// Fewest sentences that are read for a text to be a log.
const FEWEST_SENTENCES: usize = 3;

/// The reader of the format.
pub(super) struct Nmea;

impl LogFormat for Nmea {
    fn recognise(&self, _files: &FileSource, opened: &Opened) -> Option<ReadRecording> {
        let opened = is_log(&opened.bytes).then(|| opened.clone())?;
        Some(Box::new(move |reading, progress| read(opened, reading, progress)))
    }
}

/// Recognises a text by its sentences: bytes of 0 are in no text, and chance makes no sum right.
fn is_log(bytes: &[u8]) -> bool {
    let head = &bytes[..bytes.len().min(SEARCHED_FOR_SENTENCES)];
    if head.contains(&0) {
        return false;
    }
    let found = Lines::new(head, false);
    let read = found.filter(|found| found.framed().is_some_and(|framed| framed.told().is_some()));
    read.take(FEWEST_SENTENCES).count() == FEWEST_SENTENCES
}

/// Reads a file that [`is_log`] recognised.
///
/// # Errors
/// When there is no depth in it, or it was cancelled.
fn read(opened: Opened, reading: &Reading<'_>, progress: &Progress) -> Result<Survey, OpenError> {
    let bytes = opened.bytes.clone();
    let mut log =
        Collected::new(opened.source(NAME.to_owned()), vec![opened.bytes.clone()], reading);
    // Once for what there is, and once for what is taken of it.
    progress.start(2 * bytes.len() as u64);
    let mut tally = Tally::default();
    let lines = || Lines::new(&bytes, reading.is_growing);
    lines().each(progress, |found| tally.take(&found))?;
    let Some(mut reader) = Reader::new(&tally) else {
        return Err(OpenError::Unsupported {
            path: opened.path,
            what: format!(
                "this NMEA log holds no depth in its {} bytes, only {}; have the echo sounder's sentences DPT, DBT or DBS recorded too",
                bytes.len(),
                tally.summary()
            ),
        });
    };
    lines().each(progress, |found| reader.take(&mut log, &found))?;
    reader.finish(&mut log);
    Ok(assemble::assemble(log, reading))
}
