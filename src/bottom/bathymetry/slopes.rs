//! How far the depth between lines departs from the slopes on them.
//!
//! Between a level floor and a bank the triangles are straight, and the ground is not: it follows
//! the slope of one line, and then that of the other. Where the slopes around the corners of a
//! triangle, gone on to a place, all lead to other depths than the triangle, its error is about
//! half of the least of these differences: on the bends of `reach.py` the two correlate by 0.8 at 4
//! to 8 m from the nearest depth.

use super::super::{Node, TinSampler};
use std::collections::HashMap;

/// Standard deviation of the depth as a share of the least difference.
const ERROR_SHARE: f64 = 0.5;
/// Nodes around a square that tell a slope, at least.
const FEWEST_NODES: f64 = 8.0;
/// They lie apart across their line by this share of the side of a square, as a standard deviation:
/// nodes along a line tell nothing of the slope across it.
const LEAST_ACROSS: f64 = 1.0 / 3.0;

/// Slopes of the ground around nodes: metres of depth a metre to the east, and to the north.
pub(super) struct NodeSlopes {
    square_m: f64,
    slopes: HashMap<[i64; 2], [f64; 2]>,
}

/// Sums over the nodes of a square, of places relative to its corner.
#[derive(Clone, Copy, Default)]
struct PlaneSums {
    count: f64,
    /// East, north, depth.
    first: [f64; 3],
    /// East with east, east with north, north with north, depth with east, depth with north.
    second: [f64; 5],
}

impl PlaneSums {
    fn add(&mut self, [x, y]: [f64; 2], depth_m: f64) {
        self.count += 1.0;
        let first = [x, y, depth_m];
        let second = [x * x, x * y, y * y, depth_m * x, depth_m * y];
        self.first = [0, 1, 2].map(|index| self.first[index] + first[index]);
        self.second = [0, 1, 2, 3, 4].map(|index| self.second[index] + second[index]);
    }

    /// The same relative to a corner that lies so far to the south-west, added to others.
    fn add_moved(&mut self, other: &Self, [dx, dy]: [f64; 2]) {
        let Self { count: n, first: [x, y, z], second: [xx, xy, yy, zx, zy] } = *other;
        let first = [x + n * dx, y + n * dy, z];
        let second = [
            xx + 2.0 * dx * x + n * dx * dx,
            xy + dx * y + dy * x + n * dx * dy,
            yy + 2.0 * dy * y + n * dy * dy,
            zx + dx * z,
            zy + dy * z,
        ];
        self.count += n;
        self.first = [0, 1, 2].map(|index| self.first[index] + first[index]);
        self.second = [0, 1, 2, 3, 4].map(|index| self.second[index] + second[index]);
    }

    /// The slope of the plane through the nodes; `None` where they are few, or lie on a line.
    fn slope(&self, least_across_m: f64) -> Option<[f64; 2]> {
        if self.count < FEWEST_NODES {
            return None;
        }
        let [x, y, z] = self.first.map(|sum| sum / self.count);
        let [xx, xy, yy, zx, zy] = self.second.map(|sum| sum / self.count);
        let (xx, xy, yy) = (xx - x * x, xy - x * y, yy - y * y);
        let (zx, zy) = (zx - z * x, zy - z * y);
        let half_trace = 0.5 * (xx + yy);
        let determinant = xx * yy - xy * xy;
        let least = half_trace - (half_trace * half_trace - determinant).max(0.0).sqrt();
        (least > least_across_m * least_across_m)
            .then(|| [(zx * yy - zy * xy) / determinant, (zy * xx - zx * xy) / determinant])
    }
}

impl NodeSlopes {
    /// Slopes over three squares by three of a side of `square_m`.
    pub(super) fn of(nodes: &[Node], square_m: f64) -> Self {
        let mut sums: HashMap<[i64; 2], PlaneSums> = HashMap::new();
        for node in nodes {
            let square = square_of(node.place(), square_m);
            let corner = square.map(|index| index as f64 * square_m);
            let place = [node.east_m - corner[0], node.north_m - corner[1]];
            sums.entry(square).or_default().add(place, node.depth_m);
        }
        let around = |[column, row]: [i64; 2]| {
            let mut all = PlaneSums::default();
            for (right, up) in (-1..=1).flat_map(|right| (-1..=1).map(move |up| (right, up))) {
                if let Some(sums) = sums.get(&[column + right, row + up]) {
                    all.add_moved(sums, [right, up].map(|steps| steps as f64 * square_m));
                }
            }
            all.slope(LEAST_ACROSS * square_m)
        };
        let slopes = sums.keys().filter_map(|square| Some((*square, around(*square)?)));
        Self { square_m, slopes: slopes.collect() }
    }

    fn at(&self, place: [f64; 2]) -> Option<[f64; 2]> {
        self.slopes.get(&square_of(place, self.square_m)).copied()
    }

    /// For questions about many places, of which most lie in the triangle of the one before.
    pub(super) fn sampler<'a>(&'a self, triangles: TinSampler<'a>) -> BendSampler<'a> {
        BendSampler { slopes: self, triangles, corners: Vec::with_capacity(3) }
    }
}

fn square_of(place: [f64; 2], square_m: f64) -> [i64; 2] {
    place.map(|metres| (metres / square_m).floor() as i64)
}

/// Keeps the corners that it looked up last.
pub(super) struct BendSampler<'a> {
    slopes: &'a NodeSlopes,
    triangles: TinSampler<'a>,
    /// Place and slope of each corner.
    corners: Vec<([f64; 2], Option<[f64; 2]>)>,
}

impl BendSampler<'_> {
    /// Standard deviation of the depth of a triangle at a place by the slopes around its corners,
    /// metres; 0 where none is known, or one agrees.
    pub(super) fn sigma_m(&mut self, [east_m, north_m]: [f64; 2]) -> f64 {
        let Some(nodes) = self.triangles.nodes_at([east_m, north_m]) else {
            return 0.0;
        };
        let straight_m: f64 = nodes.clone().map(|(node, weight)| weight * node.depth_m).sum();
        let are_same = nodes
            .clone()
            .map(|(node, _)| node.place())
            .eq(self.corners.iter().map(|(place, _)| *place));
        if !are_same {
            let corner = |(node, _): (Node, f64)| (node.place(), self.slopes.at(node.place()));
            self.corners = nodes.clone().map(corner).collect();
        }
        let differences_m = nodes.zip(&self.corners).filter_map(|((node, _), (place, slope))| {
            let [east, north] = (*slope)?;
            let gone_on_m =
                node.depth_m + east * (east_m - place[0]) + north * (north_m - place[1]);
            Some((gone_on_m - straight_m).abs())
        });
        ERROR_SHARE * differences_m.reduce(f64::min).unwrap_or(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::{Between, Tin};
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
                    nodes.push(Node { east_m, north_m, depth_m: depth_m(east_m), spread_m: 0.0 });
                }
            }
        }
        nodes
    }

    fn sigma_m(nodes: Vec<Node>, place: [f64; 2]) -> f64 {
        let slopes = NodeSlopes::of(&nodes, 1.5);
        let tin = Tin::new(nodes).expect("triangles");
        slopes.sampler(tin.sampler(Between::Linear)).sigma_m(place)
    }

    #[test]
    fn a_bend_between_lines_is_uncertain_by_half_of_what_it_misses_and_a_plane_is_not() {
        for bend_m in [6.0, 8.0] {
            // The triangles miss the bend itself by the most: there one of the slopes is right.
            let [west_m, east_m] = [3.0, 12.0];
            let fall_m = 0.6 * (east_m - bend_m);
            let missed_m = fall_m * (bend_m - west_m) / (east_m - west_m);
            let found_m = sigma_m(strips(bend_m), [bend_m, 15.0]);
            assert!((found_m / (0.5 * missed_m) - 1.0).abs() < 0.1, "{found_m} {missed_m}");
        }
        let plane = sigma_m(strips(-100.0), [7.0, 15.0]);
        assert!(plane < 1e-6, "{plane}");
    }

    #[test]
    fn nodes_on_a_line_tell_no_slope_across_it() {
        let on_lines =
            |node: &Node| [0.0, 12.0].iter().any(|line| (node.east_m - line).abs() < 0.2);
        let nodes: Vec<Node> = strips(6.0).into_iter().filter(on_lines).collect();
        assert_eq!(sigma_m(nodes, [6.0, 15.0]), 0.0);
    }
}
