//! Joins pieces of a border to rings, and sorts rings into outlines and holes.

use super::{Piece, Stop};
use bathyscope_log::support::outline::{bounds, is_crossed};
use std::cell::OnceCell;

/// An area with holes.
#[derive(Clone, Debug, PartialEq)]
pub struct Polygon {
    /// The outline, counter-clockwise (east, north); its last point is its first.
    pub outline: Vec<[f64; 2]>,
    /// Holes, clockwise; the last point of each is its first.
    pub holes: Vec<Vec<[f64; 2]>>,
}

impl Polygon {
    /// Returns the area without the holes, square metres.
    pub fn area_m2(&self) -> f64 {
        // The holes run the other way, so that their areas are negative.
        signed_area(&self.outline) + self.holes.iter().map(|hole| signed_area(hole)).sum::<f64>()
    }
}

/// Joins pieces to closed rings. At every stop as many pieces end as begin. Where two parts of the
/// area touch at a corner, the ring stays in the square of its last piece, so that it never crosses
/// itself.
pub(super) fn closed(pieces: &[Piece]) -> Vec<Vec<Stop>> {
    let mut order: Vec<usize> = (0..pieces.len()).collect();
    order.sort_unstable_by_key(|&piece| (pieces[piece].from, pieces[piece].square));
    let mut used = vec![false; pieces.len()];
    let next = |at: Stop, square: usize, used: &mut [bool]| {
        let first = order.partition_point(|&piece| pieces[piece].from < at);
        let leaving = order[first..].iter().copied();
        let mut free =
            leaving.take_while(|&piece| pieces[piece].from == at).filter(|&piece| !used[piece]);
        let same = free.clone().find(|&piece| pieces[piece].square == square);
        let chosen = same.or_else(|| free.next())?;
        used[chosen] = true;
        Some(chosen)
    };
    let mut rings = Vec::new();
    for begin in 0..pieces.len() {
        if used[begin] {
            continue;
        }
        used[begin] = true;
        let mut ring = vec![pieces[begin].from];
        let mut at = begin;
        while pieces[at].to != pieces[begin].from {
            ring.push(pieces[at].to);
            let Some(following) = next(pieces[at].to, pieces[at].square, &mut used) else {
                break;
            };
            at = following;
        }
        ring.push(ring[0]);
        rings.push(ring);
    }
    rings
}

/// Sorts rings: counter-clockwise ones are outlines, clockwise ones holes in the smallest outline
/// around them. Rings without area are left out.
pub fn polygons(rings: Vec<Vec<[f64; 2]>>) -> Vec<Polygon> {
    let (mut outlines, mut holes) = (Vec::new(), Vec::new());
    for ring in rings.into_iter().filter(|ring| ring.len() > 3) {
        let area_m2 = signed_area(&ring);
        if area_m2 > 0.0 {
            outlines.push((area_m2, bounds(ring.iter().copied()), ring));
        } else if area_m2 < 0.0 {
            holes.push(ring);
        }
    }
    // The first outline that holds a hole is then the smallest.
    outlines.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut owned: Vec<Vec<Vec<[f64; 2]>>> = vec![Vec::new(); outlines.len()];
    let edges: Vec<OnceCell<EdgesByRow<'_>>> = vec![OnceCell::new(); outlines.len()];
    for hole in holes {
        let box_of_hole = bounds(hole.iter().copied());
        let owner = outlines.iter().zip(&edges).position(|((_, bounds, ring), edges)| {
            let edges = || edges.get_or_init(|| EdgesByRow::new(ring, *bounds));
            is_inside(box_of_hole, *bounds) && edges().surround(&hole)
        });
        if let Some(owner) = owner {
            owned[owner].push(hole);
        }
    }
    drop(edges);
    let outlines = outlines.into_iter().map(|(_, _, outline)| outline);
    outlines.zip(owned).map(|(outline, holes)| Polygon { outline, holes }).collect()
}

/// Returns the area of a ring by Gauss's formula about its first point; positive counter-clockwise.
fn signed_area(ring: &[[f64; 2]]) -> f64 {
    let Some([x0, y0]) = ring.first().copied() else {
        return 0.0;
    };
    let cross = |step: &[[f64; 2]]| {
        (step[0][0] - x0) * (step[1][1] - y0) - (step[1][0] - x0) * (step[0][1] - y0)
    };
    0.5 * ring.windows(2).map(cross).sum::<f64>()
}

fn is_inside(inner: [f64; 4], outer: [f64; 4]) -> bool {
    inner[0] >= outer[0] && inner[1] >= outer[1] && inner[2] <= outer[2] && inner[3] <= outer[3]
}

/// Edges of an outline by the rows of the outline that they cross: a place is compared with the
/// edges of its row alone.
#[derive(Clone)]
struct EdgesByRow<'a> {
    outline: &'a [[f64; 2]],
    south_m: f64,
    rows_per_m: f64,
    /// Edges of each row, by the index of their first corner.
    rows: Vec<Vec<usize>>,
}

impl<'a> EdgesByRow<'a> {
    /// Sorts the edges of an outline into rows; its bounds are west, south, east and north.
    fn new(outline: &'a [[f64; 2]], [_, south_m, _, north_m]: [f64; 4]) -> Self {
        // There are about as many rows as each has edges.
        let count = outline.len().isqrt().max(1);
        let mut edges = Self {
            outline,
            south_m,
            rows_per_m: count as f64 / (north_m - south_m),
            rows: vec![Vec::new(); count],
        };
        for (first, ends) in outline.windows(2).enumerate() {
            let [one, other] = [ends[0], ends[1]].map(|[_, y_m]| edges.row_of(y_m));
            for row in &mut edges.rows[one.min(other)..=one.max(other)] {
                row.push(first);
            }
        }
        edges
    }

    fn row_of(&self, y_m: f64) -> usize {
        let row = (y_m - self.south_m) * self.rows_per_m;
        (row as usize).min(self.rows.len() - 1)
    }

    /// Returns true if most corners of a ring lie inside the outline: rings do not cross, but may
    /// touch.
    fn surround(&self, ring: &[[f64; 2]]) -> bool {
        let corners = &ring[..ring.len() - 1];
        let inside = corners.iter().filter(|corner| self.go_around(**corner));
        2 * inside.count() > corners.len()
    }

    /// Returns true if a ray from a place to the east crosses the edges an odd number of times.
    fn go_around(&self, place: [f64; 2]) -> bool {
        let row = self.rows[self.row_of(place[1])].iter();
        let edges = row.map(|&first| [self.outline[first], self.outline[first + 1]]);
        edges.filter(|edge| is_crossed(*edge, place)).count() % 2 == 1
    }
}
