//! Change of the bottom between two depth maps: the rise of each cell, whether it exceeds the
//! errors, and the volumes that were filled and cut.
//!
//! A change is detected where it passes the level of detection, 1.96 times the standard deviation
//! of the difference (Lane, Westaway and Hicks 2003, Earth Surf. Process. Landforms 28; Wheaton et
//! al. 2010, ibid. 35), and has its whole volume, with the rim (`regions`). The standard deviation
//! of a volume has a part that is the same everywhere (draft, water level), one that varies from
//! place to place and averages out over areas that are larger than its range (Rolstad, Haug and
//! Denby 2009, J. Glaciology 55, equation 8, for a spherical variogram), and one for what is drawn
//! between measured places.

mod observed;
mod regions;

pub use observed::ObservedErrors;
pub use regions::{ChangeField, ChangeRegion};

use std::collections::BTreeMap;
use std::f64::consts::PI;

/// Standard deviations that 95 % of normal errors do not exceed.
const WITHIN_95: f64 = 1.96;

/// Errors that the cells of a difference have in common.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChangeErrors {
    /// Standard deviation of what is the same in all cells: draft, water level, sound speed;
    /// metres.
    pub systematic_m: f64,
    /// Depths farther apart than this err independently, metres.
    pub range_m: f64,
}

impl ChangeErrors {
    /// No errors in common, only the depths' own errors.
    const NONE: Self = Self { systematic_m: 0.0, range_m: 0.0 };
}

/// Change of a cell that has a depth in both maps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CellChange {
    /// Rise of the bottom, metres; negative where it sank.
    pub rise_m: f64,
    /// Standard deviation of the depths' own errors in that, metres.
    pub sigma_m: f64,
    /// Square metres on the ground.
    pub area_m2: f64,
}

impl CellChange {
    /// Returns the level of detection, metres: errors alone stay below it in 95 of 100 cells.
    pub fn detection_level_m(&self, errors: &ChangeErrors) -> f64 {
        WITHIN_95 * self.sigma_m.hypot(errors.systematic_m)
    }

    /// Returns true if the change exceeds the level of detection.
    pub(crate) fn is_detected(&self, errors: &ChangeErrors) -> bool {
        self.rise_m.abs() > self.detection_level_m(errors)
    }
}

/// Cells together.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ChangeSum {
    /// Number of cells.
    pub cells: usize,
    /// Square metres.
    pub area_m2: f64,
    /// Cubic metres; negative where the bottom sank.
    pub volume_m3: f64,
    /// Connected places.
    pub places: usize,
    /// Sum of the variances of the cells, each multiplied by the area of the cell.
    variance_m4: f64,
    /// Sum of the variances of the volumes that are drawn between measured places.
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

    /// Standard deviation of the volume, cubic metres: of errors that vary from place to place, of
    /// what is the same everywhere, and of what is drawn between measured places.
    pub fn sigma_m3(&self, errors: &ChangeErrors) -> [f64; 3] {
        let averaged = PI * errors.range_m.powi(2) / (5.0 * self.area_m2.max(f64::MIN_POSITIVE));
        let random = (self.area_m2 * self.variance_m4 * averaged.min(1.0)).sqrt();
        let systematic = self.area_m2 * errors.systematic_m;
        [random, systematic, self.between_m6.sqrt()]
    }

    /// Half the width of the interval that holds the volume with 95 %, cubic metres.
    pub fn within_95_m3(&self, errors: &ChangeErrors) -> f64 {
        let [random, systematic, between] = self.sigma_m3(errors);
        WITHIN_95 * random.hypot(systematic).hypot(between)
    }
}

/// The change over all cells that both maps know.
#[derive(Clone, Debug, Default)]
pub struct ChangeTotals {
    /// All cells, whether their change is detected or not.
    pub all: ChangeSum,
    /// The places where the bottom rose, from detected cells to the rim.
    pub fill: ChangeSum,
    /// The places where it sank.
    pub cut: ChangeSum,
    /// Both: errors that are the same everywhere move fill and cut together.
    pub net: ChangeSum,
    /// The cells outside of these places.
    undetected: ChangeSum,
    /// Cells by their change in whole millimetres.
    rises_mm: BTreeMap<i64, usize>,
    levels_mm: BTreeMap<i64, usize>,
}

impl ChangeTotals {
    /// Counts the cells of a raster and the places where it changed.
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
            if let Some(cell) = field.cell(index) {
                self.count(&cell, is_inside, errors);
            }
        }
    }

    fn count(&mut self, cell: &CellChange, is_inside: bool, errors: &ChangeErrors) {
        self.all.add(cell);
        if !is_inside {
            self.undetected.add(cell);
        }
        for (counts, metres) in [
            (&mut self.rises_mm, cell.rise_m),
            (&mut self.levels_mm, cell.detection_level_m(errors)),
        ] {
            *counts.entry((1e3 * metres).round() as i64).or_default() += 1;
        }
    }

    /// The most fill and the most cut that may hide where nothing is detected, cubic metres: the
    /// end of the interval of 95 %.
    pub fn hidden_m3(&self, errors: &ChangeErrors) -> [f64; 2] {
        let within_m3 = self.undetected.within_95_m3(errors);
        let volume_m3 = self.undetected.volume_m3;
        [volume_m3, -volume_m3].map(|volume_m3| (volume_m3 + within_m3).max(0.0))
    }

    /// The median rise, metres: where most of the bottom did not change, what one map is set off
    /// from the other.
    pub fn median_rise_m(&self) -> Option<f64> {
        share_m(&self.rises_mm, self.all.cells, 0.5)
    }

    /// The median level of detection, metres.
    pub fn median_level_m(&self) -> Option<f64> {
        share_m(&self.levels_mm, self.all.cells, 0.5)
    }

    /// The change that 98 of 100 cells do not exceed either way, metres: what a scale of colours
    /// should reach to.
    pub fn reach_m(&self) -> f64 {
        let ends = [0.01, 0.99].map(|share| share_m(&self.rises_mm, self.all.cells, share));
        ends.into_iter().flatten().map(f64::abs).fold(0.0, f64::max)
    }
}

/// Returns the quantile of the counted values at `share`, metres; `None` without any.
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
