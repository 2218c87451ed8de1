//! Reads tables of soundings as surveys: CSV files that programs and apps of fish-finders export.
//!
//! In: the bytes of a table. Out: a collected log.
//!
//! A row is a depth, with its position and time where known. Commas, semicolons or tabs separate
//! the columns (`points::text_file`), and the first line names them (`layout`): longitude and
//! latitude, or easting and northing in metres; depth, in the unit of its name; optionally time,
//! heading and course. Names and separators are those of ReefMaster's export
//! (`Latitude,Longitude,Depth`), of tables that SonarWiz and other programs write, and of the
//! project's own tracks.
//!
//! Two kinds of tables without names are recognised. One is `Bathymetry.csv` of Deeper's sonars:
//! latitude, longitude, depth in metres, Unix milliseconds and optionally the temperature, in
//! either order; latitude and longitude are 0 in rows between two positions of the phone. The other
//! has three columns, of which two can only be degrees: latitude, longitude and depth in metres.
//!
//! A table of pings that has the same name as a picture is read with it by `picture_table`.
//!
//! Rows without times are assumed to be one second apart, in the order of the file, with a warning.
//! The level from which a program counts depths is not stated; depths are assumed to be below the
//! transducer.
//!
//! Sources: Deeper's support page "Exporting raw sonar data"; ReefMaster's reference, "Exporting
//! Track Data". No real table was available.

mod decode;
mod layout;
#[cfg(test)]
mod tests;

use super::log_format::{FileSource, LogFormat, ReadRecording, Reading};
use super::points::text_file::is_comment;
use super::{OpenError, Opened, assemble, collected::Collected};
use crate::support::progress::{Cancelled, Progress};
use crate::survey::Survey;
use std::path::Path;

pub(super) use decode::{Reader, TablePing};
pub(super) use layout::{Layout, Recognised};

const NAME: &str = "CSV of soundings";
/// Bytes at the beginning of a file by which a table is recognised.
const HEAD: usize = 1 << 16;
/// Most rows by which a table is recognised.
const ROWS_OF_HEAD: usize = 50;
/// Most bytes of a line that are read.
const LONGEST_LINE: usize = 1 << 12;

/// Reader of the format.
pub(super) struct SoundingTable;

impl LogFormat for SoundingTable {
    fn recognise(&self, _files: &FileSource, opened: &Opened) -> Option<ReadRecording> {
        let has_soundings = |recognised: &Recognised| match recognised {
            Recognised::Table(layout) => layout.has_soundings(),
            Recognised::Own => true,
        };
        let recognised = sniff(&opened.bytes).filter(has_soundings)?;
        let opened = opened.clone();
        Some(Box::new(move |reading, progress| {
            match recognised {
            Recognised::Table(layout) => read(&opened, layout.without_pings(), reading, progress),
            Recognised::Own => Err(opened.unsupported(
                "this is a table that Bathyscope wrote, and no recording; open the log that it was made of",
            )),
        }
        }))
    }

    fn is_read_by_name_only(&self, _path: &Path) -> bool {
        true
    }
}

/// Recognises a table by its first rows; `None` for other files.
pub(super) fn sniff(bytes: &[u8]) -> Option<Recognised> {
    let head = &bytes[..bytes.len().min(HEAD)];
    if head.contains(&0) {
        return None;
    }
    // The last line may be truncated.
    let lines = Lines::new(head, head.len() < bytes.len());
    let texts: Vec<String> = lines.take(ROWS_OF_HEAD).map(|line| line.text).collect();
    Layout::of(&texts)
}

/// Reads a table whose layout is known.
///
/// # Errors
/// When the table contains no depth, or the user cancelled the reading.
fn read(
    opened: &Opened,
    layout: Layout,
    reading: &Reading<'_>,
    progress: &Progress,
) -> Result<Survey, OpenError> {
    let mut log = Collected::new(&[opened], NAME, reading);
    log.source.device = layout.device().to_owned();
    read_rows(&opened.bytes, &mut Reader::new(layout, 0), &mut log, reading, progress)?;
    if log.depths.is_empty() {
        let what =
            "no row of it has a depth; write one number above 0 into the column of the depth";
        return Err(opened.broken(NAME, what));
    }
    Ok(assemble::assemble(log, reading))
}

/// Reads all rows of a table into the reader and the log.
///
/// # Errors
/// When the user cancelled the reading.
pub(super) fn read_rows(
    bytes: &[u8],
    reader: &mut Reader,
    log: &mut Collected,
    reading: &Reading<'_>,
    progress: &Progress,
) -> Result<(), Cancelled> {
    progress.start(bytes.len() as u64);
    let mut lines = Lines::new(bytes, reading.is_growing);
    if reader.layout.has_header() {
        lines.next();
    }
    progress.walk(0, bytes.len(), |_| {
        let Some(line) = lines.next() else { return Ok(bytes.len()) };
        reader.take(log, &line);
        Ok(lines.at)
    })?;
    reader.finish(log);
    Ok(())
}

/// A line that is no comment and not empty.
struct Line {
    /// Offsets of the beginning and the end of the line.
    at: usize,
    end: usize,
    text: String,
}

/// Iterator over the lines of a table.
struct Lines<'a> {
    bytes: &'a [u8],
    at: usize,
    /// True if the file is still being written: a last line without an end is then left out.
    is_growing: bool,
}

impl<'a> Lines<'a> {
    fn new(bytes: &'a [u8], is_growing: bool) -> Self {
        let at = if bytes.starts_with(b"\xEF\xBB\xBF") { 3 } else { 0 };
        Self { bytes, at, is_growing }
    }
}

impl Iterator for Lines<'_> {
    type Item = Line;

    fn next(&mut self) -> Option<Line> {
        loop {
            let at = self.at;
            let rest = self.bytes.get(at..).filter(|rest| !rest.is_empty())?;
            let length = rest.iter().position(|byte| matches!(byte, b'\n' | b'\r'));
            if length.is_none() && self.is_growing {
                return None;
            }
            let end = at + length.unwrap_or(rest.len());
            self.at = end + 1;
            let text = String::from_utf8_lossy(&self.bytes[at..end.min(at + LONGEST_LINE)]);
            if !is_comment(&text) {
                let text = text.into_owned();
                return Some(Line { at, end, text });
            }
        }
    }
}
