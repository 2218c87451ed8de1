//! Starts work in background threads and collects its results.

use super::figures::Figures;
use super::loader::{Loading, OpenMode, OpenRequest, OpenedPath, ReadBottom};
use super::preview::PreviewRequest;
use super::{Action, App, Jobs, LogId, LogOrigin, OpenLog, Task, TaskOutcome};
use bathyscope_log::support::printable::quoted;
use bathyscope_log::survey::Survey;
use bathyscope_products::export::is_same_file;
use bathyscope_products::pipeline::{ProcessedLog, Products};
use bathyscope_products::project::LogFile;
use std::collections::VecDeque;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Number of remembered logs.
const RECENT: usize = 10;

impl App {
    /// Collects the results of finished background work. The window calls this once a frame.
    pub fn poll(&mut self) {
        self.poll_loading();
        self.poll_engine();
        self.poll_following();
        self.collect_tail();
        self.poll_file_watch();
        self.poll_cards();
        if let Some(preview) = self.pipeline.previewer.poll(&self.jobs)
            && preview.is_for(&self.log.settings)
            && self.stale().is_some()
        {
            self.log.preview = Some(preview.returns);
        }
        self.poll_comparing();
        self.poll_tables();
        self.poll_positions();
        self.poll_planning();
        self.poll_passes();
        self.poll_project();
        self.poll_export();
        self.poll_detecting();
        for id in self.log_ids() {
            self.poll_log(id);
        }
        self.poll_objects();
        self.poll_base_map();
        self.poll_isobath_area();
        self.follow_heights();
        self.derive();
        self.derive_picture();
        self.follow_profile();
    }

    /// Collects the results of background work on one log.
    fn poll_log(&mut self, id: LogId) {
        let jobs = self.jobs.clone();
        if let Some(log) = self.log_mut(id) {
            log.poll_figures();
        }
        self.poll_review(id);
        self.poll_autosave(id);
        self.poll_judging(id);
        if let Some(log) = self.log_mut(id) {
            log.poll_places(&jobs);
        }
        self.poll_external(id);
        if let Some(log) = self.log_mut(id) {
            log.poll_exclusions(&jobs);
            log.poll_calibrating(&jobs);
        }
    }

    fn poll_engine(&mut self) {
        let Some(processed) = self.pipeline.engine.poll() else {
            return;
        };
        let log = self.pipeline.requested.take().map(|(id, ..)| id);
        match (processed, log) {
            (Ok(products), Some(id)) => self.take_products(id, products),
            (Ok(_), None) => {}
            (Err(failed), _) => {
                // The same settings would fail again.
                self.pipeline.is_waiting = true;
                self.warn(failed.to_string());
            }
        }
        self.schedule();
    }

    fn poll_loading(&mut self) {
        let Some(opened) = self.files.loading.as_ref().and_then(Loading::poll) else {
            return;
        };
        let Some(loading) = self.files.loading.take() else {
            return;
        };
        let OpenRequest { origin, place } = loading.request;
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
        let jobs = self.jobs.clone();
        let Some(log) = self.log_mut(id) else {
            return;
        };
        if let Some(text) = log.take_products(products, &jobs) {
            self.withdraw(Action::Undo);
            self.offer(text, Action::Undo);
        }
        if id == self.log.id
            && let Some(request) = self.preview_request()
        {
            self.pipeline.previewer.warm_up(request, &self.jobs);
        }
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
            self.pipeline.previewer.want(request, &self.jobs);
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

    /// Stops all running work; the last results stay.
    pub(super) fn cancel(&mut self) {
        self.pipeline.engine.cancel();
        self.pipeline.is_waiting = true;
        self.stop_detecting();
        self.pipeline.previewer.forget();
        self.log.preview = None;
        self.files.loading = None;
        self.files.to_load.clear();
        self.files.project_saving.stop();
        self.files.exporting = None;
        self.files.opening_base_map = None;
        self.files.reading_area.stop();
        self.map.comparing.stop();
        self.map.planning.stop();
        self.findings.passes.stop();
        self.findings.reference_comparison.stop();
        for log in self.logs_mut() {
            log.external.stop_reading();
        }
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
        self.files.loading = None;
        self.files.to_load = requests(origins, place);
        self.load_next();
    }

    fn load_next(&mut self) {
        if self.files.loading.is_none()
            && let Some(request) = self.files.to_load.pop_front()
        {
            let open = match request.place {
                // A log that replaces the open ones is read again, even if it is open.
                OpenMode::Instead => Vec::new(),
                OpenMode::Added { .. } => {
                    self.logs().filter_map(|log| log.survey.clone()).collect()
                }
            };
            let in_project = self.project_path().is_some();
            self.files.loading = Some(Loading::start(request, open, in_project, &self.jobs));
        }
        if self.files.loading.is_none() && self.files.to_load.is_empty() {
            self.set_apart();
        }
    }
}

impl OpenLog {
    /// Collects the counted figures.
    fn poll_figures(&mut self) {
        match self.counting.as_ref().map(Task::poll) {
            Some(TaskOutcome::Done(figures)) => {
                self.figures = figures;
                self.counting = None;
            }
            Some(TaskOutcome::Failed) => self.counting = None,
            Some(TaskOutcome::Pending) | None => {}
        }
    }

    /// Sets new results; returns a sentence about the depths if they are the results of a change of
    /// scale.
    fn take_products(&mut self, products: Products, jobs: &Jobs) -> Option<String> {
        self.preview = None;
        let said = self.calibrating.said_of_change(&products);
        if let Some(survey) = self.survey.clone() {
            self.reviewing.follow(&survey, &products.navigation);
            self.count_figures(survey, products.clone(), jobs);
        }
        self.products = Some(products);
        said
    }

    /// Starts counting the figures that panels show of some results.
    pub(super) fn count_figures(&mut self, survey: Arc<Survey>, products: Products, jobs: &Jobs) {
        let ProcessedLog { survey, products } = ProcessedLog::new(survey, products);
        self.counting =
            Some(Task::start(jobs, move |progress| Figures::of(&survey, &products, progress).ok()));
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
