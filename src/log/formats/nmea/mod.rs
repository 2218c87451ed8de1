//! Reads NMEA 0183: logs of sentences as surveys of depths and a track, and sentences that
//! recorders write into their own logs.
//!
//! In: the bytes of a text log, or one sentence. Out: a collected log, or the content of the
//! sentence.
//!
//! A log is lines of text. A sentence begins with `$`, a talker of two letters and a type of three;
//! fields with commas between them follow, then `*` and two hexadecimal digits, the exclusive or of
//! the bytes between `$` and `*`. Text before the `$` of a line is written by the logger: a tag
//! block of NMEA 4.10 (`\s:x,c:1700000000*hh\`), or a time (`lines`). Sentences that begin with
//! `!`, such as those of AIS, are skipped.
//!
//! The reader uses (`sentence`): depths of DPT (metres below the transducer; the second field is
//! the distance up to the water line, if negative the distance down to the keel) and DBT (below the
//! transducer in feet, metres, fathoms); positions of GGA, GNS, RMC and GLL; course and speed of
//! RMC and VTG; headings of HDT and THS (true), HDG and HDM (magnetic, with deviation and variation
//! of HDG and variation of RMC); the date of RMC and ZDA. DBS counts from the water's surface and
//! is only used where there is neither DPT nor DBT, or DBS has many times as many depths
//! (`decode`). DBK counts from the keel, whose depth no sentence gives, and is skipped.
//!
//! A depth has no time of its own (`decode`). Where the logger wrote a time before each sentence,
//! this time gives the delay of a depth after the last position; otherwise depths between two
//! positions are spread evenly. Times without a date continue past midnight.
//!
//! Sources: the published descriptions of these sentences in manuals of Simrad (DPT, DBT), NOAA's
//! description of logged DPT (`scs_dpt`, which has the time before the sentence), gpsd's "NMEA
//! Revealed". The reader is compared with pynmea2 on generated logs.

mod decode;
mod lines;
mod sentence;
#[cfg(test)]
mod tests;

pub(super) use sentence::{Sentence, sentence};

use super::log_format::{FileSource, LogFormat, ReadRecording, Reading};
use super::{OpenError, Opened, assemble, collected::Collected};
use crate::support::progress::Progress;
use crate::survey::Survey;
use decode::{Reader, Tally};
use lines::Lines;

const NAME: &str = "NMEA 0183";
/// Bytes that are searched for sentences: other sentences may come first.
const SEARCHED_FOR_SENTENCES: usize = 1 << 16;
/// Fewest readable sentences with which a text counts as a log.
const FEWEST_SENTENCES: usize = 3;

/// Reader of the format.
pub(super) struct Nmea;

impl LogFormat for Nmea {
    fn recognise(&self, _files: &FileSource, opened: &Opened) -> Option<ReadRecording> {
        let opened = is_log(&opened.bytes).then(|| opened.clone())?;
        Some(Box::new(move |reading, progress| read(&opened, reading, progress)))
    }
}

/// Recognises a text by its sentences: a text contains no zero bytes, and correct checksums do not
/// occur by chance.
fn is_log(bytes: &[u8]) -> bool {
    let head = &bytes[..bytes.len().min(SEARCHED_FOR_SENTENCES)];
    if head.contains(&0) {
        return false;
    }
    let found = Lines::new(head, false);
    let read =
        found.filter(|found| found.framed().is_some_and(|framed| framed.sentence().is_some()));
    read.take(FEWEST_SENTENCES).count() == FEWEST_SENTENCES
}

/// Reads a file that [`is_log`] recognised.
///
/// # Errors
/// When the log contains no depth, or the user cancelled the reading.
fn read(opened: &Opened, reading: &Reading<'_>, progress: &Progress) -> Result<Survey, OpenError> {
    let bytes = &opened.bytes;
    let mut log = Collected::new(&[opened], NAME, reading);
    // The log is read twice: first to count its sentences, then to decode them.
    progress.start(2 * bytes.len() as u64);
    let mut tally = Tally::default();
    let lines = || Lines::new(bytes, reading.is_growing);
    lines().each(progress, |found| tally.take(&found))?;
    let Some(mut reader) = Reader::new(&tally) else {
        return Err(opened.unsupported(format!(
            "this NMEA log holds no depth in its {} bytes, only {}; have the echo sounder's sentences DPT, DBT or DBS recorded too",
            bytes.len(),
            tally.summary()
        )));
    };
    lines().each(progress, |found| reader.take(&mut log, &found))?;
    reader.finish(&mut log);
    Ok(assemble::assemble(log, reading))
}
