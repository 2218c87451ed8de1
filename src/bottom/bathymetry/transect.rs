//! Samples the depths of a surface along a line.

use super::Surface;

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
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bathymetry::Grid;

    /// Three rows of four cells of 2 m, west edge at 10, north edge at 106; the bed slopes to the
    /// east and to the south.
    fn slope() -> Surface {
        let grid = Grid::at([10.0, 106.0], 2.0, [4, 3]);
        let depth = |index: usize| {
            let [east_m, north_m] = grid.centre_of(index);
            (0.5 * east_m - 0.25 * north_m + 30.0) as f32
        };
        Surface::of_depths(grid, (0..12).map(depth).collect())
    }

    #[test]
    fn a_plane_is_met_exactly_between_centres_and_held_beyond() {
        let surface = slope();
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
        let surface = slope();
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
        let mut surface = slope();
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
