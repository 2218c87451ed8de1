//! Asking a detector: on a worker, results as they come.

use crate::app::{App, Outcome, Task};
use crate::detection::model::shipped;
use crate::detection::{Detection, DetectorSettings, Model, SoFar, find};
use std::path::{Path, PathBuf};
use std::sync::{Arc, mpsc};

/// Least confidence that is asked for: what lies below the slider is there when it is drawn down.
const LEAST_SCORE: f32 = 0.05;
/// Name of the step in the undo menu.
const LABEL: &str = "find objects";

/// A detector at hand.
#[derive(Clone)]
pub(super) struct Detector {
    /// `None`: the one that comes with the program.
    path: Option<PathBuf>,
    model: Arc<Model>,
}

/// Progress messages of the worker.
enum SearchMessage {
    /// The model is ready.
    Ready(Detector),
    /// The boxes up to some ping.
    SoFar(SoFar),
}

/// A search under way.
pub(super) struct Detecting {
    messages: mpsc::Receiver<SearchMessage>,
    /// Pings from the log's start on that it has come over.
    pings: usize,
    task: Task<Result<Vec<Detection>, String>>,
}

impl App {
    /// Name of the model that is or will be asked.
    pub fn model_name(&self) -> String {
        let path = self.log.reviewing.model_path.as_deref();
        path.map_or_else(|| "shipped with the program".to_owned(), file_name)
    }

    /// What the model's file was taken for, once it has been loaded.
    pub fn model_description(&self) -> Option<&str> {
        let detector = self.log.reviewing.detector.as_ref()?;
        Some(detector.model.description())
    }

    /// Done share of the search under way, 0 to 1.
    pub fn detect_fraction(&self) -> Option<f32> {
        let detecting = self.log.reviewing.detecting.as_ref()?;
        Some(detecting.task.fraction())
    }

    /// Takes another model for the next search; `None` for the one that comes with the program.
    pub(in crate::app) fn use_model(&mut self, path: Option<PathBuf>) {
        self.log.reviewing.model_path = path;
    }

    /// Starts a search for objects; one that runs is replaced.
    pub(in crate::app) fn detect(&mut self) {
        let (Some(survey), Some(products)) = (&self.log.survey, &self.log.products) else {
            let text = "open a log first; its objects can be found once its track is placed";
            return self.notify(text.to_owned(), true);
        };
        if !survey.has_side_scan() {
            let text = "there is no usable side-scan in this log to find objects in";
            return self.notify(text.to_owned(), true);
        }
        let (survey, navigation) = (survey.clone(), products.navigation.clone());
        let path = self.log.reviewing.model_path.clone();
        let known = self.log.reviewing.detector.clone();
        let known = known.filter(|detector| detector.path == path);
        let (sender, messages) = mpsc::channel();
        let task = Task::start(&self.jobs, move |progress| {
            let detector = match known {
                Some(detector) => detector,
                None => load(path)?,
            };
            let model = detector.model.clone();
            // Nobody listens any more when the search was replaced.
            sender.send(SearchMessage::Ready(detector)).ok();
            let settings = DetectorSettings {
                score: Some(LEAST_SCORE.min(model.score())),
                ..DetectorSettings::default()
            };
            let on_found = |so_far| {
                sender.send(SearchMessage::SoFar(so_far)).ok();
            };
            find(&survey, &navigation, &model, &settings, progress, on_found)
                .map_err(|error| error.to_string())
        });
        self.log.reviewing.detecting = Some(Detecting {
            messages,
            pings: 0,
            task,
        });
    }

    /// Pings from the log's start on that the search under way has come over; `None` while none runs.
    pub fn searched_so_far(&self) -> Option<usize> {
        let detecting = self.log.reviewing.detecting.as_ref()?;
        Some(detecting.pings)
    }

    /// What of the log the boxes do not speak of, in a sentence, because a search still runs or was stopped; `None` where it has
    /// been searched from end to end, and where nothing is known of a search.
    pub fn search_note(&self) -> Option<String> {
        let review = &self.log.reviewing.review;
        match self.searched_so_far() {
            Some(0) => Some("The search has begun.".to_owned()),
            Some(pings) => Some(format!(
                "The search is running: pings 0 to {} of {} so far.",
                pings - 1,
                review.identity().pings
            )),
            None => {
                (review.coverage()).map(|part| format!("The search was stopped: it covers {part}."))
            }
        }
    }

    /// Ends a search; what it found so far stays, with the pings that it has come over.
    pub(in crate::app) fn stop_detecting(&mut self) {
        if let Some(detecting) = self.log.reviewing.detecting.take() {
            let last = self.receive_messages(&detecting);
            self.end_search(last);
        }
    }

    /// Ends the undo step of a search that has come to no end.
    fn end_search(&mut self, last: Option<SoFar>) {
        match last {
            Some(so_far) => self.adopt(&so_far.boxes, so_far.pings, false),
            None => self.take_review(self.log.reviewing.review.clone(), LABEL, false),
        }
    }

    /// Receives the messages of a search: its model, and the last of its boxes.
    fn receive_messages(&mut self, detecting: &Detecting) -> Option<SoFar> {
        let mut last = None;
        while let Ok(message) = detecting.messages.try_recv() {
            match message {
                SearchMessage::Ready(detector) => self.meet(detector),
                SearchMessage::SoFar(so_far) => last = Some(so_far),
            }
        }
        last
    }

    /// Collects what a search found.
    pub(in crate::app) fn poll_detecting(&mut self) {
        let Some(mut detecting) = self.log.reviewing.detecting.take() else {
            return;
        };
        let outcome = detecting.task.poll();
        let last = self.receive_messages(&detecting);
        let found = match outcome {
            Outcome::Pending => {
                if let Some(so_far) = last {
                    detecting.pings = so_far.pings;
                    self.adopt(&so_far.boxes, so_far.pings, true);
                }
                self.log.reviewing.detecting = Some(detecting);
                return;
            }
            Outcome::Done(found) => found,
            Outcome::Failed => Err("the search for objects failed unexpectedly".to_owned()),
        };
        match found {
            Ok(found) => {
                let pings = self.log.reviewing.review.identity().pings;
                self.adopt(&found, pings, false);
                if found.is_empty() {
                    let text =
                        "no objects were found; draw what you see with N, or choose another model";
                    self.notify(text.to_owned(), false);
                }
            }
            Err(text) => {
                self.end_search(last);
                self.notify(text, true);
            }
        }
    }

    /// The first search with a model shows from the confidence that its makers suggest.
    fn meet(&mut self, detector: Detector) {
        let known = self.log.reviewing.detector.as_ref();
        if known.is_none_or(|known| !Arc::ptr_eq(&known.model, &detector.model)) {
            self.log.reviewing.queue.threshold = detector.model.score();
            self.log.reviewing.count_mistakes();
        }
        self.log.reviewing.detector = Some(detector);
    }

    /// Takes the boxes that were found in the log's first pings.
    fn adopt(&mut self, found: &[Detection], pings: usize, live: bool) {
        let Some((detector, raster)) =
            (self.log.reviewing.detector.clone()).zip(self.log.reviewing.raster().cloned())
        else {
            return;
        };
        let path = detector.path.as_deref();
        let name = path.map_or_else(|| "shipped".to_owned(), file_name);
        let review = &self.log.reviewing.review;
        let names = detector.model.names();
        let review = review.adopt_part(&name, names, found, &raster, 0..pings);
        self.take_review(Arc::new(review), LABEL, live);
    }
}

fn file_name(path: &Path) -> String {
    let name = path.file_name().unwrap_or(path.as_os_str());
    name.to_string_lossy().into_owned()
}

fn load(path: Option<PathBuf>) -> Result<Detector, String> {
    let loaded = match &path {
        Some(path) => Model::load(path),
        None => shipped(),
    };
    let model = Arc::new(loaded.map_err(|error| error.to_string())?);
    Ok(Detector { path, model })
}
