//! How the bottom changed between two depth maps: by how much each cell rose, whether that can be told from their errors, and the volumes that were
//! filled and cut.
//!
//! A change counts where it passes the level of detection, 1.96 times the standard deviation of the difference (Lane, Westaway and Hicks 2003, Earth
//! Surf. Process. Landforms 28; Wheaton et al. 2010, ibid. 35). The standard deviation of a volume has a part that is the same everywhere
//! (draft, water level), and one that varies from place to place and averages out over areas that are larger than its range (Rolstad,
//! Haug and Denby 2009, J. Glaciology 55, equation 8, for a spherical variogram).

use std::collections::BTreeMap;
use std::f64::consts::PI;

/// Standard deviations that 95 % of normal errors do not exceed.
const WITHIN_95: f64 = 1.96;

/// What errors have in common.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChangeErrors {
    /// Standard deviation of what is the same in all cells: draft, water level, sound speed; metres.
    pub systematic_m: f64,
    /// Depths farther apart than this err independently, metres.
    pub range_m: f64,
}

/// What is known of a cell in both maps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CellChange {
    /// How much the bottom rose, metres; negative where it sank.
    pub rise_m: f64,
    /// Standard deviation of the depths' own errors in that, metres.
    pub sigma_m: f64,
    /// Square metres on the ground.
    pub area_m2: f64,
}

impl CellChange {
    /// Changes below it cannot be told from errors, in 95 of 100 cells where there is none; metres.
    pub fn detection_level_m(&self, errors: &ChangeErrors) -> f64 {
        WITHIN_95 * self.sigma_m.hypot(errors.systematic_m)
    }

    /// Whether the change passes it.
    pub fn is_detected(&self, errors: &ChangeErrors) -> bool {
        self.rise_m.abs() > self.detection_level_m(errors)
    }
}

/// Cells together.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ChangeSum {
    /// How many.
    pub cells: usize,
    /// Square metres.
    pub area_m2: f64,
    /// Cubic metres; negative where the bottom sank.
    pub volume_m3: f64,
    /// Of the variances, each by its area.
    variance_m4: f64,
}

impl ChangeSum {
    fn add(&mut self, cell: &CellChange) {
        self.cells += 1;
        self.area_m2 += cell.area_m2;
        self.volume_m3 += cell.area_m2 * cell.rise_m;
        self.variance_m4 += cell.area_m2 * cell.sigma_m.powi(2);
    }

    /// Standard deviation of the volume, cubic metres: of what varies from place to place, and of what is the same everywhere.
    pub fn sigma_m3(&self, errors: &ChangeErrors) -> [f64; 2] {
        let averaged = PI * errors.range_m.powi(2) / (5.0 * self.area_m2.max(f64::MIN_POSITIVE));
        let random = (self.area_m2 * self.variance_m4 * averaged.min(1.0)).sqrt();
        [random, self.area_m2 * errors.systematic_m]
    }

    /// Half the width of the interval that holds the volume with 95 %, cubic metres.
    pub fn within_95_m3(&self, errors: &ChangeErrors) -> f64 {
        let [random, systematic] = self.sigma_m3(errors);
        WITHIN_95 * random.hypot(systematic)
    }
}

/// The change over all cells that both maps know.
#[derive(Clone, Debug, Default)]
pub struct ChangeTotals {
    /// All cells, whether their change is detected or not.
    pub all: ChangeSum,
    /// Where the bottom rose by more than the level of detection.
    pub fill: ChangeSum,
    /// Where it sank by more.
    pub cut: ChangeSum,
    /// Both: errors that are the same everywhere move fill and cut together.
    pub net: ChangeSum,
    /// Cells by their change in whole millimetres.
    rises_mm: BTreeMap<i64, usize>,
    levels_mm: BTreeMap<i64, usize>,
}

impl ChangeTotals {
    /// Counts a cell.
    pub fn add(&mut self, cell: &CellChange, errors: &ChangeErrors) {
        self.all.add(cell);
        if cell.is_detected(errors) {
            self.net.add(cell);
            match cell.rise_m > 0.0 {
                true => self.fill.add(cell),
                false => self.cut.add(cell),
            }
        }
        let level_m = cell.detection_level_m(errors);
        for (counts, metres) in [
            (&mut self.rises_mm, cell.rise_m),
            (&mut self.levels_mm, level_m),
        ] {
            *counts.entry((1e3 * metres).round() as i64).or_default() += 1;
        }
    }

    /// The median rise, metres: where most of the bottom did not change, what one map is set off from the other.
    pub fn median_rise_m(&self) -> Option<f64> {
        share_m(&self.rises_mm, self.all.cells, 0.5)
    }

    /// The median level of detection, metres.
    pub fn median_level_m(&self) -> Option<f64> {
        share_m(&self.levels_mm, self.all.cells, 0.5)
    }

    /// The change that 98 of 100 cells do not exceed either way, metres: what a scale of colours should reach to.
    pub fn reach_m(&self) -> f64 {
        let ends = [0.01, 0.99].map(|share| share_m(&self.rises_mm, self.all.cells, share));
        ends.into_iter().flatten().map(f64::abs).fold(0.0, f64::max)
    }
}

/// The number, in metres, below which so large a share of the counted ones lies.
fn share_m(counts_mm: &BTreeMap<i64, usize>, all: usize, share: f64) -> Option<f64> {
    let mut below = 0;
    let found = counts_mm.iter().find(|(_, count)| {
        below += **count;
        below as f64 >= share * all as f64
    });
    found.map(|(millimetres, _)| *millimetres as f64 * 1e-3)
}

#[cfg(test)]
mod tests {
    use super::*;

    const ERRORS: ChangeErrors = ChangeErrors {
        systematic_m: 0.03,
        range_m: 5.0,
    };

    fn cell(rise_m: f64) -> CellChange {
        CellChange {
            rise_m,
            sigma_m: 0.04,
            area_m2: 0.25,
        }
    }

    #[test]
    fn only_changes_beyond_their_errors_count() {
        assert!((cell(0.0).detection_level_m(&ERRORS) - 0.098).abs() < 1e-12);
        let mut totals = ChangeTotals::default();
        for rise_m in [0.02, 0.09, 0.5, 0.5, -0.05, -0.3] {
            totals.add(&cell(rise_m), &ERRORS);
        }
        assert_eq!(
            [totals.all, totals.fill, totals.cut, totals.net].map(|sum| sum.cells),
            [6, 2, 1, 3]
        );
        assert!((totals.fill.volume_m3 - 0.25).abs() < 1e-12);
        assert!((totals.cut.volume_m3 + 0.075).abs() < 1e-12);
        assert!((totals.net.volume_m3 - 0.175).abs() < 1e-12);
        assert_eq!(totals.median_rise_m(), Some(0.02));
        assert_eq!(totals.median_level_m(), Some(0.098));
        assert_eq!(totals.reach_m(), 0.5);
        assert_eq!(ChangeTotals::default().median_rise_m(), None);
    }

    #[test]
    fn errors_of_a_volume_average_out_over_large_areas_but_for_what_is_the_same_everywhere() {
        let sum = |cells: usize| {
            let mut sum = ChangeSum::default();
            (0..cells).for_each(|_| sum.add(&cell(0.2)));
            sum
        };
        // 10 m2 are within the range: all err together. 10 000 m2: by sqrt(pi 25 / 50 000).
        let [small, large] = [40, 40_000].map(|cells| sum(cells).sigma_m3(&ERRORS));
        assert!(
            (small[0] - 0.4).abs() < 1e-9 && (small[1] - 0.3).abs() < 1e-9,
            "{small:?}"
        );
        let expected = 10_000.0 * 0.04 * (PI * 25.0 / 50_000.0_f64).sqrt();
        assert!(
            (large[0] - expected).abs() < 1e-6 && (large[1] - 300.0).abs() < 1e-6,
            "{large:?}"
        );
        assert!((sum(40).within_95_m3(&ERRORS) - 1.96 * 0.5).abs() < 1e-9);
        assert_eq!(ChangeSum::default().within_95_m3(&ERRORS), 0.0);
    }
}
