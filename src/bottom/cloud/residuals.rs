//! Statistics of differences, and those of side-scan depths from recorded depths.

use super::{Correction, PointClass, PointCloud};
use bathyscope_log::support::statistics::{median, quantile};
use bathyscope_log::survey::Survey;
use serde::Serialize;

/// Statistics of differences: of elevations, measured minus reference, so that above 0 is
/// shallower; where other things are compared, it is said there.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Residuals {
    /// Number of differences.
    pub n: usize,
    /// Mean.
    pub mean_m: f64,
    /// Median.
    pub median_m: f64,
    /// Standard deviation (n - 1).
    pub sd_m: f64,
    /// Root mean square.
    pub rms_m: f64,
    /// Mean absolute.
    pub mae_m: f64,
    /// 95th percentile of the absolute value.
    pub p95_m: f64,
}

/// Elevation of side-scan points minus that of the recorded depth at the same ping (positive is
/// shallower), over the kept points where the recorder had the bottom; `None` without any. Recorded
/// depths are corrected as the cloud's were.
///
/// The two are those of different places where the bottom point lies across-track: on a slope the
/// difference is real.
pub fn residuals(
    survey: &Survey,
    cloud: &PointCloud,
    correction: &Correction,
    classes: &[PointClass],
) -> Option<Residuals> {
    Residuals::of(&mut same_ping_differences(survey, cloud, correction, classes))
}

/// The differences behind [`residuals`], metres: those of several logs are put together before
/// statistics are made of them.
pub fn same_ping_differences(
    survey: &Survey,
    cloud: &PointCloud,
    correction: &Correction,
    classes: &[PointClass],
) -> Vec<f64> {
    cloud
        .kept(classes)
        .filter(|(_, point)| point.source.is_side_scan())
        .filter_map(|(_, point)| {
            let ping = survey.side_scan.get(point.ping as usize)?;
            let recorded_m = f64::from(ping.good_depth_m());
            (recorded_m > 0.0).then(|| point.z_m + correction.depth_m(ping.time_s, recorded_m))
        })
        .collect()
}

impl Residuals {
    /// Statistics of differences in metres, which are overwritten; `None` when there are none.
    pub fn of(differences: &mut [f64]) -> Option<Self> {
        let n = differences.len();
        if n == 0 {
            return None;
        }
        let mean = |values: &mut dyn Iterator<Item = f64>| values.sum::<f64>() / n as f64;
        let mean_m = mean(&mut differences.iter().copied());
        let mae_m = mean(&mut differences.iter().map(|d| d.abs()));
        let square = mean(&mut differences.iter().map(|d| d * d));
        let about_mean: f64 = differences.iter().map(|d| (d - mean_m).powi(2)).sum();
        let median_m = median(differences);
        for difference in differences.iter_mut() {
            *difference = difference.abs();
        }
        differences.sort_unstable_by(f64::total_cmp);
        Some(Self {
            n,
            mean_m,
            median_m,
            sd_m: (about_mean / (n.max(2) - 1) as f64).sqrt(),
            rms_m: square.sqrt(),
            mae_m,
            p95_m: quantile(differences, 0.95),
        })
    }
}
