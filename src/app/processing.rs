//! Processes the open logs in background threads, and follows what their results change.
//!
//! First returns are found ahead of the pipeline, so that the drawn line follows the slider. The
//! plain threshold is evaluated for the whole log from its index of running maxima; the tracker is
//! run over the visible pings. One such job runs at a time, and the newest request waits for it: if
//! each request cancelled the last job, nothing at all would appear during a long drag.

use super::figures::Figures;
use super::jobs::{JobKey, JobQueue};
use super::{Action, App, LogId, OpenLog};
use bathyscope_bottom::first_return::{
    BottomSettings, FirstReturnSettings, FirstReturns, ImageSettings, Method, Normalisation,
    SampleMode, ThresholdIndex, track_range,
};
use bathyscope_log::support::progress::{Cancelled, Progress};
use bathyscope_log::survey::Survey;
use bathyscope_products::export::is_same_file;
use bathyscope_products::pipeline::{ProcessedLog, Products, Settings, Stage, run};
use std::ops::Range;
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

/// Request for the first returns of some settings.
pub(super) struct PreviewRequest {
    survey: Arc<Survey>,
    image: ImageSettings,
    first_return: FirstReturnSettings,
    /// Manual picks that replace the found ones.
    bottom: BottomSettings,
    /// Visible pings.
    visible: Range<usize>,
    /// The last result, which pings outside the visible ones keep.
    base: Arc<FirstReturns>,
}

impl PreviewRequest {
    fn key(&self) -> PreviewKey {
        (self.first_return.method, self.image.samples, self.first_return.dead_zone_m)
    }
}

/// A measurement of the log that is made once and kept between drags: the plain threshold needs its
/// index, the tracker only the scale of the picture, which takes no memory.
enum Measured {
    Index(ThresholdIndex),
    Scale(Normalisation),
}

impl Measured {
    fn measure(request: &PreviewRequest, progress: &Progress) -> Result<Self, Cancelled> {
        let (survey, image) = (&request.survey, &request.image);
        let dead_zone_m = request.first_return.dead_zone_m;
        match request.first_return.method {
            Method::Threshold => {
                ThresholdIndex::build(survey, image, dead_zone_m, progress).map(Self::Index)
            }
            Method::Tracker => {
                Normalisation::measure(survey, image, dead_zone_m, progress).map(Self::Scale)
            }
        }
    }
}

/// Inputs of [`Measured`] besides the survey: method, samples, and dead zone in metres.
type PreviewKey = (Method, SampleMode, f64);

/// First returns that were found with some settings.
struct Preview {
    image: ImageSettings,
    first_return: FirstReturnSettings,
    returns: Arc<FirstReturns>,
}

impl Preview {
    /// Returns true if the first returns were found with the settings in force.
    fn is_for(&self, settings: &Settings) -> bool {
        self.image == settings.image && self.first_return.finds_the_same(&settings.first_return)
    }
}

struct Answer {
    key: PreviewKey,
    measured: Arc<Measured>,
    preview: Option<Preview>,
}

/// The measurements of the shown log, and the request that waits for the running one.
#[derive(Default)]
pub(super) struct Previewer {
    measured: Option<(PreviewKey, Arc<Measured>)>,
    queued: Option<PreviewRequest>,
}

impl Previewer {
    /// Makes the measurement for `request` in advance, so that the first drag does not have to wait
    /// for it.
    fn warm_up(&mut self, request: PreviewRequest, jobs: &mut JobQueue) {
        let known = self.measured.as_ref().map(|(key, _)| *key);
        if known != Some(request.key()) && !jobs.is_running(&JobKey::Preview) {
            self.start(request, jobs, false);
        }
    }

    /// Requests first returns; an older request that has not begun is dropped.
    pub(super) fn want(&mut self, request: PreviewRequest, jobs: &mut JobQueue) {
        if jobs.is_running(&JobKey::Preview) {
            self.queued = Some(request);
        } else {
            self.start(request, jobs, true);
        }
    }

    /// Drops the first returns that are searched ahead of the pipeline, and what was measured for
    /// them.
    pub(super) fn forget(&mut self, jobs: &mut JobQueue) {
        jobs.stop(&JobKey::Preview);
        *self = Self::default();
    }

    fn start(&mut self, request: PreviewRequest, jobs: &mut JobQueue, requested: bool) {
        let key = request.key();
        let known = self.measured.as_ref().filter(|(known, _)| *known == key);
        let known = known.map(|(_, measured)| measured.clone());
        jobs.run(
            JobKey::Preview,
            move |progress| answer(request, known, requested, progress).ok(),
            App::take_preview,
        );
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

    /// Sets new results of a log; notifies the analyst of depths that a change of scale changed.
    pub(super) fn take_products(&mut self, id: LogId, products: Products) {
        let Some(log) = self.logs.get_mut(id) else {
            return;
        };
        log.preview = None;
        let sentence = log.calibrating.said_of_change(&products);
        if let Some(survey) = &log.survey {
            log.reviewing.follow(survey, &products.navigation);
        }
        log.products = Some(products);
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

    /// Returns the request for first returns ahead of the pipeline, in the visible pings of the
    /// shown log, or in all of them by the method `threshold`; `None` without results or without
    /// side-scan.
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
        self.findings.reference_comparison.stop(&mut self.jobs);
        self.jobs.stop_requested();
        self.pipeline.previewer.forget(&mut self.jobs);
        self.logs.shown.preview = None;
        self.files.to_load.clear();
    }

    /// Returns true if a path is a file of the log, which is never overwritten, and then warns the
    /// analyst.
    pub(super) fn refuses_log(&mut self, id: LogId, path: &Path) -> bool {
        let is_this = |file: &PathBuf| is_same_file(file, path);
        let survey = self.logs.survey_of(id);
        let is_log = survey.is_some_and(|survey| survey.source.files.iter().any(is_this));
        if is_log {
            let path = path.display();
            self.notices.warn(format!("that is the log itself; choose another name: {path}"));
        }
        is_log
    }

    /// Shows first returns that were found ahead of the pipeline, if their settings are still in
    /// force, and starts the search that waited.
    fn take_preview(&mut self, answer: Option<Answer>) {
        if let Some(Answer { key, measured, preview }) = answer {
            self.pipeline.previewer.measured = Some((key, measured));
            let is_current = |preview: &Preview| preview.is_for(&self.logs.shown.settings);
            if let Some(preview) = preview.filter(is_current)
                && self.logs.shown.stale().is_some()
            {
                self.logs.shown.preview = Some(preview.returns);
            }
        }
        if let Some(request) = self.pipeline.previewer.queued.take() {
            self.pipeline.previewer.start(request, &mut self.jobs, true);
        }
    }
}

fn answer(
    request: PreviewRequest,
    known: Option<Arc<Measured>>,
    requested: bool,
    progress: &Progress,
) -> Result<Answer, Cancelled> {
    let key = request.key();
    let measured = match known {
        Some(measured) => measured,
        None => Arc::new(Measured::measure(&request, progress)?),
    };
    let preview = if requested {
        let mut returns = search(&request, &measured, progress)?;
        request.bottom.apply(&request.survey, &mut returns);
        Some(Preview {
            image: request.image,
            first_return: request.first_return,
            returns: Arc::new(returns),
        })
    } else {
        None
    };
    Ok(Answer { key, measured, preview })
}

fn search(
    request: &PreviewRequest,
    measured: &Measured,
    progress: &Progress,
) -> Result<FirstReturns, Cancelled> {
    let settings = &request.first_return;
    match measured {
        Measured::Index(index) => {
            Ok(index.detect(&request.survey, settings.threshold, settings.above_bottom_margin_m))
        }
        Measured::Scale(normalisation) => {
            let end = request.visible.end.min(request.base.port.len());
            let pings = request.visible.start.min(end)..end;
            let seen =
                track_range(&request.survey, normalisation, settings, pings.clone(), progress)?;
            let mut all = FirstReturns::clone(&request.base);
            let sides = [(&mut all.port, &seen.port), (&mut all.starboard, &seen.starboard)];
            for (all, seen) in sides {
                Arc::make_mut(all)[pings.clone()].copy_from_slice(seen);
            }
            all.warnings = seen.warnings;
            Ok(all)
        }
    }
}
