//! What is left out of a log: drawn by the analyst, taken back in, and counted before the results follow.

use super::{App, LogId, OpenLog};
use crate::pipeline::{Background, Jobs, Same, Settings};
use crate::survey::{
    LeftOut, LeftOutReason, LeftOutSettings, LeftOutStretch, LogPart, Navigation, Survey,
};
use std::sync::Arc;

/// What an analyst says of a part of a log.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Leave {
    /// It is left out.
    Out,
    /// It counts, whatever is found there.
    In,
    /// Nothing any more: turns and stops that are found there are left out, all else counts.
    AsFound,
}

impl Leave {
    /// Undo's name for it: `exclude pings 120..240`.
    fn label(self, part: LogPart) -> String {
        let what = match self {
            Self::Out => "exclude",
            Self::In => "include again",
            Self::AsFound => "reset",
        };
        match part {
            LogPart::Pings([first, last]) => format!("{what} pings {first}..{last}"),
            LogPart::Time(_) => format!("{what} a stretch"),
        }
    }
}

/// What the settings leave out of a log, and how much that is.
#[derive(Clone, Debug, Default)]
pub struct FoundLeftOut {
    /// Which pings and soundings.
    pub left_out: LeftOut,
    /// Length of each stretch along the track, metres.
    pub lengths_m: Vec<f64>,
}

/// How much is left out.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Extent {
    /// Stretches.
    pub stretches: usize,
    /// Side-scan pings.
    pub pings: usize,
    /// Length along the track, metres.
    pub length_m: f64,
    /// Seconds.
    pub duration_s: f64,
}

impl FoundLeftOut {
    /// Of a log by its settings.
    pub fn new(survey: &Survey, navigation: &Navigation, settings: &LeftOutSettings) -> Self {
        let left_out = LeftOut::new(survey, navigation, settings);
        let lengths_m = (left_out.stretches.iter())
            .map(|stretch| stretch.length_m(survey, navigation))
            .collect();
        Self {
            left_out,
            lengths_m,
        }
    }

    /// Each stretch with its length along the track, metres.
    pub fn stretches(&self) -> impl Iterator<Item = (&LeftOutStretch, f64)> {
        self.left_out
            .stretches
            .iter()
            .zip(self.lengths_m.iter().copied())
    }

    /// How much is left out, for one reason or for all.
    pub fn extent(&self, reason: Option<LeftOutReason>) -> Extent {
        let counted = |(stretch, _): &(&LeftOutStretch, f64)| {
            reason.is_none_or(|reason| stretch.reason == reason)
        };
        let all = self.stretches().filter(counted);
        all.fold(Extent::default(), |sum, (stretch, length_m)| Extent {
            stretches: sum.stretches + 1,
            pings: sum.pings + stretch.pings.map_or(0, |[first, last]| last + 1 - first),
            length_m: sum.length_m + length_m,
            duration_s: sum.duration_s + stretch.time_s[1] - stretch.time_s[0],
        })
    }
}

/// What it is found of; equal keys give the same.
type Key = (Same<Survey>, Same<Navigation>, LeftOutSettings);

/// What the settings in force leave out: there before the results that go without it.
#[derive(Default)]
pub(super) struct LeavingOut {
    found: Background<Key, Arc<FoundLeftOut>>,
}

impl LeavingOut {
    fn follow(&mut self, log: (&Arc<Survey>, &Arc<Navigation>, &Settings), jobs: &Jobs) {
        let (survey, navigation, settings) = log;
        let key = (
            Same(survey.clone()),
            Same(navigation.clone()),
            settings.left_out.clone(),
        );
        let (survey, navigation) = (survey.clone(), navigation.clone());
        let settings = settings.left_out.clone();
        self.found.ask(key, jobs, move |_| {
            let found = FoundLeftOut::new(&survey, &navigation, &settings);
            Some(Arc::new(found))
        });
    }

    pub fn is_busy(&self) -> bool {
        self.found.is_running()
    }
}

impl OpenLog {
    /// What the settings in force leave out of it; `None` until it is known where its pings lie.
    pub fn left_out(&self) -> Option<&Arc<FoundLeftOut>> {
        self.leaving_out.found.result()
    }
}

impl App {
    /// Has what is left out follow the settings.
    pub(super) fn poll_left_out(&mut self) {
        let log = &mut self.log;
        if let (Some(survey), Some(products)) = (&log.survey, &log.products) {
            let found_in = (survey, &products.navigation, log.settings.as_ref());
            log.leaving_out.follow(found_in, &self.jobs);
        }
    }

    /// Leaves a part of a log out, or takes it back in, as an undo step.
    pub(super) fn leave_out(&mut self, log: LogId, part: LogPart, leave: Leave) {
        self.with_log(log, |app| app.leave_out_here(part, leave));
    }

    fn leave_out_here(&mut self, part: LogPart, leave: Leave) {
        let Some(survey) = &self.log.survey else {
            return;
        };
        let mut settings = Settings::clone(&self.log.settings);
        let left_out = &settings.left_out;
        settings.left_out = match leave {
            Leave::Out => left_out.leaving_out(survey, part),
            // Until it is known where the boat was nothing is found, and nothing has to be kept in.
            Leave::In => match &self.log.products {
                Some(products) => left_out.taking_in(survey, &products.navigation, part),
                None => left_out.as_found(survey, part),
            },
            Leave::AsFound => left_out.as_found(survey, part),
        };
        self.change(settings, leave.label(part), false);
    }

    /// The stretch that a ping of a log is left out with.
    pub fn left_out_at(&self, log: LogId, ping: usize) -> Option<LeftOutStretch> {
        let left_out = &self.open_log(log)?.left_out()?.left_out;
        let stretch = left_out.stretch_at(ping)?;
        left_out.stretches.get(stretch).copied()
    }

    /// Takes the stretch that the selected ping lies in back in.
    pub(super) fn take_back_in(&mut self) {
        let at = self.selection.map(|mark| mark.ping);
        match at.and_then(|ping| self.left_out_at(self.log.id, ping)) {
            Some(stretch) => self.leave_out(self.log.id, stretch.part(), Leave::In),
            None => {
                let text =
                    "the selected ping is not excluded; select a ping of an excluded stretch";
                self.notify(text.to_owned(), true);
            }
        }
    }

    /// How much a part of a log is.
    pub fn extent_of(&self, log: LogId, part: LogPart) -> Option<Extent> {
        let log = self.open_log(log)?;
        let survey = log.survey.as_ref()?;
        Some(Extent {
            stretches: 1,
            pings: match part {
                LogPart::Pings([first, last]) => last.saturating_sub(first) + 1,
                LogPart::Time(_) => 0,
            },
            length_m: part.length_m(survey, &log.products.as_ref()?.navigation),
            duration_s: part.duration_s(survey),
        })
    }
}
