//! Sets the mounting of recorders: exchanged sides, and the default for the logs of a recorder.

use super::error::AppError;
use super::{App, LogId, OpenLog};
use bathyscope_bottom::calibration::SoundingLag;
use bathyscope_log::survey::MountingSettings;
use bathyscope_products::pipeline::Settings;
use std::collections::BTreeMap;
use std::sync::Arc;

/// Mountings by recorder ([`bathyscope_log::survey::Source::recorder`]).
pub type Mountings = BTreeMap<String, MountingSettings>;

/// Returns the settings with their bottom edits on the side of the echoes that they were drawn on,
/// if the settings exchange the sides.
pub(super) fn with_sides(mut settings: Settings, before: &Settings) -> Settings {
    let swapped = settings.mounting.swap_sides;
    if swapped != before.mounting.swap_sides {
        settings.bottom = settings.bottom.with_sides(swapped);
    }
    settings
}

impl App {
    /// Returns the default mounting of the shown log's recorder; `None` if it has none.
    pub(crate) fn usual_mounting(&self) -> Option<MountingSettings> {
        self.document.mountings.get(&self.logs.shown.recorder()).copied()
    }

    /// Shifts the soundings of the shown log to earlier times by the lag that its first returns
    /// show.
    pub(super) fn apply_sounding_lag(&mut self) {
        let Some((lag, in_force_s)) = self.logs.shown.sounding_lag() else {
            return self.notices.warn("first returns show no lag of the soundings");
        };
        let lag_s = in_force_s + lag.told_s();
        self.edit_settings("lag of the soundings", |settings| {
            settings.mounting.sounding_lag_s = lag_s;
        });
    }

    /// Applies the default mounting of its recorder to a log that was just opened. This is not an
    /// undo step.
    pub(super) fn mount_as_usual(&mut self, id: LogId) {
        let Some(log) = self.logs.get(id) else {
            return;
        };
        let (name, recorder, shared) = (log.name(), log.recorder(), log.settings.clone());
        if let Err(error) = self.follow_source(id, &shared) {
            self.notices.warn(error);
        }
        let Some(mounting) = self.document.mountings.get(&recorder).copied() else {
            return;
        };
        let mounted = self.mount(id, mounting);
        let said = |()| format!("{name} has the default mounting of {recorder}");
        self.notices.tell(mounted.map(said));
    }

    /// Makes the mounting of the shown log the default of its recorder, and applies it to all open
    /// logs of that recorder, as an undo step.
    pub(super) fn use_mounting(&mut self) {
        let recorder = self.logs.shown.recorder();
        if recorder.is_empty() {
            return;
        }
        let before = self.step_now();
        let mounting = self.logs.shown.settings.mounting;
        let mountings = Arc::make_mut(&mut self.document.mountings);
        if mounting.is_none() {
            mountings.remove(&recorder)
        } else {
            mountings.insert(recorder.clone(), mounting)
        };
        let shown = self.logs.shown.id;
        let is_other = |log: &&OpenLog| {
            log.id != shown && log.recorder() == recorder && log.settings.mounting != mounting
        };
        let others: Vec<LogId> = self.logs.all().filter(is_other).map(|log| log.id).collect();
        for id in others {
            if let Err(error) = self.mount(id, mounting) {
                self.notices.warn(error);
            }
        }
        self.record_named(&before, format!("mounting of {recorder}"));
        self.schedule();
    }

    /// Removes the default mounting of the shown log's recorder, as an undo step.
    pub(super) fn forget_mounting(&mut self) {
        let recorder = self.logs.shown.recorder();
        let before = self.step_now();
        if Arc::make_mut(&mut self.document.mountings).remove(&recorder).is_none() {
            return self.notices.warn("the recorder of this log has no default mounting");
        }
        self.record_named(&before, format!("no default mounting of {recorder}"));
    }

    /// Sets the mounting of a log, with its boxes and its bottom edits. After an error the log is
    /// unchanged.
    fn mount(&mut self, id: LogId, mounting: MountingSettings) -> Result<(), AppError> {
        let Some(log) = self.logs.get(id) else {
            return Ok(());
        };
        let mut settings = Settings::clone(&log.settings);
        settings.mounting = mounting;
        let settings = with_sides(settings, &log.settings);
        let own = log.own.clone();
        settings.check()?;
        self.follow_source(id, &settings)?;
        let (_, own) = own.change(&self.document.shared, &settings)?;
        if let Some(log) = self.logs.get_mut(id) {
            log.own = Arc::new(own);
            log.settings = Arc::new(settings);
            log.exchange_boxes();
        }
        Ok(())
    }
}

impl OpenLog {
    /// Returns the lag of the soundings that first returns show, and the lag in force when they
    /// were found, seconds; `None` if they show none.
    pub fn sounding_lag(&self) -> Option<(SoundingLag, f64)> {
        let products = self.products.as_ref()?;
        Some((products.calibration.sounding_lag?, products.settings.mounting.sounding_lag_s))
    }

    /// Returns the recorder of the log, as far as the log names it; empty in an empty window.
    pub fn recorder(&self) -> String {
        let survey = self.survey.as_ref();
        survey.map_or_else(String::new, |survey| survey.source.recorder())
    }

    /// Moves the boxes with their echoes to the other side if the sides are exchanged.
    pub(super) fn exchange_boxes(&mut self) {
        let swapped = (self.survey.as_ref()).is_some_and(|survey| survey.swapped_sides);
        self.reviewing.exchange(swapped);
    }
}
