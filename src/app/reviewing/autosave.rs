//! Saves decisions as they are made: in a sidecar file of the log, written under another name and
//! renamed, every few seconds and when the log or the window is closed. Decisions that an earlier
//! run left in the file are offered to the analyst, but never merged without a request.

use super::{Parked, is_touched};
use crate::app::error::AppError;
use crate::app::jobs::JobKey;
use crate::app::{Action, App, LogId};
use bathyscope_bottom::presentation::text;
use bathyscope_objects::review::{Review, ReviewError, Reviewed};
use bathyscope_products::export::{self, ExportError};
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Least time between two writes.
const EVERY: Duration = Duration::from_secs(3);
/// Ending of the file's name, which replaces that of the log.
const SUFFIX: &str = "review.unsaved.json";

/// State of the automatic saving of a log's decisions.
#[derive(Default)]
pub(super) struct Autosave {
    /// The file of the log; `None` if the log is no file.
    log: Option<PathBuf>,
    /// The version in the file, if this run wrote or restored it.
    written: Option<Arc<Review>>,
    last: Option<Instant>,
    /// Contents of a file of an earlier run that was found, until they are compared with the saved
    /// review.
    found: Option<Result<Review, ReviewError>>,
    /// Decisions of an earlier run that the analyst has not restored yet.
    left: Option<Arc<Review>>,
    /// True if the file cannot be written, and the analyst was notified.
    failed: bool,
}

impl Autosave {
    /// Returns true if a version of the review is the one in the file.
    pub(super) fn holds(&self, review: &Arc<Review>) -> bool {
        let written = self.written.as_ref();
        written.is_some_and(|written| Arc::ptr_eq(written, review))
    }

    /// Replaces the version in the file, if it is `before`, by the equal version for a longer state
    /// of the log.
    pub(super) fn carry(&mut self, before: &Arc<Review>, carried: &Arc<Review>) {
        if self.holds(before) {
            self.written = Some(carried.clone());
        }
    }

    fn path(&self) -> Option<PathBuf> {
        Some(self.log.as_ref()?.with_extension(SUFFIX))
    }

    /// Returns the time until the next write is due.
    fn wait(&self) -> Duration {
        let passed = self.last.map_or(EVERY, |last| last.elapsed());
        EVERY.saturating_sub(passed)
    }

    /// Returns the function that does the next write; `None` if the log has no file. If the file
    /// holds decisions of an earlier run that were not restored, the function first renames it to
    /// an unused name.
    fn next(&mut self) -> Option<impl FnOnce(&Review) -> Result<(), ExportError> + Send + use<>> {
        let path = self.path()?;
        let was_left = self.left.take().is_some();
        Some(move |review: &Review| {
            if was_left {
                export::rename_older(&path)?;
            }
            write(&path, review)
        })
    }

    /// Removes the file after the review was saved, because its decisions are not needed any more.
    pub(super) fn clear(&mut self) {
        if self.written.take().is_some()
            && let Some(path) = self.path()
        {
            // A remaining file would only be offered again.
            std::fs::remove_file(path).ok();
        }
    }
}

fn write(path: &Path, review: &Review) -> Result<(), ExportError> {
    let text = review.to_json();
    export::write_atomically(path, |mut file| {
        file.write_all(text.as_bytes())?;
        file.write_all(b"\n")
    })
}

impl Parked {
    /// Returns true if closing the window would lose the decisions of this review.
    fn is_at_risk(&self) -> bool {
        !Arc::ptr_eq(&self.review, &self.saved) && is_touched(&self.review) && !self.is_kept
    }
}

impl App {
    /// Returns true if closing the window now would lose decisions, because they are in no file.
    pub fn is_at_risk(&self) -> bool {
        let here = self.logs().any(|log| {
            let reviewing = &log.reviewing;
            reviewing.is_unsaved() && !reviewing.autosave.holds(&reviewing.review)
        });
        here || self.logs.parked.iter().any(Parked::is_at_risk)
    }

    /// Returns the time until decisions must be written; `None` if there is nothing to write.
    pub fn autosave_due(&self) -> Option<Duration> {
        self.logs().filter_map(|log| self.autosave_due_of(log.id)).min()
    }

    /// Returns the time until decisions about a log must be written; `None` if there is nothing to
    /// write.
    fn autosave_due_of(&self, id: LogId) -> Option<Duration> {
        let is_writing = self.is_running(&JobKey::WriteUnsaved(id));
        let reviewing = &self.open_log(id).filter(|_| !is_writing)?.reviewing;
        self.wants_autosave(id).then(|| reviewing.autosave.wait())
    }

    fn wants_autosave(&self, id: LogId) -> bool {
        let Some(reviewing) = self.open_log(id).map(|log| &log.reviewing) else {
            return false;
        };
        let autosave = &reviewing.autosave;
        let is_read = autosave.found.is_none() && !self.is_running(&JobKey::ReadUnsaved(id));
        let is_possible = autosave.log.is_some() && !autosave.failed && is_read;
        is_possible && reviewing.is_unsaved() && !autosave.holds(&reviewing.review)
    }

    /// Writes decisions about a log when the time has come, and notifies the analyst of decisions
    /// that an earlier run left.
    pub(in crate::app) fn autosave(&mut self, id: LogId) {
        // The saved review is read first, because the left decisions are compared with it.
        if !self.is_running(&JobKey::ReadReview(id))
            && let Some(found) =
                self.log_mut(id).and_then(|log| log.reviewing.autosave.found.take())
        {
            self.take_left(id, found);
        }
        if self.autosave_due_of(id) != Some(Duration::ZERO) {
            return;
        }
        let Some(log) = self.log_mut(id) else {
            return;
        };
        if let Some(write) = log.reviewing.autosave.next() {
            log.reviewing.autosave.last = Some(Instant::now());
            let review = log.reviewing.review.clone();
            let requested = review.clone();
            self.jobs.run_or(
                JobKey::WriteUnsaved(id),
                move |_| write(&requested),
                move |app, written| app.take_written(id, review, written.map_err(AppError::from)),
                move |app| {
                    // The next write would fail as well.
                    if let Some(log) = app.log_mut(id) {
                        log.reviewing.autosave.failed = true;
                    }
                    app.say_not_kept(&AppError::Failed("the writing"));
                },
            );
        }
    }

    /// Remembers the version of a review that was written, or that writing failed.
    fn take_written(&mut self, id: LogId, review: Arc<Review>, written: Result<(), AppError>) {
        if let Some(log) = self.log_mut(id) {
            let autosave = &mut log.reviewing.autosave;
            autosave.failed = written.is_err();
            if written.is_ok() {
                autosave.written = Some(review);
            }
        }
        if let Err(why) = written {
            self.say_not_kept(&why);
        }
    }

    /// Offers the decisions of an earlier run to the analyst, unless they are those of this run.
    fn take_left(&mut self, id: LogId, found: Result<Review, ReviewError>) {
        let Some(log) = self.log_mut(id) else {
            return;
        };
        let reviewing = &mut log.reviewing;
        match found {
            // This run wrote the file.
            Ok(left) if left.shared() == reviewing.review.shared() => {
                reviewing.autosave.written = Some(reviewing.review.clone());
            }
            Ok(left) => {
                let decided =
                    left.boxes().filter(|review_box| Reviewed::is_kept(review_box)).count();
                reviewing.autosave.left = Some(Arc::new(left));
                let boxes = text::plural(decided, "box", "boxes");
                let notice =
                    format!("Decisions about {boxes} were not saved when this log was last open");
                self.offer(notice, Action::TakeUpUnsaved);
            }
            Err(error) => {
                // A file that cannot be read is never overwritten: it may be somebody's work.
                reviewing.autosave.log = None;
                self.warn(format!("cannot use the unsaved decisions: {error}"));
            }
        }
    }

    /// Writes the unsaved decisions about all logs now, because others are opened or the window
    /// closes.
    pub fn keep_decisions(&mut self) {
        for id in self.log_ids() {
            self.keep_decisions_of(id);
        }
    }

    /// Writes the unsaved decisions about a log now, because it is closed.
    pub(in crate::app) fn keep_decisions_of(&mut self, id: LogId) {
        // A running write must end before this one, so that the newest version stays.
        self.wait_for(&JobKey::WriteUnsaved(id));
        if !self.wants_autosave(id) {
            return;
        }
        let Some(log) = self.log_mut(id) else {
            return;
        };
        if let Some(write) = log.reviewing.autosave.next() {
            let review = log.reviewing.review.clone();
            let written = write(&review).map_err(AppError::from);
            self.take_written(id, review, written);
        }
    }

    fn say_not_kept(&mut self, why: &AppError) {
        self.warn(format!(
            "decisions cannot be saved automatically; save the review in the Review menu: {why}"
        ));
    }

    /// Starts saving the decisions about a log that is a file, and searches for those that an
    /// earlier run left.
    pub(in crate::app) fn look_for_unsaved(&mut self, id: LogId) {
        let Some(log) = self.log_mut(id) else {
            return;
        };
        let Some(survey) = log.survey.clone() else {
            return;
        };
        let autosave = &mut log.reviewing.autosave;
        autosave.log = survey.source.files.first().cloned();
        if let Some(path) = autosave.path().filter(|path| path.is_file()) {
            self.jobs.run_or(
                JobKey::ReadUnsaved(id),
                move |_| Review::open_for(&path, &survey),
                move |app, found| {
                    if let Some(log) = app.log_mut(id) {
                        log.reviewing.autosave.found = Some(found);
                    }
                },
                move |app| {
                    // A file that cannot be read is never overwritten: it may be somebody's work.
                    if let Some(log) = app.log_mut(id) {
                        log.reviewing.autosave.log = None;
                    }
                    let name = JobKey::ReadUnsaved(id).name();
                    app.warn(AppError::Failed(name).to_string());
                },
            );
        }
    }

    /// Restores the decisions that an earlier run left about the shown log, as one undo step.
    pub(in crate::app) fn take_up_unsaved(&mut self) {
        let Some(left) = self.log.reviewing.autosave.left.take() else {
            let text = "there are no unsaved decisions of an earlier run about this log";
            return self.warn(text.to_owned());
        };
        self.log.reviewing.autosave.written = Some(left.clone());
        self.take_review(self.log.id, left, "restore decisions", false);
        self.withdraw(Action::TakeUpUnsaved);
    }
}
