//! Writes a log, or a part of it, to a file for other programs: in a recorder's format for which
//! there is a writer, its records as CSV and Parquet, or its track as GPX.
//!
//! In: a log with its navigation, and the choice of its part. Out: a file.

mod traces;

use super::track::write_track_gpx;
use super::{is_same_file, track, write_atomically};
use crate::Error;
use bathyscope_bottom::calibration::PingRange;
use bathyscope_log::formats::log_writer::{LogToWrite, LogWriter};
use bathyscope_log::formats::{FORMATS, writer_for};
use bathyscope_log::support::calendar::unix_from_iso;
use bathyscope_log::support::progress::Progress;
use bathyscope_log::survey::{
    Navigation, PositionSettings, Projection, Survey, WaterArea, navigate_with,
};
use std::io::{self, BufWriter, Write as _};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::str::FromStr;

/// Endings of the formats that are not those of recorders, without the dot.
const TABLES: [&str; 3] = ["csv", "parquet", "gpx"];
const NO_DATE: &str = "the log names no date; give the time in seconds of the log";
const EMPTY: &str = "nothing of the log lies in the part that was asked for";

/// Format of a copy.
#[derive(Clone, Copy)]
enum CopyFormat {
    /// The format of a recorder.
    Recorder(&'static dyn LogWriter),
    /// A line for each trace.
    Csv,
    /// A row for each trace, with its samples.
    Parquet,
    /// The track as GPX.
    Gpx,
}

impl CopyFormat {
    /// Returns the format for the ending of a file.
    ///
    /// # Errors
    /// When there is no format for this ending.
    fn of(path: &Path) -> Result<Self, Error> {
        let ending = path.extension().unwrap_or_default();
        let is = |name: &str| ending.eq_ignore_ascii_case(name);
        match writer_for(ending) {
            Some(writer) => Ok(Self::Recorder(writer)),
            None if is("csv") => Ok(Self::Csv),
            None if is("parquet") => Ok(Self::Parquet),
            None if is("gpx") => Ok(Self::Gpx),
            None => Err(format!(
                "the ending of the file names no format that is written; end it in {}: {}",
                endings_in_words(),
                path.display()
            )
            .into()),
        }
    }
}

/// Lists the endings of all files that a log can be copied to.
fn endings_in_words() -> String {
    let written = FORMATS.iter().filter_map(|format| format.written_as());
    let endings: Vec<String> = written.chain(TABLES).map(|ending| format!(".{ending}")).collect();
    endings.join(", ")
}

/// Refuses a path without the ending of a format, or one of the log's own files, before any work.
///
/// # Errors
/// When no format has the ending of the file, or the file is one of `log_files`.
pub fn check_copy(path: &Path, log_files: &[PathBuf]) -> Result<(), Error> {
    CopyFormat::of(path)?;
    if log_files.iter().any(|file| is_same_file(file, path)) {
        let path = path.display();
        let refusal = "that is the log itself, which is never changed; name another file";
        Err(format!("{refusal}: {path}").into())
    } else {
        Ok(())
    }
}

/// Content of a copy.
#[derive(Clone, Debug, PartialEq)]
pub struct Copied {
    /// Number of side-scan pings.
    pub pings: usize,
    /// Number of recorded depths.
    pub soundings: usize,
    /// A sentence for each kind of content of the log that the format cannot hold.
    pub losses: Vec<String>,
}

impl Copied {
    /// Describes the content: `1200 side-scan pings and 300 depths`.
    pub fn summary(&self) -> String {
        let Self { pings, soundings, .. } = self;
        format!("{pings} side-scan pings and {soundings} depths")
    }
}

/// Writes a part of a log in the format for the ending of the file. The boat is placed by
/// `positions`, with the projection [`Projection::Enu`].
///
/// # Errors
/// When [`check_copy`] refuses the file, the part has no record of the log, the format cannot hold
/// the log, writing fails, or the work is cancelled.
pub fn copy_log(
    path: &Path,
    survey: &Survey,
    positions: PositionSettings<'_>,
    choice: &LogPartChoice,
    progress: &Progress,
) -> Result<Copied, Error> {
    check_copy(path, &survey.source.files)?;
    let positions = PositionSettings { projection: Projection::Enu, ..positions };
    let navigation = navigate_with(survey, positions, progress)?;
    let stretches = choice.stretches(survey, &navigation)?;
    let (survey, navigation) = survey.part(&navigation, &stretches);
    let log = LogToWrite { survey: &survey, navigation: &navigation };
    Ok(Copied {
        pings: survey.side_scan.len(),
        soundings: survey.soundings.len(),
        losses: write(path, &log, progress)?,
    })
}

fn write(path: &Path, log: &LogToWrite<'_>, progress: &Progress) -> Result<Vec<String>, Error> {
    let format = CopyFormat::of(path)?;
    let losses = write_atomically(path, |file| {
        let mut losses = Vec::new();
        let mut out = BufWriter::new(file);
        match format {
            CopyFormat::Recorder(writer) => losses = writer.write(log, &mut out, progress)?,
            CopyFormat::Parquet => {
                traces::write_parquet(log, out.get_ref().try_clone()?, progress)?
            }
            CopyFormat::Csv => traces::write_csv(log, &mut out, progress)?,
            CopyFormat::Gpx => {
                let pieces = track(log.survey, log.navigation);
                let name = log.survey.name();
                write_track_gpx(&mut out, &name, log.survey.start_unix_s, &pieces)?;
            }
        }
        out.flush()?;
        if log.survey.pairs.len() > 1 && !matches!(format, CopyFormat::Gpx) {
            losses.push("of several frequencies the side-scan that is shown was written; source.frequency_khz chooses it".to_owned());
        }
        if !log.survey.swath.is_empty() && !matches!(format, CopyFormat::Gpx) {
            losses.push("no format that is written holds depths across the track (StructureScan 3D); they were left out".to_owned());
        }
        // A copy of a log that was cut meanwhile is not valid.
        log.survey.check_files().map_err(io::Error::other)?;
        Ok(losses)
    })?;
    Ok(losses)
}

/// A moment of a log.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TimeBound {
    /// Seconds after the log's time zero.
    Log(f64),
    /// Unix seconds.
    Unix(f64),
}

impl FromStr for TimeBound {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let seconds = text.trim().parse().ok();
        let seconds = seconds.filter(|seconds: &f64| seconds.is_finite());
        let log = seconds.map(Self::Log);
        let unix = || unix_from_iso(text).map(Self::Unix);
        let refused = || {
            format!(
                "a time is written in seconds of the log, 60, or as a date with the time of day in UTC, 2024-05-01T10:00:00; got {text}"
            )
        };
        Ok(log.or_else(unix).ok_or_else(refused)?)
    }
}

impl TimeBound {
    /// Reads `FROM..TO`.
    ///
    /// # Errors
    /// When the text is not of this form.
    pub fn span(text: &str) -> Result<[Self; 2], Error> {
        let refused = || format!("a span of time is written FROM..TO; got {text}");
        let (from, to) = text.split_once("..").ok_or_else(refused)?;
        Ok([from.parse()?, to.parse()?])
    }

    /// Converts the moment to seconds after the time zero of a log.
    fn of_log(self, survey: &Survey) -> Result<f64, Error> {
        match self {
            Self::Log(time_s) => Ok(time_s),
            Self::Unix(unix_s) => Ok(unix_s - survey.start_unix_s.ok_or(NO_DATE)?),
        }
    }
}

/// Part of a log: the records that meet all choices; the whole log without any choice.
#[derive(Clone, Debug, Default)]
pub struct LogPartChoice {
    /// Range of side-scan pings, or of soundings in a log without side-scan; the end is excluded.
    pub pings: Option<PingRange>,
    /// First and last moment of the part.
    pub time: Option<[TimeBound; 2]>,
    /// Area in which the boat is on the fitted track.
    pub area: Option<WaterArea>,
}

impl LogPartChoice {
    /// Returns the stretches of records ([`Survey::part`]) that are chosen.
    ///
    /// # Errors
    /// When the log has fewer records than were requested, has no date for a given date, or no
    /// record is chosen.
    pub fn stretches(
        &self,
        survey: &Survey,
        navigation: &Navigation,
    ) -> Result<Vec<Range<usize>>, Error> {
        let times_s = survey.record_times_s();
        let count = times_s.len();
        let asked = self.pings.map_or(0..count, |pings| pings.start..pings.end);
        if asked.end > count {
            let Range { start, end } = asked;
            return Err(format!("the log has {count} pings; {start}..{end} were asked for").into());
        }
        let span_s = match self.time {
            Some([from, to]) => [from.of_log(survey)?, to.of_log(survey)?],
            None => [f64::NEG_INFINITY, f64::INFINITY],
        };
        let places =
            if !survey.side_scan.is_empty() { &navigation.pings } else { &navigation.soundings };
        let is_in_area = |record: usize| {
            self.area.as_ref().is_none_or(|area| {
                places.get(record).is_some_and(|place| {
                    area.contains(navigation.to_lon_lat(&survey.track, place.east_m, place.north_m))
                })
            })
        };
        let is_chosen = |record: &usize| {
            (span_s[0]..=span_s[1]).contains(&times_s[*record]) && is_in_area(*record)
        };
        let mut stretches: Vec<Range<usize>> = Vec::new();
        for record in asked.filter(is_chosen) {
            match stretches.last_mut() {
                Some(last) if last.end == record => last.end += 1,
                _ => stretches.push(record..record + 1),
            }
        }
        if stretches.is_empty() { Err(EMPTY.into()) } else { Ok(stretches) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bathyscope_log::support::geo::LonLat;
    use bathyscope_log::survey::{PingNav, SidePing};

    fn log() -> (Survey, Navigation) {
        let survey = Survey {
            start_unix_s: Some(1_634_000_000.0),
            ..Survey::of_pings((0..10).map(|time| SidePing::with_depth(f64::from(time), 3.0)))
        };
        let place = |east: i32| PingNav::northbound([100.0 * f64::from(east), 0.0], 1.0);
        (survey, Navigation::of_pings((0..10).map(place)))
    }

    #[test]
    fn choices_are_cut_with_each_other() {
        let (survey, navigation) = log();
        let of = |choice: LogPartChoice| {
            let stretches = choice.stretches(&survey, &navigation)?;
            let ends = stretches.into_iter().map(|stretch| [stretch.start, stretch.end]);
            Ok(ends.collect::<Vec<_>>())
        };
        assert_eq!(of(LogPartChoice::default()), Ok(vec![[0, 10]]));
        let span = TimeBound::span("2..2021-10-12T00:53:27Z").expect("a span");
        let pings = Some(PingRange { start: 1, end: 6 });
        let both = LogPartChoice { pings, time: Some(span), ..LogPartChoice::default() };
        assert_eq!(of(both.clone()), Ok(vec![[2, 6]]));
        // Two parts: from 150 m to 350 m and from 450 m on.
        let east = |metres: f64| survey.track.frame.to_lon_lat(metres, 0.0).lon_deg;
        let ring = |west: f64, east_m: f64| {
            let corners = [(west, -1.0), (east_m, -1.0), (east_m, 1.0), (west, 1.0)];
            corners.map(|(metres, lat_deg)| LonLat { lon_deg: east(metres), lat_deg }).to_vec()
        };
        let area = WaterArea {
            rings: vec![ring(150.0, 350.0), ring(450.0, 2000.0)],
            ..WaterArea::default()
        };
        let all = LogPartChoice { area: Some(area), ..both };
        assert_eq!(of(all), Ok(vec![[2, 4], [5, 6]]));
        let none = LogPartChoice {
            time: Some([TimeBound::Log(50.0), TimeBound::Log(60.0)]),
            ..LogPartChoice::default()
        };
        assert_eq!(of(none), Err(Error::from(EMPTY)));
        let beyond = LogPartChoice {
            pings: Some(PingRange { start: 1, end: 11 }),
            ..LogPartChoice::default()
        };
        let too_few = "the log has 10 pings; 1..11 were asked for";
        assert_eq!(of(beyond), Err(Error::from(too_few)));
    }

    #[test]
    fn times_that_are_none_are_refused() {
        for text in ["5", "a..b", "1..", "..", "inf..2", "2021-10-12..3"] {
            assert!(TimeBound::span(text).is_err(), "{text}");
        }
        let (mut survey, navigation) = log();
        survey.start_unix_s = None;
        let time = Some([TimeBound::Unix(0.0), TimeBound::Log(5.0)]);
        let choice = LogPartChoice { time, ..LogPartChoice::default() };
        assert_eq!(choice.stretches(&survey, &navigation), Err(Error::from(NO_DATE)));
    }
}
