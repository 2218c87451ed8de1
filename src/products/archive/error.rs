//! What is wrong with an archive.

use crate::formats::parquet_table::ParquetError;
use crate::products::export::{ExportError, NoFolder, RasterError};
use crate::support::file_error::FileError;
use crate::support::mapped_file::FileFault;
use crate::support::progress::Cancelled;

/// Why something cannot be done in an archive.
#[derive(Debug, thiserror::Error)]
pub(crate) enum ArchiveError {
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
