//! Draws isobaths: cuts the squares whose corners are the centres of four cells at one level
//! (marching squares), joins the cuts, and rounds the lines for those who prefer looks to
//! exactness. Cuts lines at the edges of tiles, and joins them again.

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

/// Least length of a part, metres: shorter parts, rounded to the millimetre of the files, are no
/// lines any more.
pub(super) const LEAST_LENGTH_M: f64 = 0.01;

/// Returns the parts of a line that lie in a box (west, south, east, north). Where a line leaves a
/// box and enters the next one, the place is exactly the same in both.
pub fn clipped(line: &Isobath, bounds: [f64; 4]) -> Vec<Isobath> {
    let mut parts: Vec<Vec<[f64; 2]>> = Vec::new();
    for step in line.points.windows(2) {
        let Some([from, to]) = clipped_step([step[0], step[1]], bounds) else {
            continue;
        };
        match parts.last_mut() {
            Some(part) if part.last() == Some(&from) => part.push(to),
            _ => parts.push(vec![from, to]),
        }
    }
    let parts = parts.into_iter().map(|mut points| {
        points.dedup();
        Isobath { depth_m: line.depth_m, points }
    });
    parts.filter(|part| part.length_m() > LEAST_LENGTH_M).collect()
}

/// Returns the part of a step in a box (Liang and Barsky 1984); `None` where they do not meet.
fn clipped_step(
    [from, to]: [[f64; 2]; 2],
    [west, south, east, north]: [f64; 4],
) -> Option<[[f64; 2]; 2]> {
    // Most steps lie beyond one edge.
    let lies_beyond = |axis: usize, low: f64, high: f64| {
        from[axis].max(to[axis]) < low || from[axis].min(to[axis]) > high
    };
    if lies_beyond(0, west, east) || lies_beyond(1, south, north) {
        return None;
    }
    let way = [to[0] - from[0], to[1] - from[1]];
    // Shares of the step at which it enters and leaves, and the edges there.
    let mut entry: (f64, Option<(usize, f64)>) = (0.0, None);
    let mut exit: (f64, Option<(usize, f64)>) = (1.0, None);
    for (axis, low, high) in [(0, west, east), (1, south, north)] {
        if way[axis] == 0.0 {
            if !(low..=high).contains(&from[axis]) {
                return None;
            }
            continue;
        }
        let (near, far) = if way[axis] > 0.0 { (low, high) } else { (high, low) };
        let share = |edge: f64| (edge - from[axis]) / way[axis];
        if share(near) > entry.0 {
            entry = (share(near), Some((axis, near)));
        }
        if share(far) < exit.0 {
            exit = (share(far), Some((axis, far)));
        }
    }
    let at = |(share, edge): (f64, Option<(usize, f64)>), end: [f64; 2]| match edge {
        None => end,
        Some((axis, edge)) => {
            let mut place = [0, 1].map(|axis| from[axis] + share * way[axis]);
            place[axis] = edge;
            place
        }
    };
    (entry.0 < exit.0).then(|| [at(entry, from), at(exit, to)])
}

/// Depth and place of the start or end of a piece, as bits.
type End = [u64; 3];

/// Joins pieces to lines: a piece that ends where another piece of its depth begins continues with
/// it. A piece that begins where an earlier one of its depth does stays apart.
pub fn joined(pieces: Vec<Isobath>) -> Vec<Isobath> {
    let end = |depth_m: f64, [x, y]: [f64; 2]| -> End { [depth_m, x, y].map(f64::to_bits) };
    let (mut by_begin, mut links, mut lines) = (HashMap::new(), Vec::new(), Vec::new());
    for piece in pieces {
        let (Some(&first), Some(&last)) = (piece.points.first(), piece.points.last()) else {
            continue;
        };
        let [begin, end] = [first, last].map(|place| end(piece.depth_m, place));
        if begin == end || by_begin.contains_key(&begin) {
            lines.push(piece)
        } else {
            links.push([begin, end]);
            by_begin.insert(begin, piece);
        }
    }
    for ends in join(&links) {
        let mut parts = ends.iter().filter_map(|begin| by_begin.remove(begin));
        let Some(mut line) = parts.next() else {
            continue;
        };
        for part in parts {
            line.points.extend(part.points.into_iter().skip(1));
        }
        lines.push(line);
    }
    lines
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

    #[test]
    fn what_leaves_one_tile_enters_the_next_at_the_same_place() {
        let line = Isobath {
            depth_m: 2.0,
            points: vec![[1.0, 1.0], [9.3, 4.7], [11.7, 5.9], [8.0, 8.0], [7.0, 12.0], [6.0, 9.0]],
        };
        let west = clipped(&line, [0.0, 0.0, 10.0, 10.0]);
        let east = clipped(&line, [10.0, 0.0, 20.0, 10.0]);
        assert_eq!(west.len(), 3);
        assert_eq!(east.len(), 1);
        assert_eq!(west[0].points.last(), east[0].points.first());
        assert_eq!(east[0].points.last(), west[1].points.first());
        assert_eq!(east[0].points[0][0], 10.0);
        assert_eq!(west[1].points.last().map(|at| at[1]), Some(10.0));
        assert_eq!(clipped(&line, [20.0, 0.0, 30.0, 10.0]), []);
        assert_eq!(clipped(&line, [0.0, 0.0, 20.0, 20.0]), [line]);
        let short = Isobath { depth_m: 2.0, points: vec![[1.0, 1.0], [1.001, 1.0]] };
        assert_eq!(clipped(&short, [0.0, 0.0, 20.0, 20.0]), []);
    }

    #[test]
    fn what_was_cut_is_joined_again() {
        let line = Isobath {
            depth_m: 2.0,
            points: vec![[1.0, 1.0], [9.3, 4.7], [21.7, 5.9], [8.0, 8.0], [7.0, 9.0]],
        };
        let ring = Isobath {
            depth_m: 2.0,
            points: vec![[3.0, 3.0], [17.0, 3.0], [17.0, 7.0], [3.0, 3.0]],
        };
        let boxes = [[20.0, 0.0, 30.0, 10.0], [0.0, 0.0, 10.0, 10.0], [10.0, 0.0, 20.0, 10.0]];
        let cut = |line: &Isobath| -> Vec<Isobath> {
            boxes.iter().flat_map(|tile| clipped(line, *tile)).collect()
        };
        let pieces = cut(&line);
        assert_eq!(pieces.len(), 5);
        let back = joined(pieces);
        assert_eq!(back.len(), 1);
        assert!((back[0].length_m() - line.length_m()).abs() < 1e-9);
        assert_eq!((back[0].points[0], back[0].points.last()), ([1.0, 1.0], Some(&[7.0, 9.0])));
        let back = joined(cut(&ring));
        assert_eq!(back.len(), 1);
        assert!(back[0].is_ring() && (back[0].length_m() - ring.length_m()).abs() < 1e-9);
        let other = Isobath { depth_m: 3.0, points: vec![[7.0, 9.0], [1.0, 9.0]] };
        assert_eq!(joined(vec![line.clone(), other.clone(), ring.clone()]).len(), 3);
        assert_eq!(joined(vec![line.clone(), line]).len(), 2);
    }
}
