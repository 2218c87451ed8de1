//! Processes the open logs in background threads, and follows what their results change.

use super::figures::Figures;
use super::jobs::JobKey;
use super::preview::PreviewRequest;
use super::{Action, App, LogId, OpenLog};
use bathyscope_log::survey::Survey;
use bathyscope_products::export::is_same_file;
use bathyscope_products::pipeline::{ProcessedLog, Products, Settings, Stage, run};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

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
        for id in self.logs.ids() {
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
        requested.is_some() && self.jobs.is_running(&JobKey::Process)
    }

    /// Starts processing a log whose results are missing or older than its settings: the shown log
    /// first.
    pub(super) fn schedule(&mut self) {
        if self.pipeline.is_waiting {
            return;
        }
        let behind = |log: &&OpenLog| log.is_behind();
        let shown = self.logs.get(self.logs.shown.id).filter(behind);
        let next = shown.or_else(|| self.logs.visible().find(behind));
        let Some((log, survey)) = next.and_then(|log| Some((log, log.survey.clone()?))) else {
            return;
        };
        let is_running = self.jobs.is_running(&JobKey::Process);
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
        let jobs = self.jobs.workers().clone();
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
                app.notices.warn(PROCESSING_FAILED);
            },
        );
    }

    /// Sets new results of a log.
    pub(super) fn take_products(&mut self, id: LogId, products: Products) {
        let Some(log) = self.logs.get_mut(id) else {
            return;
        };
        let sentence = log.take_products(products);
        let counted = log.settled();
        if let Some(log) = counted {
            self.count_figures(id, log);
        }
        if let Some(text) = sentence {
            self.notices.withdraw(Action::Undo);
            self.notices.offer(text, Action::Undo);
        }
        if id == self.logs.shown.id
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
                if let Some(log) = app.logs.get_mut(id) {
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

    /// Returns the request for first returns in the visible pings of the shown log, ahead of the
    /// pipeline; `None` without results or without side-scan.
    pub(super) fn preview_request(&self) -> Option<PreviewRequest> {
        let survey = self.logs.shown.survey.as_ref().filter(|survey| survey.has_side_scan())?;
        Some(PreviewRequest {
            survey: survey.clone(),
            image: self.logs.shown.settings.image.clone(),
            first_return: self.logs.shown.settings.first_return.clone(),
            bottom: self.logs.shown.settings.bottom.clone(),
            visible: self.view.visible.clone(),
            base: self.logs.shown.products.as_ref()?.returns.clone(),
        })
    }

    /// Stops the work that the analyst has asked for; the last results stay.
    pub(super) fn cancel(&mut self) {
        self.pipeline.is_waiting = true;
        self.stop_detecting();
        self.stop_comparing();
        self.jobs.stop_requested();
        self.forget_previews();
        self.logs.shown.preview = None;
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
        let survey = self.logs.get(id).and_then(|log| log.survey.as_ref());
        let is_log = survey.is_some_and(|survey| survey.source.files.iter().any(is_this));
        if is_log {
            let path = path.display();
            self.notices.warn(format!("that is the log itself; choose another name: {path}"));
        }
        is_log
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
