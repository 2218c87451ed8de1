//! The results of the stages, each tagged with the settings that made it.

use super::Settings;
use super::relief::relief;
use crate::bottom::bathymetry;
use crate::bottom::cloud::{
    self, CloudPoint, Correction, PingDepth, PointClass, PointCloud, PointScales, Reduction,
};
use crate::sonar::calibration::{self, Calibration, FlatSpot};
use crate::sonar::first_return::{self, BottomLine, FirstReturns};
use crate::support::named::named;
use crate::support::progress::{Cancelled, Progress};
use crate::survey::{Exclusions, Navigation, Relief, SideSpan, Sounding, Survey, navigate_with};
use std::sync::Arc;

/// A stage of the pipeline, in the order of the data.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Stage {
    /// Position and heading of every ping.
    Navigation,
    /// First return on both sides.
    FirstReturn,
    /// Flat stretches of the track, and scales.
    Calibration,
    /// Points.
    Cloud,
    /// What each point is; the outlier filter runs here.
    Outliers,
    /// The bottom across the track.
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
    /// The first stage whose result differs between two settings; `None` when all results are the same.
    pub fn first_stale(old: &Settings, new: &Settings) -> Option<Stage> {
        // With the sides of a log all that is known of it is another, its places included.
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

/// What the pipeline made of a survey with some settings. Cheap to clone: every part is shared.
#[derive(Clone, Debug)]
pub struct Products {
    /// The settings that made them.
    pub settings: Arc<Settings>,
    /// Position and heading of every ping.
    pub navigation: Arc<Navigation>,
    /// What counts for nothing: no point, depth, echo or box comes from there.
    pub exclusions: Arc<Exclusions>,
    /// Ranked flat stretches.
    pub flat_spots: Arc<Vec<FlatSpot>>,
    /// First returns as they were found.
    pub found: Arc<FirstReturns>,
    /// First returns with the bottom edits.
    pub returns: Arc<FirstReturns>,
    /// The bottom that the picture is laid out by: these first returns, or the recorded depths with the bottom edits.
    pub bottom_line: Arc<FirstReturns>,
    /// Scales.
    pub calibration: Arc<Calibration>,
    /// What was done to depths.
    pub correction: Arc<Correction>,
    /// All points.
    pub cloud: Arc<PointCloud>,
    /// The class of each point.
    pub classes: Arc<Vec<PointClass>>,
    /// The depth under the boat at every side-scan ping.
    pub depths: Arc<Vec<PingDepth>>,
    /// How the bottom lies across the track.
    pub relief: Arc<Relief>,
    /// Ends of the colour scale of depth, metres: the 2nd and 98th percentile of the soundings that the recorder had the bottom for, as
    /// corrected. The others would stretch the colours. In a log without such soundings, those of the depths that side-scan gives;
    /// `None` where no depth is known.
    pub depth_range_m: Option<[f32; 2]>,
    /// Ends of the colour scales of echo level and slant range.
    pub scales: PointScales,
}

impl Products {
    /// What samples and recorded depths are in metres by these results: for every read-out.
    pub fn reduction(&self) -> Reduction<'_> {
        Reduction::new(&self.calibration, &self.correction)
    }

    /// The first returns that count: those of excluded pings do not.
    pub(super) fn counted_returns(&self) -> Arc<FirstReturns> {
        match self.exclusions.is_empty() {
            true => self.returns.clone(),
            false => Arc::new(self.returns.without(&self.exclusions)),
        }
    }

    /// The first returns that a calibration may be based on.
    pub(super) fn judged_returns(&self, survey: &Survey) -> Arc<FirstReturns> {
        judged(
            survey,
            &self.settings,
            &self.found,
            &self.exclusions,
            || self.counted_returns(),
        )
    }

    /// The points that count for the map, in the order of the cloud.
    pub fn kept_points(&self) -> impl Iterator<Item = &CloudPoint> + Clone {
        self.cloud.kept(&self.classes).map(|(_, point)| point)
    }
}

/// Ends of the colour scale of depth over some results, metres: from the least to the greatest that one of them needs. `None` where no
/// depth is known.
pub(crate) fn colour_range_m<'a>(all: impl Iterator<Item = &'a Products>) -> Option<[f32; 2]> {
    let each = all.filter_map(|products| products.depth_range_m);
    each.reduce(|[shallow, deep], [s, d]| [shallow.min(s), deep.max(d)])
}

/// The percentiles of [`Products::depth_range_m`].
fn depth_range_m(
    survey: &Survey,
    correction: &Correction,
    depths: &[PingDepth],
) -> Option<[f32; 2]> {
    let locked = survey.soundings.iter().filter(|sounding| sounding.locked);
    let depth_m = |sounding: &Sounding| {
        correction.depth_m(sounding.time_s, f64::from(sounding.depth_m)) as f32
    };
    let of_pings = || bathymetry::depth_range(depths.iter().map(|depth| depth.depth_m));
    bathymetry::depth_range(locked.map(depth_m)).or_else(of_pings)
}

/// How many flat stretches are ranked.
const FLAT_SPOTS: usize = 8;

/// Runs the stages whose results differ from `previous` (same survey), or all of them.
///
/// # Errors
/// When the work was cancelled.
pub fn run(
    survey: &Survey,
    settings: &Settings,
    previous: Option<&Products>,
    progress: &Progress,
    mut on_stage: impl FnMut(Stage),
) -> Result<Products, Cancelled> {
    let stale = match previous {
        Some(previous) => Stage::first_stale(&previous.settings, settings),
        None => Some(Stage::Navigation),
    };
    // The first return depends on neither position nor heading: a change of heading source must not run the tracker again.
    let same_picks = |old: &&Products| {
        old.settings.image == settings.image
            && old.settings.mounting.swap_sides == settings.mounting.swap_sides
            && old
                .settings
                .first_return
                .finds_the_same(&settings.first_return)
    };
    let reuse = |stage: Stage| match stage {
        // The bottom edits are applied again, which costs next to nothing.
        Stage::FirstReturn => previous.filter(same_picks),
        _ => previous.filter(|_| stale.is_none_or(|first| stage < first)),
    };
    let mut begin = |stage: Stage| {
        on_stage(stage);
        progress.check()
    };

    let navigation = match reuse(Stage::Navigation) {
        Some(old) => old.navigation.clone(),
        None => {
            begin(Stage::Navigation)?;
            Arc::new(navigate_with(
                survey,
                settings.position_settings(),
                progress,
            )?)
        }
    };
    let exclusions = match previous.filter(|old| Arc::ptr_eq(&old.navigation, &navigation)) {
        Some(old) if old.settings.excluded == settings.excluded => old.exclusions.clone(),
        _ => Arc::new(Exclusions::new(survey, &navigation, &settings.excluded)),
    };
    let found = match reuse(Stage::FirstReturn) {
        Some(old) => old.found.clone(),
        None => {
            begin(Stage::FirstReturn)?;
            let Settings {
                image,
                first_return,
                ..
            } = settings;
            Arc::new(first_return::detect(survey, image, first_return, progress)?)
        }
    };
    let returns = with_bottom(survey, settings, previous, &found);
    let counted = match exclusions.is_empty() {
        true => returns.clone(),
        false => Arc::new(returns.without(&exclusions)),
    };
    let (flat_spots, calibration) = match reuse(Stage::Calibration) {
        Some(old) => (old.flat_spots.clone(), old.calibration.clone()),
        None => {
            begin(Stage::Calibration)?;
            let previous = previous.filter(|old| {
                Arc::ptr_eq(&old.returns, &returns) && Arc::ptr_eq(&old.exclusions, &exclusions)
            });
            let judged = judged(survey, settings, &found, &exclusions, || counted.clone());
            let spots = rank(survey, previous, &navigation, &judged, progress)?;
            let how = &settings.calibration;
            let made = calibration::calibrate(survey, &navigation, &judged, &spots, how, progress)?;
            (spots, Arc::new(made))
        }
    };
    let correction = match reuse(Stage::Cloud) {
        Some(old) => old.correction.clone(),
        None => Arc::new(Correction::new(settings.depth(), survey)),
    };
    let reduction = Reduction::new(&calibration, &correction);
    let same_line = |old: &&Products| {
        Arc::ptr_eq(&old.returns, &returns)
            && Arc::ptr_eq(&old.calibration, &calibration)
            && old.settings.first_return.bottom_line == settings.first_return.bottom_line
    };
    let bottom_line = match previous.filter(same_line) {
        Some(old) => old.bottom_line.clone(),
        None => bottom_line(survey, settings, &returns, &reduction),
    };
    let cloud = match reuse(Stage::Cloud) {
        Some(old) => old.cloud.clone(),
        None => {
            begin(Stage::Cloud)?;
            let (scale, how) = (&calibration, &settings.cloud);
            let made = cloud::build(
                survey,
                &navigation,
                &counted,
                scale,
                how,
                &correction,
                progress,
            )?;
            Arc::new(made.without(&exclusions))
        }
    };
    let (classes, depths, depth_range_m, scales) = match reuse(Stage::Outliers) {
        Some(old) => (
            old.classes.clone(),
            old.depths.clone(),
            old.depth_range_m,
            old.scales,
        ),
        None => {
            begin(Stage::Outliers)?;
            let classes = cloud::classify(&cloud, &settings.class_rules(), progress)?;
            let mut depths = cloud::ping_depths(survey, &cloud, &classes, &correction);
            cloud::clear_excluded_depths(&mut depths, 0, &exclusions);
            let range_m = depth_range_m(survey, &correction, &depths);
            let scales = PointScales::of(survey, &cloud, &classes, &reduction);
            (Arc::new(classes), Arc::new(depths), range_m, scales)
        }
    };
    let relief = match reuse(Stage::Relief) {
        Some(old) => old.relief.clone(),
        None => {
            begin(Stage::Relief)?;
            let how = &settings.surface;
            Arc::new(relief(
                survey,
                &navigation,
                &cloud,
                &classes,
                how,
                progress,
            )?)
        }
    };
    Ok(Products {
        settings: Arc::new(settings.clone()),
        navigation,
        exclusions,
        flat_spots,
        found,
        returns,
        bottom_line,
        calibration,
        correction,
        cloud,
        classes,
        depths,
        relief,
        depth_range_m,
        scales,
    })
}

/// First returns with the bottom edits; those of `previous` where they are the same.
fn with_bottom(
    survey: &Survey,
    settings: &Settings,
    previous: Option<&Products>,
    found: &Arc<FirstReturns>,
) -> Arc<FirstReturns> {
    if settings.bottom.is_empty() {
        return found.clone();
    }
    let same =
        |old: &&Products| Arc::ptr_eq(&old.found, found) && old.settings.bottom == settings.bottom;
    if let Some(old) = previous.filter(same) {
        return old.returns.clone();
    }
    let mut returns = FirstReturns::clone(found);
    settings.bottom.apply(survey, &mut returns);
    Arc::new(returns)
}

/// The first returns that a calibration may be based on. What was accepted as bottom is flagged there as it was found: it is bottom beside the
/// boat, at another depth than that of the soundings. `counted` are all that count.
fn judged(
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

/// The bottom line by the settings.
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

/// The flat stretches; those of `previous`, results of the same picks, where the track is the same too. They depend on track and picks
/// only: choosing one of them, or a scale, leaves the ranking as it is.
fn rank(
    survey: &Survey,
    previous: Option<&Products>,
    navigation: &Arc<Navigation>,
    returns: &FirstReturns,
    progress: &Progress,
) -> Result<Arc<Vec<FlatSpot>>, Cancelled> {
    if let Some(old) = previous.filter(|old| Arc::ptr_eq(&old.navigation, navigation)) {
        return Ok(old.flat_spots.clone());
    }
    let spots = calibration::flat_spots(survey, navigation, returns, FLAT_SPOTS, progress)?;
    Ok(Arc::new(spots))
}
