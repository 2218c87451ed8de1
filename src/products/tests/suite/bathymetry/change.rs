//! Tests that the interval of a volume holds the truth, over simulated pairs of surveys of a bottom
//! with and without a mound.

use crate::Dice;
use bathyscope_bottom::bathymetry::change::{ChangeErrors, ChangeField, ChangeTotals};
use bathyscope_bottom::bathymetry::{
    CellSource, DepthPoint, Surface, SurfaceMethod, SurfaceSettings, surface,
};
use bathyscope_log::support::progress::Progress;
use std::f64::consts::TAU;

const CELL_M: f64 = 0.5;
const EAST_M: f64 = 48.0;
const NORTH_M: f64 = 60.0;
const ERRORS: ChangeErrors = ChangeErrors { systematic_m: 0.03, range_m: 20.0 };

/// A mound of a Gaussian's shape.
#[derive(Clone, Copy)]
struct Mound {
    place: [f64; 2],
    height_m: f64,
    sd_m: f64,
}

impl Mound {
    fn random(dice: &mut Dice) -> Self {
        Self {
            place: [EAST_M, NORTH_M].map(|side_m| side_m * (0.25 + 0.5 * dice.uniform())),
            height_m: 0.3 + 0.5 * dice.uniform(),
            sd_m: 1.5 + 2.5 * dice.uniform(),
        }
    }

    fn rise_m(&self, [east_m, north_m]: [f64; 2]) -> f64 {
        let away_m2 = (east_m - self.place[0]).powi(2) + (north_m - self.place[1]).powi(2);
        self.height_m * (-0.5 * away_m2 / self.sd_m.powi(2)).exp()
    }

    fn volume_m3(&self) -> f64 {
        TAU * self.height_m * self.sd_m.powi(2)
    }
}

/// The map of a survey on lines so far apart, some time after those of another: soundings every
/// half metre with noise of 2 cm, positions off by 0.3 m a line, and 2 cm of draft that nobody
/// wrote down.
fn survey(spacing_m: f64, phases: [f64; 2], mound: Option<Mound>, dice: &mut Dice) -> Surface {
    let draft_m = dice.normal(0.02);
    let first_m = 0.25 * spacing_m * dice.uniform();
    let lines = (EAST_M / spacing_m) as usize + 1;
    let mut points = Vec::new();
    for line in 0..lines {
        let off_m = [0, 1].map(|_| dice.normal(0.3));
        for step in 0..=(2.0 * NORTH_M) as usize {
            let place = [first_m + line as f64 * spacing_m, 0.5 * step as f64];
            let broad = (place[0] / 14.0 + phases[0]).sin() * (place[1] / 17.0 + phases[1]).cos();
            let rise_m = mound.map_or(0.0, |mound| mound.rise_m(place));
            let depth_m = 2.6 + 0.4 * broad - rise_m + draft_m + dice.normal(0.02);
            let place = [0, 1].map(|axis| place[axis] + off_m[axis]);
            points.push(DepthPoint::of_sounding(place, depth_m));
        }
    }
    let settings = SurfaceSettings {
        method: SurfaceMethod::Linear,
        cell_m: Some(CELL_M),
        ..SurfaceSettings::default()
    };
    let made = surface(points, &settings, &Progress::new());
    made.expect("nobody cancels").expect("a surface")
}

/// Computes the change between the maps, and the errors that they show.
fn change(newer: &Surface, older: &Surface) -> (ChangeTotals, ChangeErrors) {
    let columns = newer.grid.columns;
    let known = |surface: &Surface, cell: usize| {
        let away_m = f64::from(surface.distance_m[cell]);
        let is_measured = surface.source[cell] > CellSource::Interpolated;
        // Between lines a map knows less.
        (surface.depth_m[cell], 0.02 + 0.006 * away_m, is_measured)
    };
    let (mut rise_m, mut sigma_m, mut is_measured) = (Vec::new(), Vec::new(), Vec::new());
    for cell in 0..newer.depth_m.len() {
        let [east_m, north_m] = newer.grid.centre_of(cell);
        let (new_m, new_sigma_m, is_new) = known(newer, cell);
        let other = older.grid.index_at(east_m, north_m);
        let other = other.map(|other| known(older, other));
        let (old_m, old_sigma_m, is_old) = other.unwrap_or((f32::NAN, 0.0, false));
        rise_m.push(old_m - new_m);
        sigma_m.push(new_sigma_m.hypot(old_sigma_m) as f32);
        is_measured.push([is_new, is_old]);
    }
    let field = ChangeField {
        columns,
        cell_area_m2: CELL_M * CELL_M,
        rise_m: &rise_m,
        sigma_m: &sigma_m,
        stated_m: &sigma_m,
        is_measured: &is_measured,
    };
    let observed = field.observed_errors(&ERRORS);
    let errors = ChangeErrors { range_m: observed.range_m, ..ERRORS };
    let field = ChangeField { sigma_m: &observed.sigma_m, ..field };
    let mut totals = ChangeTotals::default();
    totals.add(&field, &field.regions(&errors), &errors);
    (totals, errors)
}

#[test]
fn the_interval_of_a_volume_holds_the_truth_in_95_of_100_pairs() {
    let mut of_all = 0;
    for spacing_m in [4.0, 8.0, 12.0] {
        let mut dice = Dice(11);
        let (mut held, mut detected, mut false_alarms) = (0, 0, 0);
        let (mut shares, mut ratios) = (Vec::new(), Vec::new());
        for _ in 0..100 {
            let phases = [0, 1].map(|_| TAU * dice.uniform());
            let mound = Mound::random(&mut dice);
            let [older, newer, again] =
                [None, Some(mound), None].map(|mound| survey(spacing_m, phases, mound, &mut dice));
            let (totals, errors) = change(&newer, &older);
            let (fill, truth_m3) = (totals.fill, mound.volume_m3());
            let within_m3 = fill.within_95_m3(&errors);
            let holds = match fill.places {
                0 => totals.hidden_m3(&errors)[0] >= truth_m3,
                _ => (fill.volume_m3 - truth_m3).abs() <= within_m3,
            };
            held += usize::from(holds);
            if fill.places > 0 {
                detected += 1;
                shares.push(within_m3 / truth_m3);
                ratios.push(fill.volume_m3 / truth_m3);
            }
            let (same, errors) = change(&again, &older);
            let beyond = |sum: bathyscope_bottom::bathymetry::change::ChangeSum| {
                sum.volume_m3.abs() > sum.within_95_m3(&errors)
            };
            false_alarms += usize::from(beyond(same.fill) || beyond(same.cut));
        }
        let middle = |values: &mut Vec<f64>| {
            values.sort_by(f64::total_cmp);
            values[values.len() / 2]
        };
        let (share, ratio) = (middle(&mut shares), middle(&mut ratios));
        println!(
            "lines {spacing_m} m apart: held {held}, detected {detected}, volume {ratio:.2} and half interval {share:.2} of the truth in the median pair, {false_alarms} false alarms"
        );
        // A mound between lines far apart, of which a line touches the fringe, is larger than any
        // rule can tell.
        assert!(held >= 92, "{spacing_m} m: {held}");
        of_all += held;
        assert!(false_alarms <= 5, "{spacing_m} m: {false_alarms}");
    }
    assert!(of_all >= 285, "{of_all} of 300");
}
