//! Decisions are kept as they are made: in a sidecar file of the log, written aside and renamed, every few seconds
//! and when the log or the window is closed. What an earlier run left there is offered, never mixed in unasked.

use super::{Parked, Reviewing, is_touched};
use crate::app::error::AppError;
use crate::app::{Action, App, Outcome, Task};
use crate::detection::review::{Review, Reviewed};
use crate::products::export::{self, ExportError};
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Least time between two writes.
const EVERY: Duration = Duration::from_secs(3);
/// End of the name of the file, in place of the log's.
const SUFFIX: &str = "review.unsaved.json";

/// A version on its way into the file.
struct Writing {
    review: Arc<Review>,
    task: Task<Result<(), ExportError>>,
}

/// What is kept, and what an earlier run left.
#[derive(Default)]
pub(super) struct Autosave {
    /// The log; `None` when it is no file.
    log: Option<PathBuf>,
    /// The version in the file.
    written: Option<Arc<Review>>,
    last: Option<Instant>,
    writing: Option<Writing>,
    looking: Option<Task<Result<Review, AppError>>>,
    /// Decisions of an earlier run that nobody has taken up yet.
    left: Option<Arc<Review>>,
    /// The file cannot be written; it was said.
    failed: bool,
}

impl Autosave {
    /// Whether a version is in the file.
    pub(super) fn holds(&self, review: &Arc<Review>) -> bool {
        let written = self.written.as_ref();
        written.is_some_and(|written| Arc::ptr_eq(written, review))
    }

    /// Takes a version for the one in the file that says the same of a longer state of the log.
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

    /// How long the next write has to wait.
    fn wait(&self) -> Duration {
        let passed = self.last.map_or(EVERY, |last| last.elapsed());
        EVERY.saturating_sub(passed)
    }

    /// What one write does: where to, and whether decisions that lie there were never taken up. They go under another name, that of no
    /// file.
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

    /// The review was saved: what was kept on the way is not needed any more.
    pub(super) fn clear(&mut self) {
        self.writing = None;
        if self.written.take().is_some()
            && let Some(path) = self.path()
        {
            // Left behind, it would only be offered again.
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
    /// Whether closing would lose decisions.
    fn is_at_risk(&self) -> bool {
        !Arc::ptr_eq(&self.review, &self.saved) && is_touched(&self.review) && !self.is_kept
    }
}

impl App {
    /// Whether closing now would lose decisions: they are in no file.
    pub(crate) fn is_at_risk(&self) -> bool {
        let here = self.logs().any(|log| {
            let reviewing = &log.reviewing;
            reviewing.is_unsaved() && !reviewing.autosave.holds(&reviewing.review)
        });
        here || self.logs.parked.iter().any(Parked::is_at_risk)
    }

    /// Time until decisions are due to be written; `None` when there is nothing to write.
    pub(crate) fn autosave_due(&self) -> Option<Duration> {
        self.logs()
            .filter_map(|log| log.reviewing.autosave_due())
            .min()
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
}

impl App {
    /// Writes decisions when they are due, and notifies of those that an earlier run left.
    pub(in crate::app) fn poll_autosave(&mut self) {
        self.poll_left();
        if let Some(writing) = self.log.reviewing.autosave.writing.take() {
            match writing.task.poll() {
                Outcome::Pending => self.log.reviewing.autosave.writing = Some(writing),
                Outcome::Done(Ok(())) => self.log.reviewing.autosave.written = Some(writing.review),
                Outcome::Done(Err(error)) => self.cannot_keep(&error.into()),
                Outcome::Failed => self.cannot_keep(&AppError::Failed("the writing")),
            }
        }
        if self.log.reviewing.autosave_due() == Some(Duration::ZERO) {
            let review = self.log.reviewing.review.clone();
            let autosave = &mut self.log.reviewing.autosave;
            if let Some(write) = autosave.next() {
                let requested = review.clone();
                let task = Task::start(&self.jobs, move |_| write(&requested));
                autosave.last = Some(Instant::now());
                autosave.writing = Some(Writing { review, task });
            }
        }
    }

    /// Writes what is not in the file yet, now: another log is opened, or the window closes.
    pub(crate) fn keep_decisions(&mut self) {
        // A write under way ends before this one, so that the newest stays.
        while self.log.reviewing.autosave.writing.is_some() {
            self.poll_autosave();
            std::thread::sleep(Duration::from_millis(1));
        }
        if !self.log.reviewing.wants_autosave() {
            return;
        }
        let review = self.log.reviewing.review.clone();
        match self
            .log
            .reviewing
            .autosave
            .next()
            .map(|write| write(&review))
        {
            Some(Ok(())) => self.log.reviewing.autosave.written = Some(review),
            Some(Err(error)) => self.cannot_keep(&error.into()),
            None => {}
        }
    }

    fn cannot_keep(&mut self, why: &AppError) {
        self.log.reviewing.autosave.failed = true;
        let text = format!(
            "decisions cannot be saved automatically; save the review in the Review menu: {why}"
        );
        self.notify(text, true);
    }

    /// Keeps the decisions about a log that is a file from now on, and looks for those that an earlier run left.
    pub(in crate::app) fn look_for_unsaved(&mut self) {
        let Some(survey) = &self.log.survey else {
            return;
        };
        let autosave = &mut self.log.reviewing.autosave;
        autosave.log = survey.source.files.first().cloned();
        let Some(path) = autosave.path().filter(|path| path.is_file()) else {
            return;
        };
        let survey = survey.clone();
        autosave.looking = Some(Task::start(&self.jobs, move |_| {
            Ok(Review::open_for(&path, &survey)?)
        }));
    }

    fn poll_left(&mut self) {
        // The saved review comes first: what was left is compared with it.
        if self.log.reviewing.opening.is_some() {
            return;
        }
        let autosave = &mut self.log.reviewing.autosave;
        let left = match autosave.looking.as_ref().map(Task::poll) {
            Some(Outcome::Done(left)) => left,
            Some(Outcome::Failed) => Err(AppError::Failed("reading them")),
            Some(Outcome::Pending) | None => return,
        };
        autosave.looking = None;
        let now = &self.log.reviewing.review;
        match left {
            // This run wrote it.
            Ok(left) if left.shared() == now.shared() => autosave.written = Some(now.clone()),
            Ok(left) => {
                let decided = left.boxes().filter(|one| Reviewed::is_kept(one)).count();
                autosave.left = Some(Arc::new(left));
                let text = format!(
                    "Decisions about {decided} boxes were not saved when this log was last open"
                );
                self.offer(text, Action::TakeUpUnsaved);
            }
            Err(error) => {
                // Never written over: it may be somebody's work.
                autosave.log = None;
                self.notify(format!("cannot use the unsaved decisions: {error}"), true);
            }
        }
    }

    /// Takes up what an earlier run left, as one undo step.
    pub(in crate::app) fn take_up_unsaved(&mut self) {
        let Some(left) = self.log.reviewing.autosave.left.take() else {
            let text = "there are no unsaved decisions of an earlier run about this log";
            return self.notify(text.to_owned(), true);
        };
        self.log.reviewing.autosave.written = Some(left.clone());
        self.take_review(left, "restore decisions", false);
        self.withdraw(Action::TakeUpUnsaved);
    }
}
