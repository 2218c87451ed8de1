//! Finds the water that a plan may use: within a polygon, or within the outline of the sailed
//! water.

use crate::bathymetry::Grid;
use crate::nearest::Nearest;
use bathyscope_log::support::outline::{self, between, edges};
use bathyscope_log::support::statistics::sorted;
use rayon::prelude::*;

/// Least side of a cell, metres: a boat cannot follow a line any better.
const LEAST_CELL_M: f64 = 0.5;
/// Largest number of cells of the water, and of the rectangle around it: above these, the cells are
/// larger.
const MOST_OPEN: usize = 10_000;
const MOST_CELLS: f64 = 400_000.0;
/// Largest number of times that cells are made larger: each time their number fits, except for
/// rounding.
const ATTEMPTS: usize = 12;

/// Cells of open water on a grid.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Water {
    /// Grid of the cells.
    pub grid: Grid,
    open: Vec<bool>,
}

impl Water {
    /// Returns the cells that are completely within rings (a place within an even number of rings
    /// is outside, so that islands are rings too); `None` where there are none.
    pub(super) fn within(rings: &[Vec<[f64; 2]>]) -> Option<Self> {
        let bounds = bounds(rings.iter().flatten().copied())?;
        fitting(bounds, |grid| within_rings(grid, rings))
    }

    /// Returns the ground around soundings with gaps of up to `2 reach_m` closed: every place that
    /// no circle of radius `reach_m` without a sounding in it covers. `None` without soundings.
    pub(super) fn around(soundings: &[[f64; 2]], reach_m: f64) -> Option<Self> {
        let [west, south, east, north] = bounds(soundings.iter().copied())?;
        let pad_m = 1.2 * reach_m;
        let bounds = [west - pad_m, south - pad_m, east + pad_m, north + pad_m];
        fitting(bounds, |grid| closed(grid, soundings, reach_m))
    }

    /// Returns true if a place is in open water.
    pub(super) fn holds(&self, [east_m, north_m]: [f64; 2]) -> bool {
        let cell = self.grid.index_at(east_m, north_m);
        cell.is_some_and(|cell| self.open[cell])
    }

    /// Returns indices and centres of the open cells.
    pub(super) fn cells(&self) -> impl Iterator<Item = (usize, [f64; 2])> {
        let open = (0..).zip(&self.open).filter(|(_, open)| **open);
        open.map(|(cell, _)| (cell, self.grid.centre_of(cell)))
    }
}

/// Returns west, south, east and north of the places; `None` without a finite place.
fn bounds(places: impl Iterator<Item = [f64; 2]>) -> Option<[f64; 4]> {
    let finite = places.filter(|place| place.iter().all(|value| value.is_finite()));
    let bounds = outline::bounds(finite);
    (bounds != outline::NOWHERE).then_some(bounds)
}

/// Returns the water on the finest grid that does not have too many cells; `None` where there is
/// none.
fn fitting(
    [west, south, east, north]: [f64; 4],
    open: impl Fn(&Grid) -> Vec<bool>,
) -> Option<Water> {
    let (width_m, height_m) = (east - west, north - south);
    let mut cell_m = LEAST_CELL_M.max((width_m * height_m / MOST_CELLS).sqrt());
    for _ in 0..ATTEMPTS {
        let cells = |length_m: f64| (length_m / cell_m).ceil() as usize + 2;
        let grid = Grid {
            west_m: west - cell_m,
            north_m: north + cell_m,
            cell_m,
            columns: cells(width_m),
            rows: cells(height_m),
        };
        let open = open(&grid);
        let count = open.iter().filter(|open| **open).count();
        match count {
            0 => return None,
            _ if count <= MOST_OPEN => return Some(Water { grid, open }),
            _ => cell_m *= 1.02 * (count as f64 / MOST_OPEN as f64).sqrt(),
        }
    }
    None
}

/// Marks the cells whose centre is in the rings, except those that a ring crosses and their
/// neighbours: the remaining cells are completely inside.
fn within_rings(grid: &Grid, rings: &[Vec<[f64; 2]>]) -> Vec<bool> {
    let mut open = vec![false; grid.len()];
    let rows = open.par_chunks_mut(grid.columns.max(1)).enumerate();
    rows.for_each(|(row, cells)| {
        let north_m = grid.centre(row, 0)[1];
        let crossings = sorted(rings.iter().flat_map(|ring| crossed(ring, north_m)));
        for between in crossings.chunks_exact(2) {
            for (column, cell) in cells.iter_mut().enumerate() {
                let east_m = grid.centre(row, column)[0];
                *cell |= between[0] < east_m && east_m < between[1];
            }
        }
    });
    for ring in rings {
        for [from, to] in edges(ring) {
            let length_m = (to[0] - from[0]).hypot(to[1] - from[1]);
            let count = (2.0 * length_m / grid.cell_m).ceil().min(1e7) as usize;
            for step in 0..=count {
                let share = step as f64 / count.max(1) as f64;
                close_about(grid, between(from, to, share), &mut open);
            }
        }
    }
    open
}

/// Returns the places where a ring crosses a parallel, metres east.
fn crossed(ring: &[[f64; 2]], north_m: f64) -> impl Iterator<Item = f64> {
    edges(ring).filter_map(move |[[x0, y0], [x1, y1]]| {
        let crosses = (y0 > north_m) != (y1 > north_m);
        crosses.then(|| x0 + (north_m - y0) / (y1 - y0) * (x1 - x0))
    })
}

/// Marks the cell of a place and the cells around it as closed.
fn close_about(grid: &Grid, [east_m, north_m]: [f64; 2], open: &mut [bool]) {
    let Some(cell) = grid.index_at(east_m, north_m) else {
        return;
    };
    let (row, column) = (cell / grid.columns, cell % grid.columns);
    for near in row.saturating_sub(1)..(row + 2).min(grid.rows) {
        let first = near * grid.columns;
        open[first + column.saturating_sub(1)..first + (column + 2).min(grid.columns)].fill(false);
    }
}

/// Computes the morphological closing of the soundings by a circle: the cells within its radius of
/// a sounding, except those within its radius of a cell outside.
fn closed(grid: &Grid, soundings: &[[f64; 2]], reach_m: f64) -> Vec<bool> {
    let Some(near) = Nearest::of(&thinned(soundings, 0.5 * grid.cell_m)) else {
        return vec![false; grid.len()];
    };
    let cells = (0..grid.len()).into_par_iter();
    let reached: Vec<bool> =
        cells.map(|cell| near.distance_m(grid.centre_of(cell)) <= reach_m).collect();
    let is_rim = |cell: &usize| {
        let (row, column) = (cell / grid.columns, cell % grid.columns);
        let beside = [
            (row > 0).then(|| cell - grid.columns),
            (row + 1 < grid.rows).then(|| cell + grid.columns),
            (column > 0).then(|| cell - 1),
            (column + 1 < grid.columns).then(|| cell + 1),
        ];
        !reached[*cell] && beside.into_iter().flatten().any(|cell| reached[cell])
    };
    let rim: Vec<[f64; 2]> =
        (0..grid.len()).filter(is_rim).map(|cell| grid.centre_of(cell)).collect();
    let Some(rim) = Nearest::of(&rim) else {
        return reached;
    };
    // The outermost lines themselves are on the boundary, and must not be lost by half a cell of
    // rounding.
    let inner_m = reach_m - 0.5 * grid.cell_m;
    let cells = reached.par_iter().enumerate();
    cells
        .map(|(cell, reached)| *reached && rim.distance_m(grid.centre_of(cell)) >= inner_m)
        .collect()
}

/// Returns one of the places in each square with sides of `side_m` metres, without places that are
/// not finite.
pub(super) fn thinned(places: &[[f64; 2]], side_m: f64) -> Vec<[f64; 2]> {
    let square = |place: &[f64; 2]| place.map(|metres| (metres / side_m).floor() as i64);
    let finite = |place: &&[f64; 2]| place.iter().all(|value| value.is_finite());
    let mut places: Vec<[f64; 2]> = places.iter().filter(finite).copied().collect();
    places.sort_by(|a, b| {
        let squares = square(a).cmp(&square(b));
        squares.then(a[0].total_cmp(&b[0])).then(a[1].total_cmp(&b[1]))
    });
    places.dedup_by_key(|place| square(place));
    places
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_of_a_polygon_with_an_island_lie_in_it_wholly() {
        let ring = |half_m: f64| {
            vec![[-half_m, -half_m], [half_m, -half_m], [1.2 * half_m, half_m], [-half_m, half_m]]
        };
        let rings = [ring(40.0), ring(8.0)];
        let water = Water::within(&rings).unwrap();
        let inside = |[x, y]: [f64; 2]| {
            let crossings = rings.iter().flat_map(|ring| crossed(ring, y));
            crossings.filter(|east_m| *east_m > x).count() % 2 == 1
        };
        let half_m = 0.5 * water.grid.cell_m;
        let mut area_m2 = 0.0;
        for (_, [x, y]) in water.cells() {
            area_m2 += water.grid.cell_m.powi(2);
            for (dx, dy) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
                assert!(inside([x + dx * half_m, y + dy * half_m]));
            }
        }
        let all_m2 = 80.0 * 84.0 - 16.0 * 16.8;
        // A strip of two cells along the sides is not open.
        let sides_m = rings.iter().flat_map(|ring| edges(ring));
        let sides_m: f64 = sides_m.map(|[[x, y], [to_x, to_y]]| (to_x - x).hypot(to_y - y)).sum();
        let closed_m2 = 2.0 * water.grid.cell_m * sides_m;
        assert!(area_m2 > all_m2 - closed_m2 && area_m2 < all_m2, "{area_m2} {closed_m2}");
        assert!(!water.holds([0.0, 0.0]) && water.holds([20.0, 0.0]) && !water.holds([60.0, 0.0]));
    }

    #[test]
    fn a_missing_strip_is_closed_and_the_outside_of_a_bend_is_not() {
        // Lines 10 m apart, two of them missing; then a leg far to the north.
        let mut soundings = Vec::new();
        for line in [0.0, 10.0, 40.0, 50.0] {
            soundings.extend((0..=100).map(|step| [f64::from(step), line]));
        }
        soundings.extend((50..=200).map(|step| [0.0, f64::from(step)]));
        let water = Water::around(&soundings, 30.0).unwrap();
        assert!(water.holds([50.0, 25.0]), "the strip");
        assert!(water.holds([50.0, 0.0]) && water.holds([0.0, 150.0]), "what was sailed");
        assert!(!water.holds([80.0, 120.0]), "beyond");
        assert!(!water.holds([50.0, -4.0]) && !water.holds([-4.0, 150.0]));
    }

    #[test]
    fn a_large_survey_has_larger_cells() {
        let soundings: Vec<[f64; 2]> = (0..40_000)
            .map(|index| [f64::from(index % 200) * 20.0, f64::from(index / 200) * 20.0])
            .collect();
        let water = Water::around(&soundings, 30.0).unwrap();
        let count = water.cells().count();
        assert!((MOST_OPEN / 2..=MOST_OPEN).contains(&count), "{count}");
        assert!(Water::around(&[], 30.0).is_none() && Water::within(&[]).is_none());
    }
}
