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
mod tests {
    use super::*;

    const ERRORS: ChangeErrors = ChangeErrors { systematic_m: 0.03, range_m: 5.0 };

    fn cell(rise_m: f64) -> CellChange {
        CellChange { rise_m, sigma_m: 0.04, area_m2: 0.25 }
    }

    /// Number of cells along a side of the test raster; a cell has half a metre.
    const SIDE: usize = 40;

    /// Test raster of rises, with a noise of a centimetre that is the same in each run; only some
    /// of its columns are measured.
    struct Field {
        rise_m: Vec<f32>,
        sigma_m: Vec<f32>,
        stated_m: Vec<f32>,
        is_measured: Vec<[bool; 2]>,
    }

    impl Field {
        fn new(every: usize, rise_m: impl Fn(f64, f64) -> f64) -> Self {
            let cells = 0..SIDE * SIDE;
            let at = |cell: usize| [cell % SIDE, cell / SIDE].map(|count| 0.5 * count as f64);
            let noisy = cells.clone().map(|cell| {
                let [east_m, south_m] = at(cell);
                let noise_m = 0.01 * (1.3 * (cell * cell % 97) as f64).sin();
                (rise_m(east_m, south_m) + noise_m) as f32
            });
            Self {
                rise_m: noisy.collect(),
                sigma_m: vec![0.02; SIDE * SIDE],
                stated_m: vec![0.02; SIDE * SIDE],
                is_measured: cells.map(|cell| [(cell % SIDE).is_multiple_of(every); 2]).collect(),
            }
        }

        fn field(&self) -> ChangeField<'_> {
            ChangeField {
                columns: SIDE,
                cell_area_m2: 0.25,
                rise_m: &self.rise_m,
                sigma_m: &self.sigma_m,
                stated_m: &self.stated_m,
                is_measured: &self.is_measured,
            }
        }

        fn totals(&self) -> ChangeTotals {
            let mut totals = ChangeTotals::default();
            let field = self.field();
            totals.add(&field, &field.regions(&ERRORS), &ERRORS);
            totals
        }
    }

    /// Returns the rise of a mound of 40 cm with a standard deviation of 1.5 m and of a hollow of
    /// 60 cm with a standard deviation of 1 m, plus an offset of 1 cm.
    fn mound_and_hollow(east_m: f64, south_m: f64) -> f64 {
        let bump = |east: f64, south: f64, sd: f64| {
            (-0.5 * ((east_m - east).powi(2) + (south_m - south).powi(2)) / (sd * sd)).exp()
        };
        0.01 + 0.4 * bump(6.0, 6.0, 1.5) - 0.6 * bump(14.0, 13.0, 1.0)
    }

    #[test]
    fn a_place_has_its_whole_volume_and_noise_has_none() {
        assert!((cell(0.0).detection_level_m(&ERRORS) - 0.098).abs() < 1e-12);
        let totals = Field::new(1, mound_and_hollow).totals();
        let truth_m3 = [2.0 * PI * 0.4 * 2.25, -2.0 * PI * 0.6];
        for (sum, truth_m3) in [totals.fill, totals.cut].iter().zip(truth_m3) {
            assert_eq!(sum.places, 1);
            // The volume includes the offset, since it cannot be distinguished from a change.
            let offset_m3 = 0.01 * sum.area_m2;
            let off_m3 = sum.volume_m3 - offset_m3 - truth_m3;
            assert!(off_m3.abs() < 0.05 * truth_m3.abs(), "{sum:?} {truth_m3}");
            assert!(off_m3.abs() < sum.within_95_m3(&ERRORS));
            assert_eq!(sum.sigma_m3(&ERRORS)[2], 0.0, "all cells are measured");
        }
        assert_eq!(totals.net.places, 2);
        assert_eq!(totals.all.cells, SIDE * SIDE);
        assert_eq!(totals.undetected.cells + totals.net.cells, SIDE * SIDE);
        assert!((totals.median_rise_m().expect("cells") - 0.01).abs() < 0.004);

        let raised = Field::new(1, |_, _| 0.3).totals();
        assert_eq!(raised.fill.cells, SIDE * SIDE, "no cell is left to say what noise is");
        // Half a metre of fill in a third of the map is none of what sets one map off from the
        // other.
        let third = Field::new(1, |east_m, _| 0.5 * f64::from(u8::from(east_m < 7.0))).totals();
        assert!((third.fill.volume_m3 - 0.5 * 7.0 * 20.0).abs() < 2.0, "{third:?}");
        let quiet = Field::new(1, |_, _| 0.02).totals();
        assert_eq!([quiet.fill.cells, quiet.cut.cells], [0, 0]);
        let [fill_m3, cut_m3] = quiet.hidden_m3(&ERRORS);
        let volume_m3 = 0.02 * 400.0;
        assert!((fill_m3 - cut_m3 - 2.0 * volume_m3).abs() < 0.5 && cut_m3 > volume_m3);
    }

    #[test]
    fn what_is_drawn_between_lines_is_uncertain_and_what_lies_within_the_width_of_a_change_is_not()
    {
        // Lines 12 m apart cross the middle of a mound of 1.5 m; between them its map is straight.
        let straight = |east_m: f64, south_m: f64| {
            let along = (-0.5 * ((south_m - 10.0) / 1.5_f64).powi(2)).exp();
            0.5 * along * (1.0 - (east_m - 12.0).abs() / 12.0).max(0.0)
        };
        let fill = Field::new(24, straight).totals().fill;
        let truth_m3 = 2.0 * PI * 0.5 * 2.25;
        assert!(fill.volume_m3 > 2.0 * truth_m3, "{fill:?}");
        let within_m3 = fill.within_95_m3(&ERRORS);
        assert!((fill.volume_m3 - truth_m3).abs() < within_m3 && within_m3 < 1.6 * fill.volume_m3);
        // Lines 1.5 m apart leave nothing to guess.
        let dense = Field::new(3, mound_and_hollow).totals().fill;
        let [random, _, between] = dense.sigma_m3(&ERRORS);
        assert!(between > 0.0 && between < random, "{dense:?}");
    }

    #[test]
    fn the_edges_of_a_change_along_a_line_lie_anywhere_up_to_the_next_lines() {
        // 0.4 m of fill along the middle one of three lines 6 m apart, over all of the map.
        let drawn = |east_m: f64, _| 0.4 * (1.0 - (east_m - 6.0).abs() / 6.0).max(0.0);
        let fill = Field::new(12, drawn).totals().fill;
        let [_, _, between_m3] = fill.sigma_m3(&ERRORS);
        // Two edges, each evenly distributed over 6 m, along 20 m.
        let expected_m3 = (2.0_f64 / 12.0).sqrt() * 0.4 * 6.0 * 20.0;
        assert!((0.7..1.2).contains(&(between_m3 / expected_m3)), "{between_m3} {expected_m3}");
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
        assert!((small[0] - 0.4).abs() < 1e-9 && (small[1] - 0.3).abs() < 1e-9, "{small:?}");
        let expected = 10_000.0 * 0.04 * (PI * 25.0 / 50_000.0_f64).sqrt();
        assert!((large[0] - expected).abs() < 1e-6 && (large[1] - 300.0).abs() < 1e-6, "{large:?}");
        assert!((sum(40).within_95_m3(&ERRORS) - 1.96 * 0.5).abs() < 1e-9);
        assert_eq!(ChangeSum::default().within_95_m3(&ERRORS), 0.0);
    }

    /// Errors of half a metre are stated between lines 3 m apart.
    fn drawn(rise_m: impl Fn(f64, f64) -> f64) -> Field {
        let mut made = Field::new(6, rise_m);
        for (sigma_m, of) in made.sigma_m.iter_mut().zip(&made.is_measured) {
            *sigma_m = if of[0] { 0.02 } else { 0.5 };
        }
        made.stated_m.clone_from(&made.sigma_m);
        made
    }

    #[test]
    fn what_both_maps_draw_alike_between_the_same_lines_is_no_error_of_their_difference() {
        let mut made = drawn(|_, _| 0.01);
        let found = made.field().observed_errors(&ERRORS);
        // The noise of the difference is 7 mm.
        assert!(found.sigma_m.iter().all(|sigma_m| *sigma_m < 0.02), "{found:?}");
        assert!(found.share < 0.03, "{}", found.share);
        assert!(found.range_m < 2.0, "noise is independent from cell to cell: {}", found.range_m);
        // With them a mound of 20 cm is found from rim to rim.
        let mound = |east_m: f64, south_m: f64| {
            0.01 + 0.2 * (-0.125 * ((east_m - 9.0).powi(2) + (south_m - 10.0).powi(2))).exp()
        };
        made = drawn(mound);
        let found = made.field().observed_errors(&ERRORS);
        made.sigma_m = found.sigma_m;
        let totals = made.totals();
        assert_eq!([totals.fill.places, totals.cut.places], [1, 0]);
        let truth_m3 = 2.0 * PI * 0.2 * 4.0;
        let off_m3 = totals.fill.volume_m3 - truth_m3;
        assert!(off_m3.abs() < totals.fill.within_95_m3(&ERRORS).min(0.2 * truth_m3), "{totals:?}");
    }

    #[test]
    fn a_change_that_the_lines_do_not_show_is_an_error_between_them() {
        // A mound of 30 cm between two lines: one of the maps interpolates a bank differently.
        let between = |east_m: f64, south_m: f64| {
            let across = (PI * east_m / 3.0).sin().powi(2);
            0.3 * across * (-0.125 * ((east_m - 10.5).powi(2) + (south_m - 10.0).powi(2))).exp()
        };
        let on_a_line = |east_m: f64, south_m: f64| between(east_m + 1.5, south_m);
        for (rise_m, places) in [(&between as &dyn Fn(f64, f64) -> f64, 0), (&on_a_line, 1)] {
            let mut made = drawn(rise_m);
            made.sigma_m = made.field().observed_errors(&ERRORS).sigma_m;
            let totals = made.totals();
            assert!(totals.all.volume_m3 > 1.0, "{totals:?}");
            assert_eq!(totals.fill.places, places, "{totals:?}");
        }
    }

    #[test]
    fn stated_errors_stand_where_the_maps_have_other_lines() {
        let mut made = drawn(|_, _| 0.01);
        for (cell, of) in made.is_measured.iter_mut().enumerate() {
            *of = [0, 3].map(|off| (cell % SIDE + off).is_multiple_of(6));
        }
        let found = made.field().observed_errors(&ERRORS);
        assert_eq!(found.sigma_m, made.sigma_m);
        assert_eq!((found.share, found.range_m), (1.0, ERRORS.range_m));
    }
}
