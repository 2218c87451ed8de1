//! Samples surfaces along a line, resamples them to larger and smaller cells, computes the
//! direction that they face, and extends them over more ground than was measured: the picture of a
//! side-scan reaches farther than the depths do, and is laid on a flat extrapolation of the depths.

use super::{CellSource, Grid, Surface};
use rayon::prelude::*;

/// Corner of a line on the ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Corner {
    /// East and north in the plane of the survey, metres.
    pub place: [f64; 2],
    /// Distance on the ground from the start of the line, metres.
    pub distance_m: f64,
}

/// Place on a line, and the depth there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TransectStation {
    /// Distance on the ground from the start of the line, metres.
    pub distance_m: f64,
    /// East and north in the plane of the survey, metres.
    pub place: [f64; 2],
    /// Depth, metres; `None` where nothing is known.
    pub depth_m: Option<f32>,
}

/// Returns the depth at every corner of a line, and between two corners at equal steps of at most
/// `step_m`; the steps are larger where the whole line would have more than `most` stations.
pub fn transect(
    corners: &[Corner],
    step_m: f64,
    most: usize,
    depth_at: impl Fn([f64; 2]) -> Option<f32>,
) -> Vec<TransectStation> {
    let length_m = corners.last().map_or(0.0, |last| last.distance_m);
    let step_m = step_m.max(length_m / most.max(1) as f64);
    if !(step_m > 0.0 && length_m.is_finite()) {
        return Vec::new();
    }
    let station =
        |distance_m, place| TransectStation { distance_m, place, depth_m: depth_at(place) };
    let first = corners.first().map(|first| station(first.distance_m, first.place));
    let legs = corners.windows(2).flat_map(|leg| {
        let (from, to) = (leg[0], leg[1]);
        let steps = ((to.distance_m - from.distance_m) / step_m).ceil().max(1.0) as usize;
        (1..=steps).map(move |step| {
            let share = step as f64 / steps as f64;
            let on = |from: f64, to: f64| from + (to - from) * share;
            let place = [0, 1].map(|axis| on(from.place[axis], to.place[axis]));
            (on(from.distance_m, to.distance_m), place)
        })
    });
    let rest = legs.map(|(distance_m, place)| station(distance_m, place));
    first.into_iter().chain(rest).collect()
}

impl Grid {
    /// Returns the grid with the same cells that covers a box, too: west, south, east and north
    /// edge, metres.
    #[must_use]
    pub fn reaching(&self, [west_m, south_m, east_m, north_m]: [f64; 4]) -> Self {
        let cells = |metres: f64| (metres / self.cell_m).ceil().max(0.0) as usize;
        let [columns, rows] = [self.columns, self.rows].map(|count| count as f64 * self.cell_m);
        let [west, north] = [cells(self.west_m - west_m), cells(north_m - self.north_m)];
        let [east, south] =
            [cells(east_m - self.west_m - columns), cells(self.north_m - rows - south_m)];
        Self {
            west_m: self.west_m - west as f64 * self.cell_m,
            north_m: self.north_m + north as f64 * self.cell_m,
            columns: west + self.columns + east,
            rows: north + self.rows + south,
            cell_m: self.cell_m,
        }
    }

    /// Returns the grid with `times` cells along the side of each cell.
    #[must_use]
    pub fn finer(&self, times: usize) -> Self {
        Self {
            cell_m: self.cell_m / times as f64,
            columns: self.columns * times,
            rows: self.rows * times,
            ..*self
        }
    }
}

impl Surface {
    /// Returns the depth at a place, bilinear between the centres of the four cells about it;
    /// `None` where one of the cells that count is unknown, so that a gap stays a gap. In the outer
    /// half of the outermost cells the depth is that of their centres.
    pub fn depth_at(&self, place: [f64; 2]) -> Option<f32> {
        let grid = &self.grid;
        grid.index_at(place[0], place[1])?;
        let [rows, columns] = grid.about(place);
        let [down, right] = [rows, columns].map(|about| about.share.clamp(0.0, 1.0));
        let mut depth_m = 0.0;
        for (row, row_share) in rows.cells.into_iter().zip([1.0 - down, down]) {
            for (column, column_share) in columns.cells.into_iter().zip([1.0 - right, right]) {
                let share = row_share * column_share;
                // A place within rounding of a centre counts as on it.
                if share > 1e-9 {
                    let index = row * grid.columns + column;
                    depth_m += share * f64::from(*self.depth_m.get(index)?);
                }
            }
        }
        depth_m.is_finite().then_some(depth_m as f32)
    }

    /// Returns the surface on a grid with the same cells that reaches farther ([`Grid::reaching`]),
    /// with a depth in all cells for which `wanted` returns true. Where no depth is known, it is
    /// the mean of the depths around, over the more ground the farther away they are. Such a cell
    /// has [`CellSource::None`], and neither spread nor distance.
    #[must_use]
    pub fn extrapolated_flat(&self, grid: Grid, wanted: impl Fn(usize) -> bool + Sync) -> Self {
        let numbers = |values: &[f32]| carried(&self.grid, values, &grid, f32::NAN);
        let source = carried(&self.grid, &self.source, &grid, CellSource::None);
        let mut made = self.on_grid(grid, numbers, source);
        let held_m = held(&grid, &made.depth_m);
        let cells = made.depth_m.par_iter_mut().zip(held_m).enumerate();
        cells.for_each(|(cell, (depth_m, held_m))| {
            if depth_m.is_nan() && wanted(cell) {
                *depth_m = held_m;
            }
        });
        made
    }

    /// Returns the surface with `times` cells along the side of each cell: depths are bilinear
    /// between the centres of the cells, where they are known; all other values are those of the
    /// cell.
    #[must_use]
    pub fn finer(&self, times: usize) -> Self {
        if times <= 1 {
            return self.clone();
        }
        let grid = self.grid.finer(times);
        let of_cell = |cell: usize| {
            let [row, column] = [cell / grid.columns, cell % grid.columns];
            row / times * self.grid.columns + column / times
        };
        let numbers = |values: &[f32]| -> Vec<f32> {
            let cells = (0..grid.len()).into_par_iter();
            cells.map(|cell| values[of_cell(cell)]).collect()
        };
        let sources = (0..grid.len()).map(|cell| self.source[of_cell(cell)]);
        let mut made = self.on_grid(grid, numbers, sources.collect());
        let cells = made.depth_m.par_iter_mut().enumerate();
        cells.for_each(|(cell, depth_m)| {
            if !depth_m.is_nan() {
                *depth_m = self.depth_at(grid.centre_of(cell)).unwrap_or(*depth_m);
            }
        });
        made
    }

    /// Returns the surface in cells `times` as long: each holds the mean of the known values of its
    /// parts, and the best of their sources.
    #[must_use]
    pub fn coarser(&self, times: usize) -> Self {
        let grid = self.grid.coarser(times);
        let means = |values: &[f32]| means(&self.grid, values, &grid, times);
        let best = best(&self.grid, &self.source, &grid, times);
        self.on_grid(grid, means, best)
    }

    /// Returns the unit vector perpendicular to the bottom at the centre of a cell: east, north,
    /// up. Differences are taken between known neighbours only; where there are none, and outside
    /// of the grid, the bottom counts as level.
    pub fn normal(&self, row: usize, column: usize) -> [f32; 3] {
        let at = |row: Option<usize>, column: Option<usize>| {
            let (row, column) = (row?, column?);
            let is_inside = row < self.grid.rows && column < self.grid.columns;
            let depth_m = is_inside.then(|| self.depth_m[row * self.grid.columns + column])?;
            (!depth_m.is_nan()).then_some(f64::from(depth_m))
        };
        let (up, down) = (row.checked_sub(1), row.checked_add(1));
        let (left, right) = (column.checked_sub(1), column.checked_add(1));
        let here = at(Some(row), Some(column));
        let cell_m = self.grid.cell_m;
        // Depths grow downwards: a bottom that falls towards the east faces east.
        let east = slope(at(Some(row), left), here, at(Some(row), right), cell_m);
        let north = slope(at(down, Some(column)), here, at(up, Some(column)), cell_m);
        let length = (1.0 + east * east + north * north).sqrt();
        [east / length, north / length, 1.0 / length].map(|part| part as f32)
    }
}

/// Returns the values of a grid on a grid with the same cells that reaches farther; `beyond` in the
/// cells outside of the first.
fn carried<T: Copy>(from: &Grid, values: &[T], to: &Grid, beyond: T) -> Vec<T> {
    let cells = |metres: f64| (metres / to.cell_m).round() as usize;
    let first = cells(to.north_m - from.north_m) * to.columns + cells(from.west_m - to.west_m);
    let mut made = vec![beyond; to.len()];
    for (row, values) in values.chunks(from.columns.max(1)).enumerate() {
        made[first + row * to.columns..][..values.len()].copy_from_slice(values);
    }
    made
}

/// Returns the depths with the unknown ones filled, if any is known: an unknown depth is bilinear
/// between the means of cells twice as long, which are filled in the same way.
fn held(grid: &Grid, depth_m: &[f32]) -> Vec<f32> {
    if grid.len() <= 1 || depth_m.iter().all(|depth_m| !depth_m.is_nan()) {
        return depth_m.to_vec();
    }
    let coarse = grid.coarser(2);
    let around_m = held(&coarse, &means(grid, depth_m, &coarse, 2));
    let around = |place: [f64; 2]| {
        let [rows, columns] = coarse.about(place);
        let between = |[a, b]: [f64; 2], share: f64| a + (b - a) * share.clamp(0.0, 1.0);
        let in_row = |row: usize| {
            let at = |column: usize| f64::from(around_m[row * coarse.columns + column]);
            between(columns.cells.map(at), columns.share)
        };
        between(rows.cells.map(in_row), rows.share) as f32
    };
    let cells = depth_m.par_iter().enumerate();
    let cells = cells.map(
        |(cell, depth_m)| if depth_m.is_nan() { around(grid.centre_of(cell)) } else { *depth_m },
    );
    cells.collect()
}

/// Returns the growth of a value per metre, from its known values before, here and behind; 0 where
/// these are too few.
fn slope(before: Option<f64>, here: Option<f64>, behind: Option<f64>, cell_m: f64) -> f64 {
    match (before, here, behind) {
        (Some(before), _, Some(behind)) => (behind - before) / (2.0 * cell_m),
        (Some(before), Some(here), None) => (here - before) / cell_m,
        (None, Some(here), Some(behind)) => (behind - here) / cell_m,
        _ => 0.0,
    }
}

/// Returns values in larger cells: the mean of the known values of each cell's parts; NaN without
/// any.
fn means(fine: &Grid, values: &[f32], coarse: &Grid, times: usize) -> Vec<f32> {
    let mut made = vec![f32::NAN; coarse.len()];
    made.par_chunks_mut(coarse.columns.max(1)).enumerate().for_each(|(row, made)| {
        let rows = row * times..((row + 1) * times).min(fine.rows);
        for (column, made) in made.iter_mut().enumerate() {
            let columns = column * times..((column + 1) * times).min(fine.columns);
            let parts = rows.clone().flat_map(|row| {
                values[row * fine.columns..][columns.clone()].iter().filter(|value| !value.is_nan())
            });
            let (sum, count) =
                parts.fold((0.0, 0), |(sum, count), value| (sum + f64::from(*value), count + 1));
            if count > 0 {
                *made = (sum / f64::from(count)) as f32;
            }
        }
    });
    made
}

/// Returns the best source among the parts of each larger cell.
fn best(fine: &Grid, values: &[CellSource], coarse: &Grid, times: usize) -> Vec<CellSource> {
    let mut made = vec![CellSource::None; coarse.len()];
    for (row, line) in values.chunks(fine.columns.max(1)).enumerate() {
        for (column, value) in line.iter().enumerate() {
            let cell = &mut made[row / times * coarse.columns + column / times];
            *cell = (*cell).max(*value);
        }
    }
    made
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Creates a surface of 3 rows of cells: depths from west to east in the middle row, and
    /// unknown depths in the others.
    fn strip(depth_m: impl Fn(usize) -> f32) -> Surface {
        let grid = Grid::at([100.0, 50.0], 0.5, [40, 3]);
        let depths = (0..grid.len()).map(|cell| match cell / grid.columns {
            1 => depth_m(cell % grid.columns),
            _ => f32::NAN,
        });
        let mut surface = Surface::of_depths(grid, depths.collect());
        for (source, depth_m) in surface.source.iter_mut().zip(&surface.depth_m) {
            if depth_m.is_nan() {
                *source = CellSource::None;
            }
        }
        surface
    }

    #[test]
    fn a_larger_grid_lies_on_the_same_cells() {
        let grid = strip(|_| 1.0).grid;
        assert_eq!(grid.reaching([101.0, 49.0, 110.0, 49.5]), grid, "within");
        let larger = grid.reaching([99.9, 40.2, 120.1, 50.0]);
        let expected = Grid { west_m: 99.5, columns: 1 + 40 + 1, rows: 3 + 17, ..grid };
        assert_eq!(larger, expected);
    }

    #[test]
    fn known_depths_stay_and_the_bed_goes_on_level_from_them() {
        let strip = strip(|_| 4.0);
        let grid = strip.grid.reaching([90.0, 40.0, 130.0, 60.0]);
        let columns = grid.columns;
        let wide = strip.extrapolated_flat(grid, |cell| cell % columns != 7);
        for (cell, (depth_m, source)) in wide.depth_m.iter().zip(&wide.source).enumerate() {
            let [east_m, north_m] = grid.centre_of(cell);
            let known = strip.at(east_m, north_m);
            assert_eq!(*source == CellSource::Sounding, known.is_some());
            match cell % columns {
                7 => assert!(depth_m.is_nan(), "not wanted"),
                _ => assert!((depth_m - 4.0).abs() < 1e-5, "{depth_m}"),
            }
        }
    }

    #[test]
    fn beside_a_slope_the_bed_is_as_deep_as_abreast_and_evens_out_farther_away() {
        let strip = strip(|column| 2.0 + 0.1 * column as f32);
        let grid = strip.grid.reaching([100.0, 30.0, 120.0, 70.0]);
        let wide = strip.extrapolated_flat(grid, |_| true);
        let along = |north_m: f64| {
            let at = |east_m| f64::from(wide.at(east_m, north_m).expect("within").0);
            (at(102.25), at(117.75))
        };
        let (west_m, east_m) = along(48.25);
        assert!((west_m - 2.4).abs() < 0.15 && (east_m - 5.5).abs() < 0.15, "{west_m} {east_m}");
        let (far_west_m, far_east_m) = along(32.0);
        assert!(far_east_m - far_west_m < 0.6 * (east_m - west_m), "evens out");
        assert!(wide.depth_m.iter().all(|depth_m| (2.0..=5.9).contains(depth_m)));
    }

    #[test]
    fn finer_cells_have_the_depths_between_the_coarse_ones() {
        let depth_m = |cell: usize| 2.0 + 0.1 * (cell % 40) as f32;
        let grid = strip(|_| 0.0).grid;
        let mut depths: Vec<f32> = (0..grid.len()).map(depth_m).collect();
        depths[2 * 40 + 30] = f32::NAN;
        let coarse = Surface::of_depths(grid, depths);
        let finer = coarse.finer(4);
        assert_eq!((finer.grid.columns, finer.grid.rows), (160, 12));
        for (cell, depth_m) in finer.depth_m.iter().enumerate() {
            let [east_m, north_m] = finer.grid.centre_of(cell);
            let known = coarse.at(east_m, north_m);
            assert_eq!(known.is_some(), !depth_m.is_nan());
            // The depth grows by 0.1 m a cell of 0.5 m, except beside the hole and in the outermost
            // half cells, which have no neighbour to interpolate with.
            if known.is_some() && (100.25..114.0).contains(&east_m) {
                let expected_m = 2.0 + 0.2 * (east_m - 100.25);
                assert!((f64::from(*depth_m) - expected_m).abs() < 1e-4);
            }
        }
        assert_eq!(coarse.finer(1).depth_m.len(), coarse.depth_m.len());
    }

    #[test]
    fn where_nothing_is_known_nothing_is_made_up() {
        let nothing = strip(|_| f32::NAN);
        let grid = nothing.grid.reaching([90.0, 40.0, 130.0, 60.0]);
        let wide = nothing.extrapolated_flat(grid, |_| true);
        assert!(wide.depth_m.iter().all(|depth_m| depth_m.is_nan()));
    }

    /// 5 x 3 cells of 0.5 m: a plane that falls 1 in 2 towards the east and rises 1 in 4 towards
    /// the north, with a hole.
    fn plane() -> Surface {
        let grid = Grid::at([10.0, 20.0], 0.5, [5, 3]);
        let depth = |cell: usize| {
            let [east_m, north_m] = grid.centre_of(cell);
            match cell {
                7 => f32::NAN,
                _ => (0.5 * east_m - 0.25 * north_m) as f32,
            }
        };
        let depth_m: Vec<f32> = (0..grid.len()).map(depth).collect();
        Surface { spread_m: depth_m.clone(), ..Surface::of_depths(grid, depth_m) }
    }

    #[test]
    fn a_plane_faces_one_way_everywhere_beside_its_hole_too() {
        let surface = plane();
        let length = (1.0f32 + 0.25 + 0.0625).sqrt();
        let expected = [0.5 / length, -0.25 / length, 1.0 / length];
        for (row, column) in [(0, 0), (0, 1), (1, 1), (1, 3), (2, 4), (2, 3)] {
            let normal = surface.normal(row, column);
            let near = |(a, b): (f32, f32)| (a - b).abs() < 1e-5;
            let pairs = normal.into_iter().zip(expected);
            assert!(pairs.clone().all(near), "{row} {column}: {normal:?}");
        }
        assert_eq!(surface.normal(9, 9), [0.0, 0.0, 1.0]);
    }

    #[test]
    fn larger_cells_hold_the_mean_of_what_is_known_of_them() {
        let (surface, coarse) = (plane(), plane().coarser(2));
        assert_eq!((coarse.grid.columns, coarse.grid.rows), (3, 2));
        assert_eq!(coarse.grid.cell_m, 1.0);
        let of = |cells: &[usize]| {
            let sum: f32 = cells.iter().map(|cell| surface.depth_m[*cell]).sum();
            sum / cells.len() as f32
        };
        assert!((coarse.depth_m[0] - of(&[0, 1, 5, 6])).abs() < 1e-5);
        assert!((coarse.depth_m[1] - of(&[2, 3, 8])).abs() < 1e-5, "without the hole");
        assert!((coarse.depth_m[5] - of(&[14])).abs() < 1e-5, "at the edge");
        let mut parts = plane();
        parts.source = vec![CellSource::Interpolated; 15];
        parts.source[8] = CellSource::FirstReturn;
        let sources = parts.coarser(2).source;
        let others = [0, 2, 3, 4, 5].map(|cell| sources[cell]);
        assert_eq!(sources[1], CellSource::FirstReturn);
        assert_eq!(others, [CellSource::Interpolated; 5]);
        assert_eq!(surface.grid.times_coarser(6), 2);
        assert_eq!(surface.grid.times_coarser(15), 1);
    }

    /// Three rows of four cells of 2 m, west edge at 10, north edge at 106; the bed slopes to the
    /// east and to the south.
    fn sloping_bed() -> Surface {
        let grid = Grid::at([10.0, 106.0], 2.0, [4, 3]);
        let depth = |index: usize| {
            let [east_m, north_m] = grid.centre_of(index);
            (0.5 * east_m - 0.25 * north_m + 30.0) as f32
        };
        Surface::of_depths(grid, (0..12).map(depth).collect())
    }

    #[test]
    fn a_plane_is_met_exactly_between_centres_and_held_beyond() {
        let surface = sloping_bed();
        for place in [[11.0, 105.0], [12.3, 103.9], [16.99, 101.01], [14.0, 103.0]] {
            let plane_m = 0.5 * place[0] - 0.25 * place[1] + 30.0;
            let depth_m = f64::from(surface.depth_at(place).unwrap());
            assert!((depth_m - plane_m).abs() < 1e-5, "{place:?}");
        }
        assert_eq!(surface.depth_at([10.0, 106.0]), surface.depth_at([11.0, 105.0]));
        for outside in
            [[9.99, 103.0], [18.01, 103.0], [12.0, 99.99], [12.0, 106.01], [f64::NAN, 103.0]]
        {
            assert_eq!(surface.depth_at(outside), None);
        }
    }

    #[test]
    fn a_line_is_looked_at_at_its_corners_and_between() {
        let surface = sloping_bed();
        let corner = |place, distance_m| Corner { place, distance_m };
        let corners =
            [corner([11.0, 105.0], 0.0), corner([14.0, 105.0], 3.0), corner([14.0, 98.0], 10.0)];
        let stations = transect(&corners, 0.5, 1000, |place| surface.depth_at(place));
        assert_eq!(stations.len(), 1 + 6 + 14);
        assert_eq!((stations[6].place, stations[6].distance_m), ([14.0, 105.0], 3.0));
        assert_eq!(stations[0].depth_m, surface.depth_at([11.0, 105.0]));
        let known = stations.iter().filter(|station| station.depth_m.is_some());
        assert_eq!(known.map(|station| station.distance_m).reduce(f64::max), Some(8.0));
        let few = transect(&corners, 0.5, 4, |_| None);
        assert!(few.len() <= 6 && few.last().unwrap().distance_m == 10.0, "{few:?}");
        assert!(transect(&[], 0.5, 4, |_| None).is_empty());
        assert!(transect(&corners[..1], 0.0, 4, |_| None).is_empty());
    }

    #[test]
    fn a_gap_stays_a_gap_and_no_more() {
        let mut surface = sloping_bed();
        // Row 1, column 2: its centre lies at 15 E, 103 N.
        surface.depth_m[6] = f32::NAN;
        for gap in [[15.0, 103.0], [13.01, 103.0], [14.9, 104.99], [16.0, 102.0]] {
            assert_eq!(surface.depth_at(gap), None, "{gap:?}");
        }
        // On the lines through the centres around it, it does not count.
        for known in [[13.0, 103.0], [17.0, 102.5], [15.0, 105.0], [14.0, 101.0], [12.9, 104.0]] {
            assert!(surface.depth_at(known).is_some(), "{known:?}");
        }
    }
}
