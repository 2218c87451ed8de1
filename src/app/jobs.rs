//! Runs work in background threads, and hands each answer to the state of the window.
//!
//! [`JobQueue::run`] starts work under a [`JobKey`]. When the work has ended, [`App::poll`] calls
//! the function that was passed with it, with the answer. The queue tells what is running and how
//! much of it is done, stops what Cancel stops, and reports a worker that panicked, so that no part
//! of the state has to remember its own work.

use super::error::AppError;
use super::{App, Jobs, LogId, Task, TaskOutcome};
use bathyscope_log::support::progress::Progress;
use std::path::PathBuf;

/// Identity of a piece of work. Work that is started under the key of running work replaces it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum JobKey {
    Process,
    OpenLog,
    OpenProject,
    HashLogs,
    HashUntitled,
    CreateProject,
    SaveProject,
    OpenBaseMap,
    ReadArea,
    OpenReference,
    CompareReference,
    PlanLines,
    ListPasses,
    NextPass,
    ComparePositions,
    CompareHeights,
    Export,
    SearchObjects,
    SearchTail,
    Preview,
    DepthMap,
    Isobaths,
    Mosaic,
    Bottom,
    Picture,
    JoinObjects,
    CountPasses,
    FitShape,
    ListObjects,
    StartFollowing,
    FollowStep,
    FollowWhole,
    CountFigures(LogId),
    PlaceBoxes(LogId),
    ReadReview(LogId),
    ReadTruth(LogId),
    CompareTruth(LogId),
    ReadTable(LogId),
    FindExclusions(LogId),
    TryScale(LogId),
    CheckFiles,
    ListDrives,
    SearchDrive(PathBuf),
}

/// Relation of work to the analyst.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum JobRole {
    /// The analyst has asked for the work: the status line shows it, and Cancel stops it.
    Requested,
    /// The work follows a change of the state or saves it; only newer work stops it.
    Automatic,
    /// The work waits for changes outside the program, and does not count as activity.
    Watch,
}

impl JobKey {
    /// Returns the name of the work, for the status line and for the notice of its failure, and its
    /// role.
    fn kind(&self) -> (&'static str, JobRole) {
        use JobRole::{Automatic, Requested, Watch};
        match self {
            Self::Process => ("processing", Requested),
            Self::OpenLog => ("opening", Requested),
            Self::OpenProject => ("opening the project", Requested),
            Self::HashLogs => ("saving the project", Requested),
            Self::HashUntitled => ("saving decisions", Automatic),
            Self::CreateProject | Self::SaveProject => ("saving the project", Automatic),
            Self::OpenBaseMap => ("opening the base map", Requested),
            Self::ReadArea => ("reading the area", Requested),
            Self::OpenReference => ("opening the reference", Requested),
            Self::CompareReference => ("comparing", Requested),
            Self::PlanLines => ("planning lines", Requested),
            Self::ListPasses | Self::NextPass => ("looking for passes", Requested),
            Self::ComparePositions => ("comparing positions", Requested),
            Self::CompareHeights => ("comparing heights", Automatic),
            Self::Export => ("exporting", Requested),
            Self::SearchObjects => ("finding objects", Requested),
            Self::SearchTail => ("finding objects in new pings", Automatic),
            Self::Preview => ("finding first returns", Automatic),
            Self::DepthMap => ("making the depth map", Automatic),
            Self::Isobaths => ("drawing isobaths", Automatic),
            Self::Mosaic => ("normalising the mosaic's gain", Automatic),
            Self::Bottom => ("making the bottom in 3D", Automatic),
            Self::Picture => ("normalising the waterfall's gain", Automatic),
            Self::JoinObjects => ("joining objects", Automatic),
            Self::CountPasses => ("counting the passes of an object", Automatic),
            Self::FitShape => ("fitting the shape of an object", Automatic),
            Self::ListObjects => ("listing objects", Automatic),
            Self::StartFollowing => ("copying the log", Automatic),
            Self::FollowStep | Self::FollowWhole => ("following the log", Automatic),
            Self::CountFigures(_) => ("counting", Automatic),
            Self::PlaceBoxes(_) => ("locating boxes", Automatic),
            Self::ReadReview(_) => ("reading the review", Automatic),
            Self::ReadTruth(_) => ("reading the known objects", Automatic),
            Self::CompareTruth(_) => ("comparing with the known objects", Automatic),
            Self::ReadTable(_) => ("reading the table", Requested),
            Self::FindExclusions(_) => ("finding exclusions", Automatic),
            Self::TryScale(_) => ("trying the scale", Automatic),
            Self::CheckFiles => ("checking the logs' files", Watch),
            Self::ListDrives | Self::SearchDrive(_) => ("looking for logs on drives", Watch),
        }
    }

    /// Returns the log that the work is about; `None` for work about no log or several.
    fn log(&self) -> Option<LogId> {
        match self {
            Self::CountFigures(log)
            | Self::PlaceBoxes(log)
            | Self::ReadReview(log)
            | Self::ReadTruth(log)
            | Self::CompareTruth(log)
            | Self::ReadTable(log)
            | Self::FindExclusions(log)
            | Self::TryScale(log) => Some(*log),
            _ => None,
        }
    }

    /// Returns the name of the work.
    pub(crate) fn name(&self) -> &'static str {
        self.kind().0
    }

    fn role(&self) -> JobRole {
        self.kind().1
    }
}

/// Function that applies the answer of some work to the state.
type Answer = Box<dyn FnOnce(&mut App) + Send>;

/// Running work.
struct Job {
    key: JobKey,
    task: Task<Answer>,
    /// Function that is called instead of the answer if the worker panicked.
    failed: Answer,
}

/// The running work of the window. Work that is replaced or stopped is cancelled, and its answer is
/// dropped.
pub(crate) struct JobQueue {
    workers: Jobs,
    running: Vec<Job>,
}

impl JobQueue {
    /// Creates an empty queue, whose work is run by `workers`.
    pub(super) fn new(workers: Jobs) -> Self {
        Self { workers, running: Vec::new() }
    }

    /// Returns the way in which work is run.
    pub(crate) fn workers(&self) -> &Jobs {
        &self.workers
    }

    /// Starts `work`, and applies its answer by `then` when it has ended. If the worker panics, the
    /// analyst is warned that the work failed.
    pub(super) fn run<T: Send + 'static>(
        &mut self,
        key: JobKey,
        work: impl FnOnce(&Progress) -> T + Send + 'static,
        then: impl FnOnce(&mut App, T) + Send + 'static,
    ) {
        let name = key.name();
        let failed = move |app: &mut App| app.notices.warn(AppError::Failed(name));
        self.run_or(key, work, then, failed);
    }

    /// Starts `work` as [`JobQueue::run`] does; `failed` is called if the worker panics.
    pub(super) fn run_or<T: Send + 'static>(
        &mut self,
        key: JobKey,
        work: impl FnOnce(&Progress) -> T + Send + 'static,
        then: impl FnOnce(&mut App, T) + Send + 'static,
        failed: impl FnOnce(&mut App) + Send + 'static,
    ) {
        // Running work is cancelled before its successor starts.
        self.stop(&key);
        let task = Task::start(&self.workers, move |progress| {
            let answer = work(progress);
            Box::new(move |app: &mut App| then(app, answer)) as Answer
        });
        self.running.push(Job { key, task, failed: Box::new(failed) });
    }

    /// Stops work and drops its answer. Returns true if it was running.
    pub(super) fn stop(&mut self, key: &JobKey) -> bool {
        let before = self.running.len();
        self.running.retain(|job| job.key != *key);
        self.running.len() < before
    }

    /// Stops the work on a log, which is being closed.
    pub(super) fn stop_log(&mut self, log: LogId) {
        self.running.retain(|job| job.key.log() != Some(log));
    }

    /// Stops the work that the analyst has asked for.
    pub(super) fn stop_requested(&mut self) {
        self.running.retain(|job| job.key.role() != JobRole::Requested);
    }

    /// Returns true if work is running, or its answer was not applied yet.
    pub(crate) fn is_running(&self, key: &JobKey) -> bool {
        self.running.iter().any(|job| job.key == *key)
    }

    /// Returns the done share of some work, 0 to 1; `None` if it is not running.
    pub(crate) fn fraction(&self, key: &JobKey) -> Option<f32> {
        let job = self.running.iter().find(|job| job.key == *key)?;
        Some(job.task.fraction())
    }

    /// Returns the key and the done share of the oldest work that the analyst has asked for; `None`
    /// if none is running.
    pub(super) fn requested(&self) -> Option<(&JobKey, f32)> {
        let job = self.running.iter().find(|job| job.key.role() == JobRole::Requested)?;
        Some((&job.key, job.task.fraction()))
    }

    /// Returns true if work is running that does not only watch for changes.
    pub(super) fn is_busy(&self) -> bool {
        self.running.iter().any(|job| job.key.role() != JobRole::Watch)
    }

    /// Removes work that has ended, and returns the function that applies its answer; `None` if no
    /// work has ended.
    fn next_answer(&mut self) -> Option<Answer> {
        for index in 0..self.running.len() {
            match self.running[index].task.poll() {
                TaskOutcome::Pending => {}
                TaskOutcome::Done(answer) => {
                    self.running.remove(index);
                    return Some(answer);
                }
                TaskOutcome::Failed => return Some(self.running.remove(index).failed),
            }
        }
        None
    }

    /// Waits for the end of some work, and returns the function that applies its answer; `None` if
    /// the work is not running.
    fn wait(&mut self, key: &JobKey) -> Option<Answer> {
        let index = self.running.iter().position(|job| job.key == *key)?;
        let job = self.running.remove(index);
        Some(job.task.wait().unwrap_or(job.failed))
    }
}

/// The last result of a kind of work, and the inputs that it was last requested with. A request
/// with the same inputs starts no work; the last result stays until there is a new one.
pub(super) struct Kept<K, T> {
    requested: Option<K>,
    result: Option<T>,
}

impl<K, T> Default for Kept<K, T> {
    fn default() -> Self {
        Self { requested: None, result: None }
    }
}

impl<K, T> Kept<K, T> {
    /// Returns the last result, which may be that of older inputs.
    pub(super) fn result(&self) -> Option<&T> {
        self.result.as_ref()
    }

    /// Drops the result, and stops work on another.
    pub(super) fn drop_all(&mut self, jobs: &mut JobQueue, job: &JobKey) {
        jobs.stop(job);
        *self = Self::default();
    }
}

impl App {
    /// Applies the answers of all work that has ended. Returns true if there were any.
    pub(super) fn take_answers(&mut self) -> bool {
        let mut any = false;
        // An answer may stop other work that has ended as well, whose answer is then void.
        while let Some(answer) = self.jobs.next_answer() {
            answer(self);
            any = true;
        }
        any
    }

    /// Waits for the end of some work, if it is running, and applies its answer.
    pub(super) fn wait_for(&mut self, key: &JobKey) {
        if let Some(answer) = self.jobs.wait(key) {
            answer(self);
        }
    }

    /// Starts `work` for the inputs `key`, unless they are those of the last request. Its result is
    /// set in the place that `at` finds; `work` returns `None` if it was cancelled or there is no
    /// result, and then the earlier result stays.
    pub(super) fn keep<K: PartialEq, T: Send + 'static>(
        &mut self,
        job: JobKey,
        key: K,
        work: impl FnOnce(&Progress) -> Option<T> + Send + 'static,
        at: impl Fn(&mut Self) -> Option<&mut Kept<K, T>> + Send + 'static,
    ) {
        match at(self) {
            Some(kept) if kept.requested.as_ref() != Some(&key) => kept.requested = Some(key),
            _ => return,
        }
        // After a failure the earlier result stays: the same inputs would fail again.
        self.jobs.run(job, work, move |app, made| {
            if let (Some(kept), Some(made)) = (at(app), made) {
                kept.result = Some(made);
            }
        });
    }
}
