//! Writes a log, or a part of it, to a file for other programs: in a recorder's format for which
//! there is a writer, its records as CSV and Parquet, or its track as GPX.
//!
//! In: a log with its navigation. Out: a file.

mod part;
mod traces;

pub use part::{LogPartChoice, TimeBound};

use super::track::write_track_gpx;
use super::{is_same_file, track, write_atomically};
use crate::Error;
use bathyscope_log::formats::log_writer::{LogToWrite, LogWriter};
use bathyscope_log::formats::{FORMATS, writer_for};
use bathyscope_log::support::progress::Progress;
use bathyscope_log::survey::{PositionSettings, Projection, Survey, navigate_with};
use std::io::{self, BufWriter, Write as _};
use std::path::{Path, PathBuf};

/// Endings of the formats that are not those of recorders, without the dot.
const TABLES: [&str; 3] = ["csv", "parquet", "gpx"];

/// Format of a copy.
#[derive(Clone, Copy)]
pub(crate) enum CopyFormat {
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
    pub(crate) fn of(path: &Path) -> Result<Self, Error> {
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

/// The endings of all files that a log can be copied to, without the dot.
fn copy_endings() -> impl Iterator<Item = &'static str> {
    let written = FORMATS.iter().filter_map(|format| format.written_as());
    written.chain(TABLES)
}

fn endings_in_words() -> String {
    let endings: Vec<String> = copy_endings().map(|ending| format!(".{ending}")).collect();
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
