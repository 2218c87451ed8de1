//! The nearest of many places.

use kiddo::{ImmutableKdTree, SquaredEuclidean};

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
}
