//! Marching squares: where a level cuts the squares whose corners are the centres of four cells.

use crate::bathymetry::Surface;

/// An edge between the centres of two neighbouring cells: twice the index of its western or
/// northern cell, and one more where it runs south.
pub(super) type CellEdge = usize;

/// A square of four centres, all of known depth.
#[derive(Clone, Copy)]
pub(super) struct Square {
    /// Index of its north-western cell.
    pub cell: usize,
    /// Depths north-west, north-east, south-east, south-west.
    pub depths_m: [f64; 4],
    columns: usize,
}

/// Cuts of one square: at most two, each from edge to edge with the deeper side on the left.
pub(super) type Cuts = [Option<[CellEdge; 2]>; 2];

// Sides of a square.
const N: usize = 0;
const E: usize = 1;
const S: usize = 2;
const W: usize = 3;

/// The square whose north-western cell this is; `None` where a depth is unknown or the grid ends.
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
    /// Edges to the north, east, south and west.
    pub(super) fn edges(&self) -> [CellEdge; 4] {
        let [north, south] = [self.cell, self.cell + self.columns].map(|cell| 2 * cell);
        [north, north + 3, south, north + 1]
    }

    /// Cells at the corners: north-west, north-east, south-east, south-west.
    pub(super) fn corners(&self) -> [usize; 4] {
        let south = self.cell + self.columns;
        [self.cell, self.cell + 1, south + 1, south]
    }

    /// Cuts at a level. A corner at the level counts as deeper; of a saddle, the corners on the
    /// side of the mean of the four are joined.
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

/// East and north of the place on an edge where the depth is `level_m`, linear between its ends.
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
