//! The bottom edits that earlier versions kept beside a log, `LOG.bottom.toml`. They are read when
//! the log is opened, a project keeps them from then on, and the file stays as it is.

use bathyscope_bottom::first_return::{BottomSettings, OtherLog};
use bathyscope_log::support::file_error::FileError;
use bathyscope_log::support::regular_file;
use bathyscope_log::survey::Survey;
use serde::Deserialize;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// A longer file of bottom edits was not written by this program.
const LONGEST: u64 = 64 << 20;
/// Settings as `bathyscope process --settings` takes them.
#[derive(Deserialize)]
struct BottomFile {
    bottom: BottomSettings,
}

fn bottom_path(log: &Path) -> PathBuf {
    log.with_extension(BottomSettings::SIDECAR)
}

/// Bottom edits beside a log that cannot be used.
pub type BottomFileError = FileError<BottomFault>;

/// Fault of bottom edits in a file.
#[derive(Debug, thiserror::Error)]
pub enum BottomFault {
    /// The system does not give it.
    #[error("cannot use the bottom edits: {0}")]
    Io(#[from] io::Error),
    /// It is no TOML of bottom edits.
    #[error("cannot use the bottom edits: {}", .0.message())]
    NotToml(#[from] toml::de::Error),
    /// No hand can have drawn them.
    #[error("cannot use the bottom edits: {0}")]
    Impossible(&'static str),
    /// They were drawn on another log.
    #[error("cannot use the bottom edits: {0}")]
    OtherLog(#[from] OtherLog),
}

/// Reads what was drawn on a log, if anything was.
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
