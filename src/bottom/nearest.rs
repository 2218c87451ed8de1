//! The nearest of many places, and their weights by the inverse square of their distance.

use kiddo::{ImmutableKdTree, SquaredEuclidean};
use std::num::NonZero;

/// Largest number of places that carry another: a dense cloud has thousands within the gap, and the
/// far ones count for little.
const MOST: NonZero<usize> = NonZero::new(64).unwrap();

/// Index of places for searches of the nearest one.
pub(crate) struct Nearest(ImmutableKdTree<f64, 2>);

impl Nearest {
    /// Creates the index of some places; `None` without any.
    pub(crate) fn of(places: &[[f64; 2]]) -> Option<Self> {
        let index = (!places.is_empty()).then(|| ImmutableKdTree::new_from_slice(places))?;
        Some(Self(index.ok()?))
    }

    /// Index of the nearest place, and the square of its distance.
    pub(crate) fn at(&self, place: [f64; 2]) -> (usize, f64) {
        let query = self.0.query(&place);
        let nearest = query.nearest_one::<SquaredEuclidean<f64>>().execute();
        (nearest.item as usize, nearest.distance)
    }

    /// Distance to the nearest place.
    pub(crate) fn distance_m(&self, place: [f64; 2]) -> f64 {
        self.at(place).1.sqrt()
    }

    /// Fills `weights` with the indices of the places that carry a place, and their shares
    /// `1 / distance^2`, which sum to 1 (Shepard 1968): the nearest ones, up to 64, within
    /// `reach_m`. `weights` is empty where none is so near; at one of the places, it alone counts.
    pub(crate) fn inverse_distance(
        &self,
        place: [f64; 2],
        reach_m: f64,
        weights: &mut Vec<(usize, f64)>,
    ) {
        weights.clear();
        let near = self
            .0
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
}
