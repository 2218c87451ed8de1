//! Draws isobaths: cuts the squares whose corners are the centres of four cells at one level
//! (marching squares), joins the cuts, and rounds the lines for those who prefer looks to
//! exactness.

use crate::bathymetry::Surface;
use bathyscope_log::support::outline::between;
use bathyscope_log::support::progress::{Cancelled, Progress};
use rayon::prelude::*;
use std::collections::{HashMap, HashSet};
use std::hash::Hash;

/// An edge between the centres of two neighbouring cells: twice the index of its western or
/// northern cell, and one more where it runs south.
pub(super) type CellEdge = usize;

/// A square of four centres, all of known depth.
#[derive(Clone, Copy)]
pub(super) struct Square {
    /// Index of the square's north-western cell.
    pub cell: usize,
    /// Depths north-west, north-east, south-east, south-west.
    pub depths_m: [f64; 4],
    columns: usize,
}

/// Cuts of one square: at most two, each from edge to edge with the deeper side on the left.
type Cuts = [Option<[CellEdge; 2]>; 2];

// Sides of a square.
const N: usize = 0;
const E: usize = 1;
const S: usize = 2;
const W: usize = 3;

/// Returns the square with this north-western cell; `None` where a depth is unknown or the grid
/// ends.
pub(super) fn square(surface: &Surface, row: usize, column: usize) -> Option<Square> {
    let columns = surface.grid.columns;
    if row + 1 >= surface.grid.rows || column + 1 >= columns {
        return None;
    }
    let cell = row * columns + column;
    let depth_m = |cell: usize| f64::from(surface.depth_m[cell]);
    let depths_m = [cell, cell + 1, cell + columns + 1, cell + columns].map(depth_m);
    let known = depths_m.iter().all(|depth| !depth.is_nan());
    known.then_some(Square { cell, depths_m, columns })
}

impl Square {
    /// Returns the edges to the north, east, south and west.
    pub(super) fn edges(&self) -> [CellEdge; 4] {
        let [north, south] = [self.cell, self.cell + self.columns].map(|cell| 2 * cell);
        [north, north + 3, south, north + 1]
    }

    /// Returns the cells at the corners: north-west, north-east, south-east, south-west.
    pub(super) fn corners(&self) -> [usize; 4] {
        let south = self.cell + self.columns;
        [self.cell, self.cell + 1, south + 1, south]
    }

    /// Returns the cuts at a level. A corner at the level counts as deeper; in a saddle, the
    /// corners on the side of the mean of the four are joined.
    pub(super) fn cuts(&self, level_m: f64) -> Cuts {
        let deeper = self.depths_m.map(|depth| depth >= level_m);
        let joined = || self.depths_m.iter().sum::<f64>() >= 4.0 * level_m;
        let sides = match deeper.map(u8::from) {
            [0, 0, 0, 0] | [1, 1, 1, 1] => return [None, None],
            [0, 0, 0, 1] => [Some([S, W]), None],
            [0, 0, 1, 0] => [Some([E, S]), None],
            [0, 0, 1, 1] => [Some([E, W]), None],
            [0, 1, 0, 0] => [Some([N, E]), None],
            [0, 1, 1, 0] => [Some([N, S]), None],
            [0, 1, 1, 1] => [Some([N, W]), None],
            [1, 0, 0, 0] => [Some([W, N]), None],
            [1, 0, 0, 1] => [Some([S, N]), None],
            [1, 0, 1, 1] => [Some([E, N]), None],
            [1, 1, 0, 0] => [Some([W, E]), None],
            [1, 1, 0, 1] => [Some([S, E]), None],
            [1, 1, 1, 0] => [Some([W, S]), None],
            [0, 1, 0, 1] if joined() => [Some([N, W]), Some([S, E])],
            [0, 1, 0, 1] => [Some([S, W]), Some([N, E])],
            _ if joined() => [Some([E, N]), Some([W, S])],
            _ => [Some([W, N]), Some([E, S])],
        };
        let edges = self.edges();
        sides.map(|cut| cut.map(|cut| cut.map(|side| edges[side])))
    }
}

/// Returns east and north of the place on an edge where the depth is `level_m`, linear between the
/// ends of the edge.
pub(super) fn crossing(surface: &Surface, edge: CellEdge, level_m: f64) -> [f64; 2] {
    let grid = &surface.grid;
    let (cell, runs_south) = (edge / 2, edge % 2 == 1);
    let next = cell + if runs_south { grid.columns } else { 1 };
    let [from_m, to_m] = [cell, next].map(|cell| f64::from(surface.depth_m[cell]));
    let share = (level_m - from_m) / (to_m - from_m);
    let [east_m, north_m] = grid.centre_of(cell);
    if runs_south {
        [east_m, north_m - share * grid.cell_m]
    } else {
        [east_m + share * grid.cell_m, north_m]
    }
}

/// Line of equal depth.
#[derive(Clone, Debug, PartialEq)]
pub struct Isobath {
    /// Depth of the line, metres.
    pub depth_m: f64,
    /// East and north, metres, with the deeper side on the left; a ring ends where it began.
    pub points: Vec<[f64; 2]>,
}

impl Isobath {
    /// Returns true if the line ends where it began.
    pub fn is_ring(&self) -> bool {
        self.points.len() > 3 && self.points.first() == self.points.last()
    }

    /// Returns the length of the line, metres.
    pub fn length_m(&self) -> f64 {
        let steps = self.points.windows(2);
        steps.map(|step| (step[1][0] - step[0][0]).hypot(step[1][1] - step[0][1])).sum()
    }
}

/// Returns the isobaths of a surface at some depths, in the order of the depths. Lines end where
/// the surface ends: none follows its edge.
///
/// # Errors
/// When the work was cancelled.
pub fn isobaths(
    surface: &Surface,
    levels_m: &[f64],
    progress: &Progress,
) -> Result<Vec<Isobath>, Cancelled> {
    progress.start(levels_m.len() as u64);
    let drawn: Vec<Vec<Isobath>> = levels_m
        .par_iter()
        .map(|&level_m| {
            let cuts = cuts(surface, level_m, progress)?;
            progress.advance(1);
            let lines = join(&cuts).into_iter();
            Ok(lines.filter_map(|edges| place(surface, level_m, &edges)).collect())
        })
        .collect::<Result<_, Cancelled>>()?;
    Ok(drawn.into_iter().flatten().collect())
}

fn cuts(
    surface: &Surface,
    level_m: f64,
    progress: &Progress,
) -> Result<Vec<[CellEdge; 2]>, Cancelled> {
    let mut cuts = Vec::new();
    for row in 0..surface.grid.rows {
        progress.check()?;
        for column in 0..surface.grid.columns {
            if let Some(square) = square(surface, row, column) {
                cuts.extend(square.cuts(level_m).into_iter().flatten());
            }
        }
    }
    Ok(cuts)
}

/// Joins cuts at the edges that they share. On every edge at most one cut ends and one begins.
pub(super) fn join<E: Copy + Eq + Hash>(cuts: &[[E; 2]]) -> Vec<Vec<E>> {
    let mut next: HashMap<E, E> = cuts.iter().map(|[from, to]| (*from, *to)).collect();
    let ends: HashSet<E> = cuts.iter().map(|[_, to]| *to).collect();
    let begins = || cuts.iter().map(|[from, _]| *from);
    let mut lines = Vec::new();
    // Open lines first, so that what is left is rings.
    for begin in begins().filter(|from| !ends.contains(from)).chain(begins()) {
        let mut line = vec![begin];
        let mut at = begin;
        while let Some(to) = next.remove(&at) {
            line.push(to);
            at = to;
        }
        if line.len() > 1 {
            lines.push(line);
        }
    }
    lines
}

/// Returns the line through some edges; `None` where all of a ring is one place: a summit that just
/// touches the level.
fn place(surface: &Surface, level_m: f64, edges: &[CellEdge]) -> Option<Isobath> {
    let mut points: Vec<[f64; 2]> =
        edges.iter().map(|edge| crossing(surface, *edge, level_m)).collect();
    // A line through the centre of a cell crosses several edges there.
    points.dedup();
    (points.len() > 1).then_some(Isobath { depth_m: level_m, points })
}

/// Settings for cutting the corners of lines.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Smoothing {
    /// Number of passes.
    pub passes: u32,
    /// True if a corner is cut only where this moves the line toward deeper water, so that nothing
    /// shallower comes to lie beyond it.
    pub toward_deep: bool,
}

/// Cuts the corners of a line (Chaikin 1974): each pass puts two points at a quarter and three
/// quarters of every step and leaves the corners out. The ends of an open line stay; a ring, which
/// ends where it began, stays one. The line moves by up to a quarter of a step.
pub fn smoothed(points: &[[f64; 2]], smoothing: Smoothing) -> Vec<[f64; 2]> {
    let mut line = points.to_vec();
    for _ in 0..smoothing.passes {
        line = cut_corners(&line, smoothing.toward_deep);
    }
    line
}

fn cut_corners(line: &[[f64; 2]], toward_deep: bool) -> Vec<[f64; 2]> {
    let count = line.len();
    if count < 3 {
        return line.to_vec();
    }
    let is_ring = line[0] == line[count - 1];
    let mut cut = Vec::with_capacity(2 * count);
    let mut corner = |before: [f64; 2], at: [f64; 2], after: [f64; 2]| {
        // The deeper side is on the left: cutting a turn to the left moves the line that way.
        if !toward_deep || turns_left(before, at, after) {
            cut.extend([between(before, at, 0.75), between(at, after, 0.25)])
        } else {
            cut.push(at)
        }
    };
    if is_ring {
        // The last point is the first one, whose corner lies between the last step and the first.
        corner(line[count - 2], line[0], line[1]);
    }
    line.windows(3).for_each(|three| corner(three[0], three[1], three[2]));
    let ends = if is_ring { [cut[0]; 2] } else { [line[0], line[count - 1]] };
    if !is_ring {
        cut.insert(0, ends[0]);
    }
    cut.push(ends[1]);
    cut
}

fn turns_left(before: [f64; 2], at: [f64; 2], after: [f64; 2]) -> bool {
    let [come, go] = [[before, at], [at, after]].map(|[a, b]| [b[0] - a[0], b[1] - a[1]]);
    come[0] * go[1] - come[1] * go[0] > 0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    fn passes(passes: u32) -> Smoothing {
        Smoothing { passes, toward_deep: false }
    }

    fn area(ring: &[[f64; 2]]) -> f64 {
        let steps = ring.windows(2);
        steps.map(|s| 0.5 * (s[0][0] * s[1][1] - s[1][0] * s[0][1])).sum()
    }

    #[test]
    fn ends_stay_and_corners_go() {
        let bend = [[0.0, 0.0], [4.0, 0.0], [4.0, 4.0]];
        let once = [[0.0, 0.0], [3.0, 0.0], [4.0, 1.0], [4.0, 4.0]];
        assert_eq!(smoothed(&bend, passes(1)), once);
        assert_eq!(smoothed(&bend, passes(0)), bend);
        assert_eq!(smoothed(&bend[..2], passes(5)), bend[..2]);
    }

    #[test]
    fn a_ring_stays_closed_and_shrinks_to_the_known_area() {
        let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [0.0, 0.0]];
        let ring = smoothed(&square, passes(8));
        assert_eq!(ring.first(), ring.last());
        // Chaikin's curve is the quadratic B-spline: of a unit square, 5/6.
        assert!((area(&ring) - 5.0 / 6.0).abs() < 1e-4);
    }

    #[test]
    fn toward_deep_water_a_hole_shrinks_and_a_shoal_only_grows() {
        let safe = Smoothing { passes: 3, toward_deep: true };
        // Deeper on the left: counter-clockwise around a hole, clockwise around a shoal.
        let hole = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [0.0, 0.0]];
        assert!(area(&smoothed(&hole, safe)) < 0.9);
        let shoal: Vec<[f64; 2]> = hole.into_iter().rev().collect();
        assert_eq!(smoothed(&shoal, safe), shoal);
        // The water south of this line to the east is shallow: only its bend to the left moves, to
        // the north, and the bend to the right stays.
        let line = [[0.0, 0.0], [4.0, 0.0], [8.0, 4.0], [12.0, 4.0]];
        let moved = smoothed(&line, safe);
        assert!(moved.contains(&[8.0, 4.0]) && !moved.contains(&[4.0, 0.0]), "{moved:?}");
        assert_eq!([moved[0], moved[moved.len() - 1]], [line[0], line[3]]);
    }
}
