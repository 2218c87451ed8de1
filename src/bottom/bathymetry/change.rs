//! Compares two depth maps: computes the rise of each cell, whether the rise exceeds the errors,
//! and the volumes that were filled and cut.
//!
//! A change is detected where it exceeds the level of detection, 1.96 times the standard deviation
//! of the difference (Lane, Westaway and Hicks 2003, Earth Surf. Process. Landforms 28; Wheaton et
//! al. 2010, ibid. 35). The volume of a change is that of the whole connected place, with its rim
//! (`regions`). The standard deviation of a volume has three parts: an error that is the same
//! everywhere (draft, water level), errors that vary from place to place and average out over areas
//! that are larger than their range (Rolstad, Haug and Denby 2009, J. Glaciology 55, equation 8,
//! for a spherical variogram), and the error of depths that are drawn between measured places.

mod regions;

pub use regions::{ChangeField, ChangeRegion, ObservedErrors};

use std::collections::BTreeMap;
use std::f64::consts::PI;

/// Standard deviations that 95 % of normal errors do not exceed.
const WITHIN_95: f64 = 1.96;

/// Errors that the cells of a difference have in common; 0 by default, where only the depths' own
/// errors count.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ChangeErrors {
    /// Standard deviation of the error that is the same in all cells (draft, water level, sound
    /// speed), metres.
    pub systematic_m: f64,
    /// Distance beyond which the errors of two depths are independent, metres.
    pub range_m: f64,
}

/// Change of a cell that has a depth in both maps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CellChange {
    /// Rise of the bottom, metres; negative where it sank.
    pub rise_m: f64,
    /// Standard deviation of the rise that comes from the depths' own errors, metres.
    pub sigma_m: f64,
    /// Area of the cell on the ground, square metres.
    pub area_m2: f64,
}

impl CellChange {
    /// Returns the level of detection, metres: errors alone stay below this level in 95 of 100
    /// cells.
    pub fn detection_level_m(&self, errors: &ChangeErrors) -> f64 {
        WITHIN_95 * self.sigma_m.hypot(errors.systematic_m)
    }

    /// Returns true if the change exceeds the level of detection.
    pub(crate) fn is_detected(&self, errors: &ChangeErrors) -> bool {
        self.rise_m.abs() > self.detection_level_m(errors)
    }
}

/// Sums over a set of cells.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ChangeSum {
    /// Number of cells.
    pub cells: usize,
    /// Area, square metres.
    pub area_m2: f64,
    /// Volume of the change, cubic metres; negative where the bottom sank.
    pub volume_m3: f64,
    /// Number of connected places.
    pub places: usize,
    /// Sum of the variances of the cells, each multiplied by the area of the cell.
    variance_m4: f64,
    /// Sum of the variances of the volumes of places that come from drawing between measured
    /// places.
    between_m6: f64,
}

impl ChangeSum {
    fn add(&mut self, cell: &CellChange) {
        self.cells += 1;
        self.area_m2 += cell.area_m2;
        self.volume_m3 += cell.area_m2 * cell.rise_m;
        self.variance_m4 += cell.area_m2 * cell.sigma_m.powi(2);
    }

    /// Adds a place; `between_m3` is the standard deviation of its volume because of depths that
    /// are drawn between measured places, cubic metres.
    fn add_place(&mut self, between_m3: f64) {
        self.places += 1;
        self.between_m6 += between_m3.powi(2);
    }

    /// Returns the standard deviation of the volume, cubic metres, in three parts: that of errors
    /// that vary from place to place, of errors that are the same everywhere, and of depths that
    /// are drawn between measured places.
    pub fn sigma_m3(&self, errors: &ChangeErrors) -> [f64; 3] {
        let averaged = PI * errors.range_m.powi(2) / (5.0 * self.area_m2.max(f64::MIN_POSITIVE));
        let random = (self.area_m2 * self.variance_m4 * averaged.min(1.0)).sqrt();
        let systematic = self.area_m2 * errors.systematic_m;
        [random, systematic, self.between_m6.sqrt()]
    }

    /// Returns half the width of the 95 % interval of the volume, cubic metres.
    pub fn within_95_m3(&self, errors: &ChangeErrors) -> f64 {
        let [random, systematic, between] = self.sigma_m3(errors);
        WITHIN_95 * random.hypot(systematic).hypot(between)
    }
}

/// Change over all cells that have a depth in both maps.
#[derive(Clone, Debug, Default)]
pub struct ChangeTotals {
    /// Sum over all cells, whether their change is detected or not.
    pub all: ChangeSum,
    /// Sum over the places where the bottom rose, each from its detected cells to its rim.
    pub fill: ChangeSum,
    /// Sum over the places where the bottom sank.
    pub cut: ChangeSum,
    /// Sum over both kinds of places: errors that are the same everywhere move fill and cut
    /// together.
    pub net: ChangeSum,
    /// Sum over the cells outside of these places.
    undetected: ChangeSum,
    /// Number of cells by their rise in whole millimetres.
    rises_mm: BTreeMap<i64, usize>,
    /// Number of cells by their level of detection in whole millimetres.
    levels_mm: BTreeMap<i64, usize>,
}

impl ChangeTotals {
    /// Adds the cells of a raster and the places where it changed.
    pub fn add(
        &mut self,
        field: &ChangeField<'_>,
        regions: &[ChangeRegion],
        errors: &ChangeErrors,
    ) {
        let mut is_inside = vec![false; field.rise_m.len()];
        for region in regions {
            let between_m3 = field.cell_area_m2 * region.between_m.iter().sum::<f64>();
            let one_way = if region.is_fill { &mut self.fill } else { &mut self.cut };
            for sum in [one_way, &mut self.net] {
                let cells = region.cells.iter().filter_map(|cell| field.cell(*cell));
                cells.for_each(|cell| sum.add(&cell));
                sum.add_place(between_m3);
            }
            self.all.add_place(between_m3);
            region.cells.iter().for_each(|cell| is_inside[*cell] = true);
        }
        for (index, is_inside) in is_inside.into_iter().enumerate() {
            let Some(cell) = field.cell(index) else {
                continue;
            };
            self.all.add(&cell);
            if !is_inside {
                self.undetected.add(&cell);
            }
            for (counts, metres) in [
                (&mut self.rises_mm, cell.rise_m),
                (&mut self.levels_mm, cell.detection_level_m(errors)),
            ] {
                *counts.entry((1e3 * metres).round() as i64).or_default() += 1;
            }
        }
    }

    /// Returns the most fill and the most cut that may be hidden where nothing is detected, cubic
    /// metres: the ends of the 95 % interval.
    pub fn hidden_m3(&self, errors: &ChangeErrors) -> [f64; 2] {
        let within_m3 = self.undetected.within_95_m3(errors);
        let volume_m3 = self.undetected.volume_m3;
        [volume_m3, -volume_m3].map(|volume_m3| (volume_m3 + within_m3).max(0.0))
    }

    /// Returns the median rise, metres; `None` without cells. It is the offset of one map from the
    /// other where most of the bottom did not change.
    pub fn median_rise_m(&self) -> Option<f64> {
        share_m(&self.rises_mm, self.all.cells, 0.5)
    }

    /// Returns the median level of detection, metres; `None` without cells.
    pub fn median_level_m(&self) -> Option<f64> {
        share_m(&self.levels_mm, self.all.cells, 0.5)
    }

    /// Returns the change that 98 of 100 cells do not exceed in either direction, metres, for the
    /// end of a colour scale.
    pub fn reach_m(&self) -> f64 {
        let ends = [0.01, 0.99].map(|share| share_m(&self.rises_mm, self.all.cells, share));
        ends.into_iter().flatten().map(f64::abs).fold(0.0, f64::max)
    }
}

/// Returns the quantile of the counted values at `share`, metres; `None` without values.
fn share_m(counts_mm: &BTreeMap<i64, usize>, all: usize, share: f64) -> Option<f64> {
    let mut below = 0;
    let found = counts_mm.iter().find(|(_, count)| {
        below += **count;
        below as f64 >= share * all as f64
    });
    found.map(|(millimetres, _)| *millimetres as f64 * 1e-3)
}

#[cfg(test)]
mod tests;
