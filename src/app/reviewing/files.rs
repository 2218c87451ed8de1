//! Reads and writes the file of a review: a sidecar file of the log, which itself is never changed.

use super::Reviewing;
use crate::app::jobs::JobKey;
use crate::app::{App, LogId, OpenLog};
use bathyscope_log::support::printable::quoted;
use bathyscope_log::support::progress::Progress;
use bathyscope_objects::review::Review;
use bathyscope_products::export::{self, ExportError};
use bathyscope_products::outputs::write_boxes;
use std::io::Write as _;
use std::path::PathBuf;
use std::sync::Arc;

/// Ending of the name of a review's file.
pub(in crate::app) const SUFFIX: &str = "review.json";

impl App {
    /// Writes the reviews of all logs with boxes, each into its own file or else the sidecar file
    /// of its log.
    pub(in crate::app) fn save_reviews(&mut self) {
        let reviewed = self.logs.reviewed().filter(|log| log.reviewing.has_boxes());
        let reviewed = reviewed.map(|log| (log.id, log.name(), log.review_path()));
        let reviewed: Vec<(LogId, String, Option<PathBuf>)> = reviewed.collect();
        for (id, name, path) in reviewed {
            match path {
                Some(path) => self.save_review(id, path),
                None => self.notices.warn(format!(
                    "{} is no file; save its review while it is shown alone",
                    quoted(&name)
                )),
            }
        }
    }

    /// Writes the review of a log.
    pub(in crate::app) fn save_review(&mut self, id: LogId, path: PathBuf) {
        if self.refuses_log(id, &path) {
            return;
        }
        let Some(log) = self.logs.get_mut(id) else {
            return;
        };
        let refused = &mut log.reviewing.refused;
        if refused.take_if(|refused| *refused == path).is_some() {
            match export::rename_older(&path) {
                Ok(aside) => {
                    let text = "The review that could not be used is kept as";
                    self.notices.notify(format!("{text} {}", aside.display()));
                }
                Err(error) => return self.notices.warn(error),
            }
        }
        let text =
            format!("Saved {} boxes to {}", log.reviewing.review.boxes().len(), path.display());
        self.notices.tell(log.reviewing.save(path).map(|()| text));
    }

    /// Writes boxes, objects and training pictures of the visible logs into a folder.
    pub(in crate::app) fn export_boxes(&mut self, folder: PathBuf) {
        let (logs, review) = (self.logs.processed(), self.survey_review());
        if logs.is_empty() {
            return;
        }
        self.write(move |progress| {
            let written =
                write_boxes(&logs, &review, export::DatasetPart::Train, &folder, progress);
            written.map(|written| written.summary(&folder))
        });
    }

    /// Starts reading a review of the shown log.
    pub(in crate::app) fn open_review(&mut self, path: PathBuf) {
        if !self.read_review(self.logs.shown.id, path, false) {
            self.notices.warn("open the log first, then the review of its boxes");
        }
    }

    /// Starts reading the review in a log's sidecar file, if there is one and the log has no boxes
    /// yet.
    pub(in crate::app) fn look_for_review(&mut self, id: LogId) {
        if let Some(log) = self.logs.get(id)
            && let Some(path) = log.review_path()
            && !log.reviewing.has_boxes()
            && path.is_file()
        {
            self.read_review(id, path, true);
        }
    }

    /// Starts reading a review of a log; `is_found` if it is a sidecar file, not a file that the
    /// analyst opened. Returns true if there is a log.
    fn read_review(&mut self, id: LogId, path: PathBuf, is_found: bool) -> bool {
        let Some(survey) = self.logs.survey_of(id).cloned() else {
            return false;
        };
        let from = path.clone();
        let read = move |_: &Progress| Review::open_for(&from, &survey);
        self.jobs.run(JobKey::ReadReview(id), read, move |app, read| {
            let Some(log) = app.logs.get_mut(id) else {
                return;
            };
            let review = match read {
                Ok(review) => review,
                Err(error) => {
                    log.reviewing.refused = is_found.then_some(path);
                    return app.notices.warn(error);
                }
            };
            let boxes = review.boxes().len();
            let text = if is_found {
                format!("Found {boxes} boxes in the log's sidecar file: {}", path.display())
            } else {
                format!("Opened {boxes} boxes: {}", path.display())
            };
            // The sides may have been exchanged while the file was read.
            let swapped = (log.survey.as_ref()).is_some_and(|survey| survey.swapped_sides);
            let review = Arc::new(review.with_sides(swapped));
            if is_found {
                app.take_unkept("open review", |app| {
                    if let Some(log) = app.logs.get_mut(id) {
                        log.reviewing.set(review.clone());
                    }
                });
            } else {
                app.take_review(id, review.clone(), "open review", false);
            }
            if let Some(log) = app.logs.get_mut(id) {
                log.reviewing.saved = Some(review);
                log.reviewing.path = Some(path);
            }
            app.notices.notify(text);
        });
        true
    }
}

impl OpenLog {
    /// Returns the path of the log's review: its file, or else the sidecar file of the log; `None`
    /// for a log that is no file.
    pub fn review_path(&self) -> Option<PathBuf> {
        let beside = || {
            let log = self.survey.as_ref()?.source.files.first()?;
            Some(log.with_extension(SUFFIX))
        };
        self.reviewing.path.clone().or_else(beside)
    }
}

impl Reviewing {
    /// Writes the boxes into a file, which is the file of the review from now on.
    fn save(&mut self, path: PathBuf) -> Result<(), ExportError> {
        let text = self.review.to_json();
        export::write_atomically(&path, |mut file| {
            file.write_all(text.as_bytes())?;
            file.write_all(b"\n")
        })?;
        self.saved = Some(self.review.clone());
        self.path = Some(path);
        Ok(())
    }
}
