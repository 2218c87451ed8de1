//! Weighs the nodes around a place by the inverse square of their distance.

use kiddo::{ImmutableKdTree, SquaredEuclidean};
use std::num::NonZero;

/// Largest number of nodes that carry a place: a dense cloud has thousands within the gap, and the
/// far ones count for little.
const MOST: NonZero<usize> = NonZero::new(64).unwrap();

/// Fills `weights` with the nodes that carry a place, and their shares `1 / distance^2`, which sum
/// to 1 (Shepard 1968): the nearest nodes, up to 64, within `reach_m`. `weights` is empty where no
/// node is so near; at the place of a node, this node alone counts.
pub(super) fn inverse_distance(
    index: &ImmutableKdTree<f64, 2>,
    place: [f64; 2],
    reach_m: f64,
    weights: &mut Vec<(usize, f64)>,
) {
    weights.clear();
    let near = index
        .query(&place)
        .nearest_n::<SquaredEuclidean<f64>>(MOST)
        .within(reach_m * reach_m)
        .execute();
    for found in near {
        if found.distance == 0.0 {
            weights.clear();
            weights.push((found.item as usize, 1.0));
            return;
        }
        weights.push((found.item as usize, 1.0 / found.distance));
    }
    let total: f64 = weights.iter().map(|(_, weight)| weight).sum();
    for (_, weight) in weights.iter_mut() {
        *weight /= total;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bathymetry::testing::{GOLDEN, golden_nodes};

    #[test]
    fn all_points_within_reach_give_the_golden_depths() {
        let nodes = golden_nodes();
        let places: Vec<[f64; 2]> = nodes.iter().map(|node| node.place()).collect();
        let index = ImmutableKdTree::new_from_slice(&places).unwrap();
        let mut weights = Vec::new();
        let mut depth_at = |place, reach_m| {
            inverse_distance(&index, place, reach_m, &mut weights);
            weights.iter().map(|(i, share)| share * nodes[*i].depth_m).sum::<f64>()
        };
        for golden in &GOLDEN {
            let found = depth_at(golden.place, 100.0);
            assert!((found - golden.inverse_distance).abs() < 1e-9, "{found}");
        }
        assert_eq!(depth_at(places[7], 100.0), nodes[7].depth_m);
        assert_eq!(depth_at([50.0, 50.0], 10.0), 0.0);
    }
}
