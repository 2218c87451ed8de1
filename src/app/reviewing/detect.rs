//! Searches logs for objects with a detector: one log after the other in a background thread, with
//! results as they are found; then the pings that a followed log has got since its last search.
//!
//! The boxes that are found in these pings are no undo step, because undo reverts what the analyst
//! did. An undo step that restores an older version of the boxes leaves pings unsearched, and these
//! are searched again.

use crate::app::error::AppError;
use crate::app::jobs::{JobKey, JobQueue};
use crate::app::{Action, App, LogId, OpenLog};
use bathyscope_log::support::progress::Progress;
use bathyscope_log::survey::Navigation;
use bathyscope_objects::review::{Queue, Review};
use bathyscope_objects::{Detection, DetectorSettings, Model, ModelError, SoFar, find};
use std::collections::VecDeque;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::{Arc, mpsc};

/// Least score of requested boxes, so that a lower threshold can be chosen later without a new
/// search.
const LEAST_SCORE: f32 = 0.05;
/// Number of new pings of a followed log that start a search: at a walking pace the boat covers
/// about half of a tile of the detector in them.
const ENOUGH: usize = 150;
/// Number of earlier pings that are searched again, because an object may have been cut off at the
/// end.
const AGAIN: usize = 300;
/// Name of undo steps of a search.
const LABEL: &str = "find objects";

/// A loaded detector model.
#[derive(Clone)]
struct Detector {
    /// File of the analyst's own model; `None` for the model that comes with the program.
    path: Option<PathBuf>,
    model: Arc<Model>,
}

/// Progress messages of the worker.
enum SearchMessage {
    /// The model is loaded.
    Ready(Detector),
    /// The boxes in the pings searched so far.
    SoFar(SoFar),
}

/// The search of one log.
struct Detecting {
    log: LogId,
    messages: mpsc::Receiver<SearchMessage>,
    /// Number of pings from the log's start that have been searched.
    pings: usize,
    /// Number of all pings of the log when the search began.
    all: usize,
}

/// The detector of the window, and the state of its search of one log after the other.
#[derive(Default)]
pub struct ObjectSearch {
    /// File of the analyst's own model; `None` for the model that comes with the program.
    model_path: Option<PathBuf>,
    /// The model of the last search, kept for the next one.
    detector: Option<Detector>,
    running: Option<Detecting>,
    /// Logs that are waiting to be searched.
    ahead: VecDeque<LogId>,
    /// Number of logs that the search covers.
    logs: usize,
    /// Number of the logs that are done.
    done: usize,
    /// Number of boxes found in the logs that are done.
    found: usize,
    /// True if the new pings of a followed log are searched, because objects were requested.
    searches_tail: bool,
}

impl ObjectSearch {
    /// Sets the model for the next search; `None` for the model that comes with the program.
    pub(in crate::app) fn use_model(&mut self, path: Option<PathBuf>) {
        self.model_path = path;
    }

    /// Returns the file name of the model for searches, or the words for the model that comes with
    /// the program.
    pub(crate) fn model_name(&self) -> String {
        let path = self.model_path.as_deref();
        path.map_or_else(|| "shipped with the program".to_owned(), file_name)
    }

    /// Returns the description of the model that was loaded last; `None` until one is loaded.
    pub(crate) fn model_description(&self) -> Option<&str> {
        let detector = self.detector.as_ref()?;
        Some(&detector.model.description)
    }

    /// Returns true if a log is being searched or is waiting to be searched; the search of new
    /// pings of a followed log does not count.
    pub(crate) fn is_busy(&self) -> bool {
        self.running.is_some() || !self.ahead.is_empty()
    }

    /// Removes a log from the search, because it is being closed or its sides were swapped.
    pub(in crate::app) fn leave(&mut self, log: LogId, jobs: &mut JobQueue) {
        let planned = self.ahead.len();
        self.ahead.retain(|queued| *queued != log);
        let running = self.running.take_if(|running| running.log == log);
        self.logs -= planned - self.ahead.len() + usize::from(running.is_some());
        if running.is_some() {
            jobs.stop(&JobKey::SearchObjects);
        }
    }

    /// Stops and disables the search of the new pings of a followed log.
    fn stop_tail(&mut self, jobs: &mut JobQueue) {
        jobs.stop(&JobKey::SearchTail);
        self.searches_tail = false;
    }
}

/// Progress of a search.
#[derive(Clone, Debug, PartialEq)]
pub struct SearchStatus {
    /// The log that is being searched; `None` while the next log is still being processed.
    pub log: Option<LogId>,
    /// Position of that log among the searched logs, from 1.
    pub place: usize,
    /// Number of logs that the search covers.
    pub logs: usize,
    /// Progress of the search over all its logs, 0 to 1.
    pub share: f32,
}

impl App {
    /// Returns the progress of the running search; `None` if none is running.
    pub fn search_status(&self) -> Option<SearchStatus> {
        let search = &self.findings.search;
        let running = search.running.as_ref();
        let here = self.jobs.fraction(&JobKey::SearchObjects).unwrap_or(0.0);
        search.is_busy().then(|| SearchStatus {
            log: running.map(|running| running.log),
            place: (search.done + 1).min(search.logs),
            logs: search.logs,
            share: (search.done as f32 + here) / search.logs.max(1) as f32,
        })
    }

    /// Starts a search for objects in all visible logs, beginning with the shown log; a running
    /// search is replaced.
    pub(in crate::app) fn detect(&mut self) {
        if self.logs.shown.products.is_none() {
            return self.notices.warn("open a log first, and wait for its results");
        }
        let has_side_scan =
            |log: &&OpenLog| (log.survey.as_ref()).is_some_and(|survey| survey.has_side_scan());
        let shown = self.logs.shown.id;
        let mut logs: Vec<LogId> =
            (self.logs.reviewed().filter(has_side_scan)).map(|log| log.id).collect();
        logs.sort_by_key(|id| *id != shown);
        if logs.is_empty() {
            let text = "there is no usable side-scan in this log to find objects in";
            return self.notices.warn(text);
        }
        self.jobs.stop(&JobKey::SearchObjects);
        let search = &mut self.findings.search;
        search.running = None;
        search.searches_tail = true;
        (search.logs, search.done, search.found) = (logs.len(), 0, 0);
        search.ahead = logs.into();
        self.search_next();
    }

    /// Starts searching the next log that has results; logs that are still being processed are
    /// waited for.
    fn search_next(&mut self) {
        let ahead = self.findings.search.ahead.iter();
        let ready = |id: &LogId| {
            let log = self.logs.get(*id);
            log.is_some_and(|log| log.products.is_some())
        };
        if let Some(place) = ahead.clone().position(ready) {
            if let Some(id) = self.findings.search.ahead.remove(place) {
                self.search_log(id);
            }
        } else if !self.jobs.is_running(&JobKey::Process)
            && (self.pipeline.is_waiting || self.pipeline.requested.is_none())
        {
            // No log is being processed, so that waiting would never end.
            let names = ahead.filter_map(|id| self.logs.get(*id));
            let names: Vec<String> = names.map(OpenLog::name).collect();
            self.stop_detecting();
            let text =
                format!("not searched, since they have no results yet: {}", names.join(", "));
            self.notices.warn(text);
        }
    }

    fn search_log(&mut self, id: LogId) {
        let Some((survey, products)) = self.logs.get(id).and_then(OpenLog::results) else {
            return;
        };
        let (survey, navigation) = (survey.clone(), products.navigation.clone());
        let all = survey.side_scan.len();
        let path = self.findings.search.model_path.clone();
        let known = self.findings.search.detector.clone();
        let known = known.filter(|detector| detector.path == path);
        let (sender, messages) = mpsc::channel();
        let work = move |progress: &Progress| -> Result<Vec<Detection>, AppError> {
            let detector = match known {
                Some(detector) => detector,
                None => load(path)?,
            };
            let model = detector.model.clone();
            // The receiver is dropped when the search is replaced.
            sender.send(SearchMessage::Ready(detector)).ok();
            let settings = DetectorSettings {
                score: Some(LEAST_SCORE.min(model.score)),
                ..DetectorSettings::default()
            };
            let on_found = |so_far| {
                sender.send(SearchMessage::SoFar(so_far)).ok();
            };
            let found = find(&survey, &navigation, &model, &settings, progress, on_found);
            Ok(found?)
        };
        self.findings.search.running = Some(Detecting { log: id, messages, pings: 0, all });
        let name = JobKey::SearchObjects.name();
        self.jobs.run_or(JobKey::SearchObjects, work, Self::take_search, move |app| {
            app.take_search(Err(AppError::Failed(name)));
        });
    }

    /// Returns a sentence about the searched part of the shown log, if a search is still running or
    /// was stopped; `None` if the log was searched from end to end, or if no search is known.
    pub fn search_note(&self) -> Option<String> {
        let review = &self.logs.shown.reviewing.review;
        let running = self.findings.search.running.as_ref();
        match running.filter(|running| running.log == self.logs.shown.id) {
            Some(Detecting { pings: 0, .. }) => Some("The search has begun.".to_owned()),
            Some(Detecting { pings, .. }) => Some(format!(
                "The search is running: pings 0 to {} of {} so far.",
                pings - 1,
                review.identity().pings
            )),
            None if self.findings.search.ahead.contains(&self.logs.shown.id) => {
                Some("This log has not been searched yet.".to_owned())
            }
            None => {
                (review.coverage()).map(|part| format!("The search was stopped: it covers {part}."))
            }
        }
    }

    /// Stops a search; the boxes that it has found stay, with the range of searched pings.
    pub(in crate::app) fn stop_detecting(&mut self) {
        self.findings.search.stop_tail(&mut self.jobs);
        self.jobs.stop(&JobKey::SearchObjects);
        if !self.findings.search.is_busy() {
            return;
        }
        self.findings.search.ahead.clear();
        match self.findings.search.running.take() {
            Some(running) => {
                let last = self.receive_messages(&running);
                self.end_search(running.log, last);
            }
            None => self.end_search(self.logs.shown.id, None),
        }
    }

    /// Ends the undo step of a search that did not reach the end of a log.
    fn end_search(&mut self, id: LogId, last: Option<SoFar>) {
        if let Some(so_far) = last {
            self.adopt(id, &so_far.boxes, so_far.pings, false);
        } else if let Some(log) = self.logs.get_mut(id) {
            let review = log.reviewing.review.clone();
            self.take_review(id, review, LABEL, false);
        }
    }

    /// Receives the messages of a search: keeps its model, whose recommended score becomes the
    /// threshold of the queue if the model is a new one, and returns the last message with boxes.
    fn receive_messages(&mut self, running: &Detecting) -> Option<SoFar> {
        let mut last = None;
        while let Ok(message) = running.messages.try_recv() {
            match message {
                SearchMessage::Ready(detector) => {
                    let known = self.findings.search.detector.as_ref();
                    if known.is_none_or(|known| !Arc::ptr_eq(&known.model, &detector.model)) {
                        let queue = self.logs.shown.reviewing.queue.clone();
                        self.logs.set_queue(&Queue { threshold: detector.model.score, ..queue });
                    }
                    self.findings.search.detector = Some(detector);
                }
                SearchMessage::SoFar(so_far) => last = Some(so_far),
            }
        }
        last
    }

    /// Shows the boxes that the running search has found so far, or continues with the next log.
    pub(in crate::app) fn search_on(&mut self) {
        let Some(mut running) = self.findings.search.running.take() else {
            if self.findings.search.is_busy() {
                self.search_next();
            }
            return;
        };
        if let Some(so_far) = self.receive_messages(&running) {
            running.pings = so_far.pings;
            self.adopt(running.log, &so_far.boxes, so_far.pings, true);
        }
        self.findings.search.running = Some(running);
    }

    /// Adds the boxes of one log when its search has ended. The search of all logs is one undo
    /// step, but the boxes of each log are saved at once.
    fn take_search(&mut self, found: Result<Vec<Detection>, AppError>) {
        let Some(running) = self.findings.search.running.take() else {
            return;
        };
        let last = self.receive_messages(&running);
        let found = match found {
            Ok(found) => found,
            Err(error) => {
                // The same model would fail on the next log as well.
                self.findings.search.ahead.clear();
                self.end_search(running.log, last);
                return self.notices.warn(error);
            }
        };
        let search = &mut self.findings.search;
        search.done += 1;
        search.found += found.len();
        let (is_last, is_none) = (search.ahead.is_empty(), search.found == 0);
        self.adopt(running.log, &found, running.all, !is_last);
        if !is_last {
            self.keep_project(LABEL);
            return self.search_next();
        }
        if is_none {
            self.notices.notify(format!(
                "no objects were found; draw boxes with {}, or choose another model",
                Action::NewBox.key()
            ));
        }
    }

    /// Adds the boxes that were found in the first `pings` pings of a log, as a part of the undo
    /// step of the search; the step stays open if `live` is true.
    fn adopt(&mut self, id: LogId, found: &[Detection], pings: usize, live: bool) {
        let adopted = self.adopted(id, found, 0..pings);
        if let Some(review) = adopted {
            self.take_review(id, review, LABEL, live);
        }
    }

    /// Returns the review of a log with the boxes that were found in some of its pings: they
    /// replace the undecided ones there. `None` without a model or a raster.
    fn adopted(&self, id: LogId, found: &[Detection], pings: Range<usize>) -> Option<Arc<Review>> {
        let detector = self.findings.search.detector.as_ref()?;
        let reviewing = &self.logs.get(id)?.reviewing;
        let path = detector.path.as_deref();
        let name = path.map_or_else(|| "shipped".to_owned(), file_name);
        let names = detector.model.names();
        let raster = reviewing.raster()?;
        let review = (reviewing.review).adopt(&name, names, found, raster, pings);
        Some(Arc::new(review))
    }

    /// Starts searching the pings that a followed log has got since its last search, if objects
    /// were requested.
    pub(in crate::app) fn search_tail(&mut self, id: LogId) {
        let search = &self.findings.search;
        let is_searched = search.is_busy() || self.jobs.is_running(&JobKey::SearchTail);
        if !search.searches_tail || is_searched {
            return;
        }
        let known = search.detector.clone().zip(self.logs.get(id));
        let Some((detector, log)) = known else {
            return;
        };
        let Some((survey, products)) = log.results() else {
            return;
        };
        let searched = log.reviewing.review.searched().last();
        let end = searched.map_or(0, |searched| searched.pings.end);
        let to = survey.side_scan.len().min(products.navigation.pings.len());
        if to < end + ENOUGH {
            return;
        }
        let from = end.saturating_sub(AGAIN);
        let (survey, all) = (survey.clone(), products.navigation.clone());
        let work = move |progress: &Progress| -> Result<Vec<Detection>, AppError> {
            let (stretch, _) = survey.stretch_from(from);
            let navigation = Navigation {
                pings: Arc::new(all.pings[from..to].to_vec()),
                soundings: Arc::default(),
                swath: Arc::default(),
                antenna: Arc::default(),
                zero_heading: 0,
                moving: 0,
                ..(*all).clone()
            };
            let settings = DetectorSettings {
                score: Some(LEAST_SCORE.min(detector.model.score)),
                ..DetectorSettings::default()
            };
            let model = &detector.model;
            let found = find(&stretch, &navigation, model, &settings, progress, |_| ());
            let mut found = found?;
            for detection in &mut found {
                detection.mark.pings =
                    detection.mark.pings.start + from..detection.mark.pings.end + from;
            }
            Ok(found)
        };
        let name = JobKey::SearchTail.name();
        self.jobs.run_or(
            JobKey::SearchTail,
            work,
            move |app, found| app.take_tail(id, found, from..to),
            move |app| app.take_tail(id, Err(AppError::Failed(name)), from..to),
        );
    }

    /// Adds the boxes that were found in some pings, even if the log is not followed any more.
    fn take_tail(
        &mut self,
        log: LogId,
        found: Result<Vec<Detection>, AppError>,
        pings: Range<usize>,
    ) {
        let mut found = match found {
            Ok(found) => found,
            Err(error) => {
                // The same model would fail again.
                self.findings.search.stop_tail(&mut self.jobs);
                return self.notices.warn(error);
            }
        };
        // A box at the edge of the picture is no object, and objects that begin before it are
        // listed already.
        let from = pings.start;
        found.retain(|detection| detection.mark.pings.start > from || from == 0);
        let adopted = self.adopted(log, &found, pings);
        if let Some((log, review)) = self.logs.get_mut(log).zip(adopted) {
            log.reviewing.set(review);
            self.keep_project(LABEL);
        }
    }
}

fn file_name(path: &Path) -> String {
    let name = path.file_name().unwrap_or(path.as_os_str());
    name.to_string_lossy().into_owned()
}

fn load(path: Option<PathBuf>) -> Result<Detector, ModelError> {
    let model = Arc::new(Model::load_or_shipped(path.as_deref())?);
    Ok(Detector { path, model })
}
