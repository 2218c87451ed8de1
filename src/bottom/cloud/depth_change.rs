//! Change of the depths of a cloud when it is built again, for example by another scale.

use super::{CloudPoint, PointClass, PointCloud, PointSource};
use bathyscope_log::support::statistics::median;

/// Change of the side-scan depths that count for the map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DepthChange {
    /// Depths that were compared.
    pub count: usize,
    /// Median change, metres; above 0 depths become greater.
    pub median_m: f64,
    /// The largest change, metres, with its sign.
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
