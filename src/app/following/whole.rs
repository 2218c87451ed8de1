//! Computes all results from the whole log again, replaces the shown log by a longer state of it
//! with the decisions about it, and ends following.

use super::scale::drift;
use super::step::{self, FollowedLog};
use super::{Active, App, BETWEEN_WHOLE, End, QUIET, STEPS, WHOLE_AGAIN};
use crate::app::error::AppError;
use crate::app::jobs::JobKey;
use crate::app::{LogId, OpenLog};
use bathyscope_bottom::picture::PictureSettings;
use bathyscope_bottom::presentation::text::count;
use bathyscope_log::formats::{GrowingError, GrowingLog};
use bathyscope_log::support::printable::quoted;
use bathyscope_log::support::progress::Progress;
use bathyscope_log::survey::Identity;
use bathyscope_products::pipeline::{LogSettings, Settings};
use std::sync::Arc;

impl App {
    /// Starts computing results from the whole log if it has grown by enough, has stopped growing,
    /// or if its settings have changed.
    pub(super) fn begin_whole(&mut self, active: &mut Active) {
        let is_running = self.jobs.is_running(&JobKey::FollowWhole);
        let is_busy = is_running || active.fresh.is_some() || active.tools.is_none();
        if is_busy || active.whole_at.elapsed() < BETWEEN_WHOLE || self.is_processing(active.log) {
            return;
        }
        let Some(log) = self.logs.get(active.log) else {
            return;
        };
        let made = log.whole.as_ref().map(|whole| &whole.products.settings);
        let now = log.products.as_ref().map(|products| &products.settings);
        let is_changed = made.zip(now).is_some_and(|(made, now)| bare(made) != bare(now));
        let bytes = log.survey.as_ref().map_or(0, |survey| survey.source.byte_count) as f64;
        let has_grown = bytes >= WHOLE_AGAIN * active.whole_bytes as f64;
        let rests = active.added.elapsed() >= QUIET && log.whole.is_some();
        if !(has_grown || rests || is_changed) || log.is_behind() {
            return;
        }
        self.start_whole(active, false);
    }

    /// Starts processing the present pings of a log whose results are provisional.
    fn leave_provisional(&mut self, id: LogId) {
        if let Some(log) = self.logs.get_mut(id) {
            log.leave_provisional();
        }
        self.process();
    }

    fn start_whole(&mut self, active: &mut Active, is_finished: bool) {
        let Some((tools, ground)) = active.tools.as_ref().zip(self.ground_of(active.log)) else {
            return;
        };
        let frame = (self.logs.count() > 1).then(|| self.document.plane.clone());
        let files = match tools.growing.bytes() {
            Ok(files) => files,
            Err(error) => return self.fail_following(active, &error.to_string()),
        };
        let is_cut = matches!(active.ends, Some(End::Failed));
        let work = move |progress: &Progress| {
            let files = if is_finished && !is_cut {
                // A recorder may have written its header again when it was switched off.
                match GrowingLog::again(&files, progress) {
                    Ok(growing) => growing.bytes()?,
                    Err(GrowingError::Cancelled(cancelled)) => return Err(cancelled.into()),
                    Err(_) => files,
                }
            } else {
                files
            };
            step::whole(files, is_finished, frame.as_ref(), &ground, progress)
        };
        self.jobs.run_or(
            JobKey::FollowWhole,
            work,
            |app, made| app.with_followed(|app, active| app.take_whole(active, made)),
            |app| {
                app.with_followed(|app, active| app.take_whole(active, Err(AppError::StepFailed)))
            },
        );
    }

    /// Ends following: the whole log is read and processed once more. Returns true once that is
    /// done.
    pub(super) fn finish(&mut self, active: &mut Active) -> bool {
        if STEPS.iter().any(|key| self.jobs.is_running(key)) {
            return false;
        }
        let known = self.logs.get(active.log).and_then(|log| {
            let survey = log.survey.as_ref()?;
            Some((survey.source.byte_count, log.whole.is_some()))
        });
        let Some(((bytes, is_provisional), tools)) = known.zip(active.tools.as_ref()) else {
            self.leave_provisional(active.log);
            return true;
        };
        if active.is_last {
            if !is_provisional
                && matches!(active.ends, Some(End::Asked))
                && let Some(survey) = self.logs.survey_of(active.log)
            {
                let pings = count(survey.side_scan.len());
                let text = format!("Read {} to its end: {pings} pings", quoted(&survey.name()));
                self.notices.notify(text);
            }
            if is_provisional {
                // The last reading failed: the pings that were shown last are processed as they
                // are.
                self.leave_provisional(active.log);
            }
            return true;
        }
        if self.is_processing(active.log) {
            return false;
        }
        if !is_provisional && tools.growing.byte_count() == bytes {
            return true;
        }
        active.is_last = true;
        self.start_whole(active, true);
        false
    }

    /// Returns true if the settings of the log are those that results were computed with, apart
    /// from the state of the log that the two name.
    pub(super) fn is_as_set(&self, id: LogId, ground: &FollowedLog) -> bool {
        let Some((log, survey)) = self.logs.log_and_survey(id) else {
            return false;
        };
        let is_longer = ground.survey.source.byte_count > survey.source.byte_count;
        let longest = if is_longer { &ground.survey } else { survey };
        let carried = |own: &Arc<LogSettings>| {
            let carried = own.carried_to(longest);
            carried.unwrap_or_else(|| own.as_ref().clone())
        };
        carried(&ground.own) == carried(&log.own) && *ground.shared == *self.document.shared
    }

    /// Replaces a log by a longer state with its results, and keeps the analyst's decisions.
    pub(super) fn publish(&mut self, id: LogId, ground: FollowedLog, is_provisional: bool) {
        let is_as_set = self.is_as_set(id, &ground);
        let shared = self.document.shared.clone();
        let Some(log) = self.logs.get_mut(id) else {
            return;
        };
        let FollowedLog { read, survey, mut products, own, .. } = ground;
        log.whole = log.settled().filter(|_| is_provisional);
        log.as_read = log.as_read.is_some().then_some(read);
        log.replace_survey(survey.clone());
        if is_as_set {
            log.own = own;
            log.settings = products.settings.clone();
        } else {
            log.carry_own(&shared);
        }
        let before = log.products.as_ref();
        if before.is_some_and(|old| old.settings.picture != products.settings.picture) {
            Arc::make_mut(&mut products.settings).picture = log.settings.picture.clone();
        }
        let before = before.map(|products| products.calibration.clone());
        self.carry_decisions(id);
        if is_provisional {
            if let Some(log) = self.logs.get_mut(id) {
                log.reviewing.grow(&survey, &products.navigation);
                log.products = Some(products);
            }
            self.forget_preview(id);
        } else {
            let drift = before.and_then(|before| drift(&survey, &before, &products.calibration));
            if let Some(text) = drift {
                self.notices.notify(text);
            }
            self.take_products(id, products);
            self.offer_flatter(id);
        }
        if !is_as_set {
            self.schedule();
        }
    }

    /// Assigns boxes and measurements to the present state of a log, which may be longer than the
    /// state that they were made on.
    pub(in crate::app) fn carry_decisions(&mut self, id: LogId) {
        let Some(log) = self.logs.get_mut(id) else {
            return;
        };
        let Some(survey) = log.survey.clone() else {
            return;
        };
        let identity = Identity::of(&survey);
        if let Some(file) = &mut log.file {
            file.pings = identity.pings;
        }
        log.reviewing.carry(identity.clone());
        self.map.measuring.carry(&survey, &identity);
    }
}

impl OpenLog {
    /// Drops provisional results, so that the log is processed as it is.
    pub(super) fn leave_provisional(&mut self) {
        if self.whole.take().is_some() {
            self.products = None;
        }
    }

    /// Assigns the log's own settings to its present state.
    pub(in crate::app) fn carry_own(&mut self, shared: &Settings) {
        let survey = self.survey.as_ref();
        if let Some(own) = survey.and_then(|survey| self.own.carried_to(survey))
            && let Ok(settings) = own.compose(shared)
        {
            self.own = Arc::new(own);
            self.settings = Arc::new(settings);
        }
    }
}

/// Returns settings without the state of the log, which changes with every ping, and without those
/// of its picture, on which no result depends.
fn bare(settings: &Settings) -> Settings {
    let mut bare = settings.clone();
    (bare.bottom.log_bytes, bare.bottom.pings) = (0, 0);
    bare.excluded.log = None;
    bare.picture = PictureSettings::default();
    bare
}
