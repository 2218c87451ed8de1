//! Computes depth areas: the parts of a surface between two levels, as polygons.

mod rings;

pub use rings::{Polygon, polygons};

use super::lines::{CellEdge, Square, crossing, square};
use crate::bathymetry::Surface;
use bathyscope_log::support::progress::{Cancelled, Progress};
use rayon::prelude::*;

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
            let closed = rings::closed(&pieces);
            let placed = closed.iter().map(|stops| band.places(stops)).collect();
            progress.advance(1);
            Ok(DepthArea {
                from_m: between[0],
                to_m: between[1],
                polygons: rings::polygons(placed),
            })
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
