//! The file that a review is kept in: a sidecar file of the log, which is never changed.

use crate::app::error::AppError;
use crate::app::{App, LogId, Outcome, Task};
use crate::detection::review::Review;
use crate::products::export;
use crate::products::outputs::write_boxes;
use crate::support::printable::quoted;
use std::io::Write as _;
use std::path::PathBuf;
use std::sync::Arc;

/// End of the name of a review's file.
const SUFFIX: &str = "review.json";

/// A review being read.
pub(super) struct Opening {
    path: PathBuf,
    /// A sidecar file of the log: it was found, not opened.
    unasked: bool,
    task: Task<Result<Review, AppError>>,
}

impl App {
    /// Where the review is or would be kept: its file, or the sidecar file of the log.
    pub(crate) fn review_path(&self) -> Option<PathBuf> {
        let beside = || {
            let log = self.log.survey.as_ref()?.source.files.first()?;
            Some(log.with_extension(SUFFIX))
        };
        self.log.reviewing.path.clone().or_else(beside)
    }

    /// Whether decisions about a reviewed log are in no file yet.
    pub(crate) fn has_unsaved_review(&self) -> bool {
        self.reviewed_logs().any(|log| log.reviewing.is_unsaved())
    }

    /// Writes the reviews of all logs that differ from their files, each into the file that it has or the sidecar file of its log.
    pub(in crate::app) fn save_reviews(&mut self) {
        let changed = self.reviewed_logs().filter(|log| {
            let reviewing = &log.reviewing;
            reviewing.has_boxes() && !Arc::ptr_eq(&reviewing.review, &reviewing.saved)
        });
        let changed: Vec<LogId> = changed.map(|log| log.id).collect();
        if changed.is_empty() {
            self.notify("the reviews are saved already".to_owned(), false);
        }
        for id in changed {
            self.with_log(id, |app| match app.review_path() {
                Some(path) => app.save_review(path),
                None => {
                    let name = quoted(&app.log.name());
                    let text =
                        format!("{name} is no file; save its review while it is shown alone");
                    app.notify(text, true);
                }
            });
        }
    }

    /// Writes the review.
    pub(in crate::app) fn save_review(&mut self, path: PathBuf) {
        if self.refuses_log(&path) {
            return;
        }
        if self
            .log
            .reviewing
            .refused
            .take_if(|refused| *refused == path)
            .is_some()
        {
            match export::rename_older(&path) {
                Ok(aside) => {
                    let text = "The review that could not be used is kept as";
                    self.notify(format!("{text} {}", aside.display()), false);
                }
                Err(error) => return self.notify(error.to_string(), true),
            }
        }
        let text = self.log.reviewing.review.to_json();
        let written = export::write_atomically(&path, |mut file| {
            file.write_all(text.as_bytes())?;
            file.write_all(b"\n")
        });
        match written {
            Ok(()) => {
                self.log.reviewing.autosave.clear();
                let boxes = self.log.reviewing.review.boxes().len();
                self.notify(format!("Saved {boxes} boxes to {}", path.display()), false);
                self.log.reviewing.saved = self.log.reviewing.review.clone();
                self.log.reviewing.path = Some(path);
            }
            Err(error) => self.notify(error.to_string(), true),
        }
    }

    /// Writes boxes, objects and training pictures of the visible logs into a folder.
    pub(in crate::app) fn export_boxes(&mut self, folder: PathBuf) {
        let (logs, review) = (self.processed_logs(), self.survey_review());
        if logs.is_empty() {
            return;
        }
        self.write(move |progress| {
            let written = write_boxes(&logs, &review, export::Part::Train, &folder, progress);
            written.map(|written| written.summary(&folder))
        });
    }

    /// Starts reading a review of the open survey.
    pub(in crate::app) fn open_review(&mut self, path: PathBuf) {
        self.read_review(path, false);
    }

    /// Starts reading the review in the log's sidecar file, if there is one and nothing is at hand already.
    pub(in crate::app) fn look_for_review(&mut self) {
        if let Some(path) = self.review_path()
            && !self.log.reviewing.has_boxes()
            && path.is_file()
        {
            self.read_review(path, true);
        }
    }

    fn read_review(&mut self, path: PathBuf, unasked: bool) {
        let Some(survey) = &self.log.survey else {
            let text = "open the log first, then the review of its boxes";
            return self.notify(text.to_owned(), true);
        };
        let (survey, from) = (survey.clone(), path.clone());
        let task = Task::start(&self.jobs, move |_| Ok(Review::open_for(&from, &survey)?));
        self.log.reviewing.opening = Some(Opening {
            path,
            unasked,
            task,
        });
    }

    /// Collects a review that was read.
    pub(in crate::app) fn poll_review(&mut self) {
        let Some(opening) = &self.log.reviewing.opening else {
            return;
        };
        let read = match opening.task.poll() {
            Outcome::Pending => return,
            Outcome::Done(read) => read,
            Outcome::Failed => Err(AppError::Failed("reading the review")),
        };
        let Some(opening) = self.log.reviewing.opening.take() else {
            return;
        };
        match read {
            Ok(review) => {
                let boxes = review.boxes().len();
                // The sides may have been exchanged while it was read.
                let swapped = self
                    .log
                    .survey
                    .as_ref()
                    .is_some_and(|one| one.swapped_sides);
                let review = Arc::new(review.with_sides(swapped));
                self.take_review(review.clone(), "open review", false);
                self.log.reviewing.saved = review;
                let path = opening.path.display();
                let text = match opening.unasked {
                    true => format!("Found {boxes} boxes in the log's sidecar file: {path}"),
                    false => format!("Opened {boxes} boxes: {path}"),
                };
                self.notify(text, false);
                self.log.reviewing.path = Some(opening.path);
            }
            Err(error) => {
                self.log.reviewing.refused = opening.unasked.then_some(opening.path);
                self.notify(error.to_string(), true);
            }
        }
    }
}
