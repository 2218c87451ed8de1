//! A longer state of a log in the place of the one that was shown: what was decided about it is carried over.

use super::step::FollowedLog;
use crate::app::{App, LogId};
use crate::pipeline::{LogSettings, Products};
use crate::survey::{Identity, Survey};
use std::sync::Arc;

impl App {
    /// Whether the log's settings are those that results were made with, whatever state of the log each of them names.
    pub(super) fn is_as_set(&self, id: LogId, ground: &FollowedLog) -> bool {
        let shown = self
            .open_log(id)
            .and_then(|log| Some((log, log.survey.as_ref()?)));
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

    /// Shows a longer log with its results. The analyst's decisions are carried over to it.
    pub(super) fn publish(&mut self, id: LogId, ground: FollowedLog, is_provisional: bool) {
        let is_as_set = self.is_as_set(id, &ground);
        self.with_log(id, |app| {
            let FollowedLog {
                read,
                survey,
                mut products,
                own,
                ..
            } = ground;
            app.log.whole = app.log.settled().filter(|_| is_provisional);
            app.log.as_read = app.log.as_read.is_some().then_some(read);
            app.log.replace_survey(survey.clone());
            if is_as_set {
                app.log.own = own;
                app.log.settings = products.settings.clone();
            } else {
                app.carry_own(&survey);
            }
            if app
                .log
                .products
                .as_ref()
                .is_some_and(|old| old.settings.picture != products.settings.picture)
            {
                Arc::make_mut(&mut products.settings).picture = app.log.settings.picture.clone();
            }
            app.carry_decisions(&survey);
            if is_provisional {
                app.log.reviewing.grow(&survey, &products.navigation);
                app.take_growing_products(products);
            } else {
                if let Some(before) = &app.log.products {
                    let (before, after) =
                        (before.calibration.clone(), products.calibration.clone());
                    app.tell_drift(&survey, &before, &after);
                }
                app.take_products(products);
            }
        });
        if !is_provisional {
            self.offer_flatter(id);
        }
        if !is_as_set {
            self.schedule();
        }
    }

    fn take_growing_products(&mut self, products: Products) {
        self.log.preview = None;
        self.log.products = Some(products);
        if self.is_shown() {
            // What was measured for the slider is of the shorter log.
            self.pipeline.previewer.forget();
        }
    }

    /// Carries settings that belong to one log over to a longer state of it.
    pub(in crate::app) fn carry_own(&mut self, survey: &Survey) {
        if let Some(own) = self.log.own.carried_to(survey)
            && let Ok(settings) = own.compose(&self.document.shared)
        {
            self.log.own = Arc::new(own);
            self.log.settings = Arc::new(settings);
        }
    }

    /// Carries boxes and measurements over to a longer state of the log.
    pub(in crate::app) fn carry_decisions(&mut self, survey: &Survey) {
        let identity = Identity::of(survey);
        if let Some(file) = &mut self.log.file {
            file.pings = identity.pings;
        }
        if let Some(figure) = &self.map.measuring.figure
            && figure
                .measurement
                .picks
                .values()
                .any(|pick| survey.is_or_was(&pick.log))
        {
            let mut figure = (**figure).clone();
            for pick in figure.measurement.picks.values_mut() {
                if survey.is_or_was(&pick.log) {
                    pick.log = identity.clone();
                }
            }
            self.map.measuring.figure = Some(Arc::new(figure));
        }
        self.log.reviewing.carry(identity);
    }
}
