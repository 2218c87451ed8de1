//! Finds the sentences in the lines of a log, and the time that the logger wrote before each.

use super::sentence::Framed;
use crate::support::calendar::unix_from_iso;
use crate::support::progress::{Cancelled, Progress};

/// Most bytes of a sentence: the standard has 82, but some recorders write more.
const LONGEST: usize = 256;
/// Most bytes before a sentence in which the logger's time is searched.
const LONGEST_STAMP: usize = 128;
/// Plausible Unix times, 2001 to 2100, seconds.
const UNIX_S: std::ops::Range<f64> = 1e9..4_102_444_800.0;
const DAY_S: f64 = 86_400.0;

/// A sentence and its place in the log.
#[derive(Clone, Copy, Debug)]
pub(super) struct Found<'a> {
    /// Offset of the sentence's `$`.
    pub(super) at: usize,
    /// Offset of the end of the line.
    pub(super) end: usize,
    /// The sentence, and the text after it on the line.
    text: &'a [u8],
    /// Text before the sentence on the line.
    before: &'a [u8],
}

impl<'a> Found<'a> {
    /// Returns the talker, the type and the fields of the sentence; `None` where the checksum is
    /// wrong.
    pub(super) fn framed(&self) -> Option<Framed<'a>> {
        Framed::of(self.text)
    }

    /// Returns the time that the logger wrote before the sentence: Unix seconds, or seconds since
    /// midnight where there is no date; `None` without a time.
    pub(super) fn stamp_s(&self) -> Option<f64> {
        let text = self.before.get(..self.before.len().min(LONGEST_STAMP))?;
        stamp_s(std::str::from_utf8(text).ok()?)
    }
}

/// Iterates over the sentences of a text.
pub(super) struct Lines<'a> {
    bytes: &'a [u8],
    /// Offsets of the beginning and the end of the current line.
    line: (usize, usize),
    at: usize,
}

impl<'a> Lines<'a> {
    /// Creates an iterator over the sentences of a text. In a text that is still being written, an
    /// unfinished last line is left out.
    pub(super) fn new(bytes: &'a [u8], is_growing: bool) -> Self {
        let ended = bytes.iter().rposition(|byte| is_line_end(*byte));
        let length = if is_growing { ended.map_or(0, |at| at + 1) } else { bytes.len() };
        Self { bytes: &bytes[..length], line: (0, 0), at: 0 }
    }

    /// Calls `take` with every sentence.
    ///
    /// # Errors
    /// When the user cancelled the work.
    pub(super) fn each(
        mut self,
        progress: &Progress,
        mut take: impl FnMut(Found<'a>),
    ) -> Result<(), Cancelled> {
        let end = self.bytes.len();
        progress.walk(0, end, |_| {
            let Some(found) = self.next() else { return Ok(end) };
            take(found);
            Ok(self.at)
        })
    }
}

impl<'a> Iterator for Lines<'a> {
    type Item = Found<'a>;

    fn next(&mut self) -> Option<Found<'a>> {
        let at = loop {
            let rest = self.bytes.get(self.at..)?;
            let next = rest.iter().position(|byte| *byte == b'$' || is_line_end(*byte))?;
            let at = self.at + next;
            self.at = at + 1;
            match self.bytes[at] {
                b'$' => break at,
                _ => self.line.0 = at + 1,
            }
        };
        let rest = &self.bytes[at..];
        let ends = |byte: &u8| is_line_end(*byte) || *byte == b'$';
        let length = rest[1..].iter().position(ends).map_or(rest.len(), |to| to + 1);
        if self.line.1 <= at {
            let to = rest.iter().position(|byte| is_line_end(*byte));
            self.line.1 = at + to.unwrap_or(rest.len());
        }
        let before = &self.bytes[self.line.0..at];
        // The text before a second sentence on a line begins after the first sentence.
        self.line.0 = at + length;
        Some(Found { at, end: self.line.1, text: &rest[..length.min(LONGEST)], before })
    }
}

fn is_line_end(byte: u8) -> bool {
    matches!(byte, b'\n' | b'\r')
}

/// Returns the time in the text before a sentence: the time of a tag block, Unix seconds or
/// milliseconds, ISO 8601, a date of month, day and year as in NOAA's logs, or a time of day.
fn stamp_s(before: &str) -> Option<f64> {
    if let Some((_, tags)) = before.split_once('\\') {
        let tags = tags.split(['*', '\\']).next()?;
        let time = tags.split(',').find_map(|tag| tag.strip_prefix("c:"));
        return unix_s(time?);
    }
    let text = before.trim_matches(|letter: char| !letter.is_ascii_alphanumeric());
    let words = || {
        let words = text.split([',', ';', '|', ' ', '\t', '[', ']', '"']);
        words.filter(|word| !word.is_empty())
    };
    let date_and_time = || {
        let (date, time) = (words().next()?, words().nth(1)?);
        let iso = match date.split('/').collect::<Vec<_>>()[..] {
            [month, day, year] => format!("{year}-{month}-{day}T{time}"),
            _ => format!("{date}T{time}"),
        };
        unix_from_iso(&iso)
    };
    let first = words().next()?;
    unix_from_iso(first)
        .or_else(|| unix_s(first))
        .or_else(date_and_time)
        .or_else(|| words().take(2).find_map(time_of_day_s))
}

/// Converts a number of Unix seconds or milliseconds to seconds; `None` where it is not plausible.
fn unix_s(text: &str) -> Option<f64> {
    let number: f64 = text.parse().ok()?;
    let each = [number, number / 1e3].into_iter();
    each.into_iter().find(|seconds| UNIX_S.contains(seconds))
}

/// Parses a time of day as `12:34:56.7` to seconds.
fn time_of_day_s(text: &str) -> Option<f64> {
    let parts: Vec<f64> = text.split(':').map_while(|part| part.parse().ok()).collect();
    let [hours, minutes, seconds] = parts[..] else {
        return None;
    };
    let time_s = hours * 3600.0 + minutes * 60.0 + seconds;
    (text.matches(':').count() == 2 && (0.0..DAY_S).contains(&time_s)).then_some(time_s)
}

/// Returns the seconds from one time of the logger to a later one, which may be after midnight.
pub(super) fn stamps_apart_s(earlier_s: f64, later_s: f64) -> f64 {
    let apart_s = later_s - earlier_s;
    if earlier_s < DAY_S && apart_s < -DAY_S / 2.0 { apart_s + DAY_S } else { apart_s }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_loggers_time_is_found_in_what_stands_before_a_sentence() {
        // `date -u -d "2010-03-15 14:08:45" +%s`
        const S: f64 = 1_268_662_125.0;
        for (before, expected) in [
            ("", None),
            ("\\g:1-2-3,s:r01,c:1268662125*7B\\", Some(S)),
            ("\\c:1268662125000*5E\\", Some(S)),
            ("\\s:r01*00\\", None),
            ("1268662125.5,", Some(S + 0.5)),
            ("1268662125500;N;", Some(S + 0.5)),
            ("03/15/2010,14:08:45.876,", Some(S + 0.876)),
            ("2010-03-15T14:08:45.250Z ", Some(S + 0.25)),
            ("2010-03-15 14:08:45.250\t", Some(S + 0.25)),
            ("[14:08:45.5] ", Some(50_925.5)),
            ("(COM3) 14:08:45 ", Some(50_925.0)),
            ("25:08:45 ", None),
            ("nan ", None),
            ("12 ", None),
        ] {
            assert_eq!(stamp_s(before), expected, "{before}");
        }
        assert_eq!(stamps_apart_s(86_399.0, 1.0), 2.0);
        assert_eq!(stamps_apart_s(S, S - 50_000.0), -50_000.0);
    }

    #[test]
    fn sentences_are_found_wherever_they_begin() {
        let text = b"12:00:00 $GPGLL,1\r\n!AIVDM,1\n\n$GPGLL,2$GPGLL,3\n$";
        let found: Vec<Found<'_>> = Lines::new(text, false).collect();
        let starts: Vec<(usize, Option<f64>)> =
            found.iter().map(|sentence| (sentence.at, sentence.stamp_s())).collect();
        assert_eq!(starts, [(9, Some(43_200.0)), (29, None), (37, None), (46, None)]);
        assert_eq!(found[1].end, 45);
        assert_eq!(Lines::new(text, true).count(), 3);
        assert_eq!(Lines::new(b"$GPGLL", true).count(), 0);
    }
}
