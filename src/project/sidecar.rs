//! What earlier versions kept beside a log: `LOG.bottom.toml`, `LOG.review.json` and `LOG.review.unsaved.json`. They are read when the log
//! is added to a project, which keeps all of it from then on, and stay as they are.

use super::log::ProjectLog;
use crate::detection::review::Review;
use crate::sonar::first_return::{BottomSettings, OtherLog};
use crate::support::regular_file;
use crate::survey::Survey;
use serde::Deserialize;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A longer file of bottom edits was not written by this program.
const LONGEST: u64 = 64 << 20;
/// End of the name of a review's file, in place of the log's.
const REVIEW: &str = "review.json";
/// The same of decisions that were not saved.
const UNSAVED: &str = "review.unsaved.json";

/// What lies beside a log.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sidecars {
    /// The bottom edits.
    pub bottom: Option<BottomSettings>,
    /// The boxes and the decisions about them; where some were not saved, these.
    pub review: Option<Arc<Review>>,
    /// What was found, and what could not be used, in sentences.
    pub notes: Vec<String>,
}

/// Settings as `bathyscope process --settings` takes them.
#[derive(Deserialize)]
struct BottomFile {
    bottom: BottomSettings,
}

/// Reads what lies beside a log.
pub fn read_sidecars(log: &Path, survey: &Survey) -> Sidecars {
    let mut sidecars = Sidecars::default();
    match read_bottom(log, survey) {
        Some(Ok(bottom)) => {
            let (pings, path) = (bottom.edited_count(), bottom_path(log));
            let text = format!(
                "took in the bottom of {pings} pings that was drawn by hand: {}",
                path.display()
            );
            sidecars.notes.push(text);
            sidecars.bottom = Some(bottom);
        }
        Some(Err(error)) => sidecars.notes.push(error.to_string()),
        None => {}
    }
    // What was not saved is later than what was.
    for ending in [REVIEW, UNSAVED] {
        let path = log.with_extension(ending);
        if !path.is_file() {
            continue;
        }
        match Review::open_for(&path, survey) {
            Ok(review) => {
                let boxes = review.boxes().len();
                sidecars
                    .notes
                    .push(format!("took in {boxes} boxes: {}", path.display()));
                sidecars.review = Some(Arc::new(review));
            }
            Err(error) => sidecars.notes.push(error.to_string()),
        }
    }
    sidecars
}

impl ProjectLog {
    /// With what lay beside it.
    pub fn with_sidecars(mut self, sidecars: &Sidecars) -> Self {
        if let Some(bottom) = &sidecars.bottom {
            self.settings.bottom = bottom.clone();
        }
        if let Some(review) = &sidecars.review {
            self.review = review.clone();
        }
        self
    }
}

fn bottom_path(log: &Path) -> PathBuf {
    log.with_extension(BottomSettings::SIDECAR)
}

/// Bottom edits beside a log that cannot be used.
#[derive(Debug, thiserror::Error)]
#[error("cannot use the bottom edits: {what}: {}", path.display())]
pub struct BottomFileError {
    /// What is wrong with them.
    #[source]
    pub what: BottomFault,
    /// Their file.
    pub path: PathBuf,
}

/// What is wrong with bottom edits in a file.
#[derive(Debug, thiserror::Error)]
pub enum BottomFault {
    /// The system does not give it.
    #[error(transparent)]
    Io(#[from] io::Error),
    /// It is no TOML of bottom edits.
    #[error("{}", .0.message())]
    NotToml(#[from] toml::de::Error),
    /// No hand can have drawn them.
    #[error("{0}")]
    Impossible(&'static str),
    /// They were drawn on another log.
    #[error(transparent)]
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
    Some(parsed().map_err(|what| BottomFileError { what, path }))
}
