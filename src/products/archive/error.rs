//! Errors of an archive.

use crate::export::{ExportError, NoFolder, RasterError};
use bathyscope_log::formats::parquet_table::ParquetError;
use bathyscope_log::support::file_error::FileError;
use bathyscope_log::support::mapped_file::FileFault;
use bathyscope_log::support::progress::Cancelled;

/// Error of an operation on an archive.
#[derive(Debug, thiserror::Error)]
pub enum ArchiveError {
    /// The work was cancelled.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    /// A file could not be written.
    #[error(transparent)]
    Write(#[from] ExportError),
    /// A folder could not be made.
    #[error(transparent)]
    Folder(#[from] FileError<NoFolder>),
    /// A log did not stay what it was.
    #[error(transparent)]
    Log(#[from] FileError<FileFault>),
    /// Rows could not be read.
    #[error(transparent)]
    Rows(#[from] ParquetError),
    /// A raster could not be written.
    #[error(transparent)]
    Raster(#[from] RasterError),
    /// Anything else, in a sentence that says what, where and what to do.
    #[error("{0}")]
    Refused(String),
}

impl From<String> for ArchiveError {
    fn from(sentence: String) -> Self {
        Self::Refused(sentence)
    }
}
