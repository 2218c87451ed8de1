//! Replaces a shown log by a longer state of the same log, and keeps the decisions about it.

use super::step::FollowedLog;
use crate::app::logs_change::LogsChange;
use crate::app::{App, LogId, OpenLog};
use bathyscope_log::survey::{Identity, Survey};
use bathyscope_products::pipeline::{LogSettings, Products, Settings};
use std::sync::Arc;

impl App {
    /// Returns true if the settings of the log are those that results were computed with, apart
    /// from the state of the log that the two name.
    pub(super) fn is_as_set(&self, id: LogId, ground: &FollowedLog) -> bool {
        let shown = self.logs.get(id).and_then(|log| Some((log, log.survey.as_ref()?)));
        let Some((log, survey)) = shown else {
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
            self.take_growing_products(id, &survey, products);
        } else {
            if let Some(before) = before {
                self.tell_drift(&survey, &before, &products.calibration);
            }
            self.take_products(id, products);
            self.offer_flatter(id);
        }
        if !is_as_set {
            self.schedule();
        }
    }

    /// Sets the provisional results of a longer state of a log.
    fn take_growing_products(&mut self, id: LogId, survey: &Survey, products: Products) {
        if let Some(log) = self.logs.get_mut(id) {
            log.reviewing.grow(survey, &products.navigation);
            log.products = Some(products);
        }
        self.follow_change(LogsChange::Grown(id));
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
