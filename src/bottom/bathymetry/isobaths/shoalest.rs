//! Computes the surface whose isobaths understate no shoal, the shoalest depth of each cell, and
//! the depths that a chart prints as figures: few enough to be read, the shoalest of their
//! surroundings.

use super::IsobathSettings;
use crate::bathymetry::{DepthPoint, Grid, Surface};
use crate::presentation::ticks;
use bathyscope_log::support::outline::bounds;
use std::collections::HashMap;

/// Returns the shoalest depth that was measured in each cell, metres, rounded toward the shallow
/// side; NaN where none was measured.
pub fn shoalest_m<'a>(grid: &Grid, depths: impl IntoIterator<Item = &'a DepthPoint>) -> Vec<f32> {
    let mut shoalest_m = vec![f32::NAN; grid.len()];
    for point in depths {
        let cell = grid.index_at(point.east_m, point.north_m);
        if let Some(least_m) = cell.and_then(|cell| shoalest_m.get_mut(cell)) {
            // The lesser of a number and NaN is the number.
            *least_m = least_m.min(not_deeper(point.depth_m));
        }
    }
    shoalest_m
}

/// Returns the surface, made shallower so that it is nowhere deeper than some depths: the four
/// cells around each depth are at most as deep as this depth. A line of equal depth crosses no
/// square of four centres whose cells are all shallower, so every depth that is shallower than the
/// line lies on its shallow side.
pub fn with_shoalest<'a>(
    surface: &Surface,
    depths: impl IntoIterator<Item = &'a DepthPoint>,
) -> Surface {
    let mut shoalest = surface.clone();
    let grid = surface.grid;
    for point in depths {
        let column = (point.east_m - grid.west_m) / grid.cell_m - 0.5;
        let row = (grid.north_m - point.north_m) / grid.cell_m - 0.5;
        let depth_m = not_deeper(point.depth_m);
        // The last row and column have no square beyond them, and outside of the grid there is no
        // cell.
        for (row, column) in [(0.0, 0.0), (0.0, 1.0), (1.0, 0.0), (1.0, 1.0)]
            .map(|(down, right)| (row.floor() + down, column.floor() + right))
        {
            let is_inside = |at: f64, count: usize| at >= 0.0 && at < count as f64;
            if is_inside(row, grid.rows) && is_inside(column, grid.columns) {
                let cell = row as usize * grid.columns + column as usize;
                let known_m = shoalest.depth_m[cell];
                // A depth that is not known stays unknown.
                if known_m > depth_m {
                    shoalest.depth_m[cell] = depth_m;
                }
            }
        }
    }
    shoalest
}

/// Returns a depth in the precision of a surface, rounded toward the shallow side.
fn not_deeper(depth_m: f64) -> f32 {
    let rounded = depth_m as f32;
    if f64::from(rounded) > depth_m { rounded.next_down() } else { rounded }
}

/// Approximate number of figures along the diagonal of a map, where the settings give no distance.
const ALONG_DIAGONAL: f64 = 40.0;

/// Chooses depths that are at least `radius_m` apart, shoal first: the shallowest of all, then the
/// shallowest that is far enough from it, and so on. Every other depth has a chosen one within this
/// distance that is no deeper. The chosen depths are in order from shallow to deep.
pub fn spot_soundings(points: &[DepthPoint], radius_m: f64) -> Vec<DepthPoint> {
    let mut order: Vec<&DepthPoint> = points.iter().collect();
    order.sort_unstable_by(|a, b| {
        (a.depth_m.total_cmp(&b.depth_m))
            .then(a.north_m.total_cmp(&b.north_m))
            .then(a.east_m.total_cmp(&b.east_m))
    });
    let mut chosen: Vec<DepthPoint> = Vec::new();
    let mut in_square: HashMap<[i64; 2], Vec<usize>> = HashMap::new();
    for point in order {
        let place = point.place();
        let [column, row] = place.map(|metres| (metres / radius_m).floor() as i64);
        let around = (-1..=1).flat_map(|right| (-1..=1).map(move |up| [column + right, row + up]));
        let mut near = around.filter_map(|square| in_square.get(&square)).flatten();
        let is_near = |other: &usize| {
            let other = &chosen[*other];
            (other.east_m - place[0]).hypot(other.north_m - place[1]) < radius_m
        };
        if !near.any(is_near) {
            in_square.entry([column, row]).or_default().push(chosen.len());
            chosen.push(*point);
        }
    }
    chosen
}

/// Returns the distance between spot soundings, metres: that of the settings or, without one, a
/// round distance by the extent of the depths; `None` without both.
pub fn spot_radius_m(settings: &IsobathSettings, points: &[DepthPoint]) -> Option<f64> {
    let [west, south, east, north] = bounds(points.iter().map(DepthPoint::place));
    let by_extent = || {
        let diagonal_m = (east - west).hypot(north - south);
        (east > west || north > south).then(|| ticks::round_up(diagonal_m / ALONG_DIAGONAL))
    };
    settings.spot_radius_m.or_else(by_extent)
}

#[cfg(test)]
mod tests {
    use super::super::{Smoothing, depth_areas, isobaths, smoothed};
    use super::*;
    use crate::bathymetry::testing::point as depth;
    use bathyscope_log::support::progress::Progress;

    /// Cells of a metre, all 3 m deep, east and south of the origin.
    fn flat(side: usize) -> Surface {
        let grid = Grid::at([0.0, 0.0], 1.0, [side, side]);
        Surface::of_depths(grid, vec![3.0; side * side])
    }

    /// Returns true if a place lies inside a ring, by the steps that a line to the east crosses.
    fn is_inside(ring: &[[f64; 2]], [x, y]: [f64; 2]) -> bool {
        let crossed = ring.windows(2).filter(|step| {
            let [a, b] = [step[0], step[1]];
            (a[1] > y) != (b[1] > y) && x < a[0] + (y - a[1]) / (b[1] - a[1]) * (b[0] - a[0])
        });
        crossed.count() % 2 == 1
    }

    #[test]
    fn a_shoal_that_the_cells_do_not_show_has_a_line_around_it() {
        let surface = flat(9);
        let rock = depth(4.2, -3.7, 1.4);
        let safe = with_shoalest(&surface, [&rock]);
        let drawn = |surface: &Surface| isobaths(surface, &[2.0], &Progress::new()).unwrap();
        assert!(drawn(&surface).is_empty());
        let lines = drawn(&safe);
        assert_eq!(lines.len(), 1);
        assert!(lines[0].is_ring() && is_inside(&lines[0].points, [4.2, -3.7]));
        assert_eq!(surface.depth_m.len(), safe.depth_m.len());
    }

    #[test]
    fn no_depth_lies_on_the_deep_side_of_a_deeper_line_however_lines_are_smoothed() {
        let side = 14;
        let surface = flat(side);
        let share = |index: u32, step: f64| (0.5 + step * f64::from(index)).fract();
        let points: Vec<DepthPoint> = (0..150)
            .map(|index| {
                let [east, south] = [0.754_877_666, 0.569_840_291].map(|step| share(index, step));
                let reach_m = (side - 1) as f64;
                let depth_m = 1.0 + 3.0 * share(index, 0.618_033_989);
                depth(0.5 + reach_m * east, -0.5 - reach_m * south, depth_m)
            })
            .collect();
        let safe = with_shoalest(&surface, &points);
        for level_m in [1.2, 1.5, 2.0, 2.7] {
            let areas = depth_areas(&safe, &[level_m, 100.0], &Progress::new()).unwrap();
            let polygons = || areas[0].polygons.iter();
            let rings =
                || polygons().flat_map(|polygon| polygon.holes.iter().chain([&polygon.outline]));
            for passes in 0..4 {
                let smoothing = Smoothing { passes, toward_deep: true };
                let rings: Vec<Vec<[f64; 2]>> =
                    rings().map(|ring| smoothed(ring, smoothing)).collect();
                let is_deep = |point: &&DepthPoint| {
                    let around = rings.iter().filter(|ring| is_inside(ring, point.place()));
                    around.count() % 2 == 1
                };
                let beyond = points.iter().filter(|point| point.depth_m < level_m);
                assert_eq!(beyond.filter(is_deep).count(), 0, "{level_m} m, {passes} passes");
                assert!(points.iter().filter(is_deep).count() > 0 || level_m > 2.5, "{level_m}");
            }
        }
    }

    #[test]
    fn a_cell_keeps_the_shoalest_of_its_depths() {
        let grid = flat(2).grid;
        let points = [
            depth(0.2, -0.3, 2.5),
            depth(0.9, -0.9, 1.9),
            depth(0.5, -0.5, 2.0),
            depth(1.5, -1.5, 4.0),
            depth(7.0, 7.0, 0.1),
        ];
        let made = shoalest_m(&grid, &points);
        assert_eq!((made[0], made[3]), (not_deeper(1.9), 4.0));
        assert!(made[1].is_nan() && made[2].is_nan());
    }

    #[test]
    fn what_is_deeper_beyond_the_grid_or_not_known_changes_nothing() {
        let mut surface = flat(4);
        surface.depth_m[0] = f32::NAN;
        let points = [depth(2.0, -2.0, 5.0), depth(-50.0, 1e9, 1.0), depth(0.4, -0.4, 1.0)];
        let safe = with_shoalest(&surface, &points);
        assert!(safe.depth_m[0].is_nan());
        assert!(safe.depth_m[1..].iter().all(|depth_m| *depth_m == 3.0));
        assert!(f64::from(not_deeper(1.9999999)) <= 1.9999999);
    }

    fn sounding(east_m: f64, depth_m: f64) -> DepthPoint {
        depth(east_m, 0.3 * east_m, depth_m)
    }

    #[test]
    fn the_shoalest_are_kept_and_none_lies_near_another() {
        let points: Vec<DepthPoint> = (0..400)
            .map(|index| sounding(f64::from(index), 3.0 + f64::from(index * 37 % 101) / 50.0))
            .collect();
        let chosen = spot_soundings(&points, 20.0);
        assert_eq!(chosen[0].depth_m, 3.0);
        assert!(chosen.is_sorted_by_key(|point| point.depth_m));
        let apart_m =
            |a: &DepthPoint, b: &DepthPoint| (a.east_m - b.east_m).hypot(a.north_m - b.north_m);
        for (index, point) in chosen.iter().enumerate() {
            assert!(chosen[..index].iter().all(|other| apart_m(point, other) >= 20.0));
        }
        // Each that was left out has a shallower one, or one as shallow, nearby.
        for point in &points {
            let covers = |sounding: &&DepthPoint| {
                apart_m(sounding, point) < 20.0 && sounding.depth_m <= point.depth_m
            };
            assert!(chosen.iter().any(|sounding| covers(&sounding)), "{point:?}");
        }
        assert!((10..22).contains(&chosen.len()), "{}", chosen.len());
    }

    #[test]
    fn the_distance_follows_the_extent_where_nobody_gives_it() {
        let points = [sounding(0.0, 1.0), sounding(400.0, 1.0)];
        let mut settings = IsobathSettings::default();
        assert_eq!(spot_radius_m(&settings, &points), Some(20.0));
        assert_eq!(spot_radius_m(&settings, &points[..1]), None);
        assert_eq!(spot_radius_m(&settings, &[]), None);
        settings.spot_radius_m = Some(7.0);
        assert_eq!(spot_radius_m(&settings, &points[..1]), Some(7.0));
        assert!(spot_soundings(&[], 7.0).is_empty());
    }
}
