//! Describes each cell of the ground: its distance to the nearest sounding, the number of passes
//! that insonified it, and the uncertainty of its depth.

use super::turns::apart_m;
use super::water::{Water, thinned};
use super::{Doubt, InsonifiedSide, SeenObject, SigmaLaw, SurveyCoverage};
use crate::nearest::Nearest;
use rayon::prelude::*;

/// Distance from a crossing within which its doubt applies to cells, and within which a pass
/// reduces the doubt of a cell, metres.
const DOUBT_M: f64 = 5.0;
/// Least difference of two passes that counts as a doubt, in standard deviations of a depth at a
/// sounding.
const DOUBT_SIGMAS: f64 = 2.0;
/// Largest number of doubts that are evaluated.
const MOST_DOUBTS: usize = 500;
/// Factor of a third pass on the standard deviation of the mean of two passes that differ: the root
/// of two thirds.
const THIRD_PASS: f32 = 0.816_5;
/// Worth of the first and the second look of the side-scan at a place, as shares of the standard
/// deviation where nothing is known. A look is worth less than a depth, since a plan is for depths,
/// and enough to keep lines at distances at which the range covers the ground twice.
const LOOK_WORTH: [f32; 2] = [0.05, 0.025];

/// Cell of the water.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct WaterCell {
    /// Centre of the cell.
    pub place: [f64; 2],
    /// Distance to the nearest sounding, metres.
    pub distance_m: f32,
    /// Standard deviation from passes that disagree at this cell, metres.
    pub doubt_m: f32,
    /// Number of passes that insonified the cell, up to 2.
    pub looks: u8,
}

/// State of each cell of the water, and objects on it.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct PlanningGrid {
    /// The water.
    pub water: Water,
    /// Cells of the water, in the order of [`Water::cells`].
    pub cells: Vec<WaterCell>,
    /// Objects in the water or near it.
    pub objects: Vec<SeenObject>,
    /// Standard deviation of a depth by the distance to the nearest sounding.
    pub sigma: SigmaLaw,
    /// Distance to a sounding below which the uncertainty of the ground does not fall any further,
    /// metres: half of the requested spacing.
    pub mended_m: f32,
    /// Distance across the track that side-scan insonifies, metres; 0 without side-scan.
    pub swath_m: f64,
    /// Smallest and largest distance across the track at which an object shows echo and shadow,
    /// metres.
    pub useful_m: [f64; 2],
}

impl PlanningGrid {
    /// Creates the grid of some water from the coverage of a survey.
    pub(super) fn new(known: &SurveyCoverage, water: Water, spacing_m: Option<f64>) -> Self {
        let soundings = Nearest::of(&thinned(&known.soundings, 0.25 * water.grid.cell_m));
        let doubts = largest(known);
        let places: Vec<(usize, [f64; 2])> = water.cells().collect();
        let looks = counted(&water, &known.looks);
        let cell = |&(index, place): &(usize, [f64; 2])| {
            let distance_m = soundings.as_ref().map(|near| near.distance_m(place));
            let near = doubts.iter().filter(|doubt| apart_m(doubt.place, place) < DOUBT_M);
            // The error of the mean of two passes is half of their difference.
            let doubt_m = near.map(|doubt| 0.5 * doubt.difference_m.abs()).fold(0.0, f64::max);
            WaterCell {
                place,
                distance_m: distance_m.unwrap_or(f64::INFINITY) as f32,
                doubt_m: doubt_m as f32,
                looks: looks[index],
            }
        };
        let cells = places.par_iter().map(cell).collect();
        let swath_m = across_m(known.range_m, known.depth_m);
        Self {
            cells,
            water,
            objects: known.objects.clone(),
            sigma: known.sigma.clone(),
            mended_m: spacing_m.map_or(0.0, |spacing_m| (0.5 * spacing_m) as f32),
            swath_m,
            // At less than the depth an object is below the boat, and has hardly any shadow.
            useful_m: [known.depth_m.min(0.5 * swath_m), 0.8 * swath_m],
        }
    }

    /// Returns the standard deviation of the depth of a cell, metres.
    pub(super) fn sigma_m(&self, cell: &WaterCell) -> f32 {
        self.sigma_at(cell.distance_m, cell.doubt_m)
    }

    fn sigma_at(&self, distance_m: f32, doubt_m: f32) -> f32 {
        let sigma_m = self.sigma.at(distance_m.max(self.mended_m));
        if doubt_m > 0.0 { sigma_m.hypot(doubt_m).min(self.sigma.limit_m()) } else { sigma_m }
    }

    /// Returns the reduction of the standard deviation `sigma_m` of a cell by a pass at a distance
    /// of `pass_m`, metres, with the worth of a look of the side-scan.
    pub(super) fn mended_by(&self, cell: &WaterCell, sigma_m: f32, pass_m: f32) -> f32 {
        let doubt_m =
            if pass_m < DOUBT_M as f32 { THIRD_PASS * cell.doubt_m } else { cell.doubt_m };
        let fall_m = if pass_m < cell.distance_m || doubt_m < cell.doubt_m {
            sigma_m - self.sigma_at(pass_m.min(cell.distance_m), doubt_m)
        } else {
            0.0
        };
        let is_seen = f64::from(pass_m) < self.swath_m;
        let look = LOOK_WORTH.get(usize::from(cell.looks)).filter(|_| is_seen);
        fall_m + look.map_or(0.0, |share| share * self.sigma.limit_m())
    }

    /// Returns the largest distance at which a pass can improve a cell, metres.
    pub(super) fn reach_m(&self, cell: &WaterCell) -> f64 {
        let depth_m = f64::from(cell.distance_m).min(self.sigma.reach_m());
        let doubt_m = if cell.doubt_m > 0.0 { DOUBT_M } else { 0.0 };
        let look_m = if usize::from(cell.looks) < LOOK_WORTH.len() { self.swath_m } else { 0.0 };
        depth_m.max(doubt_m).max(look_m)
    }

    /// Updates the cells and objects after a straight pass from one place to another. `is_line` is
    /// true if its side-scan counts, which is not used in turns.
    pub(super) fn sail(&mut self, from: [f64; 2], to: [f64; 2], is_line: bool) {
        let way = [to[0] - from[0], to[1] - from[1]];
        let length_m = way[0].hypot(way[1]);
        if length_m < 1e-9 {
            return;
        }
        let swath_m = if is_line { self.swath_m } else { 0.0 };
        // Distances of a place along the way and across it.
        let off_m = |place: [f64; 2]| {
            let [x, y] = [0, 1].map(|axis| place[axis] - from[axis]);
            let along_m = (x * way[0] + y * way[1]) / length_m;
            [along_m, (x * way[1] - y * way[0]).abs() / length_m]
        };
        self.cells.par_iter_mut().for_each(|cell| {
            let [along_m, across_m] = off_m(cell.place);
            let beyond_m = (along_m - along_m.clamp(0.0, length_m)).abs();
            let pass_m = across_m.hypot(beyond_m);
            cell.distance_m = cell.distance_m.min(pass_m as f32);
            if is_line && pass_m < DOUBT_M {
                cell.doubt_m *= THIRD_PASS;
            }
            if beyond_m == 0.0 && across_m < swath_m {
                cell.looks = (cell.looks + 1).min(2);
            }
        });
        if is_line {
            let heading_rad = way[0].atan2(way[1]);
            let [near_m, far_m] = self.useful_m;
            for object in &mut self.objects {
                let [along_m, across_m] = off_m(object.place);
                if (0.0..=length_m).contains(&along_m) && (near_m..=far_m).contains(&across_m) {
                    object.headings_rad.push(heading_rad);
                }
            }
        }
    }

    /// Returns the area of a cell, square metres.
    pub(super) fn cell_m2(&self) -> f64 {
        self.water.grid.cell_m.powi(2)
    }
}

/// Returns the largest of the doubts that noise does not explain.
fn largest(known: &SurveyCoverage) -> Vec<Doubt> {
    let least_m = DOUBT_SIGMAS * f64::from(known.sigma.at(0.0));
    let size = |doubt: &Doubt| doubt.difference_m.abs();
    let mut doubts = known.doubts.clone();
    doubts.retain(|doubt| size(doubt) > least_m);
    doubts.sort_by(|a, b| size(b).total_cmp(&size(a)));
    doubts.truncate(MOST_DOUBTS);
    doubts
}

/// Returns the distance across the track of a slant range on a level bottom, metres.
fn across_m(range_m: f64, depth_m: f64) -> f64 {
    (range_m * range_m - depth_m * depth_m).max(0.0).sqrt()
}

/// Returns the number of passes that insonified each cell of the grid, up to 2.
fn counted(water: &Water, looks: &[InsonifiedSide]) -> Vec<u8> {
    let grid = &water.grid;
    let mut counts = vec![0_u8; grid.len()];
    let mut last = vec![u32::MAX; grid.len()];
    for look in looks {
        let steps = (apart_m(look.from, look.to) / (0.5 * grid.cell_m)).ceil();
        for step in 0..=steps.min(1e5) as u32 {
            let share = f64::from(step) / steps.max(1.0);
            let [east_m, north_m] =
                [0, 1].map(|axis| look.from[axis] + share * (look.to[axis] - look.from[axis]));
            let Some(cell) = grid.index_at(east_m, north_m) else {
                continue;
            };
            if last[cell] != look.pass {
                last[cell] = look.pass;
                counts[cell] = (counts[cell] + 1).min(2);
            }
        }
    }
    counts
}
