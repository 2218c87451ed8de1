//! Reads files as a [`Survey`]: logs of every supported recorder, recognised by content, and the
//! files of other instruments and programs.
//!
//! In: files of recorders, instruments and other programs. Out: surveys, tracks, water levels,
//! areas, points and rasters; and the bytes of the formats that are also written.
//!
//! To add a format of recorders' logs:
//! 1. Create a folder here, whose `mod.rs` names the sources of the facts in its comment; add its
//!    `mod` line below.
//! 2. Implement [`log_format::LogFormat`] there: `recognise` by content, and read into a
//!    `Collected`; `nmea` is an example of text, `xtf` of records. Samples stay in the file; where
//!    they have to be unpacked, as in `picture_table`, the log cannot be followed.
//! 3. Add its row to [`table::FORMATS`], at its place in the order of recognition, with an ending
//!    that no other row has. A format that is also written implements [`log_writer::LogWriter`];
//!    the row names its ending. Formats are also named by the lists of fuzzed inputs in
//!    `tests/fuzz` and by the installer in `assets/packaging/windows`, which tests compare, and by
//!    the lists in `src/log/README.md`, `src/log/lib.rs` and below.
//! 4. Write its test in its folder or in `src/log/tests/suite/formats`, with a small writer of the
//!    format in `tests/support`: whole, truncated, damaged.
//! 5. Run the tests: they print the table for README.md and the line for the flow of archives.
//!    Remove its row from `KNOWN` in `table`, if it has one.
//!
//! `lowrance`, `garmin`, `xtf`, `edgetech`, `cerulean`, `klein`, `nmea`, `picture_table`,
//! `sounding_table` and `humminbird` read the records of their format, skip or repair damaged parts
//! and convert the values to SI units. All of them fill one `collected` log, with its warnings;
//! `clock` recognises damaged times. `log_format` defines the trait of a reader, its source of
//! files and the part of a log to read: the tail of a growing log is read like a separate log.
//! `assemble` builds the survey from the collected log: it pairs the sides and chooses the
//! soundings. `log_folders` finds the folders of a card that contain logs, `walk` walks over the
//! records of a log, `nmea` reads logs of sentences and sentences in other logs, `growing_log`
//! copies a growing log while it is written, `table` lists the formats that are read and recognises
//! some that are not. `instrument_files` reads the track of another receiver and water levels,
//! `area_file` a polygon of water, [`open_reference`] the file that a survey is compared with,
//! `points` and `geotiff` depths of other programs; `points` and `geotiff` also write such files,
//! as `parquet_table` writes tables of columns.

mod area_file;
mod assemble;
pub mod base_map;
mod cerulean;
mod clock;
mod collected;
mod edgetech;
mod garmin;
pub mod geotiff;
mod gpx;
mod growing_log;
pub mod humminbird;
mod instrument_files;
mod klein;
mod log_folders;
mod log_format;
pub mod log_writer;
pub mod lowrance;
mod nmea;
pub mod parquet_table;
mod picture_table;
pub mod points;
mod scalar;
mod sounding_table;
mod table;
#[cfg(test)]
mod test_logs;
mod walk;
pub mod xtf;

pub use area_file::read_area;
pub use growing_log::{GrowingError, GrowingLog};
pub use instrument_files::{TrackFile, read_gauge};
pub use log_folders::{FoundLog, LogFolder, log_folders};
pub(crate) use scalar::ByteOrder;
pub use table::{
    FORMATS, FileRole, FormatEntry, endings_to_show, formats_to_open, role_by_name, writer_for,
};

use crate::support::file_error::FileError;
use crate::support::mapped_file::FileFault;
use crate::support::progress::Progress;
use crate::survey::{Bytes, Seam, Survey};
use log_format::{FileSource, Reading};
use points::{Elevations, is_named_as_elevations, read_elevations};
use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use xtf::read_multibeam;

#[cfg(target_endian = "big")]
compile_error!("the raw records of the readers are laid over little-endian bytes");

/// Most names that an error message lists.
const MOST_NAMES: usize = 8;
/// Suffix that is added to the name of an XTF file to select its multibeam depths.
const MULTIBEAM: &str = ":multibeam";

/// Reason why a log cannot be opened. Each sentence states the fault, its place, and what to do.
#[derive(Debug, thiserror::Error)]
pub enum OpenError {
    /// The file cannot be read at all.
    #[error("cannot read `{path}`: {source}")]
    Io {
        /// Path of the file.
        path: PathBuf,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// No reader recognises the content.
    #[error("not a sonar log that Bathyscope knows ({looked_for}): {path}")]
    NotRecognised {
        /// Path of the file.
        path: PathBuf,
        /// The formats that were tried, for the user.
        looked_for: &'static str,
    },
    /// The path is a folder with several logs.
    #[error("this is a folder of {} logs; name one of them: {}: {path}", .logs.len(), some(.logs))]
    Folder {
        /// Path of the folder.
        path: PathBuf,
        /// Names of the logs in the folder.
        logs: Vec<String>,
    },
    /// The format is recognised, but nothing in the file can be used.
    #[error("{format} log is damaged: {what}: {path}")]
    Broken {
        /// Path of the file.
        path: PathBuf,
        /// Name of the recognised format.
        format: String,
        /// Fault, its place, and what to do.
        what: String,
    },
    /// The format is recognised, but the file cannot be used, for example because it contains no
    /// side-scan.
    #[error("{what}: {path}")]
    Unsupported {
        /// Path of the file.
        path: PathBuf,
        /// Advice on what to record or open instead.
        what: String,
    },
    /// A file changed while it was read.
    #[error(transparent)]
    Changed(#[from] FileError<FileFault>),
    /// A file of points cannot be read.
    #[error(transparent)]
    Points(#[from] FileError),
    /// The user cancelled the opening.
    #[error(transparent)]
    Cancelled(#[from] crate::support::progress::Cancelled),
}

/// A file with its bytes.
#[derive(Clone, Debug)]
struct Opened {
    path: PathBuf,
    bytes: Bytes,
}

impl Opened {
    /// Returns the error of a file that cannot be used, with advice on what to do instead.
    fn unsupported(&self, what: impl Into<String>) -> OpenError {
        OpenError::Unsupported { path: self.path.clone(), what: what.into() }
    }

    /// Returns the error of a file of this format in which nothing can be used.
    fn broken(&self, format: &str, what: impl Into<String>) -> OpenError {
        let (path, format) = (self.path.clone(), format.to_owned());
        OpenError::Broken { path, format, what: what.into() }
    }
}

/// Opens a log of any supported format, which may be a file or the folder of a recording of several
/// files; README.md lists the formats. The files are only ever read.
///
/// # Errors
/// When the files cannot be read, are no log that can be used, or change meanwhile, or when the
/// user cancelled; the error names the file.
pub fn open(path: &Path, progress: &Progress) -> Result<Survey, OpenError> {
    open_on(&FileSource::Disk, path, &Reading::default(), progress)
}

/// Reads a log that is already in memory (the bundled demo survey, a simulated log, a test). `name`
/// is used as the file name in messages.
///
/// # Errors
/// When the bytes are no log that can be used, or the user cancelled; the error names the file.
pub fn open_bytes(name: &str, bytes: Vec<u8>, progress: &Progress) -> Result<Survey, OpenError> {
    open_files(vec![(PathBuf::from(name), bytes)], progress)
}

/// Reads a log of several files in memory, such as a Humminbird recording; the first is the file to
/// open.
///
/// # Errors
/// When the files are no log that can be used, or the user cancelled; the error names the file.
pub fn open_files(
    files: Vec<(PathBuf, Vec<u8>)>,
    progress: &Progress,
) -> Result<Survey, OpenError> {
    open_at_hand(held(files), progress)
}

/// Reads files in memory as the format with this ending only, for the fuzzer; `None` where no
/// format has the ending or the files are not recognised as this format.
pub fn open_as_format(
    ending: &str,
    files: Vec<(PathBuf, Vec<u8>)>,
    progress: &Progress,
) -> Option<Result<Survey, OpenError>> {
    let path = first_path(&files);
    let files = FileSource::Held(held(files));
    let is_of = |format: &&FormatEntry| format.endings.iter().any(|(known, _)| *known == ending);
    let format = FORMATS.iter().find(is_of)?;
    let bytes = files.read(&path).ok()?;
    let read = format.reader.recognise(&files, &Opened { path, bytes })?;
    Some(read(&Reading::default(), progress))
}

/// Returns files in memory that share their bytes.
fn held(files: Vec<(PathBuf, Vec<u8>)>) -> Vec<(PathBuf, Bytes)> {
    let hold = |(path, bytes)| (path, Bytes::Held(Arc::new(bytes)));
    files.into_iter().map(hold).collect()
}

/// Returns the path of the first file, which is the file to open; empty where there is none.
fn first_path<T>(files: &[(PathBuf, T)]) -> PathBuf {
    files.first().map_or_else(PathBuf::new, |(path, _)| path.clone())
}

/// Reads a log that is being written; the first file is the file to open. A truncated end of a file
/// is no damage: the rest will be added later.
///
/// # Errors
/// When the files are no log that can be used, or the user cancelled; the error names the file.
pub fn open_growing(
    files: Vec<(PathBuf, Bytes)>,
    progress: &Progress,
) -> Result<Survey, OpenError> {
    let reading = Reading { is_growing: true, tail: None };
    open_as(files, &reading, progress)
}

/// Reads a log whose bytes are already available; the first file is the file to open.
///
/// # Errors
/// When the files are no log that can be used, or the user cancelled; the error names the file.
pub fn open_at_hand(
    files: Vec<(PathBuf, Bytes)>,
    progress: &Progress,
) -> Result<Survey, OpenError> {
    open_as(files, &Reading::default(), progress)
}

/// Reads the bytes that were added to the files of a log since it was read, and some bytes before,
/// as a separate log, for [`Survey::extended`]. `files` are the files of
/// [`crate::survey::Source::files`], which have become longer.
///
/// # Errors
/// When the files are no longer a log that can be used, or the user cancelled; the error names the
/// file.
pub fn open_tail(
    known: &Survey,
    seam: &Seam,
    files: Vec<(PathBuf, Bytes)>,
    progress: &Progress,
) -> Result<Survey, OpenError> {
    let reading = Reading { is_growing: true, tail: Some((known, seam)) };
    open_as(files, &reading, progress)
}

fn open_as(
    files: Vec<(PathBuf, Bytes)>,
    reading: &Reading<'_>,
    progress: &Progress,
) -> Result<Survey, OpenError> {
    let path = first_path(&files);
    open_on(&FileSource::Held(files), &path, reading, progress)
}

fn open_on(
    files: &FileSource,
    path: &Path,
    reading: &Reading<'_>,
    progress: &Progress,
) -> Result<Survey, OpenError> {
    progress.check()?;
    if files.is_folder(path) {
        return open_folder(files, path, reading, progress);
    }
    let bytes =
        files.read(path).map_err(|source| OpenError::Io { path: path.to_owned(), source })?;
    let opened = Opened { path: path.to_owned(), bytes: bytes.clone() };
    let read = read_by_content(files, opened, reading, progress);
    // A file that was shortened during reading looks like a damaged log, or like no log at all.
    if let (Err(_), Some(fault)) = (&read, bytes.fault(path)) {
        return Err(FileError::new(fault, path).into());
    }
    let survey = read?;
    survey.check_files()?;
    Ok(survey)
}

fn open_folder(
    files: &FileSource,
    folder: &Path,
    reading: &Reading<'_>,
    progress: &Progress,
) -> Result<Survey, OpenError> {
    let mut formats = FORMATS.iter();
    if let Some(read) = formats.find_map(|format| format.reader.recognise_folder(files, folder)) {
        return read(reading, progress);
    }
    match logs_on(files, folder).as_slice() {
        [] => Err(not_recognised(folder, table::looked_for_in_folder())),
        [log] => open_on(files, log, reading, progress),
        logs => {
            let name = |log: &PathBuf| {
                let name = log.file_name().unwrap_or(log.as_os_str());
                name.to_string_lossy().into_owned()
            };
            Err(OpenError::Folder {
                path: folder.to_owned(),
                logs: logs.iter().map(name).collect(),
            })
        }
    }
}

/// Returns the logs in a folder, sorted by name, each of which is opened separately. The folder
/// itself where it is one recording; empty where the path is no folder.
pub fn logs_in(folder: &Path) -> Vec<PathBuf> {
    if folder.is_dir() { logs_on(&FileSource::Disk, folder) } else { Vec::new() }
}

/// Returns the files in a folder of logs that have the name of a log but cannot be opened as one,
/// for example from a broken card or an aborted recording.
pub fn unusable_in(folder: &Path) -> Vec<PathBuf> {
    let logs = logs_in(folder);
    if !folder.is_dir() || logs == [folder] {
        return Vec::new();
    }
    let is_named_so = |path: &PathBuf| path.is_file() && role_by_name(path) == Some(FileRole::Log);
    let mut unusable = FileSource::Disk.children(folder);
    unusable.retain(|path| is_named_so(path) && !logs.contains(path));
    unusable
}

fn logs_on(files: &FileSource, folder: &Path) -> Vec<PathBuf> {
    let mut formats = FORMATS.iter();
    if formats.any(|format| format.reader.is_recording(files, folder)) {
        return vec![folder.to_owned()];
    }
    let is_log = |path: &PathBuf| {
        // A named pipe could block the reader, so it is not opened.
        let is_file = matches!(files, FileSource::Held(_)) || path.is_file();
        let bytes = is_file.then(|| files.look_at(path).ok()).flatten();
        bytes.filter(|bytes| !bytes.is_empty()).is_some_and(|bytes| {
            let path = path.clone();
            let opened = Opened { path, bytes };
            let mut formats = FORMATS.iter().map(|format| format.reader);
            formats.any(|reader| {
                !reader.is_read_by_name_only(&opened.path)
                    && reader.recognise(files, &opened).is_some()
            })
        })
    };
    let mut logs = files.children(folder);
    logs.retain(|path| !files.is_folder(path) && is_log(path));
    logs
}

fn some(names: &[String]) -> String {
    match names.get(..MOST_NAMES) {
        Some(some) if names.len() > MOST_NAMES => format!("{} ...", some.join(", ")),
        _ => names.join(", "),
    }
}

fn read_by_content(
    files: &FileSource,
    opened: Opened,
    reading: &Reading<'_>,
    progress: &Progress,
) -> Result<Survey, OpenError> {
    let mut formats = FORMATS.iter();
    if let Some(read) = formats.find_map(|format| format.reader.recognise(files, &opened)) {
        return read(reading, progress);
    }
    if opened.bytes.is_empty() {
        return Err(not_recognised(&opened.path, "the file is empty"));
    }
    if let Some(advice) = table::advice(&opened.bytes) {
        return Err(opened.unsupported(advice));
    }
    Err(not_recognised(&opened.path, table::looked_for()))
}

fn not_recognised(path: &Path, looked_for: &'static str) -> OpenError {
    OpenError::NotRecognised { path: path.to_owned(), looked_for }
}

/// Content of a file with which a survey is compared.
#[derive(Debug)]
pub enum ReferenceFile {
    /// Points with elevations.
    Points(Elevations),
    /// Log of another survey of the same water.
    Log(Box<Survey>),
}

/// Returns true if an argument names points: a file of points, or the multibeam depths of a log,
/// `FILE.xtf:multibeam`.
pub fn is_named_as_points(argument: &OsStr) -> bool {
    multibeam_of(argument).is_some() || is_named_as_elevations(argument)
}

/// Returns the path of the file in an argument `FILE.xtf:multibeam`; `None` for other arguments.
pub fn multibeam_of(argument: &OsStr) -> Option<PathBuf> {
    let file = argument.to_str()?.strip_suffix(MULTIBEAM)?;
    Some(PathBuf::from(file))
}

/// Reads the points that an argument names, for which [`is_named_as_points`] is true.
///
/// # Errors
/// When the points cannot be read, or there are none.
pub fn read_points(argument: &OsStr, progress: &Progress) -> Result<Elevations, OpenError> {
    Ok(match multibeam_of(argument) {
        Some(path) => read_multibeam(&path, progress)?,
        None => read_elevations(argument)?,
    })
}

/// Opens `FILE` or `FILE.csv:x,y,z` of points, `FILE.xtf:multibeam`, or a log; the name decides
/// which.
///
/// # Errors
/// When the file cannot be read as the kind that its name indicates.
pub fn open_reference(argument: &OsStr, progress: &Progress) -> Result<ReferenceFile, OpenError> {
    Ok(if is_named_as_points(argument) {
        ReferenceFile::Points(read_points(argument, progress)?)
    } else {
        ReferenceFile::Log(Box::new(open(Path::new(argument), progress)?))
    })
}
