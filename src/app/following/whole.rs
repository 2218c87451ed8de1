//! Computes all results from the whole log again, replaces the shown log by a longer state of it
//! with the decisions about it, and ends following. Meanwhile the scale in force stays until the
//! analyst chooses another one, and changes of depth are reported.

use super::step::{self, FollowedLog};
use super::{Active, BETWEEN_WHOLE, End, QUIET, STEPS, WHOLE_AGAIN};
use crate::app::error::AppError;
use crate::app::jobs::JobKey;
use crate::app::{Action, App, LogId, OpenLog};
use bathyscope_bottom::calibration::{Calibration, PingRange, ScaleMode};
use bathyscope_bottom::picture::PictureSettings;
use bathyscope_bottom::presentation::text::count;
use bathyscope_log::formats::{GrowingError, GrowingLog};
use bathyscope_log::support::printable::quoted;
use bathyscope_log::support::progress::Progress;
use bathyscope_log::survey::{Identity, Side, Survey};
use bathyscope_products::pipeline::{LogSettings, Products, Settings};
use std::sync::Arc;
use toml::Value;

/// Key of the setting of the stretch that the scale is measured on.
const STRETCH: &str = "calibration.pings";
/// Least change of a depth by a scale that counts as a change, metres.
const SAME_M: f64 = 0.01;

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
    pub(super) fn leave_provisional(&mut self, id: LogId) {
        if let Some(log) = self.logs.get_mut(id)
            && log.whole.take().is_some()
        {
            log.products = None;
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

    /// Keeps the stretch that the scale of a followed log is measured on, because the best-ranked
    /// stretch of a longer log is often another one.
    pub(super) fn hold_scale(&mut self, active: &mut Active) {
        let Some(log) = self.logs.get(active.log) else {
            return;
        };
        let calibration = &log.settings.calibration;
        if calibration.mode != ScaleMode::FlatSpot {
            active.stretch = None;
            return;
        }
        if calibration.pings.is_some() {
            active.stretch = calibration.pings;
            return;
        }
        // Undo may restore settings that name no stretch.
        let in_use = || {
            let products = log.products.as_ref()?;
            let is_current = products.settings.calibration == *calibration;
            let made = &products.calibration;
            let is_measured = is_current && made.mode == ScaleMode::FlatSpot;
            let spot = made.flat_spot.as_ref().filter(|_| is_measured)?;
            Some(spot.range())
        };
        if let Some(pings) = active.stretch.or_else(in_use) {
            active.stretch = Some(pings);
            if let Some(log) = self.logs.get_mut(active.log) {
                log.name_stretch(pings);
            }
            self.keep_project("flat stretch");
        }
    }

    /// Offers the best-ranked stretch of a log that has grown if its scale differs from the scale
    /// in force, and withdraws the offer for a shorter state of the log.
    fn offer_flatter(&mut self, id: LogId) {
        let Some(log) = self.logs.get_mut(id) else {
            return;
        };
        let found = log.products.as_ref().and_then(flatter);
        let offered = found.as_ref().map(|(pings, _)| *pings);
        if log.calibrating.offered == offered {
            return;
        }
        log.calibrating.offered = offered;
        self.notices.withdraw(Action::UseFlatterStretch);
        if let Some((_, text)) = found {
            self.notices.offer(text, Action::UseFlatterStretch);
        }
    }
}

impl OpenLog {
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

    /// Writes the stretch that the scale is measured on into the log's own settings. Results that
    /// used this stretch as the best-ranked one stay.
    fn name_stretch(&mut self, pings: PingRange) {
        Arc::make_mut(&mut self.own).set(STRETCH, Value::String(pings.into()));
        let name = |settings: &mut Arc<Settings>| {
            Arc::make_mut(settings).calibration.pings = Some(pings);
        };
        name(&mut self.settings);
        let whole = self.whole.as_mut().map(|whole| &mut whole.products);
        for products in self.products.as_mut().into_iter().chain(whole) {
            let made = &products.calibration;
            let spot = made.flat_spot.as_ref().filter(|_| made.mode == ScaleMode::FlatSpot);
            if spot.is_some_and(|spot| spot.range() == pings) {
                name(&mut products.settings);
            }
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

/// Returns the best-ranked stretch, and a sentence about its effect; `None` if it is the stretch in
/// force, or gives the same depths.
fn flatter(products: &Products) -> Option<(PingRange, String)> {
    let made = &products.calibration;
    let used = made.flat_spot.as_ref();
    let used = used.filter(|_| made.mode == ScaleMode::FlatSpot)?;
    let best = products.flat_spots.first()?;
    let (now, then) = used.factor.zip(best.factor)?;
    let change_m = used.depth_m * (then / now - 1.0);
    let is_other = best.pings != used.pings && change_m.abs() >= SAME_M;
    is_other.then(|| {
        let text = format!(
            "A flatter stretch was found, pings {} to {}: ranges ×{then:.3} instead of ×{now:.3}; depths change by about {:+.0} cm",
            best.pings.start,
            best.pings.end - 1,
            100.0 * change_m
        );
        (best.range(), text)
    })
}

/// Returns a sentence about the change of depths by the results of the whole log; `None` if its
/// scale and its offset have not changed.
fn drift(survey: &Survey, before: &Calibration, after: &Calibration) -> Option<String> {
    let change_m = depth_change_m(survey, before, after)?;
    let ranges = |calibration: &Calibration| {
        let change = calibration.range_change();
        change.unwrap_or_else(|| "ranges as recorded".to_owned())
    };
    (change_m.abs() >= SAME_M).then(|| {
        format!(
            "With more of the log, {} instead of {}: depths change by about {:+.0} cm",
            ranges(after),
            ranges(before),
            100.0 * change_m
        )
    })
}

/// Returns the depth of a first return at the median depth by the calibration `after` minus that by
/// `before`, metres.
fn depth_change_m(survey: &Survey, before: &Calibration, after: &Calibration) -> Option<f64> {
    let depth_m = after.measured_offset.or(before.measured_offset)?.depth_m;
    let mut spans = Side::BOTH.into_iter().filter_map(|side| survey.span(0, side));
    let span = spans.next()?;
    let sample = span.sample_at(depth_m);
    let change_m = after.range_m(span, sample) - before.range_m(span, sample);
    change_m.is_finite().then_some(change_m)
}
