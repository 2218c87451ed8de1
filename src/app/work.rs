//! What runs off the window's thread: started here, collected here.

use super::bottom::ReadBottom;
use super::figures::Figures;
use super::loader::Loading;
use super::measuring::Measuring;
use super::preview::Request;
use super::tabulating::Tabulating;
use super::{Action, App, History, LogId, Notice, OpenLog, Origin, Outcome, Task};
use crate::export::is_same_file;
use crate::pipeline::{Products, Settings};
use crate::printable::one_line;
use crate::survey::Survey;
use crate::system_words::in_plain_words;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Logs remembered.
const RECENT: usize = 10;

impl App {
    /// Collects what the workers finished. Call once a frame.
    pub fn poll(&mut self) {
        self.poll_loading();
        match self.engine.poll() {
            Some(Ok(products)) => self.take_products(products),
            Some(Err(text)) => self.tell(text, true),
            None => {}
        }
        if let Some(preview) = self.previewer.poll(&self.jobs)
            && preview.is_for(&self.log.settings)
            && self.stale().is_some()
        {
            self.log.preview = Some(preview.returns);
        }
        match self.log.counting.as_ref().map(Task::poll) {
            Some(Outcome::Done(figures)) => {
                self.log.figures = figures;
                self.log.counting = None;
            }
            Some(Outcome::Failed) => self.log.counting = None,
            Some(Outcome::Pending) | None => {}
        }
        self.poll_comparing();
        self.poll_tables();
        self.poll_export();
        self.poll_review();
        self.poll_autosave();
        self.poll_detecting();
        self.poll_judging();
        self.poll_places();
        self.poll_base_map();
        self.poll_external();
    }

    fn poll_loading(&mut self) {
        if let Some(outcome) = self.loading.as_ref().and_then(Loading::poll)
            && let Some(loading) = self.loading.take()
        {
            match outcome {
                Ok((survey, drawn)) => self.take_survey(survey, loading.origin, drawn),
                Err(text) => self.tell(text, true),
            }
        }
    }

    fn take_survey(&mut self, survey: Survey, origin: Origin, drawn: Option<ReadBottom>) {
        let path = match origin {
            Origin::Path(path) => Some(path),
            Origin::Demo => None,
        };
        if let Some(path) = &path {
            self.remember(path.clone());
        }
        self.keep_decisions();
        self.withdraw(Action::TakeUpUnsaved);
        let mut reviewing = std::mem::take(&mut self.log.reviewing);
        reviewing.start(&survey);
        // A flat spot belongs to the survey that it was picked in.
        let settings = self.log.settings.with_survey_of(&Settings::default());
        self.log = OpenLog::new(LogId::default(), survey, Arc::new(settings));
        self.log.reviewing = reviewing;
        self.survey_serial += 1;
        self.plane_serial += 1;
        self.tabulating = Tabulating::default();
        self.comparing.leave();
        self.selection = None;
        self.hover = None;
        self.visible = 0..0;
        let log = self
            .log
            .survey
            .as_ref()
            .and_then(|survey| survey.source.files.first().cloned());
        self.take_bottom(log.filter(|_| path.is_some()).as_deref(), drawn);
        self.measuring = Measuring::default();
        self.history = History::default();
        self.previewer.forget();
        if path.is_some() {
            self.look_for_review();
            self.look_for_unsaved();
        }
        self.look_for_truth(path.is_some());
        self.process();
    }

    /// Puts a log on top of the recent ones, by a path that holds in whatever folder the next run starts.
    pub(super) fn remember(&mut self, path: PathBuf) {
        let path = std::path::absolute(&path).unwrap_or(path);
        self.recent.retain(|recent| *recent != path);
        self.recent.insert(0, path);
        self.recent.truncate(RECENT);
    }

    fn take_products(&mut self, products: Products) {
        self.log.preview = None;
        if let Some(survey) = &self.log.survey {
            self.log.reviewing.follow(survey, &products.navigation);
            let (survey, counted) = (survey.clone(), products.clone());
            self.log.counting = Some(Task::start(&self.jobs, move |progress| {
                Figures::of(&survey, &counted, progress).ok()
            }));
        }
        self.log.products = Some(products);
        if let Some(request) = self.preview_request() {
            self.previewer.warm_up(request, &self.jobs);
        }
    }

    /// Starts the pipeline with the settings in force.
    pub(super) fn process(&mut self) {
        if let Some(survey) = &self.log.survey {
            self.engine.request(
                survey.clone(),
                Settings::clone(&self.log.settings),
                self.log.products.clone(),
            );
        }
    }

    /// Starts the search for the first return on what is on screen, ahead of the pipeline.
    pub(super) fn preview_returns(&mut self) {
        if let Some(request) = self.preview_request() {
            self.previewer.want(request, &self.jobs);
        }
    }

    fn preview_request(&self) -> Option<Request> {
        let survey = self
            .log
            .survey
            .as_ref()
            .filter(|survey| survey.has_side_scan())?;
        Some(Request {
            survey: survey.clone(),
            image: self.log.settings.image.clone(),
            first_return: self.log.settings.first_return.clone(),
            bottom: self.log.settings.bottom.clone(),
            visible: self.visible.clone(),
            base: self.log.products.as_ref()?.returns.clone(),
        })
    }

    /// Stops everything that runs; the last results stay.
    pub(super) fn cancel(&mut self) {
        self.engine.cancel();
        self.stop_detecting();
        self.previewer.forget();
        self.log.preview = None;
        self.loading = None;
        self.exporting = None;
        self.opening_base_map = None;
        self.comparing.stop();
        self.tabulating.stop();
        self.log.external.stop_reading();
    }

    /// Tells the analyst a sentence.
    pub(super) fn tell(&mut self, text: String, is_error: bool) {
        self.notices.push(Notice {
            text: one_line(&in_plain_words(&text)),
            is_error,
            offer: None,
        });
    }

    /// Whether a file that is to be written is one of the open log's, which nothing is written over; says so.
    pub(super) fn refuses_log(&mut self, path: &Path) -> bool {
        let is_this = |file: &PathBuf| is_same_file(file, path);
        let is_log = (self.log.survey.as_ref())
            .is_some_and(|survey| survey.source.files.iter().any(is_this));
        if is_log {
            let path = path.display();
            self.tell(
                format!("that is the log itself; choose another name: {path}"),
                true,
            );
        }
        is_log
    }

    /// Tells the analyst a sentence, and what can be done about it.
    pub(super) fn offer(&mut self, text: String, action: Action) {
        self.notices.push(Notice {
            text: one_line(&text),
            is_error: false,
            offer: Some(action),
        });
    }

    /// Takes an offer back that was accepted or makes no sense any more.
    pub(super) fn withdraw(&mut self, action: Action) {
        self.notices.retain(|notice| notice.offer != Some(action));
    }

    /// Starts opening a log; one that is still being opened is dropped.
    pub(super) fn start_loading(&mut self, origin: Origin) {
        self.loading = Some(Loading::start(origin, &self.jobs));
    }
}
