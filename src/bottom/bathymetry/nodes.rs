//! Defines depths with a place, merges the soundings of one place into one depth, and sorts places
//! for triangulation.

use bathyscope_log::support::outline::bounds;
use bathyscope_log::support::statistics::{median_of, weighted_median};
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
    /// Share by which the slope that a first return lies on ends before the nadir, 0 to 1
    /// ([`SlopeEnd::share`](crate::cloud::SlopeEnd::share)); NaN for any other depth.
    pub slope_end: f32,
}

impl DepthPoint {
    /// Returns east and north, metres.
    pub fn place(&self) -> [f64; 2] {
        [self.east_m, self.north_m]
    }

    /// Creates a sounding that counts in full.
    pub fn of_sounding([east_m, north_m]: [f64; 2], depth_m: f64) -> Self {
        Self { east_m, north_m, depth_m, weight: 1.0, is_sounding: true, slope_end: f32::NAN }
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
    /// Largest of the shares by which the slopes of first returns end before the nadir; NaN where
    /// none of them lies up a slope.
    pub slope_end: f32,
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
    let typical_m = median_of(known.filter(|spread| spread.is_finite()));
    fill_spreads(&mut nodes, if typical_m.is_nan() { 0.0 } else { typical_m });
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
    let mut slope_end = f32::NAN;
    for point in points {
        depths.push((point.depth_m, point.weight));
        east_m += point.weight * (point.east_m - first.east_m);
        north_m += point.weight * (point.north_m - first.north_m);
        // `max` of NaN and a share returns the share.
        slope_end = slope_end.max(point.slope_end);
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
        slope_end,
    })
}

fn fill_spreads(nodes: &mut [Node], typical_m: f64) {
    for node in nodes.iter_mut().filter(|node| node.spread_m.is_nan()) {
        node.spread_m = typical_m;
    }
}

/// Bits of a coordinate on the curve: the curve has 2^16 steps along a side, so that a place on it
/// is a number of 32 bits.
const CURVE_BITS: u32 = 16;
/// Number of the last round; round 0 holds all places that the others leave.
const ROUNDS: u32 = 12;
/// Least distance of a place from a line at which they span a surface, as a share of the
/// coordinates; nearer places are on the line except for rounding.
const LEAST_WIDTH: f64 = 1e-9;

/// Sorts nodes for their insertion, with three nodes that form a triangle first, so that they can
/// be triangulated quickly, whatever their arrangement. Returns `false` where the nodes span no
/// surface: fewer than three places, or all on one line.
///
/// spade's bulk loading takes quadratic time where many places lie on one line, as the soundings of
/// a straight run do: over a minute for 40 000. Inserted one by one in random order, each place
/// changes few triangles, however the places lie. Along a space-filling curve the next place is
/// near the last one, so that its triangle is found in a few steps. Rounds combine both: each round
/// is twice as large as the one before, and holds places drawn at random and sorted along the curve
/// (Amenta, Choi and Rote, Incremental constructions con BRIO, SoCG 2003).
pub(super) fn sort_for_insertion(nodes: &mut [Node]) -> bool {
    if put_triangle_first(nodes).is_none() {
        return false;
    }
    let [west, south, east, north] = bounds(nodes.iter().map(Node::place));
    // Number of steps of the curve per metre.
    let scale = f64::from((1_u32 << CURVE_BITS) - 1) / (east - west).max(north - south);
    let key = |node: &Node| {
        let steps = [node.east_m - west, node.north_m - south].map(|way| (way * scale) as u32);
        // The hash makes a number of the place that is as good as random, and the same in every
        // run.
        let hash = (node.east_m.to_bits() ^ node.north_m.to_bits().rotate_left(32))
            .wrapping_mul(0x9E37_79B9_7F4A_7C15)
            .rotate_left(29)
            .wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let round = ROUNDS - hash.leading_zeros().min(ROUNDS);
        (round, along_curve(steps))
    };
    // A sort by `key` alone computes two keys for each comparison, which takes most of its time.
    let mut keyed: Vec<_> = nodes[3..].par_iter().map(|node| (key(node), *node)).collect();
    keyed.par_sort_unstable_by_key(|(order, _)| *order);
    nodes[3..].iter_mut().zip(keyed).for_each(|(node, (_, sorted))| *node = sorted);
    true
}

/// Moves three nodes that form a triangle to the front: two that are about the farthest apart, and
/// the one farthest from their line. Returns `None` where the nodes span no surface.
fn put_triangle_first(nodes: &mut [Node]) -> Option<()> {
    let farthest = |nodes: &[Node], off: &dyn Fn(&Node) -> f64| {
        let offs = nodes.iter().map(off).enumerate();
        offs.max_by(|a, b| a.1.total_cmp(&b.1))
    };
    let any = *nodes.first()?;
    let from = |start: Node| {
        move |node: &Node| (node.east_m - start.east_m).hypot(node.north_m - start.north_m)
    };
    let (index, _) = farthest(nodes, &from(any))?;
    nodes.swap(0, index);
    let (index, length_m) = farthest(nodes, &from(nodes[0])).filter(|(index, _)| *index > 0)?;
    nodes.swap(1, index);
    let [start, end] = [nodes[0], nodes[1]];
    let along = [(end.east_m - start.east_m) / length_m, (end.north_m - start.north_m) / length_m];
    let off_line = move |node: &Node| {
        let way = [node.east_m - start.east_m, node.north_m - start.north_m];
        (along[0] * way[1] - along[1] * way[0]).abs()
    };
    let (index, width_m) = farthest(&nodes[2..], &off_line)?;
    nodes.swap(2, index + 2);
    let coordinates = [start.east_m, start.north_m, end.east_m, end.north_m];
    let size_m = coordinates.map(f64::abs).into_iter().fold(0.0, f64::max);
    (width_m > LEAST_WIDTH * size_m).then_some(())
}

/// Returns the place of a cell along Hilbert's curve, cells counted from the south-west corner.
fn along_curve([mut x, mut y]: [u32; 2]) -> u32 {
    let mut way = 0;
    for bit in (0..CURVE_BITS).rev() {
        let [right, up] = [x, y].map(|cells| cells >> bit & 1);
        way = way << 2 | ((3 * right) ^ up);
        if up == 0 {
            if right == 1 {
                (x, y) = (!x, !y);
            }
            (x, y) = (y, x);
        }
    }
    way
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
    fn the_curve_goes_through_every_cell_in_single_steps() {
        const SIDE: u32 = 64;
        let cells = (0..SIDE * SIDE).map(|cell| [cell % SIDE, cell / SIDE]);
        let mut sorted: Vec<[u32; 2]> = cells.collect();
        sorted.sort_by_key(|cell| along_curve(*cell));
        for pair in sorted.windows(2) {
            let step = pair[0][0].abs_diff(pair[1][0]) + pair[0][1].abs_diff(pair[1][1]);
            assert_eq!(step, 1, "{pair:?}");
        }
    }

    fn nodes(places: impl Iterator<Item = [f64; 2]>) -> Vec<Node> {
        let node = |[east_m, north_m]: [f64; 2]| Node {
            slope_end: f32::NAN,
            east_m,
            north_m,
            depth_m: 1.0,
            spread_m: 0.0,
            has_side_scan: false,
        };
        places.map(node).collect()
    }

    #[test]
    fn what_lies_on_one_line_but_for_rounding_is_no_surface() {
        let line = |slope: f64, off_m: f64| {
            let places = (0..1000).map(|i| [500_000.1 + 0.1 * f64::from(i), slope * f64::from(i)]);
            let mut nodes = nodes(places);
            nodes[700].north_m += off_m;
            sort_for_insertion(&mut nodes)
        };
        assert!(!line(0.0, 0.0) && !line(0.03, 0.0) && !line(1.0 / 3.0, 1e-6));
        assert!(line(0.03, 0.01));
        assert!(!sort_for_insertion(&mut nodes([[1.0, 2.0]; 9].into_iter())));
        assert!(!sort_for_insertion(&mut nodes([[1.0, 2.0], [3.0, 4.0]].into_iter())));
        assert!(!sort_for_insertion(&mut []));
    }
}
