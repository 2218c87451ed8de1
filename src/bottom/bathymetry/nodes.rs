//! Defines depths with a place, and merges the soundings of one place into one depth.

use bathyscope_log::support::statistics::{self, median, weighted_median};
use bathyscope_log::survey::{Navigation, Survey};
use rayon::prelude::*;

/// Depth at a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DepthPoint {
    /// Metres east of the survey's origin.
    pub east_m: f64,
    /// Metres north of the survey's origin.
    pub north_m: f64,
    /// Metres below the transducer.
    pub depth_m: f64,
    /// Weight where several depths meet; 1 for a recorder's own sounding, 0 to ignore the depth.
    pub weight: f64,
    /// True if the depth is one of the recorder, under the boat or across the track, or of a
    /// reference; false for a first return of the side-scan.
    pub is_sounding: bool,
}

impl DepthPoint {
    /// Returns east and north, metres.
    pub fn place(&self) -> [f64; 2] {
        [self.east_m, self.north_m]
    }

    /// Creates a sounding that counts in full.
    pub(crate) fn of_sounding([east_m, north_m]: [f64; 2], depth_m: f64) -> Self {
        Self { east_m, north_m, depth_m, weight: 1.0, is_sounding: true }
    }
}

/// Returns every sounding of the survey that has both a place and a depth, in time order.
pub fn depth_points(survey: &Survey, navigation: &Navigation) -> Vec<DepthPoint> {
    let placed = survey.soundings.iter().zip(navigation.soundings.iter());
    placed
        .filter(|(sounding, _)| sounding.is_good())
        .map(|(sounding, place)| {
            DepthPoint::of_sounding(place.place(), f64::from(sounding.depth_m))
        })
        .filter(|point| {
            point.east_m.is_finite() && point.north_m.is_finite() && point.depth_m.is_finite()
        })
        .collect()
}

/// Returns the 2nd and 98th percentile of some depths: the ends of the colour scale. `None` without
/// any finite depth.
pub fn depth_range(depths: impl IntoIterator<Item = f32>) -> Option<[f32; 2]> {
    statistics::colour_ends(depths)
}

/// Merged depth of one place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Node {
    /// Metres east of the survey's origin.
    pub east_m: f64,
    /// Metres north of the survey's origin.
    pub north_m: f64,
    /// Median depth, metres.
    pub depth_m: f64,
    /// Standard deviation (n - 1) of the depths about their median, metres. For fewer than three
    /// depths it is the median of the standard deviations at the other places; 0 when no place has
    /// three.
    pub spread_m: f64,
    /// True if a first return of the side-scan is among the depths.
    pub has_side_scan: bool,
}

impl Node {
    /// Returns east and north, metres.
    pub fn place(&self) -> [f64; 2] {
        [self.east_m, self.north_m]
    }
}

/// Fewest depths that determine a spread.
const LEAST_FOR_SPREAD: usize = 3;

/// Returns one node for all points of a square of `cell_m`: the weighted mean place and the
/// weighted median depth. A cell of 0 merges only exactly repeated places. Points without weight
/// are left out.
///
/// Recorders repeat a fix for most pings, and a triangulation takes one depth a place.
pub(crate) fn merge_repeated(points: &[DepthPoint], cell_m: f64) -> Vec<Node> {
    let mut nodes = merge_cells(points, cell_m);
    let known = nodes.iter().map(|node| node.spread_m);
    let mut known: Vec<f64> = known.filter(|spread| spread.is_finite()).collect();
    let typical_m = if known.is_empty() { 0.0 } else { median(&mut known) };
    fill_spreads(&mut nodes, typical_m);
    nodes
}

/// Merges points as [`merge_repeated`] does, but with `typical_m` as the spread of fewer than three
/// depths: no node then depends on points of other squares.
pub(super) fn merge_repeated_with(points: &[DepthPoint], cell_m: f64, typical_m: f64) -> Vec<Node> {
    let mut nodes = merge_cells(points, cell_m);
    fill_spreads(&mut nodes, typical_m);
    nodes
}

/// Merges the points of each square; the spread is NaN where it is unknown.
fn merge_cells(points: &[DepthPoint], cell_m: f64) -> Vec<Node> {
    let key = |value: f64| {
        if cell_m > 0.0 {
            (value / cell_m).floor() as i64
        } else {
            // Adding zero makes the two zeros one.
            (value + 0.0).to_bits() as i64
        }
    };
    let cell = |index: usize| [points[index].east_m, points[index].north_m].map(key);
    // Indices are sorted, not points with their keys, which would take six times as much memory.
    let mut order: Vec<usize> = (0..points.len()).collect();
    order.retain(|index| points[*index].weight > 0.0);
    order.par_sort_unstable_by_key(|index| (cell(*index), *index));
    let same_cell = |a: &usize, b: &usize| cell(*a) == cell(*b);
    let mut nodes = Vec::with_capacity(order.chunk_by(same_cell).count());
    let mut depths = Vec::new();
    for same in order.chunk_by(same_cell) {
        let same = same.iter().map(|index| points[*index]);
        nodes.extend(merge(same, &mut depths));
    }
    nodes
}

/// Merges points into one node; `None` without points. The spread is NaN where it is unknown.
fn merge(
    mut same: impl ExactSizeIterator<Item = DepthPoint> + Clone,
    depths: &mut Vec<(f64, f64)>,
) -> Option<Node> {
    let count = same.len();
    let points = same.clone();
    let has_side_scan = same.clone().any(|point| !point.is_sounding);
    let first = same.next()?;
    depths.clear();
    let (mut east_m, mut north_m, mut weights) = (0.0, 0.0, 0.0);
    for point in points {
        depths.push((point.depth_m, point.weight));
        east_m += point.weight * (point.east_m - first.east_m);
        north_m += point.weight * (point.north_m - first.north_m);
        weights += point.weight;
    }
    let depth_m = weighted_median(depths);
    let squares: f64 = depths.iter().map(|(d, _)| (d - depth_m).powi(2)).sum();
    Some(Node {
        east_m: first.east_m + east_m / weights,
        north_m: first.north_m + north_m / weights,
        depth_m,
        spread_m: if count < LEAST_FOR_SPREAD {
            f64::NAN
        } else {
            (squares / (count - 1) as f64).sqrt()
        },
        has_side_scan,
    })
}

fn fill_spreads(nodes: &mut [Node], typical_m: f64) {
    for node in nodes.iter_mut().filter(|node| node.spread_m.is_nan()) {
        node.spread_m = typical_m;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bathymetry::testing::point;

    #[test]
    fn repeated_places_give_their_median() {
        let points = [
            point(1.0, 2.0, 9.0),
            point(1.0, 2.0, 3.0),
            point(1.0, 2.0, 4.0),
            point(5.0, 5.0, 1.0),
            point(5.0, 5.0, 2.0),
        ];
        let merged = merge_repeated(&points, 0.0);
        let depths: Vec<f64> = merged.iter().map(|node| node.depth_m).collect();
        assert_eq!(depths, [4.0, 1.5]);
        assert_eq!([merged[1].east_m, merged[1].north_m], [5.0, 5.0]);
        // sqrt((5^2 + 1^2) / 2), and the same for the place that has too few depths.
        assert!((merged[0].spread_m - 13f64.sqrt()).abs() < 1e-12);
        assert_eq!(merged[1].spread_m, merged[0].spread_m);
    }

    #[test]
    fn a_cell_merges_its_neighbours_at_their_mean_place() {
        let points = [point(0.1, 0.1, 1.0), point(0.3, 0.3, 3.0), point(1.1, 0.1, 7.0)];
        let merged = merge_repeated(&points, 1.0);
        assert_eq!(merged.len(), 2);
        assert!((merged[0].east_m - 0.2).abs() < 1e-12);
        assert_eq!(merged[0].depth_m, 2.0);
        assert_eq!(merged[0].spread_m, 0.0);
    }

    #[test]
    fn weights_decide_where_sources_meet() {
        let mut points = [point(0.0, 0.0, 2.0), point(0.4, 0.0, 3.0), point(0.4, 0.0, 4.0)];
        points[0].weight = 3.0;
        let merged = merge_repeated(&points, 1.0);
        assert_eq!(merged[0].depth_m, 2.0);
        assert!((merged[0].east_m - 0.16).abs() < 1e-12);
        points[0].weight = 0.0;
        assert_eq!(merge_repeated(&points, 1.0)[0].depth_m, 3.5);
    }

    #[test]
    fn the_colour_scale_leaves_out_the_outer_two_percent() {
        let depths = (0..=100).map(|i| i as f32).chain([f32::NAN]);
        assert_eq!(depth_range(depths), Some([2.0, 98.0]));
        assert_eq!(depth_range([f32::NAN]), None);
    }
}
