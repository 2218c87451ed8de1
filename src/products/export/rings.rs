//! Makes polygons valid for the exchange formats (OGC 06-103r4, RFC 7946): after rounding of the
//! corners, rings must neither cross nor touch themselves.

use bathyscope_bottom::bathymetry::isobaths::{Polygon, polygons};
use std::ops::Range;

/// A corner, in steps of the lattice that corners are rounded to.
type LatticeCorner = [i64; 2];

/// Returns polygons with their corners rounded to `steps` steps a unit, each an outline and its
/// holes; `place` returns the coordinates of a corner.
pub(super) fn rounded(
    shapes: &[Polygon],
    steps: f64,
    place: impl Fn([f64; 2]) -> [f64; 2],
) -> Vec<Vec<Vec<[f64; 2]>>> {
    let corner = |at| place(at).map(|value| (value * steps).round() as i64);
    let back = |ring: Vec<LatticeCorner>| {
        let corners = ring.into_iter();
        corners.map(|at| at.map(|value| value as f64 / steps)).collect()
    };
    let polygons = on_lattice(shapes, corner).into_iter();
    polygons.map(|rings| rings.into_iter().map(back).collect()).collect()
}

/// Moves the corners of polygons to a lattice and makes the polygons valid again: sides that fall
/// onto each other are removed, and a ring that touches itself becomes several rings, whose areas
/// touch in that corner. Rings stay counter-clockwise around the area, holes clockwise.
///
/// The remaining sides are walked with the area on the left, turning left as sharply as possible
/// where several sides meet, so that a ring bounds one connected area. Where the walk returns to a
/// corner, the sides since then become a ring of their own.
fn on_lattice(
    shapes: &[Polygon],
    corner: impl Fn([f64; 2]) -> LatticeCorner,
) -> Vec<Vec<Vec<LatticeCorner>>> {
    let mut ways = Vec::new();
    for shape in shapes {
        for ring in std::iter::once(&shape.outline).chain(&shape.holes) {
            let corners: Vec<LatticeCorner> = ring.iter().map(|place| corner(*place)).collect();
            ways.extend(corners.windows(2).map(|way| [way[0], way[1]]));
        }
    }
    let rings = Sides::new(ways).walk();
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

/// Directed sides between corners; opposite sides have cancelled each other.
struct Sides {
    /// All sides in order, so that the sides that leave the same corner are adjacent.
    sides: Vec<Side>,
}

/// A side between two corners.
struct Side {
    from: LatticeCorner,
    to: LatticeCorner,
    /// Number of times that the side has still to be walked.
    left: u32,
    /// Indices of the sides that leave the corner `to`.
    next: Range<u32>,
}

impl Sides {
    /// Creates the sides from the ways from corner to corner around areas; opposite ways cancel
    /// each other.
    fn new(mut ways: Vec<[LatticeCorner; 2]>) -> Self {
        ways.retain(|[from, to]| from != to);
        ways.sort_unstable();
        let count = |way: [LatticeCorner; 2]| {
            let first = ways.partition_point(|other| *other < way);
            ways[first..].iter().take_while(|other| **other == way).count()
        };
        let runs = ways.chunk_by(|one, other| one == other);
        let left = runs.filter_map(|run| {
            let [from, to] = run[0];
            let left = run.len().checked_sub(count([to, from]))?;
            (left > 0).then_some((from, to, left as u32))
        });
        let left: Vec<(LatticeCorner, LatticeCorner, u32)> = left.collect();
        let leaving = |corner: LatticeCorner| {
            let first = left.partition_point(|(from, ..)| *from < corner);
            let more = left[first..].iter().take_while(|(from, ..)| *from == corner);
            first as u32..(first + more.count()) as u32
        };
        let sides = left.iter().map(|&(from, to, left)| Side { from, to, left, next: leaving(to) });
        Self { sides: sides.collect() }
    }

    /// Returns closed rings that pass no corner twice.
    fn walk(mut self) -> Vec<Vec<LatticeCorner>> {
        let mut rings = Vec::new();
        // Position of a corner on the path, by the index of the first side that leaves the corner.
        let mut place_on_path = vec![None; self.sides.len()];
        for first in 0..self.sides.len() {
            while self.sides[first].left > 0 {
                self.walk_from(first, &mut place_on_path, &mut rings);
            }
        }
        rings
    }

    /// Walks from a side until there is no further side to walk; clears `place_on_path` at the end.
    fn walk_from(
        &mut self,
        first: usize,
        place_on_path: &mut [Option<usize>],
        rings: &mut Vec<Vec<LatticeCorner>>,
    ) {
        let from = self.sides[first].from;
        let own = (self.sides).partition_point(|side| side.from < from);
        let mut path = vec![(from, own)];
        place_on_path[own] = Some(0);
        let mut side = first;
        loop {
            self.sides[side].left -= 1;
            let Side { from: last, to: at, ref next, .. } = self.sides[side];
            let (next, corner) = (next.clone(), next.start as usize);
            if next.is_empty() {
                break;
            }
            if let Some(begin) = place_on_path[corner] {
                let corners = path[begin..].iter().map(|(corner, _)| *corner);
                rings.push(corners.chain([at]).collect());
                for (_, passed) in path.drain(begin + 1..) {
                    place_on_path[passed] = None;
                }
            } else {
                place_on_path[corner] = Some(path.len());
                path.push((at, corner));
            }
            let turn_to = |side: &u32| turn(last, at, self.sides[*side as usize].to);
            let sharpest = next.min_by(|a, b| turn_to(a).total_cmp(&turn_to(b)));
            match sharpest.map(|next| next as usize) {
                Some(next) if self.sides[next].left > 0 => side = next,
                _ => break,
            }
        }
        for (_, passed) in path {
            place_on_path[passed] = None;
        }
    }
}

/// Returns the clockwise angle from the way back to the way on: a smaller angle is a sharper turn
/// to the left.
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
        // A sandglass whose neck is closed by rounding.
        let glass = [[0.0, 0.0], [4.0, 0.0], [2.1, 2.0], [4.0, 4.0], [0.0, 4.0], [1.9, 2.0]];
        let areas = made(&glass, &[]);
        assert_eq!(areas.len(), 2, "{areas:?}");
        assert!(areas.iter().all(|area| area.len() == 1 && area[0].len() == 4));
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
        let spiked = [[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [9.0, 4.2], [4.0, 4.3], [0.0, 4.0]];
        assert_eq!(made(&spiked, &[])[0][0].len(), 5);
        assert!(made(&[[0.0, 0.0], [5.0, 0.1], [9.0, 0.2]], &[]).is_empty());
    }
}
