//! Opens logs.

use super::error::AppError;
use bathyscope_bottom::first_return::BottomSettings;
use bathyscope_log::formats;
use bathyscope_log::support::progress::Progress;
use bathyscope_log::survey::{Identity, Survey};
use bathyscope_products::project::{BottomFileError, LogFile, read_bottom};
use std::path::PathBuf;
use std::sync::Arc;

/// Bytes of the bundled demo survey.
const DEMO: &[u8] = include_bytes!("../../assets/demo.sl2");

/// Source of a log that is opened.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum LogOrigin {
    /// A file or folder.
    Path(PathBuf),
    /// The bundled demo survey.
    Demo,
}

impl LogOrigin {
    /// Returns the name that is shown for the log.
    pub(crate) fn name(&self) -> String {
        match self {
            LogOrigin::Path(path) => path.file_name().map_or_else(
                || path.display().to_string(),
                |name| name.to_string_lossy().into_owned(),
            ),
            LogOrigin::Demo => "demo survey".to_owned(),
        }
    }

    /// Opens the log.
    pub(crate) fn open(&self, progress: &Progress) -> Result<Survey, formats::OpenError> {
        match self {
            LogOrigin::Path(path) => formats::open(path, progress),
            LogOrigin::Demo => formats::open_bytes("demo.sl2", DEMO.to_vec(), progress),
        }
    }
}

/// Treatment of the open logs when another log has been read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum OpenMode {
    /// The open logs are closed.
    Instead,
    /// The open logs stay, and the new log joins them.
    Added {
        /// True if the new log is shown then.
        shown: bool,
    },
}

/// A log to be opened.
#[derive(Clone, Debug)]
pub(super) struct OpenRequest {
    pub origin: LogOrigin,
    pub place: OpenMode,
}

/// The bottom edits of a sidecar file, or the error if they cannot be used.
pub(super) type ReadBottom = Result<BottomSettings, BottomFileError>;

/// Contents of a path that was opened.
pub(super) enum OpenedPath {
    /// A log, the bottom edits that were made when it was last open, and its file if it is to be
    /// kept in a project.
    Log(Box<Survey>, Option<ReadBottom>, Option<LogFile>),
    /// A folder of several logs.
    Folder(Vec<PathBuf>),
    /// The name of a recording that is already open.
    Known(String),
}

/// Opens a path; `open` are the logs that are open already. The file of the log is hashed if it
/// joins a project.
pub(super) fn open(
    origin: &LogOrigin,
    open: &[Arc<Survey>],
    in_project: bool,
    progress: &Progress,
) -> Result<OpenedPath, AppError> {
    if let LogOrigin::Path(path) = origin {
        let logs = formats::logs_in(path);
        if logs.len() > 1 {
            return Ok(OpenedPath::Folder(logs));
        }
    }
    let survey = origin.open(progress)?;
    if let Some(known) = open.iter().find(|known| is_same_recording(known, &survey)) {
        return Ok(OpenedPath::Known(known.name()));
    }
    let log = survey.source.files.first();
    let drawn = match origin {
        LogOrigin::Path(_) => log.and_then(|log| read_bottom(log, &survey)),
        LogOrigin::Demo => None,
    };
    let is_file = matches!(origin, LogOrigin::Path(_));
    let file = (in_project && is_file).then(|| LogFile::of(&survey, progress));
    let file = file.transpose()?;
    // The hash belongs to the log only if the whole log could be read.
    survey.check_files().map_err(formats::OpenError::from)?;
    Ok(OpenedPath::Log(Box::new(survey), drawn, file))
}

/// Returns true if two logs hold the same bytes, whatever their names.
fn is_same_recording(one: &Survey, other: &Survey) -> bool {
    let is_same = Identity::of(one).is_same_log(&Identity::of(other));
    let [one, other] = [one, other].map(|survey| survey.bytes.iter());
    // A clone of the demo, and a log without bytes, are identified by their size alone.
    is_same && one.zip(other).all(|(one, other)| **one == **other)
}
