//! Opens logs, one after the other, in background threads.

use super::error::AppError;
use super::jobs::JobKey;
use super::{Action, App};
use bathyscope_bottom::first_return::BottomSettings;
use bathyscope_log::formats;
use bathyscope_log::support::printable::quoted;
use bathyscope_log::support::progress::Progress;
use bathyscope_log::survey::{Identity, Survey};
use bathyscope_products::project::{BottomFileError, LogFile, read_bottom};
use std::collections::VecDeque;
use std::path::PathBuf;
use std::sync::Arc;

/// Number of remembered logs.
const RECENT: usize = 10;

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
enum OpenedPath {
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
fn read_path(
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

impl App {
    /// Opens a log, which replaces the open ones; the opening of earlier requests is dropped.
    pub(super) fn start_loading(&mut self, origin: LogOrigin) {
        self.load([origin].into_iter(), OpenMode::Instead);
    }

    /// Opens logs one after the other; the opening of earlier requests is dropped.
    pub(super) fn load(&mut self, origins: impl Iterator<Item = LogOrigin>, place: OpenMode) {
        self.jobs.stop(&JobKey::OpenLog);
        self.files.to_load = requests(origins, place);
        self.load_next();
    }

    fn load_next(&mut self) {
        let Some(request) = self.files.to_load.pop_front() else {
            return self.set_apart();
        };
        let open = match request.place {
            // A log that replaces the open ones is read again, even if it is open.
            OpenMode::Instead => Vec::new(),
            OpenMode::Added { .. } => self.logs().filter_map(|log| log.survey.clone()).collect(),
        };
        let in_project = self.project_path().is_some();
        let origin = request.origin.clone();
        let name = origin.name();
        self.files.loading.clone_from(&name);
        self.jobs.run_or(
            JobKey::OpenLog,
            move |progress| read_path(&origin, &open, in_project, progress),
            move |app, opened| app.take_opened(request, opened),
            move |app| {
                app.warn(AppError::OpeningFailed(name).to_string());
                app.load_next();
            },
        );
    }

    /// Applies the result of opening a path, and opens the next one.
    fn take_opened(&mut self, request: OpenRequest, opened: Result<OpenedPath, AppError>) {
        let OpenRequest { origin, place } = request;
        match opened {
            Ok(OpenedPath::Log(survey, drawn, file)) => {
                self.take_survey(*survey, origin, place, (drawn, file));
            }
            Ok(OpenedPath::Folder(logs)) => {
                let logs = logs.into_iter().map(LogOrigin::Path);
                for request in requests(logs, place).into_iter().rev() {
                    self.files.to_load.push_front(request);
                }
            }
            Ok(OpenedPath::Known(name)) => {
                let (name, origin) = (quoted(&name), quoted(&origin.name()));
                let text = format!("This recording is open already, as {name}: {origin}");
                self.notify(text);
            }
            Err(error) => self.warn(with_name_quoted(error.to_string(), &origin)),
        }
        self.load_next();
    }

    fn take_survey(
        &mut self,
        survey: Survey,
        origin: LogOrigin,
        place: OpenMode,
        (drawn, file): (Option<ReadBottom>, Option<LogFile>),
    ) {
        let is_file = matches!(origin, LogOrigin::Path(_));
        if let LogOrigin::Path(path) = origin {
            self.remember(path);
        }
        self.withdraw(Action::TakeUpUnsaved);
        let id = match place {
            OpenMode::Instead => {
                if self.log.survey.is_some() {
                    self.view.options = self.view.options.for_new_survey();
                }
                self.replace_logs(Arc::new(survey));
                self.logs.arrived.clear();
                self.log.id
            }
            OpenMode::Added { shown } => {
                let id = self.add_log(survey);
                if shown {
                    self.show_log(id);
                }
                id
            }
        };
        self.logs.arrived.push(id);
        self.mount_as_usual(id);
        self.take_bottom(id, drawn, is_file);
        if is_file {
            self.look_for_review(id);
            self.look_for_unsaved(id);
        }
        self.look_for_truth(id, is_file);
        if let Some(log) = self.log_mut(id) {
            log.file = file;
        }
        if is_file {
            self.take_up_settings(id);
        }
        self.keep_project("add log");
        self.pipeline.is_waiting = false;
        self.schedule();
    }

    /// Puts a log at the top of the recent ones, by a path that is valid in whatever folder the
    /// next run starts.
    pub(super) fn remember(&mut self, path: PathBuf) {
        let path = std::path::absolute(&path).unwrap_or(path);
        self.recent.retain(|recent| *recent != path);
        self.recent.insert(0, path);
        self.recent.truncate(RECENT);
    }
}

/// Returns a sentence in which a relative path is quoted, so that it is recognised as a path.
fn with_name_quoted(text: String, origin: &LogOrigin) -> String {
    match origin {
        LogOrigin::Path(path) if path.is_relative() => {
            let path = path.display().to_string();
            text.replace(&path, &quoted(&path))
        }
        _ => text,
    }
}

/// Creates the requests to open several logs: the first one has the mode `place`, and the others
/// join it.
fn requests(origins: impl Iterator<Item = LogOrigin>, place: OpenMode) -> VecDeque<OpenRequest> {
    let each = origins.enumerate().map(|(index, origin)| OpenRequest {
        origin,
        place: match index {
            0 => place,
            _ => OpenMode::Added { shown: false },
        },
    });
    each.collect()
}

/// Returns true if two logs hold the same bytes, whatever their names.
fn is_same_recording(one: &Survey, other: &Survey) -> bool {
    let is_same = Identity::of(one).is_same_log(&Identity::of(other));
    let [one, other] = [one, other].map(|survey| survey.bytes.iter());
    // A clone of the demo, and a log without bytes, are identified by their size alone.
    is_same && one.zip(other).all(|(one, other)| **one == **other)
}
