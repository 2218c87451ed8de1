//! Follows a log while its recorder writes it: new pings appear as they are recorded, shown data
//! stay, and from time to time all results are computed again from the whole log, so that at the
//! end they are those of the finished file.
//!
//! `step` reads new bytes in a background thread, `whole` decides when all results are computed
//! again, shows results, and keeps the scale in force. The results of new pings are provisional:
//! they use the calibration of the last run over the whole log
//! ([`bathyscope_products::pipeline::extend`]). That run is repeated whenever the log has grown by
//! a quarter, so the work for each ping does not grow with the log. If objects were searched for,
//! new pings are searched too. The log is only ever read, as a private copy
//! ([`bathyscope_log::formats::GrowingLog`]).

mod step;
mod whole;

use super::error::AppError;
use super::jobs::JobKey;
use super::{App, LogId, OpenLog};
use bathyscope_bottom::calibration::PingRange;
use bathyscope_bottom::presentation::text::count;
use bathyscope_log::survey::{Bytes, Survey};
use std::sync::Arc;
use std::time::{Duration, Instant};
use step::{FollowedLog, Grown, Tools};

/// The work on the followed log.
const STEPS: [JobKey; 3] = [JobKey::StartFollowing, JobKey::FollowStep, JobKey::FollowWhole];
/// Time between two checks of the log for new bytes.
const LOOK: Duration = Duration::from_millis(250);
/// Longest time for which added bytes wait to be shown.
const LONGEST_WAIT: Duration = Duration::from_secs(2);
/// Growth of the log, as a factor, after which the results of the whole log are computed again.
const WHOLE_AGAIN: f64 = 1.25;
/// Time without added bytes after which the results of the whole log are computed again.
const QUIET: Duration = Duration::from_secs(8);
/// Least time between two runs over the whole log.
const BETWEEN_WHOLE: Duration = Duration::from_secs(3);
/// Time without added bytes after which the status line reports that the log does not grow.
const SILENT: Duration = Duration::from_secs(5);

/// The followed log, if there is one.
#[derive(Default)]
pub struct Following {
    active: Option<Active>,
    /// Number that grows each time following begins, upon which the waterfall moves to its end.
    pub(crate) serial: u64,
}

/// State of following a log.
struct Active {
    log: LogId,
    /// Copy of the log and state of its results; `None` while a step uses them.
    tools: Option<Tools>,
    /// Results of the whole log as it was when they were begun, from which the next step continues.
    fresh: Option<FollowedLog>,
    /// Number of bytes of the log at the last run over the whole log.
    whole_bytes: u64,
    whole_at: Instant,
    looked: Option<Instant>,
    /// Time at which added bytes were last found.
    added: Instant,
    /// Time at which bytes that are not shown yet were first found.
    waiting: Option<Instant>,
    /// Reason for ending; the log is then read to its end once more. `None` while it is followed.
    ends: Option<End>,
    /// True if that last reading has begun.
    is_last: bool,
    /// The stretch that the scale of the log is measured on, if there is one.
    stretch: Option<PingRange>,
}

/// The recording from which a step continues.
struct StepFrom {
    survey: Arc<Survey>,
    /// True if that recording is the one of the fresh results of the whole log.
    is_fresh: bool,
}

/// Reason that a log is no longer followed.
enum End {
    /// The analyst ended it.
    Asked,
    /// The log cannot be followed any more.
    Failed,
}

/// State of following, for the status line.
#[derive(Clone, Debug, PartialEq)]
pub enum FollowStatus {
    /// The log is being copied.
    Starting,
    /// The log grows.
    Growing {
        /// Number of side-scan pings that are shown.
        pings: usize,
        /// Time that added bytes have waited to be shown.
        behind: Duration,
    },
    /// The log has not grown for a while.
    Silent {
        /// Time without growth.
        since: Duration,
    },
    /// The results of the whole log are computed once more before following ends.
    Ending,
}

impl Following {
    /// Returns the followed log; `None` if no log is followed, or following is ending.
    pub fn log(&self) -> Option<LogId> {
        let active = self.active.as_ref();
        active.filter(|active| active.ends.is_none()).map(|active| active.log)
    }

    /// Returns the time until the log is read again; `None` while no log is followed.
    pub(crate) fn due(&self) -> Option<Duration> {
        let active = self.active.as_ref()?;
        let passed = active.looked.map_or(LOOK, |looked| looked.elapsed());
        Some(LOOK.saturating_sub(passed))
    }

    /// Returns true if following is ending.
    pub(super) fn is_ending(&self) -> bool {
        self.active.as_ref().is_some_and(|active| active.ends.is_some())
    }
}

impl App {
    /// Returns true if the shown log is followed.
    pub fn is_following(&self) -> bool {
        self.following.log() == Some(self.logs.shown.id)
    }

    /// Returns the state of following; `None` while no log is followed.
    pub fn follow_status(&self) -> Option<FollowStatus> {
        let active = self.following.active.as_ref()?;
        if active.ends.is_some() {
            return Some(FollowStatus::Ending);
        }
        if self.jobs.is_running(&JobKey::StartFollowing) {
            return Some(FollowStatus::Starting);
        }
        let silent = active.added.elapsed();
        if silent > SILENT && active.waiting.is_none() {
            return Some(FollowStatus::Silent { since: silent });
        }
        let log = self.logs.get(active.log)?;
        Some(FollowStatus::Growing {
            pings: log.survey.as_ref().map_or(0, |survey| survey.side_scan.len()),
            behind: active.waiting.map_or(Duration::ZERO, |since| since.elapsed()),
        })
    }

    /// Begins or ends following the shown log.
    pub(super) fn toggle_following(&mut self) {
        if let Some(other) = self.following.log().filter(|id| *id != self.logs.shown.id) {
            let name = self.logs.name_of(other);
            let text = format!("{name} is followed already; end that first");
            return self.notices.warn(text);
        }
        if let Some(active) = &mut self.following.active {
            active.ends.get_or_insert(End::Asked);
            return;
        }
        let Some(survey) = self.logs.shown.survey.clone() else {
            let text = "open the log that the recorder writes first, then follow it";
            return self.notices.warn(text);
        };
        if survey.track.external.is_some() {
            let text = "a log with another receiver's track cannot be followed; remove the external track first";
            return self.notices.warn(text);
        }
        let now = Instant::now();
        self.following.serial += 1;
        self.following.active = Some(Active {
            log: self.logs.shown.id,
            tools: None,
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
        self.jobs.run_or(
            JobKey::StartFollowing,
            move |progress| Tools::start(&survey, progress).map_err(AppError::from),
            |app, started| app.with_followed(|app, active| app.take_start(active, started)),
            |app| {
                app.with_followed(|app, active| app.take_start(active, Err(AppError::StepFailed)))
            },
        );
    }

    /// Changes the state of following; does nothing while no log is followed.
    fn with_followed(&mut self, change: impl FnOnce(&mut Self, &mut Active)) {
        if let Some(mut active) = self.following.active.take() {
            self.hold_scale(&mut active);
            change(self, &mut active);
            self.following.active = Some(active);
        }
    }

    /// Stops reading the log that was followed.
    fn stop_steps(&mut self) {
        for key in &STEPS {
            self.jobs.stop(key);
        }
    }

    /// Starts reading the followed log again when the time has come, and ends following.
    pub(super) fn follow_log(&mut self) {
        let Some(mut active) = self.following.active.take() else {
            return;
        };
        let Some(survey) = self.logs.get(active.log).map(|log| log.survey.clone()) else {
            // The log was closed.
            return self.stop_steps();
        };
        if survey.is_some_and(|survey| survey.track.external.is_some()) {
            self.stop_steps();
            let name = self.logs.name_of(active.log);
            let text =
                format!("{name} is no longer followed: its track is that of another receiver now");
            self.notices.warn(text);
            return self.leave_provisional(active.log);
        }
        self.hold_scale(&mut active);
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

    fn take_start(&mut self, active: &mut Active, started: Result<Tools, AppError>) {
        match started {
            Ok(mut tools) => {
                let bytes = std::mem::take(&mut tools.beginning);
                if let Some(log) = self.logs.get_mut(active.log) {
                    log.leave_map(&bytes);
                }
                self.pipeline.previewer.forget(&mut self.jobs);
                active.tools = Some(tools);
            }
            Err(error) => {
                let name = self.logs.name_of(active.log);
                active.ends = Some(End::Failed);
                self.notices.warn(format!("{name} cannot be followed: {error}"));
            }
        }
    }

    fn take_grown(
        &mut self,
        active: &mut Active,
        from: &StepFrom,
        (tools, grown): (Tools, Result<Grown, AppError>),
    ) {
        active.tools = Some(tools);
        match grown {
            Ok(Grown::Waits(0)) => active.waiting = None,
            Ok(Grown::Waits(_)) => active.note_added(),
            // The step continued from a recording that is not shown any more; the next step adds
            // the same bytes.
            Ok(Grown::Longer(_)) if !self.goes_on(active, from) => active.note_added(),
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

    /// Returns true if the recording from which a step continued is still the newest.
    fn goes_on(&self, active: &Active, from: &StepFrom) -> bool {
        let newest = match (&active.fresh, from.is_fresh) {
            (Some(fresh), true) => Some(&fresh.survey),
            (None, false) => self.logs.survey_of(active.log),
            _ => None,
        };
        let is_same = newest.is_some_and(|newest| Arc::ptr_eq(newest, &from.survey));
        is_same && !self.is_processing(active.log)
    }

    fn take_whole(&mut self, active: &mut Active, made: Result<FollowedLog, AppError>) {
        active.whole_at = Instant::now();
        let id = active.log;
        match made {
            // The settings were changed meanwhile: these results are not needed any more.
            Ok(ground) if !self.is_as_set(id, &ground) => {
                active.whole_bytes = 0;
                active.is_last = false;
            }
            Ok(ground) => {
                active.whole_bytes = ground.survey.source.byte_count;
                let shown = self.logs.survey_of(id);
                let shown = shown.map_or(0, |survey| survey.source.byte_count);
                if active.ends.is_some() || shown <= active.whole_bytes {
                    self.publish(id, ground, false);
                    active.fresh = None;
                } else {
                    // More pings were shown meanwhile: the next step adds them to these results.
                    let settled = ground.settled();
                    self.count_figures(id, settled.clone());
                    if let Some(log) = self.logs.get_mut(id) {
                        log.whole = Some(settled);
                    }
                    active.fresh = Some(ground);
                }
            }
            Err(AppError::Cancelled(_)) => {}
            Err(error) => self.fail_following(active, &error.to_string()),
        }
    }

    /// Returns the present state of a log, from which a step continues.
    fn ground_of(&self, id: LogId) -> Option<FollowedLog> {
        let log = self.logs.get(id)?;
        Some(FollowedLog {
            read: log.as_read.clone().or(log.survey.clone())?,
            survey: log.survey.clone()?,
            products: log.products.clone()?,
            shared: self.document.shared.clone(),
            own: log.own.clone(),
        })
    }

    fn begin_step(&mut self, active: &mut Active) {
        let is_due = active.looked.is_none_or(|looked| looked.elapsed() >= LOOK);
        let is_behind = self.logs.get(active.log).is_none_or(OpenLog::is_behind);
        let is_reading = self.jobs.is_running(&JobKey::FollowStep);
        if !is_due || is_reading || is_behind || self.is_processing(active.log) {
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
        let from = StepFrom { survey: ground.survey.clone(), is_fresh };
        self.jobs.run_or(
            JobKey::FollowStep,
            move |progress| {
                let grown = tools.step(&ground, waits, progress);
                (tools, grown)
            },
            move |app, step| app.with_followed(|app, active| app.take_grown(active, &from, step)),
            |app| {
                app.with_followed(|app, active| {
                    app.fail_following(active, "reading it failed unexpectedly");
                });
            },
        );
    }

    /// Ends following a log, and notifies the analyst of the reason; the pings that were read stay.
    fn fail_following(&mut self, active: &mut Active, why: &str) {
        let name = self.logs.name_of(active.log);
        let survey = self.logs.survey_of(active.log);
        let pings = count(survey.map_or(0, |survey| survey.side_scan.len()));
        active.ends = Some(End::Failed);
        active.fresh = None;
        self.notices.warn(format!("{name} is no longer followed; its {pings} pings stay: {why}"));
    }
}

impl OpenLog {
    /// Replaces the memory-mapped bytes of the log by those of the copy: a map would lose its bytes
    /// if the recorder cut the file short.
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
    /// Records that bytes were added which are not shown yet.
    fn note_added(&mut self) {
        self.added = Instant::now();
        self.waiting.get_or_insert(self.added);
    }
}
