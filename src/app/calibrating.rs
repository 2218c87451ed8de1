//! Sets the scale of slant ranges of a log: a flat stretch of its track is proposed, its effect is
//! computed, and the analyst uses it or keeps the recorded range. Nothing changes before that;
//! afterwards a notice states by how much the depths changed.

use super::jobs::{JobKey, Kept};
use super::{Action, App, LogId, OpenLog, Tool};
use bathyscope_bottom::calibration::{self, CalibrationSettings, PingRange, ScaleMode};
use bathyscope_bottom::cloud::{DepthChange, PointClass, PointCloud};
use bathyscope_log::support::printable::quoted;
use bathyscope_log::support::progress::Progress;
use bathyscope_log::survey::Survey;
use bathyscope_products::pipeline::{ProcessedLog, Products, Same, ScaleTrial, Settings};
use std::sync::Arc;

/// Key of the setting of the scale in use.
const MODE: &str = "calibration.mode";
/// Pings to either side of a ping that are proposed before the positions of the pings are known.
const PINGS_ASIDE: usize = 50;

/// Inputs of a trial; equal keys give the same trial.
type TrialKey = (Same<Survey>, Same<Settings>, PingRange);

/// State of the proposal, trial and change of the scale of a log.
#[derive(Default)]
pub(super) struct Calibrating {
    /// The stretch that is proposed to the analyst; `None` if none is.
    proposal: Option<PingRange>,
    trial: Kept<TrialKey, Arc<ScaleTrial>>,
    change: Option<ScaleChange>,
    /// The flatter stretch that was offered while the log is followed.
    pub(super) offered: Option<PingRange>,
}

/// A change of scale whose results are still being computed.
struct ScaleChange {
    /// Description of the change, as the beginning of a sentence.
    what: String,
    calibration: CalibrationSettings,
    cloud: Arc<PointCloud>,
    classes: Arc<Vec<PointClass>>,
}

impl Calibrating {
    /// Drops the proposal.
    pub(super) fn drop_proposal(&mut self) {
        self.proposal = None;
        self.trial = Kept::default();
    }

    /// Returns a sentence about the effect of the last change of scale on the depths, if `products`
    /// are the results of that change; `None` when called again.
    pub(super) fn said_of_change(&mut self, products: &Products) -> Option<String> {
        let change = self.change.take();
        let change = change.filter(|change| change.calibration == products.settings.calibration)?;
        let found = DepthChange::between(&change.cloud, &change.classes, &products.cloud);
        Some(match found {
            Some(found) => format!(
                "{}: depths change by {:+.1} cm (median), {:+.1} cm at most",
                change.what,
                100.0 * found.median_m,
                100.0 * found.largest_m
            ),
            None => format!("{}: no side-scan depth changes", change.what),
        })
    }
}

impl OpenLog {
    /// Returns the stretch that is proposed for the scale; no result depends on it until it is
    /// used.
    pub fn proposed_stretch(&self) -> Option<PingRange> {
        self.calibrating.proposal
    }

    /// Returns true if a stretch gives the scale, or is proposed for it.
    pub(super) fn can_keep_recorded_range(&self) -> bool {
        self.settings.calibration.mode == ScaleMode::FlatSpot || self.calibrating.proposal.is_some()
    }

    /// Returns the changes that the proposed stretch would make; `None` until they are known.
    pub fn scale_trial(&self) -> Option<&Arc<ScaleTrial>> {
        let proposal = self.calibrating.proposal?;
        let trial = self.calibrating.trial.result();
        trial.filter(|trial| trial.spot.range() == proposal)
    }

    /// Proposes a stretch for the scale of the shown log.
    pub(super) fn propose_stretch(&mut self, pings: PingRange) {
        let count = (self.survey.as_ref()).map_or(0, |survey| survey.side_scan.len());
        let (start, end) = (pings.start, pings.end.min(count));
        if start < end {
            self.calibrating.proposal = Some(PingRange { start, end });
        }
    }

    /// Returns the stretch around a ping, of the length of the ranked stretches; `None` if it has
    /// no pings.
    pub(crate) fn stretch_around(&self, ping: usize) -> Option<PingRange> {
        let survey = self.survey.as_ref()?;
        let pings = match &self.products {
            Some(products) => calibration::stretch_around(survey, &products.navigation, ping),
            None => {
                let end = (ping + PINGS_ASIDE + 1).min(survey.side_scan.len());
                ping.saturating_sub(PINGS_ASIDE)..end
            }
        };
        let (start, end) = (pings.start, pings.end);
        (start < end).then_some(PingRange { start, end })
    }
}

impl App {
    /// Starts a trial of the stretch that is proposed for a log, unless stretch and results are
    /// those of the last trial.
    pub(super) fn try_scale(&mut self, id: LogId) {
        let proposed =
            self.logs.get(id).and_then(|log| log.calibrating.proposal.zip(log.settled()));
        let Some((pings, ProcessedLog { survey, products })) = proposed else {
            return;
        };
        let key = (Same(survey.clone()), Same(products.settings.clone()), pings);
        let work = move |progress: &Progress| {
            let trial = ScaleTrial::new(&survey, &products, pings, progress).ok()?;
            Some(Arc::new(trial))
        };
        self.keep(JobKey::TryScale(id), key, work, move |app| {
            app.logs.get_mut(id).map(|log| &mut log.calibrating.trial)
        });
    }

    /// Toggles the tool that proposes stretches. Without a proposal, the stretch at the selected
    /// ping is proposed, or else the best one.
    pub(super) fn take_calibration_tool(&mut self) {
        self.take_tool(Tool::Calibrate);
        let is_in_hand = self.logs.shown.reviewing.tool == Tool::Calibrate;
        if !is_in_hand || self.logs.shown.calibrating.proposal.is_some() {
            return;
        }
        let here = self.view.selection.and_then(|mark| self.logs.shown.stretch_around(mark.ping));
        let products = self.logs.shown.products.as_ref();
        let best = products.and_then(|products| products.flat_spots.first());
        if let Some(pings) = here.or(best.map(|spot| spot.range())) {
            self.logs.shown.propose_stretch(pings);
        }
    }

    /// Scales the shown log by the proposed stretch, as an undo step.
    pub(super) fn use_scale(&mut self) {
        let Some(pings) = self.logs.shown.calibrating.proposal else {
            let text = "no stretch is proposed; drag one with Calibrate on a stretch";
            return self.notices.warn(text);
        };
        let Some(trial) = self.logs.shown.scale_trial().cloned() else {
            return self.notices.warn("the scale of the proposed stretch is still being measured");
        };
        if trial.spot.ppd.is_none() {
            let why = trial.objections.first().cloned();
            let why = why.unwrap_or_else(|| "Its first returns are too few.".to_owned());
            let text = format!("the proposed stretch gives no scale. {why}");
            return self.notices.warn(text);
        }
        self.set_scale(self.logs.shown.id, Some(pings));
    }

    /// Scales the shown log by the recorder's own range, as an undo step, and drops the proposal.
    pub(super) fn keep_recorded_range(&mut self) {
        self.logs.shown.calibrating.drop_proposal();
        if self.logs.shown.settings.calibration.mode != ScaleMode::Header {
            self.set_scale(self.logs.shown.id, None);
        }
    }

    /// Scales the followed log by the flatter stretch that was offered for it.
    pub(super) fn use_offered_stretch(&mut self) {
        self.notices.withdraw(Action::UseFlatterStretch);
        let offered = |log: &OpenLog| Some((log.id, log.calibrating.offered?));
        let found = self.logs.all().find_map(offered);
        if let Some((id, pings)) = found {
            self.set_scale(id, Some(pings));
        }
    }

    /// Scales a log by one of its stretches, or by the recorder's own range, as an undo step and
    /// one of its own settings: a scale that is measured on its pings is not valid for another log.
    fn set_scale(&mut self, id: LogId, pings: Option<PingRange>) {
        let (mode, what) = match pings {
            Some(PingRange { start, end }) => {
                let last = end.saturating_sub(1);
                (ScaleMode::FlatSpot, format!("Scale from pings {start} to {last}"))
            }
            None => (ScaleMode::Header, "Scale: recorded range".to_owned()),
        };
        let before = self.step_now();
        let (shared, count) = (self.document.shared.clone(), self.logs.count());
        let Some(log) = self.logs.get_mut(id) else {
            return;
        };
        let mut settings = Settings::clone(&log.settings);
        settings.calibration.mode = mode;
        settings.calibration.pings = pings;
        let owning = log.own.owning(&shared, MODE, true);
        let own = owning.unwrap_or_else(|| (*log.own).clone());
        let (_, mut own) = match own.change(&shared, &settings) {
            Ok(parts) => parts,
            Err(error) => return self.notices.warn(error),
        };
        if pings.is_none() && mode == shared.calibration.mode {
            own.unset(MODE);
        }
        let own = Arc::new(own);
        log.own = own.clone();
        // The effect on the depths is reported once the results exist.
        log.calibrating.change = log.products.as_ref().map(|products| ScaleChange {
            what: what.clone(),
            calibration: settings.calibration,
            cloud: products.cloud.clone(),
            classes: products.classes.clone(),
        });
        log.calibrating.drop_proposal();
        if log.reviewing.tool == Tool::Calibrate {
            log.reviewing.tool = Tool::Look;
        }
        let title = match count {
            0 | 1 => what,
            _ => format!("{what}, {}", quoted(&log.name())),
        };
        self.record_named(&before, title);
        self.set_own(id, own, false);
    }
}
