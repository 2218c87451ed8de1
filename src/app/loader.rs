//! Opens logs in background threads.

use super::Jobs;
use super::error::AppError;
use super::{Task, TaskOutcome};
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

/// Name and progress of the log that is being opened, for the status line.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct LoadStatus {
    /// Name of the log.
    pub name: String,
    /// Done share, 0 to 1.
    pub fraction: f32,
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

/// The opening of a log, which is cancelled when this is dropped.
pub(super) struct Loading {
    pub request: OpenRequest,
    task: Task<Result<OpenedPath, AppError>>,
}

impl Loading {
    /// Starts opening a log beside those that are `open`.
    pub(super) fn start(
        request: OpenRequest,
        open: Vec<Arc<Survey>>,
        in_project: bool,
        jobs: &Jobs,
    ) -> Self {
        let requested = request.origin.clone();
        let task = Task::start(jobs, move |progress| {
            if let LogOrigin::Path(path) = &requested {
                let logs = formats::logs_in(path);
                if logs.len() > 1 {
                    return Ok(OpenedPath::Folder(logs));
                }
            }
            let survey = requested.open(progress)?;
            if let Some(known) = open.iter().find(|known| is_same_recording(known, &survey)) {
                return Ok(OpenedPath::Known(known.name()));
            }
            let log = survey.source.files.first();
            let drawn = match &requested {
                LogOrigin::Path(_) => log.and_then(|log| read_bottom(log, &survey)),
                LogOrigin::Demo => None,
            };
            let is_file = matches!(requested, LogOrigin::Path(_));
            let file = (in_project && is_file).then(|| LogFile::of(&survey, progress));
            let file = file.transpose()?;
            // The hash belongs to the log only if the whole log could be read.
            survey.check_files().map_err(formats::OpenError::from)?;
            Ok(OpenedPath::Log(Box::new(survey), drawn, file))
        });
        Self { request, task }
    }

    /// Returns the result once, when opening has ended; `None` while it is running.
    pub(super) fn poll(&self) -> Option<Result<OpenedPath, AppError>> {
        match self.task.poll() {
            TaskOutcome::Done(opened) => Some(opened),
            TaskOutcome::Pending => None,
            TaskOutcome::Failed => Some(Err(AppError::OpeningFailed(self.request.origin.name()))),
        }
    }

    pub(super) fn status(&self) -> LoadStatus {
        LoadStatus { name: self.request.origin.name(), fraction: self.task.fraction() }
    }
}

/// Returns true if two logs hold the same bytes, whatever their names.
fn is_same_recording(one: &Survey, other: &Survey) -> bool {
    let is_same = Identity::of(one).is_same_log(&Identity::of(other));
    let [one, other] = [one, other].map(|survey| survey.bytes.iter());
    // A clone of the demo, and a log without bytes, are identified by their size alone.
    is_same && one.zip(other).all(|(one, other)| **one == **other)
}
