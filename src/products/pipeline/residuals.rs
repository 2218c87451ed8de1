//! Compares side-scan points, and those of a swath, with the soundings of the same survey; and
//! computes the effect of another geometry or scale on a log before any setting is changed.

use super::surface::CloudPlane;
use super::{ProcessedLog, Products};
use bathyscope_bottom::bathymetry::compare::{
    Comparison, Match, Matching, ReferencePoints, match_points,
};
use bathyscope_bottom::calibration::{
    self, Calibration, CalibrationSettings, FlatSpot, OffsetMode, PingRange, PpdReach,
    RangeAtDepth, ScaleMode,
};
use bathyscope_bottom::cloud::{
    self, CloudPoint, CloudSettings, DepthChange, Geometry, PickTraits, PointSource, Residuals,
};
use bathyscope_log::support::geo::MapPlane;
use bathyscope_log::support::progress::{Cancelled, Progress};
use bathyscope_log::survey::Survey;
use serde::Serialize;
use std::sync::Arc;

/// Largest horizontal distance of the sounding that a side-scan point is compared with, metres.
const RADIUS_M: f64 = 1.0;

/// Agreement of the depths of one source with those of another.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct NamedComparison {
    /// Source of the compared depths.
    pub source: &'static str,
    /// Reference of the compared depths.
    pub reference: String,
    /// Way in which the reference of each point is found, in words.
    pub matching: String,
    /// Statistics of the comparison.
    #[serde(flatten)]
    pub comparison: Comparison,
}

/// Compares port, starboard, both and the swath with the surface of the soundings at the same
/// place, and with the nearest sounding, of all logs together in the plane of a map; empty if there
/// is no side-scan point or no sounding.
///
/// # Errors
/// When the work was cancelled.
pub(crate) fn comparisons(
    logs: &[ProcessedLog],
    map: &MapPlane,
    progress: &Progress,
) -> Result<Vec<NamedComparison>, Cancelled> {
    let Some(first) = logs.first() else {
        return Ok(Vec::new());
    };
    let (reference, _) = points(logs, map, is_sounding, |_, _| ());
    let (measured, kinds) = points(logs, map, |point| !is_sounding(point), kind);
    let max_gap_m = first.products.settings.surface.max_gap_m;
    let ways = [Matching::Surface { max_gap_m }, Matching::Nearest { radius_m: RADIUS_M }];
    let level_m = first.products.correction.middle_level_m;
    let mut found = Vec::new();
    for matching in ways {
        // Each point is matched once, even if it is in several lists.
        let all = match_points(&measured, &reference, matching, progress)?;
        for (source, counts) in LISTS {
            let matches: Vec<Match> =
                all.iter().filter(|matched| counts(kinds[matched.measured])).copied().collect();
            if !matches.is_empty() {
                let measured = kinds.iter().filter(|kind| counts(**kind)).count();
                found.push(NamedComparison {
                    source,
                    reference: "down-scan".to_owned(),
                    matching: matching.in_words(),
                    comparison: Comparison::new(measured, &matches, level_m),
                });
            }
        }
    }
    Ok(found)
}

fn is_sounding(point: &CloudPoint) -> bool {
    point.source == PointSource::DownScan
}

/// Properties of a point that decide which lists it is in.
#[derive(Clone, Copy)]
struct PointKind {
    source: PointSource,
    /// True if the recorder had lost the bottom: the depth there comes from side-scan alone, and is
    /// compared with nearby soundings.
    is_lost: bool,
}

/// Test that returns true if a point is in a list.
type PointTest = fn(PointKind) -> bool;

/// Lists of points, each with a name.
const LISTS: [(&str, PointTest); 5] = [
    ("side-scan", |kind| kind.source.is_side_scan()),
    ("port", |kind| kind.source == PointSource::Port),
    ("starboard", |kind| kind.source == PointSource::Starboard),
    ("side-scan where the bottom was lost", |kind| kind.source.is_side_scan() && kind.is_lost),
    ("swath", |kind| kind.source == PointSource::Swath),
];

/// Returns the kept points of all logs in the plane of a map, log by log, each with the result of
/// `read`.
fn points<T>(
    logs: &[ProcessedLog],
    map: &MapPlane,
    counts: impl Fn(&CloudPoint) -> bool,
    read: impl Fn(&Survey, &CloudPoint) -> T,
) -> (Vec<[f64; 3]>, Vec<T>) {
    let mut found = (Vec::new(), Vec::new());
    for log in logs {
        for (place, point) in (CloudPlane { map, log }).points(&counts) {
            found.0.push(place);
            found.1.push(read(&log.survey, point));
        }
    }
    found
}

/// Returns the properties of a point that decide which lists it is in.
fn kind(survey: &Survey, point: &CloudPoint) -> PointKind {
    PointKind { source: point.source, is_lost: survey.good_depth_m(point.ping as usize).is_nan() }
}

/// Residuals of side-scan points from soundings, with one geometry and one calibration.
#[derive(Serialize)]
pub struct GeometryChoice {
    geometry: Geometry,
    calibration: &'static str,
    /// True if these are the settings of the products.
    in_force: bool,
    /// Number of points without a sounding near them.
    unmatched: usize,
    #[serde(flatten)]
    residuals: Residuals,
}

const GEOMETRIES: [Geometry; 4] =
    [Geometry::Published, Geometry::SelfConsistent, Geometry::Nadir, Geometry::Slope];

const CALIBRATIONS: [(&str, ScaleMode, PpdReach, OffsetMode); 4] = [
    ("flat_spot, constant", ScaleMode::FlatSpot, PpdReach::Constant, OffsetMode::None),
    ("flat_spot, factor", ScaleMode::FlatSpot, PpdReach::Factor, OffsetMode::None),
    ("header", ScaleMode::Header, PpdReach::Factor, OffsetMode::None),
    ("header less offset", ScaleMode::Header, PpdReach::Factor, OffsetMode::Fit),
];

/// Returns the residuals of each combination that gives points over the soundings; a flat spot that
/// gives no scale has none. Only the calibration, the cloud and the outlier filter are run again,
/// each where its settings differ.
pub fn choices(
    survey: &Survey,
    products: &Products,
    progress: &Progress,
) -> Result<Vec<GeometryChoice>, Cancelled> {
    let soundings = products.kept_points().filter(|point| is_sounding(point));
    let max_gap_m = products.settings.surface.max_gap_m;
    let reference =
        ReferencePoints::new(soundings.map(CloudPoint::place), Matching::Surface { max_gap_m });
    let (judged, counted) = (products.judged_returns(survey), products.counted_returns());
    // A swath does not depend on these choices.
    let survey = &Survey { swath: Arc::default(), ..survey.clone() };
    let traits = PickTraits::new(survey, &products.navigation, &counted);
    let mut found = Vec::new();
    for (name, mode, ppd, offset) in CALIBRATIONS {
        let mut settings = products.settings.calibration.clone();
        settings.mode = mode;
        settings.ppd = ppd;
        settings.offset = match (offset, settings.offset) {
            // The offset mode in force, if it fits an offset.
            (OffsetMode::Fit, in_force @ (OffsetMode::Auto | OffsetMode::Fit)) => in_force,
            _ => offset,
        };
        let made = products.calibrated(survey, &judged, &settings, progress)?;
        if made.mode != mode {
            continue;
        }
        for geometry in GEOMETRIES {
            let in_force = settings == products.settings.calibration
                && geometry == products.settings.cloud.geometry;
            let cloud = if in_force {
                products.cloud.clone()
            } else {
                let how = CloudSettings { geometry, ..products.settings.cloud.clone() };
                let counted = (&*counted, &traits);
                Arc::new(products.placed(survey, counted, &made, &how, progress)?)
            };
            let points = cloud.points.iter().enumerate();
            let points: Vec<(usize, &CloudPoint)> =
                points.filter(|(_, point)| point.source.is_side_scan()).collect();
            let matches = reference.matches(&points, |(_, point)| point.place(), progress)?;
            // With a single track, some geometries have no point over the soundings; they are left
            // out before the points are classified.
            if matches.is_empty() {
                continue;
            }
            let classes = if in_force {
                products.classes.clone()
            } else {
                let rules = products.settings.class_rules();
                Arc::new(cloud::classify(&cloud, &rules, progress)?)
            };
            let is_kept = |(index, _): &(usize, &CloudPoint)| classes[*index].is_kept();
            let kept = points.iter().filter(|point| is_kept(point)).count();
            let matches = matches.iter().filter(|matched| is_kept(&points[matched.measured]));
            let mut differences: Vec<f64> = matches.map(|matched| matched.difference_m).collect();
            let unmatched = kept - differences.len();
            found.extend(Residuals::of(&mut differences).map(|residuals| GeometryChoice {
                geometry,
                calibration: name,
                in_force,
                unmatched,
                residuals,
            }));
        }
    }
    Ok(found)
}

/// Scale that a stretch of pings gives, and its effect.
#[derive(Clone, Debug)]
pub struct ScaleTrial {
    /// Stretch of pings and its scale.
    pub spot: FlatSpot,
    /// Objections to the scale, in sentences.
    pub objections: Vec<String>,
    /// Ranges of the first returns of the whole log at recorded depths, by the recorder's scale.
    pub points: Vec<RangeAtDepth>,
    /// Effect of the scale on the depths; `None` if the stretch gives no scale, or the log has no
    /// side-scan depths.
    pub effect: Option<ScaleEffect>,
}

/// Effect of another scale on the depths of a log.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScaleEffect {
    /// Change of the depths.
    pub change: DepthChange,
    /// Elevation of side-scan points minus that of the soundings of the same pings, with the
    /// present scale and with the other; `None` without soundings.
    pub residuals: Option<[Residuals; 2]>,
}

impl ScaleTrial {
    /// Computes the scale that a stretch of pings gives, and its effect on a log with its results.
    ///
    /// # Errors
    /// When the work was cancelled.
    pub fn new(
        survey: &Survey,
        products: &Products,
        pings: PingRange,
        progress: &Progress,
    ) -> Result<Self, Cancelled> {
        let returns = products.judged_returns(survey);
        let stretch = pings.start..pings.end;
        let spot = calibration::stretch(survey, &products.navigation, &returns, stretch);
        let objections = spot.objections(survey, products.flat_spots.first());
        progress.check()?;
        let points = calibration::ranges_at_depths(survey, &returns);
        let effect = match spot.ppd {
            Some(_) => {
                let settings = CalibrationSettings {
                    mode: ScaleMode::FlatSpot,
                    pings: Some(pings),
                    ..products.settings.calibration.clone()
                };
                let made = products.calibrated(survey, &returns, &settings, progress)?;
                effect(survey, products, &made, progress)?
            }
            None => None,
        };
        Ok(Self { spot, objections, points, effect })
    }
}

/// Computes the effect of a calibration from the points that result from it.
fn effect(
    survey: &Survey,
    products: &Products,
    calibration: &Calibration,
    progress: &Progress,
) -> Result<Option<ScaleEffect>, Cancelled> {
    let (before, classes) = (&products.cloud, &products.classes);
    let counted = products.counted_returns();
    let settings = &products.settings.cloud;
    let traits = PickTraits::new(survey, &products.navigation, &counted);
    let counted = (&*counted, &traits);
    let after = products.placed(survey, counted, calibration, settings, progress)?;
    let change = DepthChange::between(before, classes, &after);
    // The same first returns give the same number of points, each of which keeps its class.
    let is_alike = after.points.len() == before.points.len();
    let of = |cloud| cloud::residuals(survey, cloud, &products.correction, classes);
    let then = is_alike.then(|| of(&after)).flatten();
    let residuals = of(before).zip(then).map(|(now, then)| [now, then]);
    Ok(change.map(|change| ScaleEffect { change, residuals }))
}
