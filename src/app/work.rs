//! Opens logs and processes them in background threads, and follows what their results change.

use super::error::AppError;
use super::figures::Figures;
use super::jobs::JobKey;
use super::loader::{self, OpenMode, OpenRequest, OpenedPath, ReadBottom};
use super::preview::PreviewRequest;
use super::{Action, App, LogId, LogOrigin, OpenLog};
use bathyscope_log::support::printable::quoted;
use bathyscope_log::survey::Survey;
use bathyscope_products::export::is_same_file;
use bathyscope_products::pipeline::{ProcessedLog, Products, Settings, Stage, run};
use bathyscope_products::project::LogFile;
use std::collections::VecDeque;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

/// Number of remembered logs.
const RECENT: usize = 10;

/// Notice when the pipeline ended in a panic.
const PROCESSING_FAILED: &str = "a processing step failed unexpectedly; the last result stays";

/// A request to process a log.
pub(super) struct ProcessRequest {
    log: LogId,
    survey: Arc<Survey>,
    settings: Arc<Settings>,
    /// The running stage.
    stage: Arc<Mutex<Stage>>,
}

impl ProcessRequest {
    /// Returns the running stage.
    pub(super) fn stage(&self) -> Stage {
        *self.stage.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn is_for(&self, log: &OpenLog) -> bool {
        let is_same = log.survey.as_ref().is_some_and(|survey| Arc::ptr_eq(survey, &self.survey));
        self.log == log.id && is_same && Arc::ptr_eq(&self.settings, &log.settings)
    }
}

impl App {
    /// Applies the results of finished background work, and starts the work that follows from them.
    /// The window calls this once a frame.
    pub fn poll(&mut self) {
        self.take_answers();
        self.follow_state();
        // Work that runs in the calling thread has ended already.
        while self.take_answers() {
            self.follow_state();
        }
    }

    /// Starts the work that the present state needs, and that is neither done nor running. Costs
    /// next to nothing if nothing has changed.
    fn follow_state(&mut self) {
        self.follow_log();
        self.check_files();
        self.search_cards();
        self.search_on();
        for id in self.log_ids() {
            self.autosave(id);
            self.locate_boxes(id);
            self.compare_with_truth(id);
            self.find_exclusions(id);
            self.try_scale(id);
        }
        self.follow_objects();
        self.follow_heights();
        self.derive();
        self.derive_picture();
        self.follow_profile();
    }

    /// Returns true if a log is being processed.
    pub(crate) fn is_processing(&self, id: LogId) -> bool {
        let requested = self.pipeline.requested.as_ref().filter(|request| request.log == id);
        requested.is_some() && self.is_running(&JobKey::Process)
    }

    /// Starts processing a log whose results are missing or older than its settings: the shown log
    /// first.
    pub(super) fn schedule(&mut self) {
        if self.pipeline.is_waiting {
            return;
        }
        let behind = |log: &&OpenLog| log.is_behind();
        let shown = self.open_log(self.log.id).filter(behind);
        let next = shown.or_else(|| self.visible_logs().find(behind));
        let Some((log, survey)) = next.and_then(|log| Some((log, log.survey.clone()?))) else {
            return;
        };
        let is_running = self.is_running(&JobKey::Process);
        let requested = self.pipeline.requested.as_ref();
        if is_running && requested.is_some_and(|requested| requested.is_for(log)) {
            return;
        }
        let (id, settings, before) = (log.id, log.settings.clone(), log.products.clone());
        let stage = Arc::new(Mutex::new(Stage::Navigation));
        self.pipeline.requested = Some(ProcessRequest {
            log: id,
            survey: survey.clone(),
            settings: settings.clone(),
            stage: stage.clone(),
        });
        let jobs = self.jobs().clone();
        self.jobs.run_or(
            JobKey::Process,
            move |progress| {
                let on_stage = |now| {
                    *stage.lock().unwrap_or_else(PoisonError::into_inner) = now;
                    jobs.wake();
                };
                run(&survey, &settings, before.as_ref(), progress, on_stage).ok()
            },
            move |app, products| {
                app.pipeline.requested = None;
                if let Some(products) = products {
                    app.take_products(id, products);
                }
                app.schedule();
            },
            |app| {
                app.pipeline.requested = None;
                // The same settings would fail again.
                app.pipeline.is_waiting = true;
                app.warn(PROCESSING_FAILED.to_owned());
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

    /// Sets new results of a log.
    pub(super) fn take_products(&mut self, id: LogId, products: Products) {
        let Some(log) = self.log_mut(id) else {
            return;
        };
        let sentence = log.take_products(products);
        let counted = log.settled();
        if let Some(log) = counted {
            self.count_figures(id, log);
        }
        if let Some(text) = sentence {
            self.withdraw(Action::Undo);
            self.offer(text, Action::Undo);
        }
        if id == self.log.id
            && let Some(request) = self.preview_request()
        {
            self.pipeline.previewer.warm_up(request, &mut self.jobs);
        }
    }

    /// Starts counting the figures that panels show of the results of a log.
    pub(super) fn count_figures(&mut self, id: LogId, log: ProcessedLog) {
        self.jobs.run(
            JobKey::CountFigures(id),
            move |progress| Figures::of(&log.survey, &log.products, progress).ok(),
            move |app, figures| {
                if let Some(log) = app.log_mut(id) {
                    log.figures = figures;
                }
            },
        );
    }

    /// Starts the pipeline with the settings in force.
    pub(super) fn process(&mut self) {
        self.pipeline.is_waiting = false;
        self.schedule();
    }

    /// Starts the search for first returns in the visible pings of the shown log, ahead of the
    /// pipeline.
    pub(super) fn preview_returns(&mut self) {
        if let Some(request) = self.preview_request() {
            self.pipeline.previewer.want(request, &mut self.jobs);
        }
    }

    fn preview_request(&self) -> Option<PreviewRequest> {
        let survey = self.log.survey.as_ref().filter(|survey| survey.has_side_scan())?;
        Some(PreviewRequest {
            survey: survey.clone(),
            image: self.log.settings.image.clone(),
            first_return: self.log.settings.first_return.clone(),
            bottom: self.log.settings.bottom.clone(),
            visible: self.view.visible.clone(),
            base: self.log.products.as_ref()?.returns.clone(),
        })
    }

    /// Stops the work that the analyst has asked for; the last results stay.
    pub(super) fn cancel(&mut self) {
        self.pipeline.is_waiting = true;
        self.stop_detecting();
        self.stop_comparing();
        self.jobs.stop_requested();
        self.forget_previews();
        self.log.preview = None;
        self.files.to_load.clear();
    }

    /// Drops the first returns that are searched ahead of the pipeline, and what was measured for
    /// them.
    pub(super) fn forget_previews(&mut self) {
        self.jobs.stop(&JobKey::Preview);
        self.pipeline.previewer = Default::default();
    }

    /// Returns true if a path is a file of the log, which is never overwritten, and then warns the
    /// analyst.
    pub(super) fn refuses_log(&mut self, id: LogId, path: &Path) -> bool {
        let is_this = |file: &PathBuf| is_same_file(file, path);
        let survey = self.open_log(id).and_then(|log| log.survey.as_ref());
        let is_log = survey.is_some_and(|survey| survey.source.files.iter().any(is_this));
        if is_log {
            let path = path.display();
            self.warn(format!("that is the log itself; choose another name: {path}"));
        }
        is_log
    }

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
            move |progress| loader::open(&origin, &open, in_project, progress),
            move |app, opened| app.take_opened(request, opened),
            move |app| {
                app.warn(AppError::OpeningFailed(name).to_string());
                app.load_next();
            },
        );
    }
}

impl OpenLog {
    /// Sets new results; returns a sentence about the depths if they are the results of a change of
    /// scale.
    fn take_products(&mut self, products: Products) -> Option<String> {
        self.preview = None;
        let sentence = self.calibrating.said_of_change(&products);
        if let Some(survey) = self.survey.clone() {
            self.reviewing.follow(&survey, &products.navigation);
        }
        self.products = Some(products);
        sentence
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
