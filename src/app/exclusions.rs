//! Excludes parts of a log that the analyst draws, or includes them again, and counts the excluded
//! pings before the results are updated.

use super::jobs::JobKey;
use super::{App, LogId, OpenLog, OpenLogs};
use bathyscope_log::support::progress::Progress;
use bathyscope_log::survey::{
    ExcludedStretch, ExclusionReason, ExclusionSettings, Exclusions, LogPart, Navigation, Survey,
};
use bathyscope_products::pipeline::{Same, Settings};
use std::sync::Arc;

/// A change of the exclusion of a part of a log.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ExclusionEdit {
    /// Excludes the part.
    Exclude,
    /// Includes the part, even where a turn or a stop is found in it.
    Include,
    /// Includes the part and its soundings, even those that were judged false.
    Trust,
    /// Removes the edit of the part: turns and stops found there are excluded, everything else
    /// counts.
    Reset,
}

impl ExclusionEdit {
    /// Returns the name of the change as an undo step: `exclude pings 120..240`.
    fn label(self, part: LogPart) -> String {
        let what = match self {
            Self::Exclude => "exclude",
            Self::Include => "include again",
            Self::Trust => "trust the soundings of",
            Self::Reset => "reset",
        };
        match part {
            LogPart::Pings([first, last]) => format!("{what} pings {first}..{last}"),
            LogPart::Time(_) => format!("{what} a stretch"),
        }
    }
}

/// Exclusions of a log by its settings, with their lengths.
#[derive(Clone, Debug, Default)]
pub struct FoundExclusions {
    /// Excluded pings and soundings.
    pub exclusions: Exclusions,
    /// Length of each stretch along the track, metres.
    pub lengths_m: Vec<f64>,
}

/// Amount of excluded data.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ExcludedExtent {
    /// Number of stretches.
    pub stretches: usize,
    /// Number of side-scan pings.
    pub pings: usize,
    /// Length along the track, metres.
    pub length_m: f64,
    /// Duration, seconds.
    pub duration_s: f64,
}

impl FoundExclusions {
    /// Finds the exclusions of a log from its settings.
    pub fn new(survey: &Survey, navigation: &Navigation, settings: &ExclusionSettings) -> Self {
        let exclusions = Exclusions::new(survey, navigation, settings);
        let lengths_m = (exclusions.stretches.iter())
            .map(|stretch| stretch.part().length_m(survey, navigation))
            .collect();
        Self { exclusions, lengths_m }
    }

    /// Returns each stretch with its length along the track, metres.
    pub fn stretches(&self) -> impl Iterator<Item = (&ExcludedStretch, f64)> {
        self.exclusions.stretches.iter().zip(self.lengths_m.iter().copied())
    }

    /// Returns the amount that is excluded, for one reason or for all.
    pub fn extent(&self, reason: Option<ExclusionReason>) -> ExcludedExtent {
        let counted = |(stretch, _): &(&ExcludedStretch, f64)| {
            reason.is_none_or(|reason| stretch.reason == reason)
        };
        let all = self.stretches().filter(counted);
        all.fold(ExcludedExtent::default(), |sum, (stretch, length_m)| ExcludedExtent {
            stretches: sum.stretches + 1,
            pings: sum.pings + stretch.pings.map_or(0, |[first, last]| last + 1 - first),
            length_m: sum.length_m + length_m,
            duration_s: sum.duration_s + stretch.time_s[1] - stretch.time_s[0],
        })
    }
}

/// Inputs of the exclusions; equal keys give the same exclusions.
pub(super) type ExclusionKey = (Same<Survey>, Same<Navigation>, ExclusionSettings);

impl OpenLog {
    /// Returns the exclusions of the log by the settings in force; `None` until the positions of
    /// its pings are known.
    pub fn exclusions(&self) -> Option<&Arc<FoundExclusions>> {
        self.found_exclusions.result()
    }
}

impl OpenLogs {
    /// Returns the excluded stretch of a log that contains a ping; `None` if the ping is not
    /// excluded.
    pub(crate) fn excluded_at(&self, log: LogId, ping: usize) -> Option<ExcludedStretch> {
        let exclusions = &self.get(log)?.exclusions()?.exclusions;
        let stretch = exclusions.stretch_at(ping)?;
        exclusions.stretches.get(stretch).copied()
    }

    /// Returns the extent of a part of a log; `None` where the log has no results.
    pub(crate) fn extent_of(&self, log: LogId, part: LogPart) -> Option<ExcludedExtent> {
        let log = self.get(log)?;
        let survey = log.survey.as_ref()?;
        Some(ExcludedExtent {
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

impl App {
    /// Starts the search for the exclusions of a log again if its settings have changed. It ends
    /// before the results that leave them out.
    pub(super) fn find_exclusions(&mut self, id: LogId) {
        let log = self.logs.get(id).and_then(|log| {
            let (survey, products) = (log.survey.clone()?, log.products.as_ref()?);
            Some((survey, products.navigation.clone(), log.settings.excluded.clone()))
        });
        let Some((survey, navigation, settings)) = log else {
            return;
        };
        let key = (Same(survey.clone()), Same(navigation.clone()), settings.clone());
        let work = move |_: &Progress| {
            Some(Arc::new(FoundExclusions::new(&survey, &navigation, &settings)))
        };
        self.keep(JobKey::FindExclusions(id), key, work, move |app| {
            app.logs.get_mut(id).map(|log| &mut log.found_exclusions)
        });
    }

    /// Excludes a part of a log or includes it again, as an undo step.
    pub(super) fn exclude(&mut self, id: LogId, part: LogPart, edit: ExclusionEdit) {
        let Some((log, survey)) = self.logs.log_and_survey(id) else {
            return;
        };
        let mut settings = Settings::clone(&log.settings);
        let exclusions = &settings.excluded;
        settings.excluded = match edit {
            ExclusionEdit::Exclude => exclusions.excluding(survey, part),
            // Before the positions of the boat are known, no turn or stop is found, and no part
            // needs to be included against it.
            ExclusionEdit::Include => match &log.products {
                Some(products) => exclusions.including(survey, &products.navigation, part),
                None => exclusions.reset(survey, part),
            },
            ExclusionEdit::Trust => exclusions.trusting(survey, part),
            ExclusionEdit::Reset => exclusions.reset(survey, part),
        };
        self.change_of(id, settings, edit.label(part), false);
    }

    /// Includes the excluded stretch that contains the selected ping again.
    pub(super) fn include_again(&mut self) {
        let at = self.view.selection.map(|mark| mark.ping);
        match at.and_then(|ping| self.logs.excluded_at(self.logs.shown.id, ping)) {
            Some(stretch) => {
                self.exclude(self.logs.shown.id, stretch.part(), ExclusionEdit::Include)
            }
            None => {
                let text =
                    "the selected ping is not excluded; select a ping of an excluded stretch";
                self.notices.warn(text);
            }
        }
    }

    /// Trusts the soundings around the selected ping that were taken for those of a lost bottom or
    /// for a fault of the sounder.
    pub(super) fn trust_soundings(&mut self) {
        let judged = self.logs.shown.judged();
        let time_s =
            self.view.selection.and_then(|mark| Some(judged?.side_scan.get(mark.ping)?.time_s));
        let part =
            judged.zip(time_s).and_then(|(judged, at)| LogPart::of_false_soundings(judged, at));
        match part {
            Some(part) => self.exclude(self.logs.shown.id, part, ExclusionEdit::Trust),
            None => {
                let text = "the sounding at the selected ping counts already; select a ping whose depth does not count";
                self.notices.warn(text);
            }
        }
    }
}
