//! Defines the stages of a log and which of them a change of settings makes stale, and runs the
//! stages over a survey in order.

use super::joint::{crossline_analysis, latencies};
use super::products::{LogLatency, Products, counted, judged};
use super::surface::relief;
use super::{ProcessedLog, Settings};
use bathyscope_bottom::calibration::{self, Calibration, FlatSpot};
use bathyscope_bottom::cloud::{
    self, Clutter, Correction, PickTraits, PingDepth, PointClass, PointCloud, PointScales,
    Reduction, Residuals,
};
use bathyscope_bottom::first_return::{self, BottomLine, FirstReturns};
use bathyscope_log::named;
use bathyscope_log::support::progress::{Cancelled, Progress};
use bathyscope_log::support::statistics::colour_ends;
use bathyscope_log::survey::{
    Exclusions, Navigation, PingNav, Relief, SideSpan, Sounding, Survey, navigate_with,
};
use std::sync::Arc;

/// Number of flat stretches in the ranking.
const FLAT_SPOTS: usize = 8;

/// Stage of the pipeline, in the order of the data.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Stage {
    /// Position and heading of every ping.
    Navigation,
    /// First return on both sides.
    FirstReturn,
    /// Flat stretches of the track, and scales.
    Calibration,
    /// Points of the cloud.
    Cloud,
    /// Class of each point; includes the outlier filter.
    Outliers,
    /// Shape of the bottom across the track.
    Relief,
}

named! {
    /// All stages in order.
    pub Stage {
        Navigation: "track",
        FirstReturn: "first return",
        Calibration: "calibration",
        Cloud: "cloud",
        Outliers: "outliers",
        Relief: "relief",
    }
}

impl Stage {
    /// Returns the first stage whose result differs between two settings; `None` if all results are
    /// equal.
    pub fn first_stale(old: &Settings, new: &Settings) -> Option<Stage> {
        // A change of the sides, or of another property of the log, changes all data of the log,
        // including its places.
        let same_log =
            old.track == new.track && old.source == new.source && old.mounting == new.mounting;
        let same_places = old.heading == new.heading
            && old.projection == new.projection
            && old.position_shift == new.position_shift;
        if !same_places || !same_log {
            Some(Stage::Navigation)
        } else if old.image != new.image
            || !old.first_return.finds_the_same(&new.first_return)
            || old.bottom != new.bottom
        {
            Some(Stage::FirstReturn)
        } else if old.calibration != new.calibration || old.excluded != new.excluded {
            Some(Stage::Calibration)
        } else if old.cloud != new.cloud || old.depth() != new.depth() {
            Some(Stage::Cloud)
        } else if old.class_rules() != new.class_rules() || old.first_return != new.first_return {
            Some(Stage::Outliers)
        } else if !old.surface.counts_the_same(&new.surface) {
            Some(Stage::Relief)
        } else {
            None
        }
    }
}

/// Runs the stages whose results differ from `previous` (same survey), or all of them.
///
/// # Errors
/// When the work was cancelled.
pub fn run(
    survey: &Survey,
    settings: &Settings,
    previous: Option<&Products>,
    progress: &Progress,
    on_stage: impl FnMut(Stage),
) -> Result<Products, Cancelled> {
    let stale = match previous {
        Some(previous) => Stage::first_stale(&previous.settings, settings),
        None => Some(Stage::Navigation),
    };
    let mut run = Run { survey, settings, previous, stale, progress, on_stage };
    let navigation = run.navigation()?;
    let exclusions = run.exclusions(&navigation);
    let found = run.found()?;
    let judged = run.judged(&found, &exclusions);
    let mut run = Run { survey: judged.as_deref().unwrap_or(survey), ..run };
    let returns = run.returns(&found);
    let counted = counted(&returns, &exclusions);
    let (flat_spots, calibration) =
        run.calibration(&navigation, &exclusions, &found, &returns, &counted)?;
    let correction = run.correction();
    let reduction = Reduction::new(&calibration, &correction);
    let bottom_line = run.bottom_line(&returns, &calibration, &reduction);
    let (cloud, clutter) =
        run.cloud(&navigation, &exclusions, &counted, &calibration, &correction)?;
    let point_results =
        run.point_results((&cloud, &navigation.pings), &exclusions, &correction, &reduction)?;
    let relief = run.relief(&navigation, &cloud, &point_results.classes)?;
    let known = run.reusable(Stage::Outliers).map(|old| (old.latency, old.repeatability));
    let mut products = Products {
        settings: Arc::new(settings.clone()),
        navigation,
        exclusions,
        flat_spots,
        found,
        judged,
        returns,
        bottom_line,
        calibration,
        correction,
        cloud,
        classes: point_results.classes,
        depths: point_results.depths,
        relief,
        depth_range_m: point_results.depth_range_m,
        scales: point_results.scales,
        clutter,
        latency: None,
        repeatability: None,
    };
    (products.latency, products.repeatability) = match known {
        Some(known) => known,
        None => by_crossings(survey, &products, progress)?,
    };
    Ok(products)
}

/// Finds the latency of the positions of a log, and the differences of its depths, from the
/// crossings of its track with itself.
fn by_crossings(
    survey: &Survey,
    products: &Products,
    progress: &Progress,
) -> Result<(Option<LogLatency>, Option<Residuals>), Cancelled> {
    let log = [ProcessedLog::new(Arc::new(survey.clone()), products.clone())];
    let latency = latencies(&log, progress)?.pop().flatten();
    let all = crossline_analysis(&log, progress)?;
    Ok((latency, all.and_then(|mut all| all.within_logs.pop().flatten())))
}

/// State that all stages of a run share.
struct Run<'a, OnStage> {
    survey: &'a Survey,
    settings: &'a Settings,
    /// Results of an earlier run over the same survey; those that are still valid are used again.
    previous: Option<&'a Products>,
    /// First stage whose result differs from that of `previous`; `None` if all are equal.
    stale: Option<Stage>,
    progress: &'a Progress,
    /// Called at the beginning of each stage that runs.
    on_stage: OnStage,
}

/// Results that depend on the classes of the points.
struct PointResults {
    classes: Arc<Vec<PointClass>>,
    depths: Arc<Vec<PingDepth>>,
    depth_range_m: Option<[f32; 2]>,
    scales: PointScales,
}

impl<'a, OnStage: FnMut(Stage)> Run<'a, OnStage> {
    /// Returns the earlier results if that of this stage is still valid.
    fn reusable(&self, stage: Stage) -> Option<&'a Products> {
        self.previous.filter(|old| match stage {
            // The bottom edits are applied again in any case, which takes little time.
            Stage::FirstReturn => finds_the_same(&old.settings, self.settings),
            _ => self.stale.is_none_or(|first| stage < first),
        })
    }

    fn begin(&mut self, stage: Stage) -> Result<(), Cancelled> {
        (self.on_stage)(stage);
        self.progress.check()
    }

    /// Returns position and heading of every ping.
    fn navigation(&mut self) -> Result<Arc<Navigation>, Cancelled> {
        if let Some(old) = self.reusable(Stage::Navigation) {
            return Ok(old.navigation.clone());
        }
        self.begin(Stage::Navigation)?;
        let positions = self.settings.position_settings();
        let navigation = navigate_with(self.survey, positions, self.progress)?;
        Ok(Arc::new(navigation))
    }

    /// Returns the parts of the log that are excluded.
    fn exclusions(&self, navigation: &Arc<Navigation>) -> Arc<Exclusions> {
        let excluded = &self.settings.excluded;
        let is_same = |old: &&Products| {
            Arc::ptr_eq(&old.navigation, navigation) && old.settings.excluded == *excluded
        };
        match self.previous.filter(is_same) {
            Some(old) => old.exclusions.clone(),
            None => Arc::new(Exclusions::new(self.survey, navigation, excluded)),
        }
    }

    /// Returns the first returns, without bottom edits.
    fn found(&mut self) -> Result<Arc<FirstReturns>, Cancelled> {
        if let Some(old) = self.reusable(Stage::FirstReturn) {
            return Ok(old.found.clone());
        }
        self.begin(Stage::FirstReturn)?;
        let (image, how) = (&self.settings.image, &self.settings.first_return);
        let found = first_return::detect(self.survey, image, how, self.progress)?;
        Ok(Arc::new(found))
    }

    /// Returns the survey in which soundings that first returns contradict are marked as false, and
    /// those that the analyst trusts as good; `None` if there are neither.
    fn judged(
        &self,
        found: &Arc<FirstReturns>,
        exclusions: &Arc<Exclusions>,
    ) -> Option<Arc<Survey>> {
        let is_same = |old: &&Products| {
            Arc::ptr_eq(&old.found, found)
                && (Arc::ptr_eq(&old.exclusions, exclusions)
                    || old.settings.excluded == self.settings.excluded)
        };
        if let Some(old) = self.previous.filter(is_same) {
            return old.judged.clone();
        }
        let judged = found.judged(self.survey);
        let trusted = self.settings.excluded.trusted(judged.as_ref().unwrap_or(self.survey));
        trusted.or(judged).map(Arc::new)
    }

    /// Returns the first returns with the bottom edits.
    fn returns(&self, found: &Arc<FirstReturns>) -> Arc<FirstReturns> {
        let edits = &self.settings.bottom;
        if edits.is_empty() {
            return found.clone();
        }
        let is_same =
            |old: &&Products| Arc::ptr_eq(&old.found, found) && old.settings.bottom == *edits;
        if let Some(old) = self.previous.filter(is_same) {
            return old.returns.clone();
        }
        let mut returns = FirstReturns::clone(found);
        edits.apply(self.survey, &mut returns);
        Arc::new(returns)
    }

    /// Returns the flat stretches, and the scales from one of them. `counted` are the first returns
    /// of `returns` that count.
    fn calibration(
        &mut self,
        navigation: &Arc<Navigation>,
        exclusions: &Arc<Exclusions>,
        found: &FirstReturns,
        returns: &Arc<FirstReturns>,
        counted: &Arc<FirstReturns>,
    ) -> Result<(Arc<Vec<FlatSpot>>, Arc<Calibration>), Cancelled> {
        if let Some(old) = self.reusable(Stage::Calibration) {
            return Ok((old.flat_spots.clone(), old.calibration.clone()));
        }
        self.begin(Stage::Calibration)?;
        let (survey, settings) = (self.survey, self.settings);
        let judged = judged(survey, settings, found, exclusions, || counted.clone());
        // Flat stretches depend on the track and the picks only: their ranking does not change when
        // one of them, or another scale, is chosen.
        let same_spots = self.previous.filter(|old| {
            Arc::ptr_eq(&old.navigation, navigation)
                && Arc::ptr_eq(&old.returns, returns)
                && Arc::ptr_eq(&old.exclusions, exclusions)
        });
        let progress = self.progress;
        let spots = match same_spots {
            Some(old) => old.flat_spots.clone(),
            None => {
                let rank = calibration::flat_spots;
                Arc::new(rank(survey, navigation, &judged, FLAT_SPOTS, progress)?)
            }
        };
        let how = &settings.calibration;
        let made = calibration::calibrate(survey, navigation, &judged, &spots, how, progress)?;
        Ok((spots, Arc::new(made)))
    }

    /// Creates the correction of depths.
    fn correction(&self) -> Arc<Correction> {
        match self.reusable(Stage::Cloud) {
            Some(old) => old.correction.clone(),
            None => Arc::new(Correction::new(self.settings.depth(), self.survey)),
        }
    }

    /// Returns the bottom line of the side-scan picture.
    fn bottom_line(
        &self,
        returns: &Arc<FirstReturns>,
        calibration: &Arc<Calibration>,
        reduction: &Reduction<'_>,
    ) -> Arc<FirstReturns> {
        let which = self.settings.first_return.bottom_line;
        let is_same = |old: &&Products| {
            Arc::ptr_eq(&old.returns, returns)
                && Arc::ptr_eq(&old.calibration, calibration)
                && old.settings.first_return.bottom_line == which
        };
        match self.previous.filter(is_same) {
            Some(old) => old.bottom_line.clone(),
            None => bottom_line(self.survey, self.settings, returns, reduction),
        }
    }

    /// Returns all points, and the clutter among the first returns; excluded points have no place.
    fn cloud(
        &mut self,
        navigation: &Navigation,
        exclusions: &Exclusions,
        counted: &FirstReturns,
        calibration: &Calibration,
        correction: &Correction,
    ) -> Result<(Arc<PointCloud>, Option<Clutter>), Cancelled> {
        if let Some(old) = self.reusable(Stage::Cloud) {
            return Ok((old.cloud.clone(), old.clutter));
        }
        self.begin(Stage::Cloud)?;
        let traits = PickTraits::new(self.survey, navigation, counted);
        let made = cloud::place(
            self.survey,
            navigation,
            (counted, &traits),
            calibration,
            &self.settings.cloud,
            correction,
            self.progress,
        )?;
        Ok((Arc::new(made.without(exclusions)), traits.clutter))
    }

    /// Returns the class of each point, and the results that depend on it: depths under the boat,
    /// and the ends of colour scales.
    fn point_results(
        &mut self,
        (cloud, places): (&PointCloud, &[PingNav]),
        exclusions: &Exclusions,
        correction: &Correction,
        reduction: &Reduction<'_>,
    ) -> Result<PointResults, Cancelled> {
        if let Some(old) = self.reusable(Stage::Outliers) {
            return Ok(PointResults {
                classes: old.classes.clone(),
                depths: old.depths.clone(),
                depth_range_m: old.depth_range_m,
                scales: old.scales,
            });
        }
        self.begin(Stage::Outliers)?;
        let survey = self.survey;
        let classes = cloud::classify(cloud, &self.settings.class_rules(), self.progress)?;
        let mut depths = cloud::ping_depths(
            survey,
            places,
            (cloud, self.settings.cloud.geometry),
            &classes,
            correction,
        );
        cloud::clear_excluded_depths(&mut depths, 0, exclusions);
        Ok(PointResults {
            depth_range_m: depth_range_m(survey, correction, &depths),
            scales: PointScales::of(survey, cloud, &classes, reduction),
            classes: Arc::new(classes),
            depths: Arc::new(depths),
        })
    }

    /// Computes the shape of the bottom across the track.
    fn relief(
        &mut self,
        navigation: &Navigation,
        cloud: &PointCloud,
        classes: &[PointClass],
    ) -> Result<Arc<Relief>, Cancelled> {
        if let Some(old) = self.reusable(Stage::Relief) {
            return Ok(old.relief.clone());
        }
        self.begin(Stage::Relief)?;
        let (survey, how) = (self.survey, &self.settings.surface);
        let relief = relief(survey, navigation, cloud, classes, how, self.progress)?;
        Ok(Arc::new(relief))
    }
}

/// Returns true if the search for first returns has the same result with both settings. The search
/// does not depend on position or heading: a change of the heading source must not run the tracker
/// again.
fn finds_the_same(old: &Settings, new: &Settings) -> bool {
    old.image == new.image
        && old.mounting.swap_sides == new.mounting.swap_sides
        && old.mounting.sounding_lag_s == new.mounting.sounding_lag_s
        && old.source.frequency_khz == new.source.frequency_khz
        && old.first_return.finds_the_same(&new.first_return)
}

/// Returns the bottom line that the settings select.
pub(super) fn bottom_line(
    survey: &Survey,
    settings: &Settings,
    returns: &Arc<FirstReturns>,
    reduction: &Reduction<'_>,
) -> Arc<FirstReturns> {
    if settings.first_return.bottom_line == BottomLine::Search {
        return returns.clone();
    }
    let sample_at =
        |span: &SideSpan, depth_m: f64| reduction.sample_at(span, reduction.altitude_m(depth_m));
    Arc::new(first_return::at_recorded_depth(survey, returns, sample_at))
}

/// Computes the percentiles of [`Products::depth_range_m`].
fn depth_range_m(
    survey: &Survey,
    correction: &Correction,
    depths: &[PingDepth],
) -> Option<[f32; 2]> {
    let locked = survey.soundings.iter().filter(|sounding| sounding.is_good());
    let depth_m = |sounding: &Sounding| {
        correction.depth_m(sounding.time_s, f64::from(sounding.depth_m)) as f32
    };
    let of_pings = || colour_ends(depths.iter().map(|depth| depth.depth_m));
    colour_ends(locked.map(depth_m)).or_else(of_pings)
}
