//! Logs of one survey compared with each other by their points.

use crate::pipeline::ProcessedLog;
use bathyscope_bottom::bathymetry::compare::{Comparison, Matching, ReferencePoints};
use bathyscope_bottom::cloud::CloudPoint;
use bathyscope_log::support::progress::{Cancelled, Progress};

/// Compares the points of some logs with the triangulated points of others, all in one plane: one
/// log with the rest, a boat with another, a day with the next. Points count that the depth map
/// takes, and `surface.max_gap_m` of the first measured log limits the size of a triangle.
///
/// # Errors
/// When the work was cancelled.
pub(crate) fn compare_logs(
    measured: &[&ProcessedLog],
    reference: &[&ProcessedLog],
    progress: &Progress,
) -> Result<Comparison, Cancelled> {
    let settings = measured.first().map(|log| &log.products.settings.surface);
    let max_gap_m = settings.map_or(0.0, |surface| surface.max_gap_m);
    let matching = Matching::Surface { max_gap_m };
    let reference: Vec<[f64; 3]> = reference.iter().flat_map(|log| places(log)).collect();
    let reference = ReferencePoints::new(reference.iter().copied(), matching);
    let places: Vec<[f64; 3]> = measured.iter().flat_map(|log| places(log)).collect();
    let matches = reference.matches(&places, |place| *place, progress)?;
    let level_m = measured.first().map_or(0.0, |log| log.products.correction.middle_level_m());
    Ok(Comparison::new(places.len(), &matches, level_m))
}

/// East, north and elevation of the points that the depth map takes.
fn places(log: &ProcessedLog) -> impl Iterator<Item = [f64; 3]> {
    let surface = &log.products.settings.surface;
    let counted = log.kept_points();
    let counted = counted.filter(|point| surface.weight(point) > 0.0);
    let places = counted.map(CloudPoint::place);
    places.filter(|place| place.iter().all(|value| value.is_finite()))
}
