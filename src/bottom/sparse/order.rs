//! Order in which unknowns are eliminated: the fill-in, and so the time, depends on it; the
//! solution does not.

use super::{Equations, Occurrences};
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::sparse::SymbolicSparseColMatRef;
use faer::sparse::linalg::amd;

/// Marks what has no place yet.
const NONE: u32 = u32::MAX;

/// Unknowns that occur together in an equation.
pub(super) struct Neighbours {
    starts: Vec<usize>,
    unknowns: Vec<u32>,
}

impl Neighbours {
    pub(super) fn new(equations: &Equations, of_unknown: &Occurrences, unknowns: usize) -> Self {
        let mut starts = vec![0];
        let mut found: Vec<u32> = Vec::new();
        // The last unknown that a neighbour was found for.
        let mut seen = vec![usize::MAX; unknowns];
        for unknown in 0..unknowns {
            seen[unknown] = unknown;
            for (equation, _) in of_unknown.of(unknown) {
                for other in equations.unknowns_of(equation) {
                    let seen = &mut seen[*other as usize];
                    if *seen != unknown {
                        *seen = unknown;
                        found.push(*other);
                    }
                }
            }
            starts.push(found.len());
        }
        Self { starts, unknowns: found }
    }

    /// Returns the neighbours of an unknown, itself left out, each once.
    pub(super) fn of(&self, unknown: usize) -> &[u32] {
        &self.unknowns[self.starts[unknown]..self.starts[unknown + 1]]
    }

    /// Number of unknowns.
    fn unknowns(&self) -> usize {
        self.starts.len() - 1
    }

    /// The triangle of the matrix whose columns are the unknowns in an order, each with its
    /// diagonal first: where columns begin, and the rows that `is_in` says of a row and a column
    /// belong to it.
    pub(super) fn triangle(
        &self,
        order: &[u32],
        places: &[u32],
        is_in: impl Fn(usize, usize) -> bool,
    ) -> (Vec<usize>, Vec<usize>) {
        let mut starts = vec![0];
        let mut rows = Vec::with_capacity(self.unknowns() + self.unknowns.len() / 2);
        for (column, unknown) in order.iter().enumerate() {
            rows.push(column);
            let of_column = self.of(*unknown as usize).iter();
            let of_column = of_column.map(|other| places[*other as usize] as usize);
            rows.extend(of_column.filter(|row| is_in(*row, column)));
            starts.push(rows.len());
        }
        (starts, rows)
    }

    /// Returns the order of approximately least degree (Amestoy et al. 1996): good for any
    /// equations. `None` where there is no room.
    pub(super) fn of_least_degree(&self) -> Option<Vec<u32>> {
        let unknowns = self.unknowns();
        let given: Vec<u32> = (0..unknowns as u32).collect();
        let (starts, rows) = self.triangle(&given, &given, |row, column| row > column);
        let triangle =
            SymbolicSparseColMatRef::new_unsorted_checked(unknowns, unknowns, &starts, None, &rows);
        let (mut order, mut places) = (vec![0; unknowns], vec![0; unknowns]);
        let room = amd::order_maybe_unsorted_scratch::<usize>(unknowns, rows.len());
        amd::order_maybe_unsorted(
            &mut order,
            &mut places,
            triangle,
            amd::Control::default(),
            MemStack::new(&mut MemBuffer::try_new(room).ok()?),
        )
        .ok()?;
        Some(order.into_iter().map(|unknown| unknown as u32).collect())
    }
}

/// Returns the place of each unknown in an order; `None` where `order` is not an order of
/// `unknowns` unknowns.
pub(super) fn places(order: &[u32], unknowns: usize) -> Option<Vec<u32>> {
    let mut places = vec![NONE; unknowns];
    for (place, unknown) in (0..).zip(order) {
        let own = places.get_mut(*unknown as usize)?;
        if *own != NONE {
            return None;
        }
        *own = place;
    }
    (order.len() == unknowns).then_some(places)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_an_order_of_all_unknowns_has_places() {
        assert_eq!(places(&[2, 0, 1], 3), Some(vec![1, 2, 0]));
        for order in [&[0, 1][..], &[0, 1, 1], &[0, 1, 3], &[0, 1, 2, 3]] {
            assert_eq!(places(order, 3), None);
        }
    }
}
