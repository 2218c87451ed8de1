//! Distributes the points of a cloud over the nodes of an octree: nodes near the root have few
//! points far apart, and each level below halves the distance.

use std::collections::VecDeque;

/// Bits of a coordinate on the lattice of the root.
const BITS: u32 = 24;
/// Bits of a cell index in a node's grid of 128 by 128 by 128; a node keeps one point of each cell,
/// so that the points of a level are evenly spread.
const GRID_BITS: u32 = 7;
/// Number of cells along a side of a node.
pub(super) const GRID: u32 = 1 << GRID_BITS;
/// Most points of a node that is not split: as many as a flat bed fills of its grid.
const MOST_IN_LEAF: usize = 1 << (2 * GRID_BITS);
/// Deepest level, below which the lattice has no finer cells; points in the same place end here.
const DEEPEST: u32 = BITS - GRID_BITS;

/// A node with its own points.
#[derive(Debug, PartialEq)]
pub(super) struct OctreeNode {
    /// Level, 0 for the root.
    pub level: u32,
    /// Place of the node in its level: east, north and up, counted from 0.
    pub cell: [u32; 3],
    /// Indices of the points, ascending.
    pub points: Vec<usize>,
}

/// Returns the coordinate on the lattice for a share of the root's side, 0 to 1.
pub(super) fn on_lattice(share: f64) -> u32 {
    // The cast limits values beyond either end.
    ((share * f64::from(1 << BITS)) as u32).min((1 << BITS) - 1)
}

/// Returns the nodes over points on the lattice, each level after the level above it. Every point
/// is in one node, and every node has points, except the root without any.
pub(super) fn nodes(places: &[[u32; 3]]) -> Vec<OctreeNode> {
    let mut nodes = Vec::new();
    let mut occupied = vec![0_u64; 1 << (3 * GRID_BITS - 6)];
    let mut waiting = VecDeque::from([OctreeNode {
        level: 0,
        cell: [0; 3],
        points: (0..places.len()).collect(),
    }]);
    while let Some(node) = waiting.pop_front() {
        if node.points.len() <= MOST_IN_LEAF || node.level == DEEPEST {
            nodes.push(node);
            continue;
        }
        let (kept, below) = split(node, places, &mut occupied);
        nodes.push(kept);
        waiting.extend(below.into_iter().filter(|child| !child.points.is_empty()));
    }
    nodes
}

/// Returns the node with the first point of each cell of its grid, and its eight children with the
/// other points.
fn split(
    node: OctreeNode,
    places: &[[u32; 3]],
    occupied: &mut [u64],
) -> (OctreeNode, [OctreeNode; 8]) {
    occupied.fill(0);
    let mut kept = Vec::new();
    let mut below = [0, 1, 2, 3, 4, 5, 6, 7].map(|octant: u32| OctreeNode {
        level: node.level + 1,
        cell: [0, 1, 2].map(|axis| 2 * node.cell[axis] + (octant >> axis & 1)),
        points: Vec::new(),
    });
    let shift = DEEPEST - node.level;
    for point in node.points {
        let [x, y, z] = places[point].map(|at| at >> shift & (GRID - 1));
        let cell = ((z << GRID_BITS | y) << GRID_BITS | x) as usize;
        let (word, bit) = (cell / 64, 1 << (cell % 64));
        if occupied[word] & bit == 0 {
            occupied[word] |= bit;
            kept.push(point);
        } else {
            let halves = [x, y, z].map(|at| at >> (GRID_BITS - 1));
            let octant = halves[0] | halves[1] << 1 | halves[2] << 2;
            below[octant as usize].points.push(point);
        }
    }
    let node = OctreeNode { points: kept, ..node };
    (node, below)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn few_points_are_one_node_and_none_too() {
        let few = nodes(&[[0; 3], [5; 3]]);
        assert_eq!((few.len(), &few[0].points[..]), (1, &[0, 1][..]));
        let none = nodes(&[]);
        assert_eq!((none.len(), none[0].points.len()), (1, 0));
    }

    #[test]
    fn a_level_halves_the_distance_and_no_point_is_lost() {
        // A flat bed of 512 by 512 points: 128 by 128 in the root, 256 by 256 on the next level,
        // the rest below.
        let side = 512;
        let step = (1 << BITS) / side;
        let places: Vec<[u32; 3]> =
            (0..side * side).map(|index| [index % side * step, index / side * step, 0]).collect();
        let nodes = nodes(&places);
        let of_level = |level: u32| nodes.iter().filter(move |node| node.level == level);
        let count = |level: u32| of_level(level).map(|node| node.points.len()).sum::<usize>();
        assert_eq!([count(0), count(1)], [128 * 128, 4 * 128 * 128]);
        let mut all: Vec<usize> = nodes.iter().flat_map(|node| node.points.clone()).collect();
        all.sort_unstable();
        assert_eq!(all, (0..places.len()).collect::<Vec<_>>());
        for node in &nodes {
            let inside =
                |point: &usize| places[*point].map(|at| at >> (BITS - node.level)) == node.cell;
            assert!(node.points.iter().all(inside), "{} {:?}", node.level, node.cell);
            assert!(node.points.is_sorted() && !node.points.is_empty());
        }
    }

    #[test]
    fn points_in_one_place_end_in_the_deepest_node() {
        let nodes = nodes(&vec![[77; 3]; 2 * MOST_IN_LEAF]);
        let deepest = nodes.last().unwrap();
        assert!(deepest.level <= DEEPEST && nodes.len() as u32 == deepest.level + 1);
        let count: usize = nodes.iter().map(|node| node.points.len()).sum();
        assert_eq!(count, 2 * MOST_IN_LEAF);
    }

    #[test]
    fn shares_beyond_the_root_are_held_at_its_sides() {
        assert_eq!([on_lattice(-1.0), on_lattice(f64::NAN)], [0, 0]);
        assert_eq!(on_lattice(1.0), (1 << BITS) - 1);
        assert_eq!(on_lattice(0.5), 1 << (BITS - 1));
    }
}
