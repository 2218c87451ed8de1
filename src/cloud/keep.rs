//! The outlier filter applied to a cloud.

use super::{OutlierSettings, PointCloud, PointSource, outliers};
use crate::progress::{Cancelled, Progress};

/// Radius outlier removal over the side-scan points of the cloud as the published code does; soundings are kept unless
/// [`super::CloudPoint::sound`] says no.
/// One flag per point.
pub fn keep_points(
    cloud: &PointCloud,
    settings: &OutlierSettings,
    progress: &Progress,
) -> Result<Vec<bool>, Cancelled> {
    let beside: Vec<usize> = (0..cloud.points.len())
        .filter(|&index| cloud.points[index].source != PointSource::DownScan)
        .collect();
    let places: Vec<[f64; 3]> = beside
        .iter()
        .map(|&index| &cloud.points[index])
        .map(|point| [point.east_m, point.north_m, point.z_m])
        .collect();
    let flags = outliers::keep(&places, settings.radius_m, settings.min_neighbors, progress)?;
    let mut kept: Vec<bool> = cloud.points.iter().map(|point| point.sound).collect();
    for (index, flag) in beside.into_iter().zip(flags) {
        kept[index] = flag;
    }
    Ok(kept)
}
