//! Side-scan points, and those of a swath, against the soundings of the same survey.

use super::plane::CloudPlane;
use crate::bottom::bathymetry::compare::{Comparison, Matching, match_points};
use crate::bottom::cloud::{CloudPoint, PointSource};
use crate::pipeline::{ProcessedLog, Products};
use crate::support::geo::MapPlane;
use crate::support::progress::{Cancelled, Progress};
use crate::survey::Survey;
use serde::Serialize;

/// Farthest sounding that a side-scan point is compared with by place, metres.
const RADIUS_M: f64 = 1.0;

/// How the depths of one source agree with those of another.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct NamedComparison {
    /// What was measured.
    pub source: &'static str,
    /// What it is compared with.
    pub reference: String,
    /// How a point finds its reference, in words.
    pub matching: String,
    /// The statistics.
    #[serde(flatten)]
    pub comparison: Comparison,
}

/// Port, starboard, both and the swath against the surface of the soundings at their place, and against the nearest sounding, of all logs
/// together in the plane of a map; empty where there is no side-scan point or no sounding.
///
/// # Errors
/// When the work was cancelled.
pub(crate) fn comparisons(
    logs: &[ProcessedLog],
    map: &MapPlane,
    progress: &Progress,
) -> Result<Vec<NamedComparison>, Cancelled> {
    use PointSource::{DownScan, Port, Starboard, Swath};
    let Some(first) = logs.first() else {
        return Ok(Vec::new());
    };
    let points = |chosen: &dyn Fn(&Survey, &CloudPoint) -> bool| {
        let of_log = |log: &ProcessedLog| {
            let plane = CloudPlane::new(&log.survey, &log.products, map.clone());
            plane.points(&log.products, |point| chosen(&log.survey, point))
        };
        logs.iter().flat_map(of_log).collect::<Vec<_>>()
    };
    let reference = points(&|_, point| point.source == DownScan);
    let max_gap_m = first.products.settings.surface.max_gap_m;
    let ways = [
        Matching::Surface { max_gap_m },
        Matching::Nearest { radius_m: RADIUS_M },
    ];
    // Where the recorder had lost the bottom, depth comes from these alone: nearby soundings are compared with them.
    let is_lost =
        |survey: &Survey, point: &CloudPoint| survey.locked_depth_m(point.ping as usize).is_nan();
    let sides: [(&'static str, &[PointSource], bool); 5] = [
        ("side-scan", &[Port, Starboard], false),
        ("port", &[Port], false),
        ("starboard", &[Starboard], false),
        (
            "side-scan where the bottom was lost",
            &[Port, Starboard],
            true,
        ),
        ("swath", &[Swath], false),
    ];
    let level_m = first.products.correction.middle_level_m();
    let mut found = Vec::new();
    for matching in ways {
        for (source, sources, only_lost) in sides {
            let points = points(&|survey, point| {
                sources.contains(&point.source) && (!only_lost || is_lost(survey, point))
            });
            let matches = match_points(&points, &reference, matching, progress)?;
            if !matches.is_empty() {
                found.push(NamedComparison {
                    source,
                    reference: "down-scan".to_owned(),
                    matching: matching.in_words(),
                    comparison: Comparison::new(points.len(), &matches, level_m),
                });
            }
        }
    }
    Ok(found)
}

/// Kept points of some sources, in the cloud's order.
pub(super) fn kept_of<'a>(products: &'a Products, sources: &[PointSource]) -> Vec<&'a CloudPoint> {
    let chosen = || (products.kept_points()).filter(|point| sources.contains(&point.source));
    let mut points = Vec::with_capacity(chosen().count());
    points.extend(chosen());
    points
}
