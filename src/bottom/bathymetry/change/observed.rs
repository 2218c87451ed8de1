//! Estimates the errors of the difference of two maps from the ground where the bottom did not
//! change.
//!
//! Surveys along the same lines draw the ground between the lines in the same way: the error of
//! this is in both maps, and not in their difference. The share of the stated errors that is in the
//! difference is measured where nothing changed, as for terrain models that are compared on stable
//! ground (Rolstad, Haug and Denby 2009, J. Glaciology 55; Hugonnet et al. 2022, IEEE JSTARS 15,
//! doi 10.1109/JSTARS.2022.3188922).

use super::{ChangeErrors, ChangeField, ChangeRegion, WITHIN_95};
use bathyscope_log::support::statistics::{median, quantile};
use std::collections::BTreeMap;
use std::f64::consts::PI;

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
