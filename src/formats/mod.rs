//! Bytes to [`Survey`]: every recorder's format, recognised by content.

use crate::progress::Progress;
use crate::survey::Survey;
use std::path::{Path, PathBuf};

/// Why a log cannot be opened. Each sentence says what is wrong, where, and what to do.
#[derive(Debug, thiserror::Error)]
pub enum OpenError {
    /// The file cannot be read at all.
    #[error("cannot read `{path}`: {source}")]
    Io {
        /// Which file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// No reader knows these bytes.
    #[error("not a sonar log that Bathyscope knows ({looked_for}): {path}")]
    NotRecognised {
        /// Which file.
        path: PathBuf,
        /// The formats that were tried, in words.
        looked_for: &'static str,
    },
    /// The format is known, but nothing in the file can be used.
    #[error("{format} log is damaged: {what}: {path}")]
    Broken {
        /// Which file.
        path: PathBuf,
        /// The recognised format.
        format: String,
        /// What is broken, where, and what to do.
        what: String,
    },
    /// The format is known but cannot hold side-scan.
    #[error("{what}: {path}")]
    Unsupported {
        /// Which file.
        path: PathBuf,
        /// What to record or open instead.
        what: String,
    },
    /// The user stopped it.
    #[error(transparent)]
    Cancelled(#[from] crate::progress::Cancelled),
}

/// Opens a log: an SL2 or SL3 file, a Humminbird DAT, folder or SON, an XTF file. The file is only ever read.
pub fn open(_path: &Path, _progress: &Progress) -> Result<Survey, OpenError> {
    todo!()
}

/// Reads a log that is already in memory (the bundled demo survey, a simulated one, a test).
/// `name` stands for the file in messages.
pub fn open_bytes(_name: &str, _bytes: Vec<u8>, _progress: &Progress) -> Result<Survey, OpenError> {
    todo!()
}
