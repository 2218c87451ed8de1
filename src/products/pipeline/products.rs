//! Results of the stages, with the settings from which they were made; and a log with its results.

use super::Settings;
use bathyscope_bottom::calibration::{self, Calibration, CalibrationSettings, FlatSpot};
use bathyscope_bottom::cloud::{
    self, CloudPoint, CloudSettings, Clutter, Correction, PickTraits, PingDepth, PointClass,
    PointCloud, PointScales, Reduction, Residuals,
};
use bathyscope_bottom::first_return::FirstReturns;
use bathyscope_log::support::progress::{Cancelled, Progress};
use bathyscope_log::support::statistics::wider;
use bathyscope_log::survey::{Exclusions, Navigation, Relief, Survey};
use bathyscope_objects::targets::PassLog;
use serde::Serialize;
use std::sync::Arc;

/// Least difference, in seconds and in standard errors, by which crossings contradict the latency
/// in force.
const CONTRADICTED_S: f64 = 0.15;
const CONTRADICTED_SIGMAS: f64 = 3.0;
/// Least number of crossings for an estimate of the difference of depths.
const FEWEST_CROSSINGS: usize = 6;
/// Standard deviation of the depths of one recorder where its track crosses itself, with boat and
/// instruments steady: this constant, metres, plus this share of the depth.
const STEADY_M: f64 = 0.05;
const STEADY_SHARE: f64 = 0.005;
/// Standard deviation of normal errors over their mean absolute value.
const SIGMA_PER_MAE: f64 = 1.2533;
/// Share of a lag of soundings that crossings may show in addition, since the lag is an average
/// over the log.
const LAG_LEFT: f64 = 0.15;

/// Latency of the positions of a log, derived from its crossings.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct LogLatency {
    /// Value that `mounting.latency_s` should have, seconds.
    pub latency_s: f64,
    /// Standard error of the latency, seconds.
    pub standard_error_s: f64,
    /// Latency in force, seconds.
    pub in_force_s: f64,
}

impl LogLatency {
    /// Returns true if the crossings contradict the latency in force.
    pub(crate) fn contradicts(&self) -> bool {
        let off_s = (self.latency_s - self.in_force_s).abs();
        off_s > CONTRADICTED_S && off_s > CONTRADICTED_SIGMAS * self.standard_error_s
    }

    /// Returns the warning that the crossings contradict the latency in force.
    fn warning(&self) -> String {
        let more_s = self.latency_s - self.in_force_s;
        let (when, cause) = if more_s > 0.0 {
            ("later", "the receiver is late, or its antenna is behind the transducer")
        } else {
            ("earlier", "the antenna is ahead of the transducer")
        };
        format!(
            "Where the track crosses itself over slopes, depths agree best with positions recorded {:.2} s {when} (standard error {:.2} s): {cause}. Depths beside slopes are wrong until it is corrected: set mounting.latency_s to {:.2} (Compare positions, then Apply positions; or process with --latency).",
            more_s.abs(),
            self.standard_error_s,
            self.latency_s
        )
    }

    /// Returns the latency as text: `0.62 s, standard error 0.08 s`.
    pub fn in_words(&self) -> String {
        format!("{:.2} s, standard error {:.2} s", self.latency_s, self.standard_error_s)
    }
}

/// Results of the pipeline for a survey and its settings. Cheap to clone: every part is shared.
#[derive(Clone, Debug)]
pub struct Products {
    /// Settings from which the results were made.
    pub settings: Arc<Settings>,
    /// Position and heading of every ping.
    pub navigation: Arc<Navigation>,
    /// Excluded parts of the log: they give no point, depth, echo or box.
    pub exclusions: Arc<Exclusions>,
    /// Ranked flat stretches.
    pub flat_spots: Arc<Vec<FlatSpot>>,
    /// First returns as they were found, without the bottom edits.
    pub found: Arc<FirstReturns>,
    /// Survey in which the soundings that first returns contradict are marked as soundings of a
    /// lost bottom; `None` if they contradict none, and in the provisional results of a growing
    /// log.
    pub judged: Option<Arc<Survey>>,
    /// First returns with the bottom edits applied.
    pub returns: Arc<FirstReturns>,
    /// Bottom line of the side-scan picture: these first returns, or the recorded depths, with the
    /// bottom edits.
    pub bottom_line: Arc<FirstReturns>,
    /// Scales of the log.
    pub calibration: Arc<Calibration>,
    /// Correction of depths.
    pub correction: Arc<Correction>,
    /// Cloud of all points.
    pub cloud: Arc<PointCloud>,
    /// Class of each point.
    pub classes: Arc<Vec<PointClass>>,
    /// Depth under the boat at every side-scan ping.
    pub depths: Arc<Vec<PingDepth>>,
    /// Shape of the bottom across the track.
    pub relief: Arc<Relief>,
    /// Ends of the colour scale of depth, metres: the 2nd and 98th percentile of the corrected
    /// soundings at which the recorder had not lost the bottom. The other soundings would stretch
    /// the colours. In a log without such soundings, the percentiles of the depths that side-scan
    /// gives; `None` if no depth is known.
    pub depth_range_m: Option<[f32; 2]>,
    /// Ends of the colour scales of echo level and slant range.
    pub scales: PointScales,
    /// Latency of positions, derived from the crossings of the track with itself; `None` if they do
    /// not determine it.
    pub latency: Option<LogLatency>,
    /// Clutter among the first returns; `None` if there is none, and for a growing log.
    pub clutter: Option<Clutter>,
    /// Difference of depths where the track crosses itself; `None` if it does not.
    pub repeatability: Option<Residuals>,
}

/// Log of a survey and its results. Cheap to clone: every part is shared.
#[derive(Clone, Debug)]
pub struct ProcessedLog {
    /// Recording. All logs of one survey are in the local coordinate frame of the first
    /// ([`Survey::in_frame`]).
    pub survey: Arc<Survey>,
    /// Results of the recording, with its own settings and calibration.
    pub products: Products,
}

impl ProcessedLog {
    /// Creates a log with its results. The survey is the judged one if the results have one
    /// ([`Products::judged`]).
    pub fn new(survey: Arc<Survey>, products: Products) -> Self {
        Self { survey: products.judged.clone().unwrap_or(survey), products }
    }

    /// Returns the survey and navigation for counting the passes of the boat.
    pub fn pass_log(&self) -> PassLog<'_> {
        (&self.survey, &self.products.navigation)
    }
}

impl Products {
    /// Returns the conversion of samples and recorded depths to metres by these results.
    pub fn reduction(&self) -> Reduction<'_> {
        Reduction::new(&self.calibration, &self.correction)
    }

    /// Returns a warning of late or early positions if crossings contradict the latency in force. A
    /// lag of the soundings has the same effect as early positions: the known lag is added to the
    /// latency found before the comparison.
    pub fn latency_warning(&self) -> Option<String> {
        let found = self.latency?;
        let lag = self.calibration.sounding_lag;
        let latency = LogLatency {
            latency_s: found.latency_s + lag.map_or(0.0, |lag| lag.lag_s),
            standard_error_s: found
                .standard_error_s
                .hypot(lag.map_or(0.0, |lag| LAG_LEFT * lag.lag_s)),
            ..found
        };
        latency.contradicts().then(|| latency.warning())
    }

    /// Returns a warning if depths differ where the track crosses itself by more than those of a
    /// steady boat; `None` if they do not, or another warning names the cause.
    pub fn repeatability_warning(&self) -> Option<String> {
        let found = self.repeatability.filter(|found| found.n >= FEWEST_CROSSINGS)?;
        let [least_m, most_m] = self.depth_range_m?.map(f64::from);
        let usual_m = STEADY_M + STEADY_SHARE * 0.5 * (least_m + most_m);
        let sigma_m = SIGMA_PER_MAE * found.mae_m;
        let is_named = self.latency_warning().is_some() || self.calibration.sounding_lag.is_some();
        (sigma_m > usual_m && !is_named).then(|| {
            format!(
                "Where the track crosses itself, depths differ by {sigma_m:.2} m (standard deviation of {} crossings), and those of a steady boat by {usual_m:.2} m: waves, positions that are off beside slopes, or a wide beam that takes the nearest ground on slopes. Single depths are no better than that.",
                found.n
            )
        })
    }

    /// Returns the first returns without those of excluded pings.
    pub(super) fn counted_returns(&self) -> Arc<FirstReturns> {
        counted(&self.returns, &self.exclusions)
    }

    /// Returns the first returns from which the flat stretches and the scale may be derived.
    pub(super) fn judged_returns(&self, survey: &Survey) -> Arc<FirstReturns> {
        judged(survey, &self.settings, &self.found, &self.exclusions, || self.counted_returns())
    }

    /// Computes the scales with other settings, from first returns that are suited to it
    /// ([`Self::judged_returns`]).
    pub(super) fn calibrated(
        &self,
        survey: &Survey,
        judged: &FirstReturns,
        settings: &CalibrationSettings,
        progress: &Progress,
    ) -> Result<Calibration, Cancelled> {
        let (navigation, spots) = (&self.navigation, &self.flat_spots);
        calibration::calibrate(survey, navigation, judged, spots, settings, progress)
    }

    /// Computes all points with another calibration and other settings, from the first returns that
    /// count ([`Self::counted_returns`]) and their traits.
    pub(super) fn placed(
        &self,
        survey: &Survey,
        counted: (&FirstReturns, &PickTraits),
        calibration: &Calibration,
        settings: &CloudSettings,
        progress: &Progress,
    ) -> Result<PointCloud, Cancelled> {
        let cloud = cloud::place(
            survey,
            &self.navigation,
            counted,
            calibration,
            settings,
            &self.correction,
            progress,
        )?;
        Ok(cloud.without(&self.exclusions))
    }

    /// Returns the points that count for the depth map, in the order of the cloud.
    pub fn kept_points(&self) -> impl Iterator<Item = &CloudPoint> + Clone {
        self.cloud.kept(&self.classes).map(|(_, point)| point)
    }
}

/// Returns the ends of a colour scale of depth that includes those of all results, metres; `None`
/// if no depth is known.
pub fn colour_range_m<'a>(all: impl Iterator<Item = &'a Products>) -> Option<[f32; 2]> {
    all.map(|products| products.depth_range_m).fold(None, wider)
}

/// Returns the first returns without those of excluded pings.
pub(super) fn counted(returns: &Arc<FirstReturns>, exclusions: &Exclusions) -> Arc<FirstReturns> {
    if exclusions.is_empty() { returns.clone() } else { Arc::new(returns.without(exclusions)) }
}

/// Returns the first returns from which the flat stretches and the scale may be derived. First
/// returns that the analyst accepted as bottom keep the flag with which they were found: they are
/// bottom beside the boat, at another depth than the soundings. `counted` returns all first returns
/// that count.
pub(super) fn judged(
    survey: &Survey,
    settings: &Settings,
    found: &FirstReturns,
    exclusions: &Exclusions,
    counted: impl FnOnce() -> Arc<FirstReturns>,
) -> Arc<FirstReturns> {
    if !settings.bottom.has_accepted() {
        return counted();
    }
    let mut returns = found.clone();
    settings.bottom.drawn_only().apply(survey, &mut returns);
    Arc::new(returns.without(exclusions))
}
