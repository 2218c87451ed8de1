//! Finds the connected places where the bottom changed, from where the change is detected out to
//! where it disappears in noise, and estimates the error of what is drawn between measured places.
//!
//! Surveys along the same lines draw the ground between the lines in the same way: the error of
//! this is in both maps, and not in their difference. The share of the stated errors that is in the
//! difference is measured where nothing changed, as for terrain models that are compared on stable
//! ground (Rolstad, Haug and Denby 2009, J. Glaciology 55; Hugonnet et al. 2022, IEEE JSTARS 15,
//! doi 10.1109/JSTARS.2022.3188922).

use super::{CellChange, ChangeErrors, ChangeSum, WITHIN_95};
use bathyscope_log::support::statistics::{median, quantile, spread_about};
use std::collections::BTreeMap;
use std::f64::consts::PI;

/// Half the side of the square that a change is averaged over before its rim is sought, metres.
const SMOOTHED_M: f64 = 1.0;
/// Largest half side of this square in cells: larger averages gain nothing.
const MOST_SMOOTHED: usize = 10;
/// Fewest cells of a place that differ by more than the largest stated error of a map is likely to
/// be: errors of position may make a few.
const FEWEST_DETECTED: usize = 4;
/// Least area of these cells, square metres.
const LEAST_DETECTED_M2: f64 = 2.0;
/// Share of maps without a change in which errors alone make a place.
const BY_CHANCE: f64 = 0.05;
/// A place ends where the change is less than this number of standard deviations of the undetected
/// cells.
const RIM_SIGMAS: f64 = 1.5;
/// Standard deviation of the two edges of a change together, as a share of the sum of their
/// standard deviations: the edges on both sides of a line err independently.
const EDGES_SHARE: f64 = std::f64::consts::FRAC_1_SQRT_2;

/// A raster of changes, row by row.
#[derive(Clone, Copy, Debug)]
pub struct ChangeField<'a> {
    /// Number of cells from west to east.
    pub columns: usize,
    /// Area of a cell, square metres.
    pub cell_area_m2: f64,
    /// Rise of the bottom, metres; NaN where one of the maps has no depth.
    pub rise_m: &'a [f32],
    /// Standard deviation of the rise that comes from the depths' own errors, metres: as stated by
    /// the maps, or as observed in their difference.
    pub sigma_m: &'a [f32],
    /// Standard deviation of the rise as stated by the maps, metres.
    pub stated_m: &'a [f32],
    /// True where a map measured a depth in the cell: the newer map first, then the older.
    pub is_measured: &'a [[bool; 2]],
}

/// Connected place where the bottom rose or sank.
#[derive(Clone, Debug, PartialEq)]
pub struct ChangeRegion {
    /// True if the bottom rose.
    pub is_fill: bool,
    /// Indices of the cells of the place.
    pub cells: Vec<usize>,
    /// Standard deviation of the rise of each cell that comes from drawing it between places that
    /// both maps measured, metres; the errors of all cells have the same sign.
    pub between_m: Vec<f64>,
}

impl ChangeField<'_> {
    /// Returns the change of a cell; `None` where one of the maps has no depth.
    pub fn cell(&self, index: usize) -> Option<CellChange> {
        let (rise_m, sigma_m) = (*self.rise_m.get(index)?, *self.sigma_m.get(index)?);
        (!rise_m.is_nan()).then(|| CellChange {
            rise_m: f64::from(rise_m),
            sigma_m: f64::from(sigma_m),
            area_m2: self.cell_area_m2,
        })
    }

    /// Returns the places where a change is detected, each grown as far as the smoothed change
    /// keeps its sign and exceeds the noise, in the order of their first cells.
    ///
    /// The noise is that of the undetected cells, in units of their stated errors. The median rise
    /// of the undetected cells is the offset of one map from the other, and each place has a cell
    /// that differs from this offset by more than the depths' own errors. The detected cells of a
    /// place together must exceed the largest of as many independent errors as the map has: the
    /// largest of many errors passes the level of detection without any change. A part of the place
    /// must do so by the stated errors, too: two surveys along the same lines draw the ground
    /// between the lines alike in most places, and in a few by their stated errors apart. A change
    /// of the bottom shows on the lines, where these errors are small.
    pub fn regions(&self, errors: &ChangeErrors) -> Vec<ChangeRegion> {
        let sigmas = self.largest_of_errors(errors);
        let (mut regions, offset_m) = self.candidates(errors);
        regions.retain(|region| self.stands_out(region, offset_m, sigmas, errors));
        regions
    }

    /// Returns the places with a detected change, some of which errors alone may have made, and the
    /// offset of one map from the other, metres.
    fn candidates(&self, errors: &ChangeErrors) -> (Vec<ChangeRegion>, f64) {
        let smoothed = self.smoothed(errors);
        let (mut quiet, mut quiet_m) = (Vec::new(), Vec::new());
        for (index, smoothed) in smoothed.iter().enumerate() {
            if let Some(cell) = self.cell(index).filter(|cell| !cell.is_detected(errors)) {
                quiet.push(*smoothed);
                quiet_m.push(cell.rise_m);
            }
        }
        // Where everything changed, no noise can be measured.
        let (mut level, mut noise, mut offset_m) = (0.0, 0.0, 0.0);
        if !quiet.is_empty() {
            level = median(&mut quiet);
            noise = spread_about(&mut quiet, level);
            offset_m = median(&mut quiet_m);
        }
        let is_seed = |index: usize| {
            self.cell(index).is_some_and(|cell| {
                let from_others = CellChange { rise_m: cell.rise_m - offset_m, ..cell };
                cell.is_detected(errors) && from_others.is_detected(&ChangeErrors::default())
            })
        };
        // The distance to measured places in the map where they are farther away.
        let [newer_m, older_m] = self.away_each_m();
        let away_m: Vec<f32> =
            newer_m.into_iter().zip(older_m).map(|(one, other)| one.max(other)).collect();
        let mut is_taken = vec![false; smoothed.len()];
        let mut found = Vec::new();
        for seed in 0..smoothed.len() {
            if is_taken[seed] || !is_seed(seed) {
                continue;
            }
            let is_fill = self.rise_m[seed] > 0.0;
            let stands_out = |index: usize| {
                let above = smoothed[index] - level;
                (if is_fill { above } else { -above }) > RIM_SIGMAS * noise
            };
            if stands_out(seed) {
                let cells = self.grown(seed, stands_out, &mut is_taken);
                found.push(self.region(is_fill, cells, &away_m));
            }
        }
        (found, offset_m)
    }

    /// Returns true if errors alone do not explain a place. Rises count from `offset_m`, the offset
    /// of one map from the other. The volume of the detected cells must exceed `sigmas` standard
    /// deviations of the errors that vary from place to place. At least [`FEWEST_DETECTED`] of
    /// these cells, on at least [`LEAST_DETECTED_M2`], must each differ by more than `sigmas`
    /// stated standard deviations, so that a few wrong depths do not count as a change.
    fn stands_out(
        &self,
        region: &ChangeRegion,
        offset_m: f64,
        sigmas: f64,
        errors: &ChangeErrors,
    ) -> bool {
        let (mut sum, mut certain) = (ChangeSum::default(), ChangeSum::default());
        for &index in &region.cells {
            if let Some(cell) = self.cell(index).filter(|cell| cell.is_detected(errors)) {
                let cell = CellChange { rise_m: cell.rise_m - offset_m, ..cell };
                sum.add(&cell);
                if cell.rise_m.abs() > sigmas * f64::from(self.stated_m[index]) {
                    certain.add(&cell);
                }
            }
        }
        let [random_m3, ..] = sum.sigma_m3(errors);
        let is_large = certain.cells >= FEWEST_DETECTED && certain.area_m2 >= LEAST_DETECTED_M2;
        is_large && sum.volume_m3.abs() > sigmas * random_m3
    }

    /// Returns the number of standard deviations that the largest of the independent errors of a
    /// map does not exceed in 95 of 100 maps; at least that of the level of detection.
    fn largest_of_errors(&self, errors: &ChangeErrors) -> f64 {
        let known = self.rise_m.iter().filter(|rise_m| !rise_m.is_nan()).count();
        let together_m2 = (PI * errors.range_m.powi(2) / 5.0).max(self.cell_area_m2);
        let independent = (known as f64 * self.cell_area_m2 / together_m2).max(1.0);
        (2.0 * (independent / BY_CHANCE).ln()).sqrt().max(WITHIN_95)
    }

    /// Returns the seed and all cells connected with it by edges that stand out too, and marks them
    /// as taken.
    fn grown(
        &self,
        seed: usize,
        stands_out: impl Fn(usize) -> bool,
        is_taken: &mut [bool],
    ) -> Vec<usize> {
        let mut cells = vec![seed];
        is_taken[seed] = true;
        let mut next = 0;
        while let Some(&cell) = cells.get(next) {
            let column = cell % self.columns;
            let beside = [
                (column > 0).then(|| cell - 1),
                (column + 1 < self.columns).then(|| cell + 1),
                cell.checked_sub(self.columns),
                Some(cell + self.columns),
            ];
            for index in beside.into_iter().flatten() {
                let is_known = self.rise_m.get(index).is_some_and(|rise| !rise.is_nan());
                if is_known && !is_taken[index] && stands_out(index) {
                    is_taken[index] = true;
                    cells.push(index);
                }
            }
            next += 1;
        }
        cells
    }

    /// Creates the region of some cells. Where measured places are farther away than the change is
    /// wide, the error of what is drawn is as large as the change. Where the change is drawn to
    /// fall off between two measured places, its edge may lie anywhere between them: if a change of
    /// height `h` ends evenly distributed over a gap `g`, its volume has a standard deviation of `h
    /// g / sqrt(12)`. The fall away from the nearer place times the distance to this place gives `h
    /// g / 4`.
    fn region(&self, is_fill: bool, cells: Vec<usize>, away: &[f32]) -> ChangeRegion {
        let width_m2 = self.width_m2(&cells);
        let between = cells.iter().map(|&cell| {
            let away_m = f64::from(away[cell]);
            let known = (-0.5 * away_m * away_m / width_m2).exp();
            let by_width_m = (1.0 - known) * f64::from(self.rise_m[cell].abs());
            let [outward, rise] = [away, self.rise_m].map(|values| self.gradient(values, cell));
            let fall = (outward[0] * rise[0] + outward[1] * rise[1]).abs();
            by_width_m.max(EDGES_SHARE * fall * away_m)
        });
        ChangeRegion { is_fill, between_m: between.collect(), cells }
    }

    /// Returns the gradient of a raster of metres at a cell, metres a metre to the east and to the
    /// south; 0 where neighbours are unknown.
    fn gradient(&self, metres: &[f32], cell: usize) -> [f64; 2] {
        let across_m = 2.0 * self.cell_area_m2.sqrt();
        let between = |before: Option<usize>, after: usize| {
            let [before, after] = [metres.get(before?)?, metres.get(after)?];
            Some(f64::from(after - before) / across_m).filter(|slope| slope.is_finite())
        };
        let column = cell % self.columns;
        let is_inside = column > 0 && column + 1 < self.columns;
        let east = between(cell.checked_sub(1), cell + 1).filter(|_| is_inside);
        let south = between(cell.checked_sub(self.columns), cell + self.columns);
        [east, south].map(Option::unwrap_or_default)
    }

    /// Returns the variance of the Gaussian mound that has the moments of the change in the
    /// measured cells of a region, square metres. On one line across a mound this is the variance
    /// of the mound, since the square of a Gaussian has half of its variance.
    fn width_m2(&self, cells: &[usize]) -> f64 {
        let measured = cells.iter().filter(|cell| self.is_measured[**cell] != [false; 2]);
        let mut sums = [0.0; 4];
        for &cell in measured {
            let weight = f64::from(self.rise_m[cell]).powi(2);
            let [x, y] = [cell % self.columns, cell / self.columns].map(|count| count as f64);
            let added = [weight, weight * x, weight * y, weight * x.mul_add(x, y * y)];
            sums = [0, 1, 2, 3].map(|index| sums[index] + added[index]);
        }
        let [weight, x, y, squares] = sums;
        let moment = if weight > 0.0 {
            squares / weight - (x / weight).powi(2) - (y / weight).powi(2)
        } else {
            0.0
        };
        // A change in a single cell is as wide as the cell.
        2.0 * self.cell_area_m2 * moment.max(0.5)
    }

    /// Returns the distance from each cell to the nearest measured cell, metres, in the newer map
    /// and in the older.
    pub(super) fn away_each_m(&self) -> [Vec<f32>; 2] {
        [0, 1].map(|map| self.away_from(|cell| self.is_measured[cell][map]))
    }

    /// Returns the distance from each cell to the nearest cell for which `is_one` is true, metres.
    pub(super) fn away_from(&self, is_one: impl Fn(usize) -> bool) -> Vec<f32> {
        let cell_m = self.cell_area_m2.sqrt() as f32;
        let start =
            (0..self.is_measured.len()).map(|cell| if is_one(cell) { 0.0 } else { f32::INFINITY });
        let cells = chamfered(start.collect(), self.columns);
        cells.into_iter().map(|cells| cell_m * cells).collect()
    }

    /// Returns the change in units of its stated error, averaged over the known cells of a square;
    /// NaN where the change is not known.
    fn smoothed(&self, errors: &ChangeErrors) -> Vec<f64> {
        let reach = (SMOOTHED_M / self.cell_area_m2.sqrt()).round() as usize;
        let reach = reach.clamp(1, MOST_SMOOTHED);
        let own = |index: usize| match self.cell(index) {
            Some(cell) => {
                // Without stated errors, the change itself is averaged.
                let sigma_m = cell.sigma_m.hypot(errors.systematic_m);
                let sigma_m = if sigma_m > 0.0 { sigma_m } else { 1.0 };
                [cell.rise_m / sigma_m, 1.0]
            }
            None => [0.0; 2],
        };
        let own: Vec<[f64; 2]> = (0..self.rise_m.len()).map(own).collect();
        let rows = self.rise_m.len() / self.columns.max(1);
        let across = summed(&own, [self.columns, rows], [1, self.columns], reach);
        let square = summed(&across, [rows, self.columns], [self.columns, 1], reach);
        let means = square.into_iter().zip(&own);
        means.map(|([sum, count], own)| if own[1] > 0.0 { sum / count } else { f64::NAN }).collect()
    }
}

/// Returns the sum of the values within `reach` steps of each value along one axis. The first pair
/// is the number of values along this axis and along the other one; the second pair is the distance
/// of neighbours in the list along each.
fn summed(
    values: &[[f64; 2]],
    [along, others]: [usize; 2],
    [step, stride]: [usize; 2],
    reach: usize,
) -> Vec<[f64; 2]> {
    let mut sums = vec![[0.0; 2]; values.len()];
    for other in 0..others {
        let at = |index: usize| other * stride + index * step;
        let mut sum = [0.0; 2];
        for index in 0..along + reach {
            if index < along {
                let added = values[at(index)];
                sum = [sum[0] + added[0], sum[1] + added[1]];
            }
            if let Some(past) = index.checked_sub(2 * reach + 1) {
                let gone = values[at(past)];
                sum = [sum[0] - gone[0], sum[1] - gone[1]];
            }
            if let Some(middle) = index.checked_sub(reach) {
                sums[at(middle)] = sum;
            }
        }
    }
    sums
}

/// Returns the distances in cells from the cells that are 0 at the start, by steps to the eight
/// neighbours in two sweeps (Borgefors 1986): at most 8 % too long.
fn chamfered(mut away: Vec<f32>, columns: usize) -> Vec<f32> {
    let diagonal = std::f32::consts::SQRT_2;
    for _ in 0..2 {
        for cell in 0..away.len() {
            let column = cell % columns;
            let mut nearest = away[cell];
            let mut pass = |steps_back: usize, way: f32| {
                if let Some(other) = cell.checked_sub(steps_back) {
                    nearest = nearest.min(away[other] + way);
                }
            };
            pass(columns, 1.0);
            if column > 0 {
                pass(1, 1.0);
                pass(columns + 1, diagonal);
            }
            if column + 1 < columns {
                pass(columns - 1, diagonal);
            }
            away[cell] = nearest;
        }
        // The second sweep runs backwards; its own reversal restores the order of the list.
        away.reverse();
    }
    away
}

/// Greatest distance at which measured places of the two maps count as the same place, metres: no
/// boat comes back to a line exactly.
const SAME_PLACE_M: f32 = 1.0;
/// Greatest ratio of two distances from a cell, to the nearest place that both maps measured and to
/// the nearest place that either measured, at which both maps draw the cell from the same places.
const FARTHER: f32 = 1.25;
/// Least share of cells drawn from the same places with which the range of the errors is estimated.
/// With fewer, the assumed range is kept: what only one map draws errs along a whole line.
const SAME_SHARE: f64 = 0.6;
/// Groups of stated errors per octave: errors within a factor of the square root of two are judged
/// together.
const BINS_PER_OCTAVE: f64 = 2.0;
/// Fewest cells from which the size of their errors is estimated.
const FEWEST_CELLS: usize = 200;
/// Fewest squares of ground from which the range of the errors is estimated.
const FEWEST_SQUARES: usize = 12;

/// Errors of a difference, estimated from its cells without a change.
#[derive(Clone, Debug, PartialEq)]
pub struct ObservedErrors {
    /// Standard deviation of each cell's rise that comes from the depths' own errors, metres: at
    /// most the stated one.
    pub sigma_m: Vec<f32>,
    /// Distance beyond which the errors of depths are independent, metres: at most the assumed one.
    pub range_m: f64,
    /// Median share of the stated errors that is in the difference; 1 where the stated errors are
    /// kept.
    pub share: f64,
}

impl ChangeField<'_> {
    /// Estimates the errors from the cells in which no change is detected with the stated errors.
    ///
    /// The stated errors are kept where the maps are not drawn from the same places, and where
    /// there are too few cells. A change that covers most of the ground is taken for an error, so
    /// that errors come out too large, not too small.
    pub fn observed_errors(&self, errors: &ChangeErrors) -> ObservedErrors {
        let quiet = self.quiet(&self.regions(errors));
        let bins = self.bins();
        let shares = self.shares(&quiet, &bins);
        let share_of = |cell: usize| {
            let share = bins[cell].and_then(|bin| shares.get(&bin));
            share.copied().unwrap_or(1.0)
        };
        let known = || (0..self.rise_m.len()).filter(|cell| !self.rise_m[*cell].is_nan());
        let mut all: Vec<f64> = known().map(share_of).collect();
        let sigma_m: Vec<f32> = (self.sigma_m.iter().enumerate())
            .map(|(cell, sigma_m)| sigma_m * share_of(cell) as f32)
            .collect();
        let same = known().filter(|cell| bins[*cell].is_some()).count() as f64;
        let range_m = if same >= SAME_SHARE * known().count() as f64 {
            self.range_m(&quiet, &sigma_m, errors.range_m)
        } else {
            errors.range_m
        };
        let share = if all.is_empty() { 1.0 } else { median(&mut all) };
        ObservedErrors { sigma_m, range_m, share }
    }

    /// Returns the rise of the cells outside of the places that changed, less the median of these
    /// cells, metres; NaN in the other cells.
    fn quiet(&self, regions: &[ChangeRegion]) -> Vec<f64> {
        let mut quiet_m: Vec<f64> = self.rise_m.iter().map(|rise_m| f64::from(*rise_m)).collect();
        for cell in regions.iter().flat_map(|region| &region.cells) {
            quiet_m[*cell] = f64::NAN;
        }
        let mut known: Vec<f64> = quiet_m.iter().copied().filter(|rise| !rise.is_nan()).collect();
        if !known.is_empty() {
            let offset_m = median(&mut known);
            quiet_m.iter_mut().for_each(|rise_m| *rise_m -= offset_m);
        }
        quiet_m
    }

    /// Returns the group of stated errors that each cell is judged with; `None` where the maps are
    /// not drawn from the same places, or the stated error is 0.
    fn bins(&self) -> Vec<Option<i32>> {
        let [newer_m, older_m] = self.away_each_m();
        let is_shared = |cell: usize| {
            let [newer, older] = self.is_measured[cell];
            newer && older_m[cell] <= SAME_PLACE_M || older && newer_m[cell] <= SAME_PLACE_M
        };
        let both_m = self.away_from(is_shared);
        let bin = |cell: usize| {
            let nearest_m = newer_m[cell].min(older_m[cell]);
            let is_same = both_m[cell] <= FARTHER * nearest_m + SAME_PLACE_M;
            let sigma_m = f64::from(self.sigma_m[cell]);
            (is_same && sigma_m > 0.0).then(|| (BINS_PER_OCTAVE * sigma_m.log2()).floor() as i32)
        };
        (0..self.sigma_m.len()).map(bin).collect()
    }

    /// Returns the observed differences of the quiet cells of each group as a share of the stated
    /// errors: the largest of the value that 68 % do not exceed, half of the value that 95 % do not
    /// exceed, and the root mean square, because a few places may err by much more than the rest.
    fn shares(&self, quiet_m: &[f64], bins: &[Option<i32>]) -> BTreeMap<i32, f64> {
        let mut ratios: BTreeMap<i32, Vec<f64>> = BTreeMap::new();
        for (cell, rise_m) in quiet_m.iter().enumerate() {
            if let (Some(bin), false) = (bins[cell], rise_m.is_nan()) {
                ratios.entry(bin).or_default().push(rise_m.abs() / f64::from(self.sigma_m[cell]));
            }
        }
        ratios.retain(|_, ratios| ratios.len() >= FEWEST_CELLS);
        let share = |(bin, mut ratios): (i32, Vec<f64>)| {
            ratios.sort_unstable_by(f64::total_cmp);
            let squares = ratios.iter().map(|ratio| ratio.min(WITHIN_95).powi(2));
            let rms = (squares.sum::<f64>() / ratios.len() as f64).sqrt();
            let share = quantile(&ratios, 0.683).max(0.5 * quantile(&ratios, 0.954)).max(rms);
            (bin, share.min(1.0))
        };
        ratios.into_iter().map(share).collect()
    }

    /// Returns the range of the errors, metres, from the differences that remain between the means
    /// over squares: means of independent cells would hardly differ, and means of cells that all
    /// err together would differ as much as single cells.
    fn range_m(&self, quiet_m: &[f64], sigma_m: &[f32], assumed_m: f64) -> f64 {
        let cell_m = self.cell_area_m2.sqrt();
        let side = (assumed_m / cell_m).round().max(1.0) as usize;
        let mut squares: BTreeMap<[usize; 2], (f64, f64)> = BTreeMap::new();
        let mut cells = (0.0, 0.0);
        for (cell, rise_m) in quiet_m.iter().enumerate() {
            let ratio = rise_m / f64::from(sigma_m[cell]);
            if ratio.is_finite() {
                let square = [cell % self.columns / side, cell / self.columns / side];
                let (sum, count) = squares.entry(square).or_default();
                (*sum, *count) = (*sum + ratio, *count + 1.0);
                cells = (cells.0 + ratio * ratio, cells.1 + 1.0);
            }
        }
        let full = 0.5 * (side * side) as f64;
        let means: Vec<f64> =
            squares.values().filter(|(_, count)| *count >= full).map(|(sum, n)| sum / n).collect();
        if means.len() < FEWEST_SQUARES || cells.0 == 0.0 {
            return assumed_m;
        }
        let of_squares = means.iter().map(|mean| mean * mean).sum::<f64>() / means.len() as f64;
        let of_cells = cells.0 / cells.1;
        let square_m2 = self.cell_area_m2 * (side * side) as f64;
        // The area whose errors are the same, and the range of a spherical variogram that has this
        // area.
        let together_m2 = square_m2 * of_squares / of_cells;
        (5.0 * together_m2 / PI).sqrt().clamp(cell_m.min(assumed_m), assumed_m)
    }
}
