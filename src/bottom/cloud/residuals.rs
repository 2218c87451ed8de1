//! Computes statistics of a cloud: differences of side-scan depths from recorded depths, the change
//! of its depths when it is built again, and the ends of the scales by which its points are
//! coloured.

use super::{CloudPoint, Correction, PointClass, PointCloud, PointSource, Reduction};
use bathyscope_log::support::statistics::{colour_ends, median, quantile, wider};
use bathyscope_log::survey::Survey;
use serde::Serialize;

/// Statistics of differences. Unless stated otherwise they are of elevations, measured minus
/// reference, so that above 0 is shallower.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Residuals {
    /// Number of differences.
    pub n: usize,
    /// Mean, metres.
    pub mean_m: f64,
    /// Median, metres.
    pub median_m: f64,
    /// Standard deviation (n - 1), metres.
    pub sd_m: f64,
    /// Root mean square, metres.
    pub rms_m: f64,
    /// Mean of the absolute values, metres.
    pub mae_m: f64,
    /// 95th percentile of the absolute values, metres.
    pub p95_m: f64,
}

/// Returns the statistics of the elevation of side-scan points minus that of the recorded depth at
/// the same ping (positive is shallower), over the kept points where the recorder had the bottom;
/// `None` without any. Recorded depths are corrected as the cloud's were.
///
/// The two elevations are those of different places where the bottom point lies across-track: on a
/// slope the difference is real.
pub fn residuals(
    survey: &Survey,
    cloud: &PointCloud,
    correction: &Correction,
    classes: &[PointClass],
) -> Option<Residuals> {
    Residuals::of(&mut same_ping_differences(survey, cloud, correction, classes))
}

/// Returns the differences behind [`residuals`], metres: the differences of several logs are joined
/// before their statistics are computed.
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
    /// Returns the statistics of differences in metres, which are overwritten; `None` when there
    /// are none.
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

/// Change of the side-scan depths that count for the map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DepthChange {
    /// Number of depths that were compared.
    pub count: usize,
    /// Median change, metres; above 0 depths become greater.
    pub median_m: f64,
    /// Largest change, metres, with its sign.
    pub largest_m: f64,
}

impl DepthChange {
    /// Compares the points that `classes` keeps of a cloud with those of the same first returns in
    /// another cloud; `None` where none is in both.
    pub fn between(
        before: &PointCloud,
        classes: &[PointClass],
        after: &PointCloud,
    ) -> Option<Self> {
        let mut changes_m = Vec::new();
        for source in [PointSource::Port, PointSource::Starboard] {
            let start = before.points.start(source);
            let kept = before.points.of(source).iter().zip(classes.get(start..)?);
            let kept = kept.filter(|(_, class)| class.is_kept());
            let mut others = after.points.of(source).iter().peekable();
            for (point, _) in kept {
                while others.next_if(|other| other.ping < point.ping).is_some() {}
                let same = |other: &&CloudPoint| other.ping == point.ping;
                if let Some(other) = others.peek().copied().filter(same) {
                    changes_m.push(point.z_m - other.z_m);
                }
            }
        }
        let further = |a: f64, b: f64| if b.abs() > a.abs() { b } else { a };
        let largest_m = changes_m.iter().copied().reduce(further)?;
        Some(Self { count: changes_m.len(), median_m: median(&mut changes_m), largest_m })
    }
}

/// Ends of the colour scales for values of a point other than its depth: the 2nd and the 98th
/// percentile of the kept points. `None` where no point has such a value.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PointScales {
    /// Level of the echo of first returns, 0 to 255.
    pub level: Option<[f32; 2]>,
    /// Slant range, metres.
    pub range_m: Option<[f32; 2]>,
}

impl PointScales {
    /// Finds the scales of the kept points of a log; `classes` holds the class of each point.
    pub fn of(
        survey: &Survey,
        cloud: &PointCloud,
        classes: &[PointClass],
        reduction: &Reduction<'_>,
    ) -> Self {
        let points = cloud.kept(classes).map(|(_, point)| point);
        let side_scan = points.clone().filter(|point| point.source.is_side_scan());
        Self {
            level: colour_ends(side_scan.map(|point| f32::from(point.level))),
            range_m: colour_ends(points.map(|point| reduction.point_range_m(survey, point) as f32)),
        }
    }

    /// Returns scales that cover both these and `other`.
    #[must_use]
    pub fn with(self, other: Self) -> Self {
        Self { level: wider(self.level, other.level), range_m: wider(self.range_m, other.range_m) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cloud::BySource;
    use std::sync::Arc;

    fn point(source: PointSource, ping: u32, z_m: f64) -> CloudPoint {
        CloudPoint {
            confidence: 1.0,
            sample: 100.0,
            ..CloudPoint::new(source, ping, [0.0, 0.0, z_m])
        }
    }

    fn cloud(port: &[(u32, f64)], starboard: &[(u32, f64)]) -> PointCloud {
        let points = BySource::from_parts(|source| {
            let of = |all: &[(u32, f64)]| {
                let points = all.iter().map(|&(ping, z_m)| point(source, ping, z_m));
                Arc::new(points.collect::<Vec<_>>())
            };
            match source {
                PointSource::DownScan | PointSource::Swath => Arc::default(),
                PointSource::Port => of(port),
                PointSource::Starboard => of(starboard),
            }
        });
        PointCloud { points, zero_heading: 0 }
    }

    #[test]
    fn the_change_is_that_of_kept_points_of_the_same_pings() {
        let before = cloud(&[(0, -2.0), (1, -2.0), (3, -2.0)], &[(0, -3.0), (2, -9.0)]);
        let after = cloud(&[(0, -2.1), (2, -8.0), (3, -2.2)], &[(0, -2.5), (2, -1.0)]);
        let mut classes = vec![PointClass::Bottom; 5];
        classes[4] = PointClass::LowNoise;
        let change = DepthChange::between(&before, &classes, &after).expect("depths");
        // Ping 1 to port has none afterwards, ping 2 to starboard does not count.
        assert_eq!(change.count, 3);
        assert!((change.median_m - 0.1).abs() < 1e-12, "{change:?}");
        assert!((change.largest_m + 0.5).abs() < 1e-12, "{change:?}");
        let none = cloud(&[], &[]);
        assert_eq!(DepthChange::between(&before, &classes, &none), None);
    }
}
