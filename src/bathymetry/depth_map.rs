//! The depth map: a grid over the soundings with values only where a sounding is near.

use super::{DepthPoint, Tin, merge_repeated};
use crate::progress::{Cancelled, Progress};
use kiddo::{ImmutableKdTree, SquaredEuclidean};
use rayon::prelude::*;

/// How the depth map is sampled.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DepthMapSettings {
    /// No value farther than this from a sounding, metres, and none between soundings more than twice as far apart.
    pub gap_m: f64,
    /// Most cells along the longer side.
    pub max_side: usize,
    /// Smallest cell, metres.
    pub min_cell_m: f64,
}

impl Default for DepthMapSettings {
    fn default() -> Self {
        Self {
            gap_m: 20.0,
            max_side: 1024,
            min_cell_m: 0.1,
        }
    }
}

/// Depths on a grid, north up: row 0 is the northernmost, column 0 the westernmost.
#[derive(Clone, Debug, PartialEq)]
pub struct DepthMap {
    /// East of the west edge of the first column, metres.
    pub west_m: f64,
    /// North of the north edge of the first row, metres.
    pub north_m: f64,
    /// Side of a cell, metres.
    pub cell_m: f64,
    /// Cells from west to east.
    pub columns: usize,
    /// Cells from north to south.
    pub rows: usize,
    /// Depth at the centre of each cell, row by row; NaN where nothing is known.
    pub depth_m: Vec<f32>,
    /// Distance from the centre of each cell to the nearest sounding, metres; NaN where nothing is known.
    pub distance_m: Vec<f32>,
}

impl DepthMap {
    /// Depth of the cell at a place and its distance to the nearest sounding; `None` where nothing is known.
    pub fn at(&self, east_m: f64, north_m: f64) -> Option<(f32, f32)> {
        let column = (east_m - self.west_m) / self.cell_m;
        let row = (self.north_m - north_m) / self.cell_m;
        if column < 0.0 || row < 0.0 || column >= self.columns as f64 || row >= self.rows as f64 {
            return None;
        }
        let index = row as usize * self.columns + column as usize;
        let depth_m = *self.depth_m.get(index)?;
        (!depth_m.is_nan()).then_some((depth_m, *self.distance_m.get(index)?))
    }

    fn over(points: &[DepthPoint], settings: &DepthMapSettings) -> Option<Self> {
        let [west_m, south_m, east_m, north_m] = bounds(points)?;
        let extent_m = (east_m - west_m).max(north_m - south_m);
        let cell_m = (extent_m / settings.max_side as f64).max(settings.min_cell_m);
        let cells = |length_m: f64| ((length_m / cell_m).ceil() as usize).max(1);
        Some(Self {
            west_m,
            north_m,
            cell_m,
            columns: cells(east_m - west_m),
            rows: cells(north_m - south_m),
            depth_m: Vec::new(),
            distance_m: Vec::new(),
        })
    }

    fn centre(&self, row: usize, column: usize) -> [f64; 2] {
        [
            self.west_m + (column as f64 + 0.5) * self.cell_m,
            self.north_m - (row as f64 + 0.5) * self.cell_m,
        ]
    }
}

/// West, south, east, north.
fn bounds(points: &[DepthPoint]) -> Option<[f64; 4]> {
    let first = points.first()?;
    let start = [first.east_m, first.north_m, first.east_m, first.north_m];
    Some(points.iter().fold(start, |[w, s, e, n], point| {
        [
            w.min(point.east_m),
            s.min(point.north_m),
            e.max(point.east_m),
            n.max(point.north_m),
        ]
    }))
}

/// Samples the triangulated soundings on a grid: linear within triangles, no value outside the hull, farther than the gap
/// from a sounding, or between soundings more than two gaps apart. `None` when there is no surface (fewer than three places, or all on one line).
pub fn depth_map(
    points: &[DepthPoint],
    settings: &DepthMapSettings,
    progress: &Progress,
) -> Result<Option<DepthMap>, Cancelled> {
    let Some(mut map) = DepthMap::over(points, settings) else {
        return Ok(None);
    };
    // Soundings nearer to each other than a cell cannot be told apart in the map.
    let points = merge_repeated(points, map.cell_m);
    progress.check()?;
    let places: Vec<[f64; 2]> = points.iter().map(|p| [p.east_m, p.north_m]).collect();
    let (Some(tin), Ok(nearest)) = (
        Tin::new(&points),
        ImmutableKdTree::<f64, 2>::new_from_slice(&places),
    ) else {
        return Ok(None);
    };
    let tin = tin.with_max_edge(2.0 * settings.gap_m);
    progress.start(map.rows as u64);
    let rows: Vec<Vec<(f32, f32)>> = (0..map.rows)
        .into_par_iter()
        .map(|row| {
            progress.check()?;
            let sampled = sample_row(&map, row, &tin, &nearest, settings.gap_m);
            progress.advance(1);
            Ok(sampled)
        })
        .collect::<Result<_, Cancelled>>()?;
    (map.depth_m, map.distance_m) = rows.into_iter().flatten().unzip();
    let known = map.depth_m.iter().any(|depth| !depth.is_nan());
    Ok(known.then_some(map))
}

fn sample_row(
    map: &DepthMap,
    row: usize,
    tin: &Tin,
    nearest: &ImmutableKdTree<f64, 2>,
    gap_m: f64,
) -> Vec<(f32, f32)> {
    let mut depths = Vec::with_capacity(map.columns);
    let centres = (0..map.columns).map(|column| map.centre(row, column));
    tin.depths(centres.clone(), &mut depths);
    let cell = |(depth_m, centre): (&f64, [f64; 2])| {
        if depth_m.is_nan() {
            return (f32::NAN, f32::NAN);
        }
        let found = nearest
            .query(&centre)
            .nearest_one::<SquaredEuclidean<f64>>()
            .execute();
        let distance_m = found.distance.sqrt();
        if distance_m > gap_m {
            return (f32::NAN, f32::NAN);
        }
        (*depth_m as f32, distance_m as f32)
    };
    depths.iter().zip(centres).map(cell).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(north_m: f64, depth_m: f64) -> impl Iterator<Item = DepthPoint> {
        (0..=40).map(move |i| DepthPoint {
            east_m: f64::from(i),
            north_m,
            depth_m,
        })
    }

    fn settings(gap_m: f64) -> DepthMapSettings {
        DepthMapSettings {
            gap_m,
            max_side: 80,
            min_cell_m: 0.1,
        }
    }

    #[test]
    fn between_two_lines_the_depth_is_linear() {
        let points: Vec<_> = line(0.0, 2.0).chain(line(10.0, 4.0)).collect();
        let map = depth_map(&points, &settings(6.0), &Progress::new())
            .unwrap()
            .unwrap();
        let (depth_m, distance_m) = map.at(20.0, 5.0).unwrap();
        assert!((depth_m - 3.0).abs() < 0.06, "{depth_m}");
        assert!((distance_m - 5.0).abs() < 0.3, "{distance_m}");
        assert_eq!(map.at(20.0, 11.0), None);
    }

    #[test]
    fn no_value_is_farther_than_the_gap_from_a_sounding() {
        // Triangles of equal sides, 5.9 m: their middles are 3.4 m from the corners.
        let points: Vec<_> = (0..49)
            .map(|i| DepthPoint {
                east_m: 5.9 * (f64::from(i % 7) + 0.5 * f64::from(i / 7)),
                north_m: 5.9 * 0.75f64.sqrt() * f64::from(i / 7),
                depth_m: f64::from(i % 5),
            })
            .collect();
        let map = depth_map(&points, &settings(3.0), &Progress::new())
            .unwrap()
            .unwrap();
        let (mut known, mut unknown) = (0, 0);
        for cell in 0..map.rows * map.columns {
            let [east_m, north_m] = map.centre(cell / map.columns, cell % map.columns);
            let brute_m = points
                .iter()
                .map(|p| (p.east_m - east_m).hypot(p.north_m - north_m))
                .fold(f64::MAX, f64::min);
            match map.at(east_m, north_m) {
                Some((_, distance_m)) => {
                    assert!((f64::from(distance_m) - brute_m).abs() < 1e-4);
                    assert!(brute_m <= 3.0);
                    known += 1;
                }
                None => unknown += usize::from(brute_m < 3.4),
            }
        }
        assert!(known > 1000 && unknown > 50, "{known} {unknown}");
    }

    #[test]
    fn the_bay_of_a_bend_stays_empty() {
        // A quarter circle of 100 m: its chord is 141 m, its bay 29 m deep.
        let points: Vec<_> = (0..=180)
            .map(|i| {
                let (sin, cos) = (f64::from(i) * 0.5).to_radians().sin_cos();
                DepthPoint {
                    east_m: 100.0 * cos,
                    north_m: 100.0 * sin,
                    depth_m: 2.0,
                }
            })
            .collect();
        let map = depth_map(&points, &settings(20.0), &Progress::new()).unwrap();
        let in_the_bay = |map: DepthMap| map.at(60.0, 60.0);
        assert_eq!(map.and_then(in_the_bay), None);
    }

    #[test]
    fn one_straight_line_is_no_surface() {
        let points: Vec<_> = line(0.0, 2.0).collect();
        assert_eq!(
            depth_map(&points, &settings(3.0), &Progress::new()),
            Ok(None)
        );
        assert_eq!(depth_map(&[], &settings(3.0), &Progress::new()), Ok(None));
    }
}
