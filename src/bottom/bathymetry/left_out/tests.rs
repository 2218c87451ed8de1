//! Tests of stated errors against beds that are known.

use super::*;
use crate::bathymetry::testing::{point, random};
use crate::bathymetry::{Spread, Surface, SurfaceSettings, surface};

/// Four lines 8 m apart over a bed, a sounding each half metre, with noise of `noise_m`.
fn lines(noise_m: f64, bed: impl Fn(f64, f64) -> f64) -> Vec<DepthPoint> {
    let points = (0..4).flat_map(|line| (0..160).map(move |step| (line, step)));
    let places = points.map(|(line, step)| (0.5 * f64::from(step), 8.0 * f64::from(line)));
    let mut random = random();
    // The sum of twelve random numbers has a standard deviation of 1 about 6.
    let mut noise = move || noise_m * ((0..12).map(|_| random()).sum::<f64>() - 6.0);
    places.map(|(east_m, north_m)| point(east_m, north_m, bed(east_m, north_m) + noise())).collect()
}

fn made(points: Vec<DepthPoint>) -> Surface {
    let settings = SurfaceSettings { cell_m: Some(0.5), ..SurfaceSettings::default() };
    let made = surface(points, &settings, &Progress::new());
    made.expect("not cancelled").expect("a surface")
}

/// Error and stated deviation of every known cell, with its place.
fn cells(made: &Surface, bed: impl Fn(f64, f64) -> f64) -> Vec<([f64; 2], f64, f64)> {
    let cell = |cell: usize| {
        let place = made.grid.centre_of(cell);
        let depth_m = made.depth_m[cell];
        let error_m = f64::from(depth_m) - bed(place[0], place[1]);
        (!depth_m.is_nan()).then(|| (place, error_m, f64::from(made.spread_m[cell])))
    };
    (0..made.grid.len()).filter_map(cell).collect()
}

#[test]
fn few_soundings_leave_the_spread_as_it_is() {
    let few: Vec<DepthPoint> =
        lines(0.0, |east_m, _| 3.0 + 0.01 * east_m).into_iter().step_by(32).collect();
    assert_eq!(made(few).spread_is, Spread::OfSoundings);
}

#[test]
fn the_stated_error_grows_away_from_soundings_and_holds_what_it_says() {
    // Lengths of 19 and 16 m in two directions, and noise of 2 cm.
    let bed = |east_m: f64, north_m: f64| {
        3.0 + 0.15 * (north_m / 3.0 + east_m / 2.5).sin()
            + 0.1 * (east_m / 2.7 - north_m / 3.0).cos()
    };
    let made = made(lines(0.02, bed));
    assert_eq!(made.spread_is, Spread::OfError);
    let cells = cells(&made, bed);
    // On the lines, and between them.
    for (band, least) in [(0.0..0.5, 0.005), (1.5..4.1, 0.03)] {
        let off_m = |north_m: f64| (north_m / 8.0 - (north_m / 8.0).round()).abs() * 8.0;
        let here = cells.iter().filter(|(place, ..)| band.contains(&off_m(place[1])));
        let ratios: Vec<f64> = here
            .map(|(_, error_m, sigma_m)| {
                assert!(*sigma_m > least, "{sigma_m}");
                error_m.abs() / sigma_m
            })
            .collect();
        let share_within = |sigmas: f64| {
            ratios.iter().filter(|ratio| **ratio < sigmas).count() as f64 / ratios.len() as f64
        };
        let [one, two] = [share_within(1.0), share_within(2.0)];
        assert!((0.45..0.9).contains(&one) && two > 0.8, "{band:?}: {one} {two}");
    }
}

#[test]
fn a_bank_along_the_lines_is_worth_as_little_as_its_bends_show() {
    let bed = |_: f64, north_m: f64| 3.0 + 0.01 * (north_m - 12.0).powi(2);
    let made = made(lines(0.02, bed));
    let between = |place: &[f64; 2]| (2.5..5.5).contains(&place[1].rem_euclid(8.0));
    let cells = cells(&made, bed);
    let here: Vec<(f64, f64)> = cells
        .iter()
        .filter(|(place, ..)| between(place))
        .map(|(_, error_m, sigma_m)| (*error_m, *sigma_m))
        .collect();
    let rms_m =
        (here.iter().map(|(error_m, _)| error_m * error_m).sum::<f64>() / here.len() as f64).sqrt();
    let count_within =
        here.iter().filter(|(error_m, sigma_m)| error_m.abs() < 2.0 * sigma_m).count();
    assert!(rms_m > 0.1, "{rms_m}");
    assert!(count_within as f64 > 0.9 * here.len() as f64, "{count_within} of {}", here.len());
}

#[test]
fn triangles_bend_where_slopes_across_the_lines_were_seen_and_are_straight_elsewhere() {
    let bed = |_: f64, north_m: f64| 3.0 + 0.01 * (north_m - 12.0).powi(2);
    let beside = |away_m: f64| {
        let points = lines(0.01, bed).into_iter();
        points.map(move |at| DepthPoint {
            north_m: at.north_m + away_m,
            depth_m: at.depth_m + bed(0.0, at.north_m + away_m) - bed(0.0, at.north_m),
            is_sounding: false,
            ..at
        })
    };
    let rms_m = |made: &Surface| {
        let between = |place: &[f64; 2]| (2.5..5.5).contains(&place[1].rem_euclid(8.0));
        let cells = cells(made, bed);
        let here = cells.iter().filter(|(place, ..)| between(place) && place[1] < 24.0);
        let errors: Vec<f64> = here.map(|(_, error_m, _)| error_m * error_m).collect();
        (errors.iter().sum::<f64>() / errors.len() as f64).sqrt()
    };
    let straight = made(lines(0.01, bed));
    assert_eq!(straight.bends, None);
    let bent = made(lines(0.01, bed).into_iter().chain(beside(-1.5)).chain(beside(1.5)).collect());
    let bends = bent.bends.expect("slopes");
    assert!(bends.left_out_m[1] < 0.8 * bends.left_out_m[0], "{bends:?}");
    assert!(bent.method_in_words().contains("bent"));
    assert!(rms_m(&bent) < 0.4 * rms_m(&straight), "{} {}", rms_m(&bent), rms_m(&straight));
}

#[test]
fn lines_are_found_in_any_direction_and_scattered_soundings_lie_along_none() {
    for degrees in [0.0, 20.0, 90.0, 135.0_f64] {
        let (sin, cos) = degrees.to_radians().sin_cos();
        let places: Vec<[f64; 2]> = lines(0.0, |_, _| 3.0)
            .iter()
            .map(|at| [at.east_m * cos - at.north_m * sin, at.east_m * sin + at.north_m * cos])
            .collect();
        let [x, y] = direction(&places).expect("a direction");
        assert!((x * sin - y * cos).abs() < 0.02, "{degrees}: {x} {y}");
    }
    let mut random = random();
    let scattered: Vec<[f64; 2]> =
        (0..2000).map(|_| [100.0 * random(), 100.0 * random()]).collect();
    assert_eq!(direction(&scattered), None);
}

#[test]
fn rough_ground_is_worth_less_than_level_ground() {
    let bed = |east_m: f64, north_m: f64| {
        let rough = f64::from(u8::from(east_m > 40.0));
        3.0 + rough * 0.3 * (east_m / 2.0).sin() * (north_m / 2.0).cos()
    };
    let made = made(lines(0.01, bed));
    let mean_m = |level: bool| {
        let here = cells(&made, bed).into_iter();
        let here =
            here.filter(|([east_m, _], ..)| if level { *east_m < 25.0 } else { *east_m > 55.0 });
        let sigmas: Vec<f64> = here.map(|(.., sigma_m)| sigma_m).collect();
        sigmas.iter().sum::<f64>() / sigmas.len() as f64
    };
    assert!(mean_m(false) > 2.0 * mean_m(true), "{} {}", mean_m(false), mean_m(true));
}

#[test]
fn a_cancelled_search_states_nothing() {
    let progress = Progress::new();
    progress.cancel();
    assert!(sigma_by_distance(&lines(0.0, |_, _| 3.0), 20.0, &progress).is_err());
}
