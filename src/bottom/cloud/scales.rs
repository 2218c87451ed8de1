//! Ends of the scales by which the points of a cloud are coloured.

use super::{PointClass, PointCloud, Reduction};
use bathyscope_log::support::statistics::{colour_ends, wider};
use bathyscope_log::survey::Survey;

/// Ends of the colour scales of what is known of a point besides its depth: the 2nd and the 98th
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

    /// Returns scales that cover both.
    #[must_use]
    pub fn with(self, other: Self) -> Self {
        Self { level: wider(self.level, other.level), range_m: wider(self.range_m, other.range_m) }
    }
}
