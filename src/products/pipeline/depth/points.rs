//! The points of a cloud as depths for a surface.

use bathyscope_bottom::bathymetry::{DepthPoint, SurfaceSettings};
use bathyscope_bottom::cloud::{CloudPoint, PointClass, PointCloud};

/// The kept points of a cloud that count for a surface, as weighted depths; `place` gives east,
/// north and elevation in its plane.
pub fn depth_points(
    cloud: &PointCloud,
    classes: &[PointClass],
    settings: &SurfaceSettings,
    place: impl Fn(&CloudPoint) -> [f64; 3],
) -> Vec<DepthPoint> {
    let weighted = || {
        let weighted = cloud.kept(classes).map(|(_, point)| (point, settings.weight(point)));
        weighted.filter(|(_, weight)| *weight > 0.0)
    };
    // Counted first: a vector of a million points that grows takes three times their memory for a
    // moment.
    let mut points = Vec::with_capacity(weighted().count());
    let placed = weighted().map(|(point, weight)| (place(point), weight, point.source));
    points.extend(placed.filter(|(place, ..)| is_finite(place)).map(
        |([east_m, north_m, z_m], weight, source)| DepthPoint {
            east_m,
            north_m,
            depth_m: -z_m,
            weight,
            is_sounding: !source.is_side_scan(),
        },
    ));
    points
}

/// Returns true if a place is known.
pub(super) fn is_finite(place: &[f64; 3]) -> bool {
    place.iter().all(|value| value.is_finite())
}
