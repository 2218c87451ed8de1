//! Saves decisions as they are made: in a sidecar file of the log, written under another name and
//! renamed, every few seconds and when the log or the window is closed. Decisions that an earlier
//! run left in the file are offered to the analyst, but never merged without a request.

use super::{Parked, Reviewing, is_touched};
use crate::app::error::AppError;
use crate::app::{Action, App, Jobs, LogId, Task, TaskOutcome};
use bathyscope_bottom::presentation::text;
use bathyscope_log::support::progress::Progress;
use bathyscope_objects::review::{Review, Reviewed};
use bathyscope_products::export::{self, ExportError};
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Least time between two writes.
const EVERY: Duration = Duration::from_secs(3);
/// Ending of the file's name, which replaces that of the log.
const SUFFIX: &str = "review.unsaved.json";

/// A version of the review that is being written into the file.
struct Writing {
    review: Arc<Review>,
    task: Task<Result<(), ExportError>>,
}

/// State of the automatic saving of a log's decisions.
#[derive(Default)]
pub(super) struct Autosave {
    /// The file of the log; `None` if the log is no file.
    log: Option<PathBuf>,
    /// The version in the file, if this run wrote or restored it.
    written: Option<Arc<Review>>,
    last: Option<Instant>,
    writing: Option<Writing>,
    looking: Option<Task<Result<Review, AppError>>>,
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

    pub(super) fn is_looking(&self) -> bool {
        self.looking.is_some()
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
        self.writing = None;
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
        self.logs().filter_map(|log| log.reviewing.autosave_due()).min()
    }
}

impl Reviewing {
    fn autosave_due(&self) -> Option<Duration> {
        let is_due = self.autosave.writing.is_none() && self.wants_autosave();
        is_due.then(|| self.autosave.wait())
    }

    fn wants_autosave(&self) -> bool {
        let reviewing = self;
        let autosave = &reviewing.autosave;
        let is_possible = autosave.log.is_some() && !autosave.failed && !autosave.is_looking();
        is_possible && reviewing.is_unsaved() && !autosave.holds(&reviewing.review)
    }

    /// Collects a finished write, and starts the next one when the time has come.
    fn poll_writing(&mut self, jobs: &Jobs) -> Result<(), AppError> {
        let collected = self.collect_writing();
        self.autosave.failed |= collected.is_err();
        if self.autosave_due() == Some(Duration::ZERO)
            && let Some(write) = self.autosave.next()
        {
            let review = self.review.clone();
            let requested = review.clone();
            let task = Task::start(jobs, move |_| write(&requested));
            self.autosave.last = Some(Instant::now());
            self.autosave.writing = Some(Writing { review, task });
        }
        collected
    }

    fn collect_writing(&mut self) -> Result<(), AppError> {
        let Some(writing) = self.autosave.writing.take() else {
            return Ok(());
        };
        match writing.task.poll() {
            TaskOutcome::Pending => self.autosave.writing = Some(writing),
            TaskOutcome::Done(written) => {
                written?;
                self.autosave.written = Some(writing.review);
            }
            TaskOutcome::Failed => return Err(AppError::Failed("the writing")),
        }
        Ok(())
    }

    /// Writes the decisions that are not in the file yet.
    fn write_now(&mut self) -> Result<(), AppError> {
        if self.wants_autosave()
            && let Some(write) = self.autosave.next()
        {
            let written = write(&self.review);
            self.autosave.failed = written.is_err();
            written?;
            self.autosave.written = Some(self.review.clone());
        }
        Ok(())
    }

    /// Collects the decisions that an earlier run left. Returns the number of boxes that it decided
    /// about, once; `None` if there are none.
    fn poll_left(&mut self) -> Result<Option<usize>, AppError> {
        // The saved review must be read first, because the left decisions are compared with it.
        if self.opening.is_some() {
            return Ok(None);
        }
        let autosave = &mut self.autosave;
        let left = match autosave.looking.as_ref().map(Task::poll) {
            Some(TaskOutcome::Done(left)) => left,
            Some(TaskOutcome::Failed) => Err(AppError::Failed("reading them")),
            Some(TaskOutcome::Pending) | None => return Ok(None),
        };
        autosave.looking = None;
        match left {
            // This run wrote the file.
            Ok(left) if left.shared() == self.review.shared() => {
                autosave.written = Some(self.review.clone());
                Ok(None)
            }
            Ok(left) => {
                let decided = left.boxes().filter(|one| Reviewed::is_kept(one)).count();
                autosave.left = Some(Arc::new(left));
                Ok(Some(decided))
            }
            Err(error) => {
                // A file that cannot be read is never overwritten: it may be somebody's work.
                autosave.log = None;
                Err(error)
            }
        }
    }
}

impl App {
    /// Writes decisions about a log when the time has come, and notifies the analyst of decisions
    /// that an earlier run left.
    pub(in crate::app) fn poll_autosave(&mut self, id: LogId) {
        let jobs = self.jobs.clone();
        let Some(log) = self.log_mut(id) else {
            return;
        };
        let left = log.reviewing.poll_left();
        let written = log.reviewing.poll_writing(&jobs);
        match left {
            Ok(Some(decided)) => {
                let boxes = text::plural(decided, "box", "boxes");
                let notice =
                    format!("Decisions about {boxes} were not saved when this log was last open");
                self.offer(notice, Action::TakeUpUnsaved);
            }
            Ok(None) => {}
            Err(error) => {
                self.warn(format!("cannot use the unsaved decisions: {error}"));
            }
        }
        self.say_not_kept(written);
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
        while (self.log_mut(id)).is_some_and(|log| log.reviewing.autosave.writing.is_some()) {
            self.poll_autosave(id);
            std::thread::sleep(Duration::from_millis(1));
        }
        let written = self.log_mut(id).map(|log| log.reviewing.write_now());
        self.say_not_kept(written.unwrap_or(Ok(())));
    }

    fn say_not_kept(&mut self, written: Result<(), AppError>) {
        if let Err(why) = written {
            let text = format!(
                "decisions cannot be saved automatically; save the review in the Review menu: {why}"
            );
            self.warn(text);
        }
    }

    /// Starts saving the decisions about a log that is a file, and searches for those that an
    /// earlier run left.
    pub(in crate::app) fn look_for_unsaved(&mut self, id: LogId) {
        let jobs = self.jobs.clone();
        let Some(log) = self.log_mut(id) else {
            return;
        };
        let Some(survey) = log.survey.clone() else {
            return;
        };
        let autosave = &mut log.reviewing.autosave;
        autosave.log = survey.source.files.first().cloned();
        if let Some(path) = autosave.path().filter(|path| path.is_file()) {
            let read = move |_: &Progress| Ok(Review::open_for(&path, &survey)?);
            autosave.looking = Some(Task::start(&jobs, read));
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
