//! Opens logs, one after the other, in background threads. Logs that do not form a survey with the
//! others are opened, but not shown on the map until the analyst asks for them.

use super::error::AppError;
use super::jobs::JobKey;
use super::project::OpenedLogs;
use super::untitled::{OpenedPath, ReadDecisions, find_decisions};
use super::{Action, App, LogId, OpenLog};
use bathyscope_log::formats;
use bathyscope_log::support::printable::quoted;
use bathyscope_log::support::progress::Progress;
use bathyscope_log::survey::{Identity, Survey, apart};
use bathyscope_products::project::read_bottom;
use std::collections::VecDeque;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Largest number of remembered logs.
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

impl OpenRequest {
    fn path(&self) -> Option<&Path> {
        match &self.origin {
            LogOrigin::Path(path) => Some(path),
            LogOrigin::Demo => None,
        }
    }
}

/// Opens a path; `open` are the logs that are open already, and `others` the logs that are opened
/// after it, or `None` if it joins the open logs.
fn read_path(
    origin: &LogOrigin,
    open: &[Arc<Survey>],
    untitled: Option<&Path>,
    others: Option<&[PathBuf]>,
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
    survey.check_files().map_err(formats::OpenError::from)?;
    let opened = match (origin, untitled) {
        (LogOrigin::Demo, _) | (_, None) => OpenedPath::Log(Box::new(survey), ReadDecisions::None),
        (LogOrigin::Path(_), Some(folder)) => find_decisions(folder, survey, others, progress)?,
    };
    Ok(match opened {
        OpenedPath::Log(survey, ReadDecisions::None) => {
            let log = survey.source.files.first();
            let bottom = log.and_then(|log| read_bottom(log, &survey));
            let decisions = bottom.map_or(ReadDecisions::None, ReadDecisions::Sidecar);
            OpenedPath::Log(survey, decisions)
        }
        opened => opened,
    })
}

impl App {
    /// Opens logs one after the other; the opening of earlier requests is dropped.
    pub(super) fn load(&mut self, origins: impl Iterator<Item = LogOrigin>, place: OpenMode) {
        self.jobs.stop(&JobKey::OpenLog);
        if place == OpenMode::Instead && self.files.project_saving.is_untitled {
            // The logs may be those that are open, whose project is opened again.
            self.leave_project();
        }
        self.files.to_load = requests(origins, place);
        self.load_next();
    }

    fn load_next(&mut self) {
        let Some(request) = self.files.to_load.pop_front() else {
            return self.set_apart();
        };
        let (open, others): (Vec<Arc<Survey>>, Option<Vec<PathBuf>>) = match request.place {
            // A log that replaces the open ones is read again, even if it is open.
            OpenMode::Instead => {
                let others = self.files.to_load.iter().filter_map(OpenRequest::path);
                (Vec::new(), Some(others.map(Path::to_owned).collect()))
            }
            OpenMode::Added { .. } => {
                (self.logs.all().filter_map(|log| log.survey.clone()).collect(), None)
            }
        };
        let untitled = self.files.untitled_folder.clone();
        let origin = request.origin.clone();
        let name = origin.name();
        self.files.loading.clone_from(&name);
        self.jobs.run_or(
            JobKey::OpenLog,
            move |progress| {
                read_path(&origin, &open, untitled.as_deref(), others.as_deref(), progress)
            },
            move |app, opened| app.take_opened(request, opened),
            move |app| {
                app.notices.warn(AppError::OpeningFailed(name));
                app.load_next();
            },
        );
    }

    /// Applies the result of opening a path, and opens the next one.
    fn take_opened(&mut self, request: OpenRequest, opened: Result<OpenedPath, AppError>) {
        let OpenRequest { origin, place } = request;
        match opened {
            Ok(OpenedPath::Log(survey, decisions)) => {
                self.take_survey(*survey, origin, place, decisions);
            }
            Ok(OpenedPath::Project(opened)) => self.take_untitled(origin, *opened),
            Ok(OpenedPath::Folder(logs)) => {
                let logs = logs.into_iter().map(LogOrigin::Path);
                for request in requests(logs, place).into_iter().rev() {
                    self.files.to_load.push_front(request);
                }
            }
            Ok(OpenedPath::Known(name)) => {
                let (name, origin) = (quoted(&name), quoted(&origin.name()));
                let text = format!("This recording is open already, as {name}: {origin}");
                self.notices.notify(text);
            }
            Err(error) => self.notices.warn(with_name_quoted(error.to_string(), &origin)),
        }
        self.load_next();
    }

    fn take_survey(
        &mut self,
        survey: Survey,
        origin: LogOrigin,
        place: OpenMode,
        decisions: ReadDecisions,
    ) {
        let is_file = matches!(origin, LogOrigin::Path(_));
        if let LogOrigin::Path(path) = origin {
            self.remember(path);
        }
        let id = match place {
            OpenMode::Instead => {
                if self.logs.shown.survey.is_some() {
                    self.view.options = self.view.options.for_new_survey();
                }
                self.replace_logs(Arc::new(survey));
                self.logs.arrived.clear();
                self.logs.shown.id
            }
            OpenMode::Added { shown } => {
                let id = self.add_log(survey);
                if shown {
                    self.show_log(id);
                }
                id
            }
        };
        if let Some(log) = self.logs.get_mut(id) {
            log.is_demo = !is_file;
        }
        self.logs.arrived.push(id);
        self.mount_as_usual(id);
        match decisions {
            ReadDecisions::Untitled(decisions) => self.take_decisions(id, *decisions),
            ReadDecisions::Sidecar(read) => {
                if let Some(log) = self.logs.get_mut(id) {
                    self.notices.tell(log.take_bottom(read));
                }
                self.look_for_review(id);
            }
            ReadDecisions::Named(path) => {
                let name = self.logs.name_of(id);
                let path = path.display();
                self.notices
                    .notify(format!("The decisions about {name} are in the project {path}"));
            }
            ReadDecisions::None if is_file => self.look_for_review(id),
            ReadDecisions::None => {}
        }
        self.look_for_truth(id, is_file);
        self.keep_project("add log");
        self.hash_new_logs();
        self.pipeline.is_waiting = false;
        self.schedule();
    }

    /// Opens the untitled project of the requested logs in place of these.
    fn take_untitled(&mut self, origin: LogOrigin, opened: OpenedLogs) {
        let requests = std::mem::take(&mut self.files.to_load);
        for path in requests.iter().rev().filter_map(OpenRequest::path) {
            self.remember(path.to_owned());
        }
        if let LogOrigin::Path(path) = origin {
            self.remember(path);
        }
        self.take_project(opened);
        self.logs.arrived.clear();
        for id in self.logs.ids() {
            self.look_for_truth(id, true);
        }
        let name = quoted(&self.logs.shown.name());
        let more = match self.logs.count() {
            0 | 1 => String::new(),
            count => format!(" and {} more", count - 1),
        };
        self.notices.notify(format!("Opened {name}{more} with the last decisions"));
    }

    /// Puts a log at the top of the recent ones, by a path that is valid in whatever folder the
    /// next run starts.
    pub(super) fn remember(&mut self, path: PathBuf) {
        let path = std::path::absolute(&path).unwrap_or(path);
        self.recent.retain(|recent| *recent != path);
        self.recent.insert(0, path);
        self.recent.truncate(RECENT);
    }

    /// Hides the newly opened logs that do not form a survey with the others, and offers to show
    /// them.
    pub(super) fn set_apart(&mut self) {
        let arrived = std::mem::take(&mut self.logs.arrived);
        let read = |log: &OpenLog| Some((log.id, log.survey.clone()?));
        let (ids, surveys): (Vec<LogId>, Vec<Arc<Survey>>) =
            self.logs.visible().filter_map(read).unzip();
        let known: Vec<bool> = ids.iter().map(|id| !arrived.contains(id)).collect();
        let surveys: Vec<&Survey> = surveys.iter().map(|survey| &**survey).collect();
        let why = ids.iter().zip(&known).zip(apart(&surveys, &known));
        let why = why.filter_map(|((id, known), why)| Some((*id, why.filter(|_| !known)?)));
        let mut names = Vec::new();
        for (id, why) in why {
            if let Some(log) = self.logs.get_mut(id) {
                log.is_visible = false;
                log.apart = Some(why);
                names.push(format!("{} ({why})", quoted(&log.name())));
            }
        }
        if names.is_empty() {
            return;
        }
        let first = self.logs.visible().next().map(|log| log.id);
        if let (false, Some(first)) = (self.logs.shown.is_visible, first) {
            self.show_log(first);
        }
        // The plane of a distant log would distort the positions of the other logs.
        self.document.is_plane_moved = true;
        self.settle_plane();
        let text = format!("Open, but not part of this survey: {}", names.join(", "));
        self.notices.offer(text, Action::ShowTogether);
        self.keep_project("logs apart");
        self.schedule();
    }

    /// Shows all logs on one map, whatever the distance between them, as an undo step.
    pub(super) fn show_together(&mut self) {
        let before = self.step_now();
        for log in self.logs.all_mut().filter(|log| log.apart.is_some()) {
            log.is_visible = true;
            log.apart = None;
        }
        self.record_named(&before, "show all logs together".to_owned());
        self.notices.withdraw(Action::ShowTogether);
        self.schedule();
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
