use super::*;

const ERRORS: ChangeErrors = ChangeErrors { systematic_m: 0.03, range_m: 5.0 };

fn cell(rise_m: f64) -> CellChange {
    CellChange { rise_m, sigma_m: 0.04, area_m2: 0.25 }
}

/// Number of cells along a side of the test raster; a cell has half a metre.
const SIDE: usize = 40;

/// Test raster of rises, with a noise of a centimetre that is the same in each run; only some of
/// its columns are measured.
struct Field {
    rise_m: Vec<f32>,
    sigma_m: Vec<f32>,
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
            is_measured: cells.map(|cell| [(cell % SIDE).is_multiple_of(every); 2]).collect(),
        }
    }

    fn field(&self) -> ChangeField<'_> {
        ChangeField {
            columns: SIDE,
            cell_area_m2: 0.25,
            rise_m: &self.rise_m,
            sigma_m: &self.sigma_m,
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

/// Returns the rise of a mound of 40 cm with a standard deviation of 1.5 m and of a hollow of 60 cm
/// with a standard deviation of 1 m, plus an offset of 1 cm.
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
    // Half a metre of fill in a third of the map is none of what sets one map off from the other.
    let third = Field::new(1, |east_m, _| 0.5 * f64::from(u8::from(east_m < 7.0))).totals();
    assert!((third.fill.volume_m3 - 0.5 * 7.0 * 20.0).abs() < 2.0, "{third:?}");
    let quiet = Field::new(1, |_, _| 0.02).totals();
    assert_eq!([quiet.fill.cells, quiet.cut.cells], [0, 0]);
    let [fill_m3, cut_m3] = quiet.hidden_m3(&ERRORS);
    let volume_m3 = 0.02 * 400.0;
    assert!((fill_m3 - cut_m3 - 2.0 * volume_m3).abs() < 0.5 && cut_m3 > volume_m3);
}

#[test]
fn what_is_drawn_between_lines_is_uncertain_and_what_lies_within_the_width_of_a_change_is_not() {
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
fn stated_errors_stand_where_the_maps_have_other_lines() {
    let mut made = drawn(|_, _| 0.01);
    for (cell, of) in made.is_measured.iter_mut().enumerate() {
        *of = [0, 3].map(|off| (cell % SIDE + off).is_multiple_of(6));
    }
    let found = made.field().observed_errors(&ERRORS);
    assert_eq!(found.sigma_m, made.sigma_m);
    assert_eq!((found.share, found.range_m), (1.0, ERRORS.range_m));
}
