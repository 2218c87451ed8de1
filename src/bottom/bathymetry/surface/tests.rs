use super::*;
use crate::bathymetry::local_surface;
use crate::bathymetry::testing::{GOLDEN, golden_nodes, golden_points};
use bathyscope_log::support::statistics::ends;

fn line(north_m: f64, depth_m: f64) -> impl Iterator<Item = DepthPoint> {
    (0..=40).map(move |i| DepthPoint::of_sounding([f64::from(i), north_m], depth_m))
}

fn settings(gap_m: f64) -> SurfaceSettings {
    SurfaceSettings {
        method: SurfaceMethod::Linear,
        max_gap_m: gap_m,
        cell_m: Some(0.5),
        ..SurfaceSettings::default()
    }
}

fn made(points: Vec<DepthPoint>, gap_m: f64) -> Surface {
    let made = surface(points, &settings(gap_m), &Progress::new());
    made.unwrap().unwrap()
}

#[test]
fn between_two_lines_the_depth_is_linear() {
    let points: Vec<_> = line(0.0, 2.0).chain(line(10.0, 4.0)).collect();
    let map = made(points.clone(), 6.0);
    let (depth_m, distance_m) = map.at(20.0, 5.0).unwrap();
    assert!((depth_m - 3.0).abs() < 0.06, "{depth_m}");
    assert!((distance_m - 5.0).abs() < 0.3, "{distance_m}");
    assert_eq!(map.at(20.0, 11.0), None);
}

/// A boat at rest: nine places with six soundings each that differ by 8 cm.
#[test]
fn where_too_few_soundings_state_an_error_it_is_their_disagreement() {
    let sounding = |index: u32| {
        let place = index / 6;
        let [east_m, north_m] =
            [0.1 + 0.5 * f64::from(place % 3), 0.1 + 0.5 * f64::from(place / 3)];
        DepthPoint::of_sounding([east_m, north_m], 10.0 + 0.08 * f64::from(index % 2))
    };
    let map = made((0..54).map(sounding).collect(), 6.0);
    assert_eq!((map.spread_is, map.usual_error_m()), (Spread::OfSoundings, None));
    let disagreement_m = map.measured_error_m().unwrap();
    assert!((0.02..0.08).contains(&disagreement_m), "{disagreement_m}");
    let by_distance = Surface { method: SurfaceMethod::InverseDistance, ..map };
    assert_eq!(by_distance.measured_error_m(), None);
}

#[test]
fn a_cell_says_what_its_depth_rests_on() {
    let beside = line(0.6, 2.0).map(|point| DepthPoint { is_sounding: false, ..point });
    let points = line(0.0, 2.0).chain(beside).chain(line(10.0, 4.0)).collect();
    let map = made(points, 6.0);
    let at = |east_m, north_m| map.source[map.grid.index_at(east_m, north_m).unwrap()];
    assert_eq!(at(20.0, 0.01), CellSource::Sounding);
    assert_eq!(at(20.0, 0.61), CellSource::FirstReturn);
    assert_eq!(at(20.0, 5.0), CellSource::Interpolated);
    let known = map.depth_m.iter().map(|depth_m| !depth_m.is_nan());
    assert!(known.eq(map.source.iter().map(|source| *source != CellSource::None)));
    let [sounding, first_return, from_levels, interpolated] = map.source_shares();
    assert_eq!(from_levels, 0.0);
    assert!((sounding + first_return + interpolated - 1.0).abs() < 1e-12);
    assert!(interpolated > 0.8 && sounding > first_return && first_return > 0.0);
}

#[test]
fn no_value_is_farther_than_the_gap_from_a_sounding() {
    // Triangles of equal sides, 5.9 m: their middles are 3.4 m from the corners.
    let points: Vec<_> = (0..49)
        .map(|i| {
            DepthPoint::of_sounding(
                [
                    5.9 * (f64::from(i % 7) + 0.5 * f64::from(i / 7)),
                    5.9 * 0.75f64.sqrt() * f64::from(i / 7),
                ],
                f64::from(i % 5),
            )
        })
        .collect();
    let map = made(points.clone(), 3.0);
    let (mut known, mut unknown) = (0, 0);
    for cell in 0..map.grid.len() {
        let [east_m, north_m] = map.grid.centre_of(cell);
        let brute_m = points
            .iter()
            .map(|p| (p.east_m - east_m).hypot(p.north_m - north_m))
            .fold(f64::MAX, f64::min);
        match map.at(east_m, north_m) {
            Some((_, distance_m)) => {
                assert!((f64::from(distance_m) - brute_m).abs() < 1e-4);
                assert!(brute_m <= 3.0);
                known += 1;
            }
            None => unknown += usize::from(brute_m < 3.4),
        }
    }
    assert!(known > 1000 && unknown > 50, "{known} {unknown}");
}

#[test]
fn the_bay_of_a_bend_stays_empty() {
    // A quarter circle of 100 m: its chord is 141 m, its bay 29 m deep.
    let points: Vec<_> = (0..=180)
        .map(|i| {
            let (sin, cos) = (f64::from(i) * 0.5).to_radians().sin_cos();
            DepthPoint::of_sounding([100.0 * cos, 100.0 * sin], 2.0)
        })
        .collect();
    let map = surface(points.clone(), &settings(20.0), &Progress::new()).unwrap();
    let in_the_bay = |map: Surface| map.at(60.0, 60.0);
    assert_eq!(map.and_then(in_the_bay), None);
}

/// A spiral that opens from a radius of 60 m to 90 m: the chord of two gaps would lie up to 3 m
/// inside the track.
#[test]
fn a_bend_is_not_bridged_by_a_lens_across_the_track() {
    let points: Vec<_> = (0..=400)
        .flat_map(|i| {
            let along = f64::from(i) / 400.0;
            let (sin, cos) = (270.0 * along).to_radians().sin_cos();
            // Depths under the boat and half a metre to either side of it.
            [-0.5, 0.0, 0.5].map(|beside_m| {
                let reach_m = 60.0 + 30.0 * along + beside_m;
                DepthPoint::of_sounding([reach_m * cos, reach_m * sin], 2.0)
            })
        })
        .collect();
    let map = made(points, 20.0);
    let known = map.distance_m.iter().filter(|distance| !distance.is_nan());
    let farthest_m = known.clone().copied().fold(0.0, f32::max);
    assert!(known.count() > 1000);
    assert!(farthest_m < 0.7, "{farthest_m} m from any depth");
}

/// Delaunay's triangles over one winding line are long and thin, and none of them counts.
#[test]
fn every_sounding_of_a_single_winding_track_has_its_cell() {
    let points: Vec<_> = (0..2000)
        .map(|i| {
            let (sin, cos) = (0.05 * f64::from(i)).to_radians().sin_cos();
            DepthPoint::of_sounding([120.0 * cos, 120.0 * sin], 2.0 + 0.001 * f64::from(i))
        })
        .collect();
    let map = made(points.clone(), 20.0);
    for point in &points {
        let (depth_m, distance_m) = map.at(point.east_m, point.north_m).expect("a cell");
        assert!((f64::from(depth_m) - point.depth_m).abs() < 0.02, "{depth_m}");
        assert!(f64::from(distance_m) < map.grid.cell_m, "{distance_m}");
    }
    let known = map.distance_m.iter().filter(|distance| !distance.is_nan());
    let farthest_m = known.copied().fold(0.0, f32::max);
    assert!(f64::from(farthest_m) < map.grid.cell_m, "{farthest_m}");
}

#[test]
fn one_straight_line_is_no_surface() {
    let points: Vec<_> = line(0.0, 2.0).collect();
    assert_eq!(surface(points.clone(), &settings(3.0), &Progress::new()), Ok(None));
    assert_eq!(surface(Vec::new(), &settings(3.0), &Progress::new()), Ok(None));
}

#[test]
fn each_method_honours_its_soundings_and_stays_within_their_depths() {
    let points = golden_points();
    let [least, most] = ends(points.iter().map(|p| p.depth_m));
    for method in [SurfaceMethod::Linear, SurfaceMethod::Natural, SurfaceMethod::InverseDistance] {
        let settings = SurfaceSettings { method, cell_m: Some(0.02), ..SurfaceSettings::default() };
        let made = surface(points.clone(), &settings, &Progress::new()).unwrap().unwrap();
        for point in &points {
            // At the hull the middle of a sounding's own cell may lie outside.
            let Some((depth_m, distance_m)) = made.at(point.east_m, point.north_m) else {
                continue;
            };
            let off_m = (f64::from(depth_m) - point.depth_m).abs();
            assert!(off_m < 0.02 && distance_m < 0.015, "{method:?} {off_m}");
        }
        let known = made.depth_m.iter().filter(|depth| !depth.is_nan());
        assert!(known.clone().count() > 150_000);
        assert!(known.copied().map(f64::from).all(|d| (least - 1e-6..=most + 1e-6).contains(&d)));
    }
}

/// A surface whose spreads are those of its soundings, however many could be left out.
fn spreads(points: &[DepthPoint]) -> Surface {
    let grid = Grid::over(points, 0.5, 4096).unwrap();
    local_surface(points, grid, 6.0, &Progress::new()).unwrap()
}

#[test]
fn the_spread_is_that_of_the_soundings_that_carry_a_cell() {
    // On a slope of 1 in 10, halfway between lines 10 m apart, the depths are 2 and 3 m: 0.5 m
    // about their mean.
    let points: Vec<_> = line(0.0, 2.0).chain(line(10.0, 3.0)).collect();
    let made = spreads(&points);
    let spread = |north_m| made.spread_m[made.grid.index_at(20.2, north_m).unwrap()];
    assert!((spread(5.2) - 0.5).abs() < 0.01, "{}", spread(5.2));
    assert!(spread(0.2) < 0.2 && spread(0.2) < spread(2.2));
    // Where the soundings of one place disagree, it is at least their own spread.
    let noisy = |point: DepthPoint| {
        [-0.3, 0.0, 0.3].map(|noise_m| DepthPoint { depth_m: 2.0 + noise_m, ..point })
    };
    let points: Vec<_> = points.into_iter().flat_map(noisy).collect();
    let made = spreads(&points);
    let spreads = made.spread_m.iter().filter(|spread| !spread.is_nan());
    assert!(spreads.clone().count() > 500);
    for spread in spreads {
        assert!((spread - 0.3).abs() < 1e-6, "{spread}");
    }
}

#[test]
fn a_source_of_no_weight_is_left_out_and_a_cancelled_surface_is_none() {
    let mut points: Vec<_> = line(0.0, 2.0).chain(line(10.0, 4.0)).collect();
    points.extend(line(5.0, 9.0).map(|point| DepthPoint { weight: 0.0, ..point }));
    let made = made(points.clone(), 6.0);
    assert!((made.at(20.0, 5.0).unwrap().0 - 3.0).abs() < 0.06);
    let progress = Progress::new();
    progress.cancel();
    assert_eq!(surface(points.clone(), &settings(6.0), &progress), Err(Cancelled));
}

#[test]
fn known_depths_lie_within_their_outermost_cells() {
    let grid = Grid::at([100.0, 50.0], 0.5, [4, 3]);
    let of = |known: &[usize]| {
        let mut depth_m = vec![f32::NAN; grid.len()];
        known.iter().for_each(|cell| depth_m[*cell] = 2.0);
        Surface::of_depths(grid, depth_m).known_bounds_m()
    };
    assert_eq!(of(&[]), None);
    assert_eq!(of(&[6]), Some([101.0, 49.0, 101.5, 49.5]));
    assert_eq!(of(&[3, 9, 10]), Some([100.5, 48.5, 102.0, 50.0]));
}

#[test]
fn depths_that_were_left_out_widen_the_error_of_deeper_cells_beside_them() {
    let points: Vec<_> = line(0.0, 3.0).chain(line(4.0, 3.0)).collect();
    let mut map = made(points, 6.0);
    assert_eq!(map.spread_is, Spread::OfError);
    let before = map.clone();
    map.doubt(&[[10.0, 0.5, 2.0], [30.0, 0.5, 3.5], [90.0, 0.0, 1.0]].map(
        |[east_m, north_m, depth_m]| DepthPoint {
            weight: 0.0,
            is_sounding: false,
            ..DepthPoint::of_sounding([east_m, north_m], depth_m)
        },
    ));
    assert_eq!(map.depth_m.len(), before.depth_m.len());
    let spread_m = |map: &Surface, [east_m, north_m]: [f64; 2]| {
        map.spread_m[map.grid.index_at(east_m, north_m).unwrap()]
    };
    let widened_m = |place| spread_m(&map, place).powi(2) - spread_m(&before, place).powi(2);
    for beside in [[10.0, 0.5], [9.6, 0.6], [10.2, 1.2]] {
        assert!((widened_m(beside) - 0.25).abs() < 1e-3, "{beside:?}: {}", widened_m(beside));
    }
    // Farther away, and where the map is the shoaler.
    for elsewhere in [[10.0, 2.5], [12.0, 0.5], [30.0, 0.5]] {
        assert_eq!(widened_m(elsewhere), 0.0, "{elsewhere:?}");
    }
}

#[test]
fn all_points_within_reach_give_the_golden_depths() {
    let nodes = golden_nodes();
    let places: Vec<[f64; 2]> = nodes.iter().map(|node| node.place()).collect();
    let nearest = Nearest::of(&places).unwrap();
    let mut weights = Vec::new();
    let mut depth_at = |place, reach_m| {
        nearest.inverse_distance(place, reach_m, &mut weights);
        weights.iter().map(|(i, share)| share * nodes[*i].depth_m).sum::<f64>()
    };
    for golden in &GOLDEN {
        let found = depth_at(golden.place, 100.0);
        assert!((found - golden.inverse_distance).abs() < 1e-9, "{found}");
    }
    assert_eq!(depth_at(places[7], 100.0), nodes[7].depth_m);
    assert_eq!(depth_at([50.0, 50.0], 10.0), 0.0);
}
