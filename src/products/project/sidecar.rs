//! Reads the bottom edits that earlier versions stored in a sidecar file, `LOG.bottom.toml`. They
//! are read when the log is opened and no project has decisions about it; the sidecar file is not
//! changed.

use bathyscope_bottom::first_return::{BottomSettings, OtherLog};
use bathyscope_log::support::file_error::FileError;
use bathyscope_log::support::regular_file;
use bathyscope_log::survey::Survey;
use serde::Deserialize;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// Largest size of a file of bottom edits, bytes: this program does not write a longer one.
const LONGEST: u64 = 64 << 20;
/// Contents of the file, in the form of the settings for `bathyscope process --settings`.
#[derive(Deserialize)]
struct BottomFile {
    bottom: BottomSettings,
}

fn bottom_path(log: &Path) -> PathBuf {
    log.with_extension(BottomSettings::SIDECAR)
}

/// Error of bottom edits beside a log that cannot be used.
pub type BottomFileError = FileError<BottomFault>;

/// Fault of bottom edits in a file.
#[derive(Debug, thiserror::Error)]
pub enum BottomFault {
    /// The file cannot be read.
    #[error("cannot use the bottom edits: {0}")]
    Io(#[from] io::Error),
    /// The file is not TOML of bottom edits.
    #[error("cannot use the bottom edits: {}", .0.message())]
    NotToml(#[from] toml::de::Error),
    /// The edits contain values that are not possible.
    #[error("cannot use the bottom edits: {0}")]
    Impossible(&'static str),
    /// The edits were made on another log.
    #[error("cannot use the bottom edits: {0}")]
    OtherLog(#[from] OtherLog),
}

/// Reads the bottom edits of a log; `None` if it has no sidecar file.
pub fn read_bottom(log: &Path, survey: &Survey) -> Option<Result<BottomSettings, BottomFileError>> {
    let path = bottom_path(log);
    let found = fs::metadata(&path).ok();
    found.filter(|found| found.is_file())?;
    let parsed = || -> Result<BottomSettings, BottomFault> {
        let text = regular_file::read_text(&path, LONGEST)?;
        let kept: BottomFile = toml::from_str(&text)?;
        kept.bottom.check().map_err(BottomFault::Impossible)?;
        Ok(kept.bottom.adopted(survey)?)
    };
    Some(parsed().map_err(BottomFileError::at(&path)))
}
