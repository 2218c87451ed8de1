//! What a survey can be compared with.

use super::OpenError;
use super::points::{Elevations, PointFileError, is_named_as_elevations, read_elevations};
use crate::support::progress::Progress;
use crate::survey::Survey;
use std::ffi::OsStr;
use std::path::Path;

/// What a file holds that a survey is compared with.
#[derive(Debug)]
pub(crate) enum ReferenceFile {
    /// Points with elevations.
    Points(Elevations),
    /// The log of another mission over the same water.
    Log(Box<Survey>),
}

/// Why there is nothing to compare a survey with, in one sentence.
#[derive(Debug, thiserror::Error)]
pub enum ReferenceError {
    /// The points cannot be read.
    #[error(transparent)]
    Points(#[from] PointFileError),
    /// The log cannot be opened, or the work was cancelled.
    #[error(transparent)]
    Log(#[from] OpenError),
}

/// Opens `FILE` or `FILE.csv:x,y,z` of points, or a log. Which of them it is its name says.
///
/// # Errors
/// When it cannot be read as what its name says that it is.
pub(crate) fn open_reference(
    argument: &OsStr,
    progress: &Progress,
) -> Result<ReferenceFile, ReferenceError> {
    Ok(match is_named_as_elevations(argument) {
        true => ReferenceFile::Points(read_elevations(argument)?),
        false => ReferenceFile::Log(Box::new(super::open(Path::new(argument), progress)?)),
    })
}
