//! The outlier filter applied to a cloud.

use super::{OutlierSettings, PointCloud, PointSource, outliers};
use crate::progress::{Cancelled, Progress};

/// Radius outlier removal over the side-scan points of the cloud as the published code does; soundings are kept unless
/// [`super::CloudPoint::reliable`] says no. Side-scan points less sure than `min_confidence` are not kept, and nobody's neighbours.
/// One flag per point.
///
/// # Errors
/// When the work was cancelled.
pub fn keep_points(
    cloud: &PointCloud,
    min_confidence: f32,
    settings: &OutlierSettings,
    progress: &Progress,
) -> Result<Vec<bool>, Cancelled> {
    let place = |index: u32| match &cloud.points[index as usize] {
        // Soundings are nobody's neighbours.
        point if point.source == PointSource::DownScan || point.is_unsure(min_confidence) => {
            [f64::NAN; 3]
        }
        point => [point.east_m, point.north_m, point.z_m],
    };
    let (radius_m, min_neighbors) = (settings.radius_m, settings.min_neighbors);
    let count = cloud.points.len();
    let mut kept = outliers::keep_places(count, &place, radius_m, min_neighbors, progress)?;
    for (kept, point) in kept.iter_mut().zip(&cloud.points) {
        if point.source == PointSource::DownScan {
            *kept = point.reliable;
        } else if point.is_unsure(min_confidence) {
            *kept = false;
        }
    }
    Ok(kept)
}
