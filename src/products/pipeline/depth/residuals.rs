//! Compares side-scan points, and those of a swath, with the soundings of the same survey.

use super::surface::CloudPlane;
use crate::pipeline::{ProcessedLog, Products};
use bathyscope_bottom::bathymetry::compare::{Comparison, Match, Matching, match_points};
use bathyscope_bottom::cloud::{CloudPoint, PointSource};
use bathyscope_log::support::geo::MapPlane;
use bathyscope_log::support::progress::{Cancelled, Progress};
use bathyscope_log::survey::Survey;
use serde::Serialize;

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
    let is_sounding = |point: &CloudPoint| point.source == PointSource::DownScan;
    let (reference, _) = points(logs, map, is_sounding, |_, _| ());
    let (measured, kinds) = points(logs, map, |point| !is_sounding(point), kind);
    let max_gap_m = first.products.settings.surface.max_gap_m;
    let ways = [Matching::Surface { max_gap_m }, Matching::Nearest { radius_m: RADIUS_M }];
    let level_m = first.products.correction.middle_level_m();
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
        for (place, point) in CloudPlane::shared(log, map).points(&counts) {
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

/// Returns the kept points of some sources, in the cloud's order.
pub(super) fn kept_of<'a>(products: &'a Products, sources: &[PointSource]) -> Vec<&'a CloudPoint> {
    let chosen = || (products.kept_points()).filter(|point| sources.contains(&point.source));
    let mut points = Vec::with_capacity(chosen().count());
    points.extend(chosen());
    points
}
