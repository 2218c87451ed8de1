//! The plate against scipy's solution of the same equations, and what it does with soundings that are wrong.

use super::equations::{Equations, Knot};
use super::plate::around;
use super::*;
use crate::bathymetry::{DepthPoint, Grid, SurfaceMethod, SurfaceSettings, surface};

const GRID: Grid = Grid {
    west_m: 100.0,
    north_m: 200.0,
    cell_m: 0.5,
    columns: 30,
    rows: 25,
};

const USUAL: Search = Search {
    give: USUAL_GIVE,
    solved: SOLVED,
};

/// East of the west edge, south of the north edge and depth, metres.
const SOUNDINGS: [[f64; 3]; 10] = [
    [1.3, 2.1, 2.09],
    [4.9, 10.3, 1.88],
    [7.7, 6.2, 2.54],
    [12.1, 3.3, 3.07],
    [13.6, 11.4, 2.81],
    [9.2, 9.9, 2.38],
    [3.1, 7.4, 1.99],
    [6.4, 1.2, 2.8],
    [10.8, 6.6, 2.75],
    [2.2, 11.7, 1.52],
];

/// Row, column and depth by `scipy.sparse.linalg.spsolve` of the equations written out: bilinear soundings, second differences in both
/// directions, twists times the root of two, all differences over `1.6 * 0.5 m`. No sounding is missed by more than is usual.
const SOLVED_BY_SCIPY: [(usize, usize, f64); 5] = [
    (0, 0, 2.079_335_293_732),
    (3, 20, 3.055_490_240_291),
    (12, 15, 2.527_783_257_154),
    (24, 29, 2.897_112_833_586),
    (20, 4, 1.645_334_729_438),
];

fn nodes(soundings: &[[f64; 3]]) -> Vec<Node> {
    let node = |[east_m, south_m, depth_m]: &[f64; 3]| Node {
        east_m: GRID.west_m + east_m,
        north_m: GRID.north_m - south_m,
        depth_m: *depth_m,
        spread_m: 0.0,
    };
    soundings.iter().map(node).collect()
}

#[test]
fn a_plate_is_what_scipy_makes_of_its_equations() {
    let plate = Plate::through(&GRID, &nodes(&SOUNDINGS), USUAL, &Progress::new()).unwrap();
    for (row, column, depth_m) in SOLVED_BY_SCIPY {
        let made_m = plate.depth_at(GRID.centre(row, column));
        assert!((made_m - depth_m).abs() < 1e-3, "{row} {column}: {made_m}");
    }
}

#[test]
fn what_soundings_hold_is_the_same_cell_by_cell_as_one_by_one() {
    for [columns, rows] in [[1, 1], [1, 5], [5, 1], [2, 2], [4, 3]] {
        let grid = Grid {
            columns,
            rows,
            ..GRID
        };
        let (wide_m, high_m) = (0.5 * columns as f64, 0.5 * rows as f64);
        let knots: Vec<Knot> = (0..40_u32)
            .map(|index| {
                let [right, down] =
                    [7, 11].map(|times| f64::from(index * times % 40) / 40.0 * 1.2 - 0.1);
                let place = [GRID.west_m + right * wide_m, GRID.north_m - down * high_m];
                let (cells, shares) = around(&grid, place);
                Knot {
                    cells,
                    shares,
                    depth_m: 0.0,
                    weight: 0.2 + f64::from(index % 5),
                }
            })
            .collect();
        let depth_m: Vec<f64> = (0..grid.len()).map(|cell| (cell as f64).sin()).collect();
        let mut expected = vec![0.0; grid.len()];
        for knot in &knots {
            let parts = || knot.cells.iter().zip(&knot.shares);
            let found_m: f64 = parts().map(|(cell, share)| share * depth_m[*cell]).sum();
            for (cell, share) in parts() {
                expected[*cell] += knot.weight * share * found_m;
            }
        }
        let mut made = vec![0.0; grid.len()];
        Equations::new([columns, rows], 0.0, knots).times(&depth_m, &mut made);
        for (made, expected) in made.iter().zip(&expected) {
            assert!((made - expected).abs() < 1e-12, "{columns} x {rows}");
        }
    }
}

/// Four lines 8 m apart over a bed, a sounding each half metre.
fn lines(bed: impl Fn(f64, f64) -> f64) -> Vec<DepthPoint> {
    let points = (0..4).flat_map(|line| (0..80).map(move |step| (line, step)));
    let places = points.map(|(line, step)| (0.5 * f64::from(step), 8.0 * f64::from(line)));
    let point = |(east_m, north_m)| DepthPoint {
        east_m,
        north_m,
        depth_m: bed(east_m, north_m),
        weight: 1.0,
        is_sounding: true,
    };
    places.map(point).collect()
}

fn made(points: Vec<DepthPoint>, method: SurfaceMethod) -> Surface {
    let settings = SurfaceSettings {
        method,
        cell_m: Some(0.5),
        ..SurfaceSettings::default()
    };
    let made = surface(points, &settings, &Progress::new());
    made.expect("not cancelled").expect("a surface")
}

/// Root mean square of a surface's errors, metres.
fn rms_m(made: &Surface, bed: impl Fn(f64, f64) -> f64) -> f64 {
    let errors = (0..made.grid.len()).filter_map(|cell| {
        let [east_m, north_m] = made
            .grid
            .centre(cell / made.grid.columns, cell % made.grid.columns);
        let depth_m = made.depth_m[cell];
        (!depth_m.is_nan()).then(|| f64::from(depth_m) - bed(east_m, north_m))
    });
    let errors: Vec<f64> = errors.collect();
    (errors.iter().map(|error| error * error).sum::<f64>() / errors.len() as f64).sqrt()
}

#[test]
fn a_slope_is_kept_and_a_swell_is_closer_than_between_triangles() {
    let slope = |east_m: f64, north_m: f64| 3.0 + 0.05 * east_m - 0.02 * north_m;
    let plate = made(lines(slope), SurfaceMethod::Smooth);
    assert!(rms_m(&plate, slope) < 2e-3, "{}", rms_m(&plate, slope));
    let swell = |east_m: f64, north_m: f64| 3.0 + 0.4 * (east_m / 4.0 + north_m / 5.0).sin();
    let [plate, triangles] = [SurfaceMethod::Smooth, SurfaceMethod::Linear]
        .map(|method| rms_m(&made(lines(swell), method), swell));
    // Beyond the second line from the edge nothing bends a plate: there it is hardly nearer than triangles.
    assert!(plate < 0.8 * triangles, "{plate} {triangles}");
}

#[test]
fn what_predicts_left_out_soundings_better_is_taken_and_says_what_it_is_worth() {
    let swell = |east_m: f64, north_m: f64| 3.0 + 0.4 * (east_m / 4.0 + north_m / 5.0).sin();
    let [auto, plate] =
        [SurfaceMethod::Auto, SurfaceMethod::Smooth].map(|method| made(lines(swell), method));
    assert_eq!(auto, plate);
    assert_eq!(
        (auto.method, auto.spread_is),
        (SurfaceMethod::Smooth, Spread::OfError)
    );
    // A ditch with edges, across the lines: triangles follow it, a plate cuts its edges.
    let ditch = |east_m: f64, _: f64| 3.0 + f64::from(u8::from((18.0..22.0).contains(&east_m)));
    let [auto, triangles] =
        [SurfaceMethod::Auto, SurfaceMethod::Linear].map(|method| made(lines(ditch), method));
    assert_eq!(
        (auto.method, auto.spread_is),
        (SurfaceMethod::Linear, Spread::OfError)
    );
    let same = auto
        .depth_m
        .iter()
        .zip(&triangles.depth_m)
        .all(|(a, b)| a.to_bits() == b.to_bits());
    assert!(same);
}

#[test]
fn few_soundings_leave_triangles_and_their_spread() {
    let few: Vec<DepthPoint> = lines(|east_m, _| 3.0 + 0.01 * east_m)
        .into_iter()
        .step_by(16)
        .collect();
    let [auto, triangles] =
        [SurfaceMethod::Auto, SurfaceMethod::Linear].map(|method| made(few.clone(), method));
    assert_eq!(
        (auto.method, auto.spread_is),
        (SurfaceMethod::Linear, Spread::OfSoundings)
    );
    let spreads = auto.spread_m.iter().zip(&triangles.spread_m);
    assert!(spreads.into_iter().all(|(a, b)| a.to_bits() == b.to_bits()));
}

#[test]
fn a_wrong_sounding_does_not_pull_the_plate_up() {
    let slope = |east_m: f64, north_m: f64| 3.0 + 0.05 * east_m - 0.02 * north_m;
    let mut points = lines(slope);
    // Fish: 1 m shallower, one sounding of forty.
    for point in points.iter_mut().step_by(40) {
        point.depth_m -= 1.0;
    }
    let plate = made(points, SurfaceMethod::Smooth);
    assert!(rms_m(&plate, slope) < 0.05, "{}", rms_m(&plate, slope));
}

#[test]
fn the_stated_error_grows_away_from_soundings_and_holds_what_it_says() {
    // Lengths of 12 and 9 m in two directions: lines 8 m apart do not resolve them.
    let bed = |east_m: f64, north_m: f64| {
        3.0 + 0.15 * (north_m / 3.0 + east_m / 2.5).sin()
            + 0.1 * (east_m / 1.7 - north_m / 3.0).cos()
    };
    let plate = made(lines(bed), SurfaceMethod::Smooth);
    let sigma_m =
        |place: [f64; 2]| plate.spread_m[plate.grid.index_at(place[0], place[1]).unwrap()];
    assert!(sigma_m([20.2, 12.2]) > 2.0 * sigma_m([20.2, 8.2]));
    let (mut within, mut known) = (0, 0);
    for cell in 0..plate.grid.len() {
        let [east_m, north_m] = plate
            .grid
            .centre(cell / plate.grid.columns, cell % plate.grid.columns);
        if !plate.depth_m[cell].is_nan() {
            let error_m = f64::from(plate.depth_m[cell]) - bed(east_m, north_m);
            within += usize::from(error_m.abs() < 2.0 * f64::from(plate.spread_m[cell]));
            known += 1;
        }
    }
    let share = within as f64 / known as f64;
    assert!(share > 0.85, "{share}");
}

#[test]
fn a_cancelled_plate_is_none() {
    let progress = Progress::new();
    progress.cancel();
    let plate = Plate::through(&GRID, &nodes(&SOUNDINGS), USUAL, &progress);
    assert!(plate.is_err());
}
