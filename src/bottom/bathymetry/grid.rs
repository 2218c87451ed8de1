//! Defines the grid of squares that a surface is sampled on and a mosaic drawn on, and the source
//! of the depth in each square.

use super::DepthPoint;
use crate::presentation::colours::{Rgb, SOURCES};
use crate::presentation::ticks;
use bathyscope_log::support::outline::bounds;
use rayon::prelude::*;

/// Smallest cell that is chosen for a survey, metres: recorders place their soundings no better.
const LEAST_CELL_M: f64 = 0.1;
/// Largest number of cells of a grid. A surface takes 12 bytes of each, and its products as many
/// again.
const MOST_CELLS: f64 = 20e6;

/// A grid of square cells, north up: row 0 is the northernmost, column 0 the westernmost.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grid {
    /// East coordinate of the west edge of the first column, metres.
    pub west_m: f64,
    /// North coordinate of the north edge of the first row, metres.
    pub north_m: f64,
    /// Side of a cell, metres.
    pub cell_m: f64,
    /// Number of cells from west to east.
    pub columns: usize,
    /// Number of cells from north to south.
    pub rows: usize,
}

impl Grid {
    /// Creates a grid from its north-western corner, the side of a cell, and its columns and rows.
    #[cfg(test)]
    pub fn at([west_m, north_m]: [f64; 2], cell_m: f64, [columns, rows]: [usize; 2]) -> Self {
        Self { west_m, north_m, cell_m, columns, rows }
    }

    /// Creates a grid over all points. Its cells have the side `cell_m`, or a larger one where
    /// there would be more than `max_side` of them along the longer side, or more than some 20
    /// million in all. Edges lie on multiples of the cell, so that grids of several surveys fit
    /// onto each other. `None` without points, and where the side of the cells would not be finite
    /// and positive.
    pub(crate) fn over(points: &[DepthPoint], cell_m: f64, max_side: usize) -> Option<Self> {
        let [west_m, south_m, east_m, north_m] = bounds(points.iter().map(DepthPoint::place));
        let extent_m = (east_m - west_m).max(north_m - south_m);
        // Two cells less, for the edges that are rounded outwards.
        let least_m = extent_m / max_side.saturating_sub(2).max(1) as f64;
        let area_m2 = (east_m - west_m) * (north_m - south_m);
        let cell_m = cell_m.max(least_m).max((area_m2 / MOST_CELLS).sqrt());
        if !(cell_m > 0.0 && cell_m.is_finite()) {
            return None;
        }
        let [west, south] = [west_m, south_m].map(|metres| (metres / cell_m).floor());
        let [east, north] = [east_m, north_m].map(|metres| (metres / cell_m).ceil());
        // A single place on an edge has its cell to the north-east.
        let cells = |from: f64, to: f64| ((to - from) as usize).max(1);
        let rows = cells(south, north);
        Some(Self {
            west_m: west * cell_m,
            north_m: (south + rows as f64) * cell_m,
            cell_m,
            columns: cells(west, east),
            rows,
        })
    }

    /// Returns the west, south, east and north edge, metres.
    pub fn bounds_m(&self) -> [f64; 4] {
        let [across_m, down_m] = [self.columns, self.rows].map(|cells| cells as f64 * self.cell_m);
        let [south_m, east_m] = [self.north_m - down_m, self.west_m + across_m];
        [self.west_m, south_m, east_m, self.north_m]
    }

    /// Returns east and north of the centre of a cell, metres.
    pub fn centre(&self, row: usize, column: usize) -> [f64; 2] {
        [
            self.west_m + (column as f64 + 0.5) * self.cell_m,
            self.north_m - (row as f64 + 0.5) * self.cell_m,
        ]
    }

    /// Returns east and north of the centre of the cell with an index, metres.
    pub fn centre_of(&self, cell: usize) -> [f64; 2] {
        self.centre(cell / self.columns, cell % self.columns)
    }

    /// Returns the index of the cell at a place, row by row; `None` outside.
    pub fn index_at(&self, east_m: f64, north_m: f64) -> Option<usize> {
        let inside = |cells: f64, count: usize| {
            // The outermost points lie on the edges, up to rounding.
            let is_inside = (-1e-9..=count as f64 + 1e-9).contains(&cells);
            is_inside.then(|| (cells.max(0.0) as usize).min(count - 1))
        };
        let column = inside((east_m - self.west_m) / self.cell_m, self.columns)?;
        let row = inside((self.north_m - north_m) / self.cell_m, self.rows)?;
        Some(row * self.columns + column)
    }

    /// Returns the indices of the cells whose centres lie within a distance of a place.
    pub(super) fn cells_within(
        &self,
        [east_m, north_m]: [f64; 2],
        reach_m: f64,
    ) -> impl Iterator<Item = usize> {
        let grid = *self;
        let span = |least_m: f64, most_m: f64, count: usize| {
            let cell = |metres: f64| ((metres / grid.cell_m).max(0.0) as usize).min(count);
            cell(least_m)..cell(most_m + grid.cell_m)
        };
        let [east_m, south_m] = [east_m - self.west_m, self.north_m - north_m];
        let columns = span(east_m - reach_m, east_m + reach_m, self.columns);
        let rows = span(south_m - reach_m, south_m + reach_m, self.rows);
        let cells = rows.flat_map(move |row| columns.clone().map(move |column| (row, column)));
        let from = move |(row, column): (usize, usize)| {
            let off_cells = [(east_m, column), (south_m, row)]
                .map(|(metres, cell)| cell as f64 + 0.5 - metres / grid.cell_m);
            off_cells[0].hypot(off_cells[1]) * grid.cell_m
        };
        let near = cells.filter(move |cell| from(*cell) <= reach_m);
        near.map(move |(row, column)| row * grid.columns + column)
    }

    /// Returns the grid with cells `times` as long; its far edges may lie beyond those of this
    /// grid.
    #[must_use]
    pub fn coarser(&self, times: usize) -> Self {
        Self {
            cell_m: self.cell_m * times as f64,
            columns: self.columns.div_ceil(times),
            rows: self.rows.div_ceil(times),
            ..*self
        }
    }

    /// Returns the least factor on the side of a cell with which there are at most `most` cells.
    pub fn times_coarser(&self, most: usize) -> usize {
        let mut times = 1;
        while self.coarser(times).len() > most.max(1) {
            times += 1;
        }
        times
    }

    /// Returns the rows and the columns before and behind a place, and the way from the centre of
    /// the first to the place, as a share of the way to the centre of the second: below 0 and above
    /// 1 beyond the outermost centres. Rows count from the north.
    pub fn about(&self, [east_m, north_m]: [f64; 2]) -> [CentresAbout; 2] {
        [
            CentresAbout::of((self.north_m - north_m) / self.cell_m, self.rows),
            CentresAbout::of((east_m - self.west_m) / self.cell_m, self.columns),
        ]
    }

    /// Number of cells.
    pub fn len(&self) -> usize {
        self.columns * self.rows
    }

    /// Returns true if there is no cell.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// Two neighbouring rows or columns about a place; the same one twice where there is only one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CentresAbout {
    /// Index of the first, and of the second.
    pub cells: [usize; 2],
    /// Way from the centre of the first to the place, in cells.
    pub share: f64,
}

impl CentresAbout {
    fn of(cells: f64, count: usize) -> Self {
        let last = count.saturating_sub(1);
        let from_centre = cells - 0.5;
        let before = (from_centre.max(0.0) as usize).min(last.saturating_sub(1));
        Self { cells: [before, (before + 1).min(last)], share: from_centre - before as f64 }
    }
}

/// Returns the side of a cell that suits the data, metres: half of the mean distance `sqrt(area /
/// places)` between places of soundings, rounded down to 1, 2 or 5 times a power of ten and at
/// least 0.1 m. The area is that of the squares of `gap_m` that hold a sounding, since beyond the
/// gap there will be no surface. `None` without points.
pub(crate) fn suited_cell_m(points: &[DepthPoint], gap_m: f64) -> Option<f64> {
    let places = occupied(points, LEAST_CELL_M);
    let area_m2 = occupied(points, gap_m) as f64 * gap_m * gap_m;
    let half_m = 0.5 * (area_m2 / places as f64).sqrt();
    (places > 0 && half_m.is_finite()).then(|| ticks::round_down(half_m).max(LEAST_CELL_M))
}

/// Returns the number of squares of a side, at least [`LEAST_CELL_M`], that hold a point.
fn occupied(points: &[DepthPoint], side_m: f64) -> usize {
    let square = |point: &DepthPoint| {
        // Distances on the earth divided by the least cell fit into 32 bits.
        point.place().map(|metres| (metres / side_m).floor() as i32)
    };
    // Sorted: a set of the squares would take several times the memory.
    let mut squares: Vec<[i32; 2]> = points.iter().map(square).collect();
    squares.par_sort_unstable();
    squares.chunk_by(|a, b| a == b).count()
}

/// The source of the depth in a cell. The numbers are those of `depth/source.tif`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[repr(u8)]
pub enum CellSource {
    /// No depth is known.
    #[default]
    None = 0,
    /// No depth was measured in the cell: it is interpolated between measured depths.
    Interpolated = 1,
    /// No depth was measured in the cell, but the levels of its echoes determine its slope:
    /// inferred, not measured.
    FromLevels = 2,
    /// A first return of the side-scan lies in the cell, and no sounding.
    FirstReturn = 3,
    /// A depth of the recorder, under the boat or across the track, or of a reference lies in the
    /// cell.
    Sounding = 4,
}

impl CellSource {
    /// The sources that a depth can have.
    pub const KNOWN: [Self; 4] =
        [Self::Sounding, Self::FirstReturn, Self::FromLevels, Self::Interpolated];

    /// Returns the name of the source for legends and tables: a word or two.
    pub fn name(self) -> &'static str {
        match self {
            Self::None => "unknown",
            Self::Interpolated => "interpolated",
            Self::FromLevels => "from levels",
            Self::FirstReturn => "first return",
            Self::Sounding => "sounding",
        }
    }

    /// Returns the number, name and colour of the sources that a depth can have, for rasters of
    /// sources.
    pub fn classes() -> [(u8, &'static str, Rgb); 4] {
        let class = |index: usize| {
            let source = Self::KNOWN[index];
            (source as u8, source.name(), SOURCES[index])
        };
        std::array::from_fn(class)
    }
}

/// Returns the best source measured in each cell of a grid; points without weight do not count.
pub(super) fn measured_cells(points: &[DepthPoint], grid: &Grid) -> Vec<CellSource> {
    let mut cells = vec![CellSource::None; grid.len()];
    for point in points.iter().filter(|point| point.weight > 0.0) {
        let index = grid.index_at(point.east_m, point.north_m);
        if let Some(cell) = index.and_then(|index| cells.get_mut(index)) {
            *cell = (*cell).max(if point.is_sounding {
                CellSource::Sounding
            } else {
                CellSource::FirstReturn
            });
        }
    }
    cells
}

/// Marks every cell that has a depth but no measured one as interpolated, and every cell without a
/// depth as unknown.
pub(super) fn settle(sources: &mut [CellSource], depth_m: &[f32]) {
    for (source, depth_m) in sources.iter_mut().zip(depth_m) {
        *source = match (depth_m.is_nan(), *source) {
            (true, _) => CellSource::None,
            (false, CellSource::None) => CellSource::Interpolated,
            (false, measured) => measured,
        };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lines(spacing_m: f64, step_m: f64) -> Vec<DepthPoint> {
        let along = 1 + (400.0 / step_m) as usize;
        (0..11 * along)
            .map(|i| {
                DepthPoint::of_sounding(
                    [step_m * (i % along) as f64, spacing_m * (i / along) as f64],
                    1.0,
                )
            })
            .collect()
    }

    #[test]
    fn denser_soundings_give_smaller_cells() {
        // sqrt(20 m x 1 m) / 2 is 2.2 m; sqrt(5 x 0.2) / 2 is 0.5 m; repeats change nothing.
        assert_eq!(suited_cell_m(&lines(20.0, 1.0), 20.0), Some(2.0));
        assert_eq!(suited_cell_m(&lines(5.0, 0.2), 5.0), Some(0.5));
        assert_eq!(suited_cell_m(&lines(20.0, 1.0).repeat(3), 20.0), Some(2.0));
        assert_eq!(suited_cell_m(&[], 20.0), None);
    }

    #[test]
    fn a_grid_holds_its_points_and_not_too_many_cells() {
        let points = lines(20.0, 1.0);
        for (cell_m, max_side) in [(2.0, 4096), (0.01, 300), (7.3, 4096), (0.1, 9000)] {
            let grid = Grid::over(&points, cell_m, max_side).unwrap();
            assert!(grid.columns.max(grid.rows) <= max_side && grid.cell_m >= cell_m);
            for point in &points {
                let index = grid.index_at(point.east_m, point.north_m).unwrap();
                let [east_m, north_m] = grid.centre_of(index);
                let off_m = (east_m - point.east_m).abs().max((north_m - point.north_m).abs());
                assert!(off_m <= 0.5 * grid.cell_m + 1e-9, "{off_m}");
            }
            assert_eq!(grid.index_at(grid.west_m - 0.1, 1.0), None);
        }
        assert_eq!(Grid::over(&[], 1.0, 10), None);
        let single = &points[..1];
        assert_eq!(Grid::over(single, 0.5, 10).map(|grid| grid.len()), Some(1));
        assert_eq!(Grid::over(single, 0.0, 10), None);
    }

    #[test]
    fn a_cell_says_the_best_that_lies_in_it() {
        let grid = Grid::at([0.0, 1.0], 1.0, [5, 1]);
        let point = |east_m, is_sounding, weight| DepthPoint {
            weight,
            is_sounding,
            ..DepthPoint::of_sounding([east_m, 0.5], 2.0)
        };
        let points = [
            point(0.2, false, 1.0),
            point(0.7, true, 0.5),
            point(1.5, false, 1.0),
            point(2.5, true, 0.0),
            point(3.5, true, 1.0),
        ];
        let mut sources = measured_cells(&points, &grid);
        settle(&mut sources, &[2.0, 2.0, 2.0, f32::NAN, f32::NAN]);
        let expected = [
            CellSource::Sounding,
            CellSource::FirstReturn,
            CellSource::Interpolated,
            CellSource::None,
            CellSource::None,
        ];
        assert_eq!(sources, expected);
    }
}
