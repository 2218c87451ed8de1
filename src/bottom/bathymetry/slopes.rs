//! Computes the depth between lines from the slopes on the lines.
//!
//! The triangles between two lines are straight, but the ground leaves each line by the slope
//! there. The first returns of both sides determine this slope across the line, and soundings the
//! slope along it. A cubic patch over each triangle (Bezier's, with the slopes at the corners and
//! quadratic precision: Farin 1986, "Triangular Bernstein-Bezier patches", section 3.3) has these
//! slopes at its corners. The patch counts where all corners agree which way the ground bends and
//! left-out soundings are then predicted better, and it never goes beyond the nearest of the planes
//! through the corners. On banks of `reach.py` errors 1.5 to 4 m from the track fall from 54, 32
//! and 38 cm to 15, 16 and 15.
//!
//! A bank or a step may end beside the boat. Its slope is then not that of the ground on the other
//! side of the line. Each first return has the share, 0 to 1, by which its slope ends
//! ([`CloudPoint::slope_end`](crate::cloud::CloudPoint::slope_end)): by this share the ground is
//! taken as level across the line, and the triangles up to the bank stay straight. Beside the
//! scarps of `reach.py` the greatest error within 0.75 m of the track falls from 72 and 90 cm to 32
//! and 25.

use super::{Between, Node, Tin, TinSampler};
use bathyscope_log::support::statistics::{ends, median_of};
use std::collections::HashMap;

/// Fewest nodes around a square that determine a slope.
const FEWEST_NODES: f64 = 8.0;
/// Least standard deviation of nodes across their line, as a share of the side of a square: nodes
/// along a line do not determine the slope across it.
const LEAST_ACROSS: f64 = 1.0 / 3.0;
/// Number of squares to each side whose slopes have their median taken: single squares where first
/// returns are missing or false would leave some triangles straight among bent ones.
const SMOOTHED: i64 = 2;
/// Share of nodes with first returns from which the side-scan measured both sides of a line.
const SEEN_SHARE: f64 = 0.5;

/// Factor on the patches. Beside a node a factor of 1 is right; farther away banks end in kinks,
/// which a patch rounds off: on seven beds of two simulators factors of 1 to 2 predicted left-out
/// soundings best, and 1.5 within 2 % of the best. All surveys have the same factor, so that two
/// surveys along the same lines bend alike.
const TIMES: f64 = 1.5;

/// Bends of a surface's triangles between the soundings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bends {
    /// Side of the squares that slopes are taken over, metres.
    pub(super) square_m: f64,
    /// Share of each bend that counts, up to 1, as found from left-out soundings.
    pub(super) share: f64,
    /// Root mean square of the errors of left-out soundings by straight triangles, and by bent
    /// ones, metres.
    pub left_out_m: [f64; 2],
}

impl Bends {
    /// Returns the slopes of the ground around some nodes.
    pub(crate) fn slopes(self, nodes: &[Node]) -> NodeSlopes {
        NodeSlopes { share: self.share, ..NodeSlopes::of(nodes, self.square_m) }
    }

    /// Returns a sentence for reports.
    pub fn sentence(&self) -> String {
        let [straight_cm, bent_cm] = self.left_out_m.map(|error_m| 100.0 * error_m);
        format!(
            "Between the lines the depth follows the slopes on them: left-out soundings are missed by {bent_cm:.1} cm with these and by {straight_cm:.1} cm without."
        )
    }
}

/// Slopes of the ground around nodes: metres of depth a metre to the east, and to the north.
pub(crate) struct NodeSlopes {
    square_m: f64,
    /// Share of each bend that counts.
    share: f64,
    slopes: HashMap<[i64; 2], [f64; 2]>,
}

/// Sums over the nodes of a square, with places relative to its corner.
#[derive(Clone, Copy, Default)]
struct PlaneSums {
    count: f64,
    /// Number of nodes with first returns of the side-scan.
    with_side_scan: f64,
    /// Number of nodes that lie up a slope, and the sum of the shares by which these slopes end.
    up_slope: [f64; 2],
    /// Sums of east, north and depth.
    first: [f64; 3],
    /// Sums of the products of east with east, east with north, north with north, depth with east,
    /// and depth with north.
    second: [f64; 5],
}

impl PlaneSums {
    fn add(&mut self, [x, y]: [f64; 2], node: &Node) {
        let depth_m = node.depth_m;
        self.count += 1.0;
        self.with_side_scan += f64::from(u8::from(node.has_side_scan));
        if !node.slope_end.is_nan() {
            self.up_slope = [self.up_slope[0] + 1.0, self.up_slope[1] + f64::from(node.slope_end)];
        }
        let first = [x, y, depth_m];
        let second = [x * x, x * y, y * y, depth_m * x, depth_m * y];
        self.first = [0, 1, 2].map(|index| self.first[index] + first[index]);
        self.second = [0, 1, 2, 3, 4].map(|index| self.second[index] + second[index]);
    }

    /// Adds the sums of another square, whose corner lies `[dx, dy]` to the north-east of this one.
    fn add_moved(&mut self, other: &Self, [dx, dy]: [f64; 2]) {
        let Self { count: n, with_side_scan, up_slope, first: [x, y, z], second } = *other;
        let [xx, xy, yy, zx, zy] = second;
        let first = [x + n * dx, y + n * dy, z];
        let second = [
            xx + 2.0 * dx * x + n * dx * dx,
            xy + dx * y + dy * x + n * dx * dy,
            yy + 2.0 * dy * y + n * dy * dy,
            zx + dx * z,
            zy + dy * z,
        ];
        self.count += n;
        self.with_side_scan += with_side_scan;
        self.up_slope = [0, 1].map(|index| self.up_slope[index] + up_slope[index]);
        self.first = [0, 1, 2].map(|index| self.first[index] + first[index]);
        self.second = [0, 1, 2, 3, 4].map(|index| self.second[index] + second[index]);
    }

    /// Returns the covariances of east, north and depth, in the order of the sums.
    fn moments(&self) -> [f64; 5] {
        let [x, y, z] = self.first.map(|sum| sum / self.count);
        let [xx, xy, yy, zx, zy] = self.second.map(|sum| sum / self.count);
        [xx - x * x, xy - x * y, yy - y * y, zx - z * x, zy - z * y]
    }

    /// Returns the slope of the plane through the nodes; `None` where they are few, or lie on a
    /// line.
    fn plane(&self, least_across_m: f64) -> Option<[f64; 2]> {
        let [xx, xy, yy, zx, zy] = self.moments();
        let half_trace = 0.5 * (xx + yy);
        let determinant = xx * yy - xy * xy;
        let across_m2 = half_trace - (half_trace * half_trace - determinant).max(0.0).sqrt();
        (self.count >= FEWEST_NODES && across_m2 > least_across_m * least_across_m)
            .then(|| [(zx * yy - zy * xy) / determinant, (zy * xx - zx * xy) / determinant])
    }

    /// Returns the mean share by which the slopes of first returns end before the nadir.
    fn slope_end(&self) -> f64 {
        let [count, ends] = self.up_slope;
        ends / count.max(1.0)
    }

    /// Returns the slope along the line that the nodes lie on, where the side-scan shows on both
    /// sides that the ground is level across the line: the first returns come from straight below.
    /// Otherwise `None`.
    fn level_across(&self, least_along_m: f64) -> Option<[f64; 2]> {
        let [xx, xy, yy, zx, zy] = self.moments();
        let half_trace = 0.5 * (xx + yy);
        let along_m2 = half_trace + (0.25 * (xx - yy).powi(2) + xy * xy).sqrt();
        let (sin, cos) = (0.5 * (2.0 * xy).atan2(xx - yy)).sin_cos();
        let slope = (zx * cos + zy * sin) / along_m2;
        let is_seen = self.with_side_scan >= SEEN_SHARE * self.count;
        (self.count >= FEWEST_NODES && is_seen && along_m2 > least_along_m * least_along_m)
            .then_some([slope * cos, slope * sin])
    }
}

impl NodeSlopes {
    /// Computes slopes over three by three squares with a side of `square_m`.
    pub(super) fn of(nodes: &[Node], square_m: f64) -> Self {
        let mut sums: HashMap<[i64; 2], PlaneSums> = HashMap::new();
        for node in nodes {
            let square = node.place().map(|metres| (metres / square_m).floor() as i64);
            let corner = square.map(|index| index as f64 * square_m);
            let place = [node.east_m - corner[0], node.north_m - corner[1]];
            sums.entry(square).or_default().add(place, node);
        }
        let around = |[column, row]: [i64; 2], reach: i64| {
            let mut all = PlaneSums::default();
            for (right, up) in
                (-reach..=reach).flat_map(|right| (-reach..=reach).map(move |up| (right, up)))
            {
                if let Some(sums) = sums.get(&[column + right, row + up]) {
                    all.add_moved(sums, [right, up].map(|steps| steps as f64 * square_m));
                }
            }
            all
        };
        let least_across_m = LEAST_ACROSS * square_m;
        let slope = |square: [i64; 2]| {
            let near = around(square, 1);
            let level = near.level_across(least_across_m);
            // A slope that ends beside the boat is not that of the ground on its other side.
            let under_boat = |nodes: PlaneSums| {
                let plane = nodes.plane(least_across_m)?;
                let level = level.unwrap_or(plane);
                let end = nodes.slope_end();
                Some([0, 1].map(|axis| plane[axis] + end * (level[axis] - plane[axis])))
            };
            under_boat(near).or_else(|| under_boat(around(square, 2))).or(level)
        };
        let found = sums.keys().filter_map(|square| Some((*square, slope(*square)?)));
        let found: HashMap<[i64; 2], [f64; 2]> = found.collect();
        let usual = |[column, row]: [i64; 2]| {
            let around = (-SMOOTHED..=SMOOTHED)
                .flat_map(|right| (-SMOOTHED..=SMOOTHED).map(move |up| [column + right, row + up]));
            let near: Vec<[f64; 2]> =
                around.filter_map(|square| found.get(&square).copied()).collect();
            [0, 1].map(|axis| median_of(near.iter().map(|slope| slope[axis])))
        };
        let slopes = found.keys().map(|square| (*square, usual(*square))).collect();
        Self { square_m, share: 1.0, slopes }
    }

    /// Returns the slope at a place, interpolated between the middles of squares; `None` where no
    /// square around it has a slope.
    fn at(&self, place: [f64; 2]) -> Option<[f64; 2]> {
        let [x, y] = place.map(|metres| metres / self.square_m - 0.5);
        let first = [x.floor(), y.floor()];
        let (mut sum, mut weights) = ([0.0; 2], 0.0);
        for step in [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]] {
            let corner = [first[0] + step[0], first[1] + step[1]];
            if let Some([east, north]) = self.slopes.get(&corner.map(|index| index as i64)) {
                let weight = (1.0 - (x - corner[0]).abs()) * (1.0 - (y - corner[1]).abs());
                sum = [sum[0] + weight * east, sum[1] + weight * north];
                weights += weight;
            }
        }
        (weights > 0.0).then(|| sum.map(|sum| sum / weights))
    }

    /// Returns a sampler for many places, of which most lie in the triangle of the place before.
    pub(super) fn sampler<'a>(&'a self, triangles: TinSampler<'a>) -> BendSampler<'a> {
        BendSampler { slopes: self, triangles, corners: Vec::with_capacity(3) }
    }
}

/// Sampler that keeps the corners of the last triangle and their slopes.
pub(crate) struct BendSampler<'a> {
    slopes: &'a NodeSlopes,
    triangles: TinSampler<'a>,
    corners: Vec<(Node, Option<[f64; 2]>)>,
}

/// Bend of the ground away from a triangle, at a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Bend {
    /// Depth of the triangle, metres.
    pub straight_m: f64,
    /// Depth of the patch less that of the triangle, metres.
    pub patch_m: f64,
    /// Distance of the nearest of the planes through the corners from the triangle, metres; 0 where
    /// the planes are not all on the same side of the triangle.
    pub least_m: f64,
}

impl Bend {
    /// Returns the depth of the ground below the triangle if the whole bend counts, metres.
    pub(super) fn deeper_m(&self) -> f64 {
        (TIMES * self.patch_m).clamp(-self.least_m, self.least_m)
    }
}

impl BendSampler<'_> {
    /// Returns the bend at a place; `None` where there is no triangle. It is zero where no slope is
    /// known, or the planes through the corners lie on both sides of the triangle.
    pub(super) fn at(&mut self, [east_m, north_m]: [f64; 2]) -> Option<Bend> {
        let Self { slopes, triangles, corners } = self;
        let nodes = triangles.nodes_at([east_m, north_m])?;
        let straight_m: f64 = nodes.clone().map(|(node, weight)| weight * node.depth_m).sum();
        let mut weights = [0.0; 3];
        for (weight, (_, of_node)) in weights.iter_mut().zip(nodes.clone()) {
            *weight = of_node;
        }
        let nodes = nodes.take(weights.len()).map(|(node, _)| node);
        if !nodes.clone().eq(corners.iter().map(|(corner, _)| *corner)) {
            corners.clear();
            corners.extend(nodes.map(|node| (node, slopes.at(node.place()))));
        }
        let planes_m = corners.iter().filter_map(|(node, slope)| {
            let [east, north] = (*slope)?;
            let along_m = east * (east_m - node.east_m) + north * (north_m - node.north_m);
            Some(node.depth_m + along_m - straight_m)
        });
        let [low_m, high_m] = ends(planes_m);
        // A slope may end anywhere between the boat and its first return: nothing bends there.
        let end = corners.iter().map(|(corner, _)| corner.slope_end).fold(0.0, f32::max);
        let patch_m = f64::from(1.0 - end) * patch_m(corners, weights);
        let (patch_m, least_m) = match (low_m > 0.0, high_m < 0.0) {
            (true, false) => (patch_m.max(0.0), low_m),
            (false, true) => (patch_m.min(0.0), -high_m),
            _ => (0.0, 0.0),
        };
        Some(Bend { straight_m, patch_m, least_m })
    }
}

/// Sampler of the depth of triangles that may bend.
pub(crate) enum BentSampler<'a> {
    Straight(TinSampler<'a>),
    Bent(BendSampler<'a>),
}

impl<'a> BentSampler<'a> {
    /// Creates a sampler of bent triangles, or of straight ones without slopes.
    pub(crate) fn new(tin: &'a Tin, slopes: Option<&'a NodeSlopes>) -> Self {
        let triangles = tin.sampler(Between::Linear);
        match slopes {
            Some(slopes) => Self::Bent(slopes.sampler(triangles)),
            None => Self::Straight(triangles),
        }
    }

    /// Returns the depth at a place, metres; `None` where there is no triangle.
    pub(crate) fn depth_at(&mut self, place: [f64; 2]) -> Option<f64> {
        match self {
            Self::Straight(triangles) => triangles.depth_at(place),
            Self::Bent(bends) => {
                let bend = bends.at(place)?;
                Some(bend.straight_m + bends.slopes.share * bend.deeper_m())
            }
        }
    }
}

/// Returns the depth of the cubic patch less that of the triangle, metres, at the place where the
/// corners have these weights.
fn patch_m(corners: &[(Node, Option<[f64; 2]>)], weights: [f64; 3]) -> f64 {
    let corners = || corners.iter().zip(weights).enumerate();
    let (mut edges_m, mut middle_m) = (0.0, 0.0);
    for (index, ((node, slope), weight)) in corners() {
        let Some([east, north]) = *slope else {
            continue;
        };
        for (_, ((other, _), far)) in corners().filter(|(other, _)| *other != index) {
            let [dx, dy] = [other.east_m - node.east_m, other.north_m - node.north_m];
            // A third of this is the distance of the control point on this edge from the triangle.
            let deeper_m = east * dx + north * dy - (other.depth_m - node.depth_m);
            edges_m += weight * weight * far * deeper_m;
            middle_m += 0.25 * deeper_m;
        }
    }
    edges_m + 2.0 * weights.into_iter().product::<f64>() * middle_m
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Strips of nodes along the north axis, three metres wide, on ground that is level west of
    /// `bend_m` and falls with a slope of 0.6 east of it.
    fn strips(bend_m: f64) -> Vec<Node> {
        let depth_m = |east_m: f64| 5.0 - 0.6 * (east_m - bend_m).max(0.0);
        let mut nodes = Vec::new();
        for strip_m in [0.0, 12.0] {
            for column in 0..7 {
                for row in 0..60 {
                    // Irregular, so that no four lie on a circle.
                    let jitter_m = 0.01 * f64::from((column * 7 + row * 13) % 11);
                    let east_m = strip_m + 0.5 * f64::from(column) + jitter_m;
                    let north_m = 0.5 * f64::from(row) - jitter_m;
                    nodes.push(Node {
                        east_m,
                        north_m,
                        depth_m: depth_m(east_m),
                        spread_m: 0.0,
                        has_side_scan: false,
                        slope_end: f32::NAN,
                    });
                }
            }
        }
        nodes
    }

    fn bend(nodes: Vec<Node>, place: [f64; 2]) -> Bend {
        let slopes = NodeSlopes::of(&nodes, 1.5);
        let tin = Tin::new(nodes).expect("triangles");
        slopes.sampler(tin.sampler(Between::Linear)).at(place).expect("a triangle")
    }

    #[test]
    fn the_patch_goes_half_way_to_a_bend_and_stays_on_a_plane() {
        for bend_m in [6.0, 8.0] {
            // The triangles miss the bend itself by the most: there one of the slopes is right.
            let [west_m, east_m] = [3.0, 12.0];
            let fall_m = 0.6 * (east_m - bend_m);
            let missed_m = fall_m * (bend_m - west_m) / (east_m - west_m);
            let found = bend(strips(bend_m), [bend_m, 15.0]);
            assert!((found.least_m / missed_m - 1.0).abs() < 0.1, "{found:?} {missed_m}");
            assert!((0.3..0.8).contains(&(found.patch_m / missed_m)), "{found:?} {missed_m}");
        }
        let plane = bend(strips(-100.0), [7.0, 15.0]);
        assert!(plane.least_m < 1e-6 && plane.patch_m.abs() < 1e-6, "{plane:?}");
    }

    #[test]
    fn a_bank_that_ends_beside_the_boat_leaves_the_ground_beyond_the_line_level() {
        // The boat runs along the middle of the western strip; its first returns to the west lie up
        // a bank.
        let deeper_m = |slope_end: f32| {
            let mut nodes = strips(-100.0);
            for node in nodes.iter_mut().filter(|node| node.east_m < 6.0) {
                let up_bank_m = (1.6 - node.east_m).max(0.0);
                node.depth_m = 10.0 - up_bank_m;
                node.has_side_scan = true;
                node.slope_end = if up_bank_m > 0.0 { slope_end } else { f32::NAN };
            }
            for node in nodes.iter_mut().filter(|node| node.east_m > 6.0) {
                node.depth_m = 10.5;
            }
            let bend = bend(nodes, [4.0, 15.0]);
            bend.straight_m + bend.deeper_m() - 10.0
        };
        let [goes_on_m, ends_m] = [0.0, 1.0].map(deeper_m);
        assert!(goes_on_m > 0.2, "the bank goes on: {goes_on_m}");
        assert!(ends_m.abs() < 0.1, "the bank ends: {ends_m}");
    }

    #[test]
    fn nodes_on_a_line_tell_no_slope_across_it() {
        let on_lines =
            |node: &Node| [0.0, 12.0].iter().any(|line| (node.east_m - line).abs() < 0.2);
        let nodes: Vec<Node> = strips(6.0).into_iter().filter(on_lines).collect();
        let found = bend(nodes, [6.0, 15.0]);
        assert_eq!((found.patch_m, found.least_m), (0.0, 0.0));
    }
}
