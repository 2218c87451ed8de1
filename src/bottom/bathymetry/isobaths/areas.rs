//! Computes depth areas, the parts of a surface between two levels, as polygons: joins pieces of a
//! border to rings, and sorts rings into outlines and holes.

use super::lines::{CellEdge, Square, crossing, square};
use crate::bathymetry::Surface;
use bathyscope_log::support::outline::{bounds, is_crossed};
use bathyscope_log::support::progress::{Cancelled, Progress};
use rayon::prelude::*;
use std::cell::OnceCell;

/// Part of a surface between two depths.
#[derive(Clone, Debug, PartialEq)]
pub struct DepthArea {
    /// Shallow limit, inclusive, metres.
    pub from_m: f64,
    /// Deep limit, exclusive, metres.
    pub to_m: f64,
    /// Parts of the area; they do not overlap.
    pub polygons: Vec<Polygon>,
}

impl DepthArea {
    /// Returns the area, square metres.
    pub fn area_m2(&self) -> f64 {
        self.polygons.iter().map(Polygon::area_m2).sum()
    }
}

/// Returns the areas between each level and the next (`levels_m` ascends). Their borders are the
/// isobaths ([`super::isobaths`], unsmoothed) and the edge of the surface.
///
/// # Errors
/// When the work was cancelled.
pub fn depth_areas(
    surface: &Surface,
    levels_m: &[f64],
    progress: &Progress,
) -> Result<Vec<DepthArea>, Cancelled> {
    progress.start(levels_m.len().saturating_sub(1) as u64);
    levels_m
        .par_windows(2)
        .map(|between| {
            let band = DepthBand { surface, levels_m: [between[0], between[1]] };
            let pieces = band.pieces(progress)?;
            let closed = closed(&pieces);
            let placed = closed.iter().map(|stops| band.places(stops)).collect();
            progress.advance(1);
            Ok(DepthArea { from_m: between[0], to_m: between[1], polygons: polygons(placed) })
        })
        .collect()
}

/// Corner of the border of an area.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
enum Stop {
    /// The centre of a cell at the edge of the surface.
    Corner(usize),
    /// Crossing of the shallower level and an edge.
    Shallow(CellEdge),
    /// Crossing of the deeper level and an edge.
    Deep(CellEdge),
}

/// Step of the border in one square, with the area on its left.
#[derive(Clone, Copy, Debug)]
struct Piece {
    from: Stop,
    to: Stop,
    /// Index of the square's north-western cell.
    square: usize,
}

struct DepthBand<'a> {
    surface: &'a Surface,
    levels_m: [f64; 2],
}

impl DepthBand<'_> {
    fn pieces(&self, progress: &Progress) -> Result<Vec<Piece>, Cancelled> {
        let grid = &self.surface.grid;
        let mut pieces = Vec::new();
        for row in 0..grid.rows {
            progress.check()?;
            for column in 0..grid.columns {
                if let Some(square) = square(self.surface, row, column) {
                    self.cuts(&square, &mut pieces);
                    self.borders(&square, row, column, &mut pieces);
                }
            }
        }
        Ok(pieces)
    }

    /// Adds the isobaths within a square: the shallower one in its direction, the deeper one
    /// reversed.
    fn cuts(&self, square: &Square, pieces: &mut Vec<Piece>) {
        let [shallow, deep] = self.levels_m.map(|level_m| square.cuts(level_m));
        let piece = |from, to| Piece { from, to, square: square.cell };
        let along = |[from, to]: [CellEdge; 2]| piece(Stop::Shallow(from), Stop::Shallow(to));
        let against = |[from, to]: [CellEdge; 2]| piece(Stop::Deep(to), Stop::Deep(from));
        pieces.extend(shallow.into_iter().flatten().map(along));
        pieces.extend(deep.into_iter().flatten().map(against));
    }

    /// Adds the sides of a square beyond which no depth is known, as far as they lie in the band.
    fn borders(&self, at: &Square, row: usize, column: usize, pieces: &mut Vec<Piece>) {
        let known = |row: Option<usize>, column: Option<usize>| {
            row.zip(column).and_then(|(row, column)| square(self.surface, row, column)).is_some()
        };
        let open = [
            !known(row.checked_sub(1), Some(column)),
            !known(Some(row), Some(column + 1)),
            !known(Some(row + 1), Some(column)),
            !known(Some(row), column.checked_sub(1)),
        ];
        let (edges, corners) = (at.edges(), at.corners());
        for side in (0..4).filter(|side| open[*side]) {
            // Sides run clockwise from the north-west; in reverse, the square lies on the left.
            let [from, to] = [(side + 1) % 4, side];
            let depths_m = [from, to].map(|corner| at.depths_m[corner]);
            let stops = self.stops(edges[side], [from, to].map(|corner| corners[corner]), depths_m);
            pieces.extend(stops.map(|[from, to]| Piece { from, to, square: at.cell }));
        }
    }

    /// Returns the part of an edge within the band, if any. Depths are linear along the edge, so
    /// there is at most one part.
    fn stops(&self, edge: CellEdge, cells: [usize; 2], depths_m: [f64; 2]) -> Option<[Stop; 2]> {
        let [shallow_m, deep_m] = self.levels_m;
        let beyond = depths_m.map(|depth| (depth < shallow_m, depth >= deep_m));
        match beyond {
            [(true, _), (true, _)] | [(_, true), (_, true)] => None,
            _ => Some([0, 1].map(|end| match beyond[end] {
                (true, _) => Stop::Shallow(edge),
                (_, true) => Stop::Deep(edge),
                _ => Stop::Corner(cells[end]),
            })),
        }
    }

    fn places(&self, stops: &[Stop]) -> Vec<[f64; 2]> {
        let [shallow_m, deep_m] = self.levels_m;
        let place = |stop: &Stop| match *stop {
            Stop::Corner(cell) => self.surface.grid.centre_of(cell),
            Stop::Shallow(edge) => crossing(self.surface, edge, shallow_m),
            Stop::Deep(edge) => crossing(self.surface, edge, deep_m),
        };
        let mut places: Vec<[f64; 2]> = stops.iter().map(place).collect();
        places.dedup();
        places
    }
}

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
fn closed(pieces: &[Piece]) -> Vec<Vec<Stop>> {
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
