//! Following a log while its recorder writes it: new pings appear as they come, what is there
//! stays, and from time to time everything is made anew from the whole log, so that at the end the
//! results are those of the finished file.
//!
//! `step` is the work in a background thread, `publish` shows what came of it, `scale` keeps the
//! scale that was in force, `whole` says when everything is made anew. Its results for the new
//! pings are provisional: they go by the calibration of the last run over the whole log
//! ([`bathyscope_products::pipeline::extend`]). That run is repeated whenever the log grew by a
//! quarter, so the work for each ping does not grow with the log. Where objects were searched for,
//! what is new is searched too. The log is only ever read, as a private copy
//! ([`bathyscope_log::formats::GrowingLog`]).

mod publish;
mod scale;
mod step;
mod whole;

use super::{App, LogId, OpenLog, Task, TaskOutcome};
use bathyscope_bottom::calibration::PingRange;
use bathyscope_bottom::presentation::text::count;
use bathyscope_log::support::printable::quoted;
use bathyscope_log::survey::{Bytes, Survey};
use bathyscope_products::pipeline::EngineStatus;
use std::sync::Arc;
use std::time::{Duration, Instant};
use step::{FollowedLog, Grown, StepError, Tools};

/// Time between two looks at the log.
const LOOK: Duration = Duration::from_millis(250);
/// Longest time that added bytes wait to be shown.
const LONGEST_WAIT: Duration = Duration::from_secs(2);
/// Growth of the log, as a factor, after which results of the whole log are made again.
const WHOLE_AGAIN: f64 = 1.25;
/// Time without added bytes after which results of the whole log are made again.
const QUIET: Duration = Duration::from_secs(8);
/// Time between two runs over the whole log.
const BETWEEN_WHOLE: Duration = Duration::from_secs(3);
/// Time without added bytes after which the status line reports it.
const SILENT: Duration = Duration::from_secs(5);

/// The log that is followed, if one is.
#[derive(Default)]
pub(super) struct Following {
    active: Option<Active>,
    /// Grows each time a log begins to be followed: the waterfall goes to its end.
    serial: u64,
}

/// A log being followed.
struct Active {
    log: LogId,
    /// `None` while a step has them.
    tools: Option<Tools>,
    starting: Option<Task<Result<Tools, StepError>>>,
    stepping: Option<Stepping>,
    whole: Option<Task<Result<FollowedLog, StepError>>>,
    /// Results of the whole log as it was a moment ago: what the next step goes on from.
    fresh: Option<FollowedLog>,
    /// Bytes of the log when it was run over as a whole, and when that was.
    whole_bytes: u64,
    whole_at: Instant,
    looked: Option<Instant>,
    /// Time at which added bytes were last found.
    added: Instant,
    /// Time at which bytes that are not shown yet were first found.
    waiting: Option<Instant>,
    /// It is read to its end once more, and that is all.
    ends: Option<End>,
    /// That reading has begun.
    is_last: bool,
    /// The stretch that its scale is measured on, where it is one.
    stretch: Option<PingRange>,
}

/// A step under way.
struct Stepping {
    /// Recording that the step goes on from.
    from: Arc<Survey>,
    /// True if that recording has fresh results of the whole log.
    is_fresh: bool,
    task: Task<(Tools, Result<Grown, StepError>)>,
}

/// Reason that a log is no longer followed.
enum End {
    /// The analyst does not want it any more.
    Asked,
    /// It cannot be.
    Failed,
}

/// State of following, for the status line.
#[derive(Clone, Debug, PartialEq)]
pub enum FollowStatus {
    /// The log is being copied.
    Starting,
    /// It grows.
    Growing {
        /// Side-scan pings that are shown.
        pings: usize,
        /// Time that added bytes have waited to be shown.
        behind: Duration,
    },
    /// The log has not grown for a while.
    Silent {
        /// Time without growth.
        since: Duration,
    },
    /// Its results are made of the whole log once more.
    Ending,
}

impl Following {
    /// Returns true if a step or a run is under way.
    pub(super) fn is_busy(&self) -> bool {
        let works = |active: &Active| {
            active.starting.is_some()
                || active.stepping.is_some()
                || active.whole.is_some()
                || active.ends.is_some()
        };
        self.active.as_ref().is_some_and(works)
    }
}

impl App {
    /// The log that is followed.
    pub fn followed(&self) -> Option<LogId> {
        let active = self.following.active.as_ref();
        active.filter(|active| active.ends.is_none()).map(|active| active.log)
    }

    /// Returns true if the log that is shown is followed.
    pub fn is_following(&self) -> bool {
        self.followed() == Some(self.log.id)
    }

    /// Grows each time a log begins to be followed.
    pub(crate) fn follow_serial(&self) -> u64 {
        self.following.serial
    }

    /// Returns the state of following; `None` while no log is followed.
    pub fn follow_status(&self) -> Option<FollowStatus> {
        let active = self.following.active.as_ref()?;
        if active.ends.is_some() {
            return Some(FollowStatus::Ending);
        }
        if active.starting.is_some() {
            return Some(FollowStatus::Starting);
        }
        let silent = active.added.elapsed();
        if silent > SILENT && active.waiting.is_none() {
            return Some(FollowStatus::Silent { since: silent });
        }
        let log = self.open_log(active.log)?;
        Some(FollowStatus::Growing {
            pings: log.survey.as_ref().map_or(0, |survey| survey.side_scan.len()),
            behind: active.waiting.map_or(Duration::ZERO, |since| since.elapsed()),
        })
    }

    /// Time until the log is read again; `None` while none is followed.
    pub(crate) fn follow_due(&self) -> Option<Duration> {
        let active = self.following.active.as_ref()?;
        let passed = active.looked.map_or(LOOK, |looked| looked.elapsed());
        Some(LOOK.saturating_sub(passed))
    }

    /// Begins to follow the shown log, or ends it.
    pub(super) fn toggle_following(&mut self) {
        if let Some(other) = self.followed().filter(|id| *id != self.log.id) {
            let name = self.open_log(other).map_or_else(String::new, |log| quoted(&log.name()));
            let text = format!("{name} is followed already; end that first");
            return self.warn(text);
        }
        if let Some(active) = &mut self.following.active {
            active.ends.get_or_insert(End::Asked);
            return;
        }
        let Some(survey) = self.log.survey.clone() else {
            let text = "open the log that the recorder writes first, then follow it";
            return self.warn(text.to_owned());
        };
        if survey.track.external.is_some() {
            let text = "a log with another receiver's track cannot be followed; remove the external track first";
            return self.warn(text.to_owned());
        }
        let known = survey.clone();
        let starting = Task::start(&self.jobs, move |progress| {
            Tools::start(&known, progress).map_err(StepError::from)
        });
        let now = Instant::now();
        self.following.serial += 1;
        self.following.active = Some(Active {
            log: self.log.id,
            tools: None,
            starting: Some(starting),
            stepping: None,
            whole: None,
            fresh: None,
            whole_bytes: survey.source.byte_count,
            whole_at: now,
            looked: None,
            added: now,
            waiting: None,
            ends: None,
            is_last: false,
            stretch: None,
        });
    }

    /// Collects what was read, and looks at the log again when that is due.
    pub(super) fn poll_following(&mut self) {
        let Some(mut active) = self.following.active.take() else {
            return;
        };
        let Some(survey) = self.open_log(active.log).map(|log| log.survey.clone()) else {
            // It was closed.
            return;
        };
        if survey.is_some_and(|survey| survey.track.external.is_some()) {
            return self.leave_following(active.log);
        }
        self.hold_scale(&mut active);
        self.collect_start(&mut active);
        self.collect_step(&mut active);
        self.collect_whole(&mut active);
        let is_done = active.ends.is_some() && self.finish(&mut active);
        if is_done {
            return;
        }
        if active.ends.is_none() {
            self.begin_whole(&mut active);
            self.begin_step(&mut active);
        }
        let id = active.log;
        self.following.active = Some(active);
        self.search_tail(id);
    }

    fn collect_start(&mut self, active: &mut Active) {
        let started = match active.starting.as_ref().map(Task::poll) {
            Some(TaskOutcome::Done(started)) => started,
            Some(TaskOutcome::Failed) => Err(StepError::Failed),
            Some(TaskOutcome::Pending) | None => return,
        };
        active.starting = None;
        match started {
            Ok(mut tools) => {
                let bytes = std::mem::take(&mut tools.beginning);
                if let Some(log) = self.log_mut(active.log) {
                    log.leave_map(&bytes);
                }
                self.pipeline.previewer.forget();
                active.tools = Some(tools);
            }
            Err(error) => {
                let name =
                    self.open_log(active.log).map_or_else(String::new, |log| quoted(&log.name()));
                active.ends = Some(End::Failed);
                self.warn(format!("{name} cannot be followed: {error}"));
            }
        }
    }

    fn collect_step(&mut self, active: &mut Active) {
        let outcome = active.stepping.as_ref().map(|step| step.task.poll());
        if matches!(outcome, None | Some(TaskOutcome::Pending)) {
            return;
        }
        let (Some(step), Some(TaskOutcome::Done((tools, grown)))) =
            (active.stepping.take(), outcome)
        else {
            return self.fail_following(active, "reading it failed unexpectedly");
        };
        active.tools = Some(tools);
        match grown {
            Ok(Grown::Waits(0)) => active.waiting = None,
            Ok(Grown::Waits(_)) => active.note_added(),
            // It goes on from what is not shown any more; the next one takes in the same.
            Ok(Grown::Longer(_)) if !self.goes_on(active, &step) => active.note_added(),
            Ok(Grown::Longer(ground)) => {
                active.added = Instant::now();
                active.waiting = None;
                active.fresh = None;
                self.publish(active.log, *ground, true);
            }
            Ok(Grown::Anew) => {
                active.note_added();
                active.whole_bytes = 0;
            }
            Err(error) => self.fail_following(active, &error.to_string()),
        }
    }

    /// Returns true if a step went on from what is the newest still.
    fn goes_on(&self, active: &Active, step: &Stepping) -> bool {
        let newest = match (&active.fresh, step.is_fresh) {
            (Some(fresh), true) => Some(&fresh.survey),
            (None, false) => self.open_log(active.log).and_then(|log| log.survey.as_ref()),
            _ => None,
        };
        let is_same = newest.is_some_and(|newest| Arc::ptr_eq(newest, &step.from));
        is_same && !self.is_engine_on(active.log)
    }

    fn collect_whole(&mut self, active: &mut Active) {
        let made = match active.whole.as_ref().map(Task::poll) {
            Some(TaskOutcome::Done(made)) => made,
            Some(TaskOutcome::Failed) => Err(StepError::Failed),
            Some(TaskOutcome::Pending) | None => return,
        };
        active.whole = None;
        active.whole_at = Instant::now();
        let id = active.log;
        match made {
            // The settings were changed meanwhile: these results are not asked for any more.
            Ok(ground) if !self.is_as_set(id, &ground) => {
                active.whole_bytes = 0;
                active.is_last = false;
            }
            Ok(ground) => {
                active.whole_bytes = ground.survey.source.byte_count;
                let shown = self.open_log(id).and_then(|log| log.survey.as_ref());
                let shown = shown.map_or(0, |survey| survey.source.byte_count);
                if active.ends.is_some() || shown <= active.whole_bytes {
                    self.publish(id, ground, false);
                    active.fresh = None;
                } else {
                    // More was shown meanwhile: the next step adds it to these.
                    let settled = ground.settled();
                    let jobs = self.jobs.clone();
                    if let Some(log) = self.log_mut(id) {
                        let (survey, products) = (settled.survey.clone(), settled.products.clone());
                        log.count_figures(survey, products, &jobs);
                        log.whole = Some(settled);
                    }
                    active.fresh = Some(ground);
                }
            }
            Err(StepError::Cancelled(_)) => {}
            Err(error) => self.fail_following(active, &error.to_string()),
        }
    }

    /// Returns the present state of a log, which a step goes on from.
    fn ground_of(&self, id: LogId) -> Option<FollowedLog> {
        let log = self.open_log(id)?;
        Some(FollowedLog {
            read: log.as_read.clone().or(log.survey.clone())?,
            survey: log.survey.clone()?,
            products: log.products.clone()?,
            shared: self.document.shared.clone(),
            own: log.own.clone(),
        })
    }

    fn is_engine_on(&self, id: LogId) -> bool {
        let is_it = self.pipeline.requested.as_ref().is_some_and(|(log, ..)| *log == id);
        is_it && self.engine_status() != EngineStatus::Idle
    }

    fn begin_step(&mut self, active: &mut Active) {
        let is_due = active.looked.is_none_or(|looked| looked.elapsed() >= LOOK);
        let is_behind = self.open_log(active.log).is_none_or(OpenLog::is_behind);
        if !is_due || active.stepping.is_some() || is_behind || self.is_engine_on(active.log) {
            return;
        }
        let shown = self.ground_of(active.log);
        if let Some(fresh) = &active.fresh
            && !self.is_as_set(active.log, fresh)
        {
            active.fresh = None;
            active.whole_bytes = 0;
        }
        let fresh = active.fresh.clone();
        let is_fresh = fresh.is_some();
        let Some(ground) = fresh.or(shown) else {
            return;
        };
        let Some(mut tools) = active.tools.take() else {
            return;
        };
        let has_waited = active.waiting.is_some_and(|since| since.elapsed() >= LONGEST_WAIT);
        let waits = !(has_waited || is_fresh);
        active.looked = Some(Instant::now());
        let from = ground.survey.clone();
        let task = Task::start(&self.jobs, move |progress| {
            let grown = tools.step(&ground, waits, progress);
            (tools, grown)
        });
        active.stepping = Some(Stepping { from, is_fresh, task });
    }

    /// Ends following a log whose track is another receiver's now: what is there is run over as it
    /// is.
    fn leave_following(&mut self, id: LogId) {
        if let Some(log) = self.log_mut(id) {
            log.leave_provisional();
            let name = quoted(&log.name());
            let text =
                format!("{name} is no longer followed: its track is that of another receiver now");
            self.warn(text);
        }
        self.process();
    }

    /// Says in one sentence why the log is not followed any more; what was read of it stays.
    fn fail_following(&mut self, active: &mut Active, why: &str) {
        let name = self.open_log(active.log).map_or_else(String::new, |log| quoted(&log.name()));
        let pings = self.open_log(active.log).and_then(|log| log.survey.as_ref());
        let pings = pings.map_or(0, |survey| survey.side_scan.len());
        active.ends = Some(End::Failed);
        active.fresh = None;
        let pings = count(pings);
        let text = format!("{name} is no longer followed; its {pings} pings stay: {why}");
        self.warn(text);
    }
}

impl OpenLog {
    /// Reads the log from the copy from now on: a map of a log that its writer cuts short would
    /// lose its bytes.
    fn leave_map(&mut self, bytes: &[Bytes]) {
        for survey in [&mut self.survey, &mut self.as_read] {
            let is_as_long = |survey: &Arc<Survey>| {
                let lengths = survey.bytes.iter().map(|bytes| bytes.len());
                lengths.eq(bytes.iter().map(|bytes| bytes.len()))
            };
            if let Some(mapped) = survey.as_ref().filter(|survey| is_as_long(survey)) {
                *survey = Some(Arc::new(Survey { bytes: bytes.to_vec(), ..Survey::clone(mapped) }));
            }
        }
    }
}

impl Active {
    /// Notes that something was added that is not shown yet.
    fn note_added(&mut self) {
        self.added = Instant::now();
        self.waiting.get_or_insert(self.added);
    }
}
