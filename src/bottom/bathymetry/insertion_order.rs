//! Sorts places so that they can be triangulated quickly, whatever their arrangement.
//!
//! spade's bulk loading takes quadratic time where many places lie on one line, as the soundings of
//! a straight run do: over a minute for 40 000. Inserted one by one in random order, each place
//! changes few triangles, however the places lie. Along a space-filling curve the next place is
//! near the last one, so that its triangle is found in a few steps. Rounds combine both: each round
//! is twice as large as the one before, and holds places drawn at random and sorted along the curve
//! (Amenta, Choi and Rote, Incremental constructions con BRIO, SoCG 2003).

use super::Node;
use bathyscope_log::support::outline::bounds;
use rayon::prelude::*;

/// Bits of a coordinate on the curve: the curve has 2^16 steps along a side, so that a place on it
/// is a number of 32 bits.
const CURVE_BITS: u32 = 16;
/// Number of the last round; round 0 holds all places that the others leave.
const ROUNDS: u32 = 12;
/// Least distance of a place from a line at which they span a surface, as a share of the
/// coordinates; nearer places are on the line except for rounding.
const LEAST_WIDTH: f64 = 1e-9;

/// Sorts nodes for their insertion, with three nodes that form a triangle first. Returns `false`
/// where the nodes span no surface: fewer than three places, or all on one line.
pub(super) fn sort(nodes: &mut [Node]) -> bool {
    if put_triangle_first(nodes).is_none() {
        return false;
    }
    let (low, scale) = extent(nodes);
    let key = |node: &Node| {
        let steps = [node.east_m - low[0], node.north_m - low[1]].map(|way| (way * scale) as u32);
        // The hash makes a number of the place that is as good as random, and the same in every
        // run.
        let hash = (node.east_m.to_bits() ^ node.north_m.to_bits().rotate_left(32))
            .wrapping_mul(0x9E37_79B9_7F4A_7C15)
            .rotate_left(29)
            .wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let round = ROUNDS - hash.leading_zeros().min(ROUNDS);
        (round, along_curve(steps))
    };
    nodes[3..].par_sort_unstable_by_key(key);
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

/// Returns the south-west corner, and the number of steps of the curve per metre.
fn extent(nodes: &[Node]) -> ([f64; 2], f64) {
    let [west, south, east, north] = bounds(nodes.iter().map(Node::place));
    let side_m = (east - west).max(north - south);
    let steps = f64::from((1_u32 << CURVE_BITS) - 1);
    ([west, south], steps / side_m)
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
            sort(&mut nodes)
        };
        assert!(!line(0.0, 0.0) && !line(0.03, 0.0) && !line(1.0 / 3.0, 1e-6));
        assert!(line(0.03, 0.01));
        assert!(!sort(&mut nodes([[1.0, 2.0]; 9].into_iter())));
        assert!(!sort(&mut nodes([[1.0, 2.0], [3.0, 4.0]].into_iter())));
        assert!(!sort(&mut []));
    }
}
