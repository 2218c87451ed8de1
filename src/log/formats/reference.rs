//! Reads the files that a survey can be compared with.

use super::OpenError;
use super::points::{Elevations, PointFileError, is_named_as_elevations, read_elevations};
use super::xtf::read_multibeam;
use crate::support::progress::Progress;
use crate::survey::Survey;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};

/// Content of a file that a survey is compared with.
#[derive(Debug)]
pub enum ReferenceFile {
    /// Points with elevations.
    Points(Elevations),
    /// The log of another mission over the same water.
    Log(Box<Survey>),
}

/// Reason why there is nothing to compare a survey with, in one sentence.
#[derive(Debug, thiserror::Error)]
pub enum ReferenceError {
    /// The points cannot be read.
    #[error(transparent)]
    Points(#[from] PointFileError),
    /// The log cannot be opened, or the work was cancelled.
    #[error(transparent)]
    Log(#[from] OpenError),
}

/// Suffix to the name of an XTF file whose multibeam depths are meant.
const MULTIBEAM: &str = ":multibeam";

/// Returns true if an argument names points: a file of them, or the multibeam depths of a log,
/// `FILE.xtf:multibeam`.
pub fn is_named_as_points(argument: &OsStr) -> bool {
    multibeam_of(argument).is_some() || is_named_as_elevations(argument)
}

/// The file whose multibeam depths are meant.
pub fn multibeam_of(argument: &OsStr) -> Option<PathBuf> {
    let file = argument.to_str()?.strip_suffix(MULTIBEAM)?;
    Some(PathBuf::from(file))
}

/// Reads what [`is_named_as_points`] says are points.
///
/// # Errors
/// When they cannot be read, or there are none.
pub fn read_points(argument: &OsStr, progress: &Progress) -> Result<Elevations, ReferenceError> {
    Ok(match multibeam_of(argument) {
        Some(path) => read_multibeam(&path, progress)?,
        None => read_elevations(argument)?,
    })
}

/// Opens `FILE` or `FILE.csv:x,y,z` of points, `FILE.xtf:multibeam`, or a log. Which of them it is
/// its name says.
///
/// # Errors
/// When it cannot be read as what its name says that it is.
pub fn open_reference(
    argument: &OsStr,
    progress: &Progress,
) -> Result<ReferenceFile, ReferenceError> {
    Ok(if is_named_as_points(argument) {
        ReferenceFile::Points(read_points(argument, progress)?)
    } else {
        ReferenceFile::Log(Box::new(super::open(Path::new(argument), progress)?))
    })
}
