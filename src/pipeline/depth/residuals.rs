//! Side-scan points against the soundings of the same log.

use super::plane::Plane;
use crate::bathymetry::compare::{Comparison, Matching, match_points};
use crate::cloud::{CloudPoint, PointSource};
use crate::pipeline::Products;
use crate::progress::{Cancelled, Progress};
use serde::Serialize;

/// Farthest sounding that a side-scan point is held against by place, metres.
const RADIUS_M: f64 = 1.0;

/// How the depths of one source agree with those of another.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct NamedComparison {
    /// What was measured.
    pub source: &'static str,
    /// What it is held against.
    pub reference: String,
    /// How a point finds its reference, in words.
    pub matching: String,
    /// The statistics.
    #[serde(flatten)]
    pub comparison: Comparison,
}

/// Port, starboard and both against the surface of the soundings at their place, and against the nearest sounding; empty
/// where there is no side-scan point or no sounding.
pub fn comparisons(
    products: &Products,
    plane: &Plane<'_>,
    progress: &Progress,
) -> Result<Vec<NamedComparison>, Cancelled> {
    use PointSource::{DownScan, Port, Starboard};
    let reference = plane.points(products, |point| point.source == DownScan);
    let max_gap_m = products.settings.surface.max_gap_m;
    let ways = [
        (
            Matching::Surface { max_gap_m },
            format!("triangulated surface, gap {max_gap_m} m"),
        ),
        (
            Matching::Nearest { radius_m: RADIUS_M },
            format!("nearest point within {RADIUS_M} m"),
        ),
    ];
    // Where the recorder had lost the bottom, depth rests on these alone: what soundings there are nearby is held against them.
    let is_lost = |point: &CloudPoint| plane.survey.locked_depth_m(point.ping as usize).is_nan();
    let sides: [(&'static str, &[PointSource], bool); 4] = [
        ("side-scan", &[Port, Starboard], false),
        ("port", &[Port], false),
        ("starboard", &[Starboard], false),
        (
            "side-scan where the bottom was lost",
            &[Port, Starboard],
            true,
        ),
    ];
    let mut found = Vec::new();
    for (matching, how) in ways {
        for (source, sources, only_lost) in sides {
            let points = plane.points(products, |point| {
                sources.contains(&point.source) && (!only_lost || is_lost(point))
            });
            let matches = match_points(&points, &reference, matching, progress)?;
            if !matches.is_empty() {
                found.push(NamedComparison {
                    source,
                    reference: "down-scan".to_owned(),
                    matching: how.clone(),
                    comparison: Comparison::new(
                        points.len(),
                        &matches,
                        products.correction.middle_level_m(),
                    ),
                });
            }
        }
    }
    Ok(found)
}

/// Kept points of some sources, in the cloud's order.
pub(super) fn kept_of<'a>(products: &'a Products, sources: &[PointSource]) -> Vec<&'a CloudPoint> {
    let chosen = || {
        let flagged = products.cloud.points.iter().zip(products.kept.iter());
        flagged.filter(|(point, kept)| **kept && sources.contains(&point.source))
    };
    let mut points = Vec::with_capacity(chosen().count());
    points.extend(chosen().map(|(point, _)| point));
    points
}

/// East, north and elevation in the survey's plane, metres.
pub(super) fn place(point: &CloudPoint) -> [f64; 3] {
    [point.east_m, point.north_m, point.z_m]
}
