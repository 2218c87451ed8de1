//! The results of the stages, each tagged with the settings that made it, and a log with its
//! results.

use super::Settings;
use bathyscope_bottom::calibration::{self, Calibration, CalibrationSettings, FlatSpot};
use bathyscope_bottom::cloud::{
    self, CloudPoint, CloudSettings, Clutter, Correction, PickTraits, PingDepth, PointClass,
    PointCloud, PointScales, Reduction, Residuals,
};
use bathyscope_bottom::first_return::FirstReturns;
use bathyscope_log::support::progress::{Cancelled, Progress};
use bathyscope_log::survey::{Exclusions, Navigation, Relief, Survey};
use bathyscope_objects::targets::PassLog;
use serde::Serialize;
use std::sync::Arc;

/// Least difference, in seconds and in standard errors, by which crossings contradict the latency
/// in force.
const CONTRADICTED_S: f64 = 0.15;
const CONTRADICTED_SIGMAS: f64 = 3.0;
/// Least number of crossings that show the difference of depths well.
const FEWEST_CROSSINGS: usize = 6;
/// Depths of one recorder differ where its track crosses itself by this much, metres, and by this
/// share of the depth, where boat and instruments are steady; standard deviation.
const STEADY_M: f64 = 0.05;
const STEADY_SHARE: f64 = 0.005;
/// Standard deviation of normal errors over their mean absolute value.
const SIGMA_PER_MAE: f64 = 1.2533;
/// Share of a lag of soundings that crossings may show besides: an average is no delay.
const LAG_LEFT: f64 = 0.15;

/// Latency of the positions of a log, as its crossings show it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct LogLatency {
    /// Value that `mounting.latency_s` should have, seconds.
    pub latency_s: f64,
    /// Its standard error, seconds.
    pub standard_error_s: f64,
    /// Latency in force, seconds.
    pub in_force_s: f64,
}

impl LogLatency {
    /// Returns true if the crossings contradict what is in force.
    pub(crate) fn contradicts(&self) -> bool {
        let off_s = (self.latency_s - self.in_force_s).abs();
        off_s > CONTRADICTED_S && off_s > CONTRADICTED_SIGMAS * self.standard_error_s
    }

    /// The sentence about what is in force, where the crossings contradict it.
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

    /// `0.62 s, standard error 0.08 s`.
    pub fn in_words(&self) -> String {
        format!("{:.2} s, standard error {:.2} s", self.latency_s, self.standard_error_s)
    }
}

/// Results of the pipeline for a survey and its settings. Cheap to clone: every part is shared.
#[derive(Clone, Debug)]
pub struct Products {
    /// The settings that made them.
    pub settings: Arc<Settings>,
    /// Position and heading of every ping.
    pub navigation: Arc<Navigation>,
    /// Parts of the log that count for nothing: no point, depth, echo or box comes from there.
    pub exclusions: Arc<Exclusions>,
    /// Ranked flat stretches.
    pub flat_spots: Arc<Vec<FlatSpot>>,
    /// First returns as they were found.
    pub found: Arc<FirstReturns>,
    /// The survey with the soundings that first returns contradict marked as those of a lost
    /// bottom; `None` where they contradict none, and in the provisional results of a log that
    /// grows.
    pub judged: Option<Arc<Survey>>,
    /// First returns with the bottom edits.
    pub returns: Arc<FirstReturns>,
    /// The bottom that the picture is laid out by: these first returns, or the recorded depths with
    /// the bottom edits.
    pub bottom_line: Arc<FirstReturns>,
    /// Scales.
    pub calibration: Arc<Calibration>,
    /// Correction of depths.
    pub correction: Arc<Correction>,
    /// All points.
    pub cloud: Arc<PointCloud>,
    /// The class of each point.
    pub classes: Arc<Vec<PointClass>>,
    /// The depth under the boat at every side-scan ping.
    pub depths: Arc<Vec<PingDepth>>,
    /// Shape of the bottom across the track.
    pub relief: Arc<Relief>,
    /// Ends of the colour scale of depth, metres: the 2nd and 98th percentile of the soundings that
    /// the recorder had the bottom for, as corrected. The others would stretch the colours. In a
    /// log without such soundings, those of the depths that side-scan gives; `None` where no depth
    /// is known.
    pub depth_range_m: Option<[f32; 2]>,
    /// Ends of the colour scales of echo level and slant range.
    pub scales: PointScales,
    /// Latency of positions, as the track's crossings with itself show it; `None` where they do
    /// not.
    pub latency: Option<LogLatency>,
    /// Clutter among the first returns; `None` without any, and of a log that grows.
    pub clutter: Option<Clutter>,
    /// Difference of depths where the track crosses itself; `None` where it does not.
    pub repeatability: Option<Residuals>,
}

/// A log of a survey and its results. Cheap to clone: every part is shared.
#[derive(Clone, Debug)]
pub struct ProcessedLog {
    /// The recording. All logs of one survey lie in the frame of the first ([`Survey::in_frame`]).
    pub survey: Arc<Survey>,
    /// Results of the recording, by its own settings and calibration.
    pub products: Products,
}

impl ProcessedLog {
    /// A log with its results. The survey is the judged one where they have one
    /// ([`Products::judged`]).
    pub fn new(survey: Arc<Survey>, products: Products) -> Self {
        Self { survey: products.judged.clone().unwrap_or(survey), products }
    }

    /// Returns the survey and navigation by which the passes of the boat are counted.
    pub fn pass_log(&self) -> PassLog<'_> {
        (&self.survey, &self.products.navigation)
    }

    /// The kept points, in the order of the cloud.
    pub fn kept_points(&self) -> impl Iterator<Item = &bathyscope_bottom::cloud::CloudPoint> {
        self.products.kept_points()
    }
}

impl Products {
    /// Returns the conversion of samples and recorded depths to metres by these results, for every
    /// read-out.
    pub fn reduction(&self) -> Reduction<'_> {
        Reduction::new(&self.calibration, &self.correction)
    }

    /// The sentence about positions that are late, or early, where crossings contradict the latency
    /// in force. A lag of the soundings looks like positions that are early: what is known of it is
    /// no latency.
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

    /// The sentence about depths that differ where the track crosses itself by more than those of a
    /// steady boat; `None` where they do not, or a warning names the cause.
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

    /// The first returns that count: those of excluded pings do not.
    pub(super) fn counted_returns(&self) -> Arc<FirstReturns> {
        counted(&self.returns, &self.exclusions)
    }

    /// The first returns that a calibration may be based on.
    pub(super) fn judged_returns(&self, survey: &Survey) -> Arc<FirstReturns> {
        judged(survey, &self.settings, &self.found, &self.exclusions, || self.counted_returns())
    }

    /// The scales by other settings, from first returns that they may be based on
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

    /// All points by another calibration and other settings, from the first returns that count
    /// ([`Self::counted_returns`]) and their traits.
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

    /// The points that count for the map, in the order of the cloud.
    pub fn kept_points(&self) -> impl Iterator<Item = &CloudPoint> + Clone {
        self.cloud.kept(&self.classes).map(|(_, point)| point)
    }
}

/// Ends of the colour scale of depth over some results, metres: from the least to the greatest that
/// one of them needs. `None` where no depth is known.
pub fn colour_range_m<'a>(all: impl Iterator<Item = &'a Products>) -> Option<[f32; 2]> {
    let each = all.filter_map(|products| products.depth_range_m);
    each.reduce(|[shallow, deep], [s, d]| [shallow.min(s), deep.max(d)])
}

/// The first returns that count: those of excluded pings do not.
pub(super) fn counted(returns: &Arc<FirstReturns>, exclusions: &Exclusions) -> Arc<FirstReturns> {
    if exclusions.is_empty() { returns.clone() } else { Arc::new(returns.without(exclusions)) }
}

/// The first returns that a calibration may be based on. What was accepted as bottom is flagged
/// there as it was found: it is bottom beside the boat, at another depth than that of the
/// soundings. `counted` are all that count.
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
