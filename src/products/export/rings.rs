//! Polygons as the exchange formats want them (OGC 06-103r4, RFC 7946): once corners are rounded, rings must still neither cross
//! nor touch themselves.

use crate::bottom::bathymetry::isobaths::{Polygon, polygons};
use std::collections::{BTreeMap, HashMap};

/// A corner, counted in steps of the lattice that corners are rounded to.
type LatticeCorner = [i64; 2];

/// Polygons with their corners rounded to so many steps a unit, each an outline and its holes; `place` gives where a corner lies.
pub(super) fn rounded(
    shapes: &[Polygon],
    steps: f64,
    place: impl Fn([f64; 2]) -> [f64; 2],
) -> Vec<Vec<Vec<[f64; 2]>>> {
    let corner = |at| place(at).map(|value| (value * steps).round() as i64);
    let back = |ring: Vec<LatticeCorner>| {
        let corners = ring.into_iter();
        corners
            .map(|at| at.map(|value| value as f64 / steps))
            .collect()
    };
    let polygons = on_lattice(shapes, corner).into_iter();
    polygons
        .map(|rings| rings.into_iter().map(back).collect())
        .collect()
}

/// Puts polygons on a lattice and makes them valid again: sides that fall onto each other go, and a ring that touches itself
/// becomes several, whose areas touch in that corner. Rings stay counter-clockwise around the area, holes clockwise.
///
/// The sides that are left are walked with the area on the left, turning left as sharply as possible where several meet, so that
/// a ring bounds one connected area; what a ring closes on its way at a corner it has been at is a ring of its own.
fn on_lattice(
    shapes: &[Polygon],
    corner: impl Fn([f64; 2]) -> LatticeCorner,
) -> Vec<Vec<Vec<LatticeCorner>>> {
    let mut sides = Sides::default();
    for shape in shapes {
        for ring in std::iter::once(&shape.outline).chain(&shape.holes) {
            let corners: Vec<LatticeCorner> = ring.iter().map(|place| corner(*place)).collect();
            corners
                .windows(2)
                .for_each(|side| sides.add(side[0], side[1]));
        }
    }
    let rings = sides.walk();
    let as_places =
        |ring: Vec<LatticeCorner>| ring.into_iter().map(|at| at.map(|steps| steps as f64));
    let rings = rings.into_iter().map(|ring| as_places(ring).collect());
    let back = |ring: Vec<[f64; 2]>| ring.into_iter().map(|at| at.map(|steps| steps as i64));
    let sorted = polygons(rings.collect()).into_iter();
    sorted
        .map(|polygon| {
            let rings = std::iter::once(polygon.outline).chain(polygon.holes);
            rings.map(|ring| back(ring).collect()).collect()
        })
        .collect()
}

/// Directed sides between corners.
#[derive(Default)]
struct Sides {
    /// How often each is there, those that run both ways taken off each other.
    counts: BTreeMap<(LatticeCorner, LatticeCorner), usize>,
}

impl Sides {
    fn add(&mut self, from: LatticeCorner, to: LatticeCorner) {
        if from == to {
            return;
        }
        match self.counts.get_mut(&(to, from)) {
            Some(1) => {
                self.counts.remove(&(to, from));
            }
            Some(count) => *count -= 1,
            None => *self.counts.entry((from, to)).or_insert(0) += 1,
        }
    }

    /// Closed rings without a corner twice.
    fn walk(mut self) -> Vec<Vec<LatticeCorner>> {
        let mut leaving: HashMap<LatticeCorner, Vec<LatticeCorner>> = HashMap::new();
        for &(from, to) in self.counts.keys() {
            leaving.entry(from).or_default().push(to);
        }
        let mut rings = Vec::new();
        while let Some((&(from, to), _)) = self.counts.first_key_value() {
            self.walk_from(from, to, &leaving, &mut rings);
        }
        rings
    }

    /// Walks from a side until the next one has been walked.
    fn walk_from(
        &mut self,
        from: LatticeCorner,
        to: LatticeCorner,
        leaving: &HashMap<LatticeCorner, Vec<LatticeCorner>>,
        rings: &mut Vec<Vec<LatticeCorner>>,
    ) {
        let mut path = vec![from];
        let mut place_on_path = HashMap::from([(from, 0)]);
        let (mut last, mut at) = (from, to);
        self.take(from, to);
        loop {
            if let Some(&begin) = place_on_path.get(&at) {
                let mut ring = path[begin..].to_vec();
                ring.push(at);
                rings.push(ring);
                for passed in path.drain(begin + 1..) {
                    place_on_path.remove(&passed);
                }
            } else {
                place_on_path.insert(at, path.len());
                path.push(at);
            }
            let ways = leaving.get(&at).into_iter().flatten().copied();
            let next = ways.min_by(|a, b| turn(last, at, *a).total_cmp(&turn(last, at, *b)));
            let Some(next) = next.filter(|next| self.take(at, *next)) else {
                return;
            };
            (last, at) = (at, next);
        }
    }

    /// Takes a side; false where it is gone.
    fn take(&mut self, from: LatticeCorner, to: LatticeCorner) -> bool {
        match self.counts.get_mut(&(from, to)) {
            Some(1) => self.counts.remove(&(from, to)).is_some(),
            Some(count) => {
                *count -= 1;
                true
            }
            None => false,
        }
    }
}

/// Clockwise angle from the way back to the way on: the smaller, the sharper the turn to the left.
fn turn(last: LatticeCorner, at: LatticeCorner, next: LatticeCorner) -> f64 {
    let angle = |to: LatticeCorner| ((to[1] - at[1]) as f64).atan2((to[0] - at[0]) as f64);
    (angle(last) - angle(next)).rem_euclid(std::f64::consts::TAU)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ring(corners: &[[f64; 2]]) -> Vec<[f64; 2]> {
        let mut ring = corners.to_vec();
        ring.push(corners[0]);
        ring
    }

    fn made(outline: &[[f64; 2]], holes: &[&[[f64; 2]]]) -> Vec<Vec<Vec<LatticeCorner>>> {
        let shape = Polygon {
            outline: ring(outline),
            holes: holes.iter().map(|hole| ring(hole)).collect(),
        };
        on_lattice(&[shape], |place| place.map(|value| value.round() as i64))
    }

    #[test]
    fn a_pinched_ring_becomes_two_areas() {
        // A sandglass, its neck rounded shut.
        let glass = [
            [0.0, 0.0],
            [4.0, 0.0],
            [2.1, 2.0],
            [4.0, 4.0],
            [0.0, 4.0],
            [1.9, 2.0],
        ];
        let areas = made(&glass, &[]);
        assert_eq!(areas.len(), 2, "{areas:?}");
        assert!(
            areas
                .iter()
                .all(|area| area.len() == 1 && area[0].len() == 4)
        );
    }

    #[test]
    fn a_hole_that_touches_the_outline_stays_a_hole() {
        let square = [[0.0, 0.0], [4.0, 0.0], [8.0, 0.0], [8.0, 8.0], [0.0, 8.0]];
        let hole = [[4.0, 0.3], [3.0, 3.0], [5.0, 3.0]];
        let areas = made(&square, &[&hole]);
        assert_eq!(areas.len(), 1, "{areas:?}");
        assert_eq!(areas[0].iter().map(Vec::len).collect::<Vec<_>>(), [6, 4]);
    }

    #[test]
    fn spikes_and_slivers_go() {
        let spiked = [
            [0.0, 0.0],
            [4.0, 0.0],
            [4.0, 4.0],
            [9.0, 4.2],
            [4.0, 4.3],
            [0.0, 4.0],
        ];
        assert_eq!(made(&spiked, &[])[0][0].len(), 5);
        assert!(made(&[[0.0, 0.0], [5.0, 0.1], [9.0, 0.2]], &[]).is_empty());
    }
}
