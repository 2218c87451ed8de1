//! The cloud: the outlier filter against Open3D's table, a brute-force count and kiddo.

use crate::truth::{KnownSurvey, results};
use bathyscope_bottom::cloud::{Residuals, outliers};
use bathyscope_log::support::progress::Progress;
use bathyscope_products::pipeline::Settings;
use bathyscope_simulation::Scene;
use proptest::prelude::*;

fn keep(points: &[[f64; 3]], radius_m: f64, min_neighbors: usize) -> Vec<bool> {
    outliers::keep(points, radius_m, min_neighbors, &Progress::new()).expect("not cancelled")
}

fn kept_indices(points: &[[f64; 3]], radius_m: f64, min_neighbors: usize) -> Vec<usize> {
    let kept = keep(points, radius_m, min_neighbors);
    (0..points.len()).filter(|&index| kept[index]).collect()
}

/// Measured on Open3D 0.20.0, legacy `remove_radius_outlier(nb_points, radius)`.
#[test]
fn the_filter_keeps_what_open3d_keeps() {
    let line = [0.0, 1.0, 2.0, 3.0, 10.0].map(|x| [x, 0.0, 0.0]);
    let table: [(usize, f64, &[usize]); 7] = [
        (1, 1.0, &[]),
        (1, 1.000001, &[0, 1, 2, 3]),
        (2, 1.000001, &[1, 2]),
        (2, 2.0, &[1, 2]),
        (2, 2.000001, &[0, 1, 2, 3]),
        (3, 2.000001, &[1, 2]),
        (4, 2.000001, &[]),
    ];
    for (min_neighbors, radius_m, expected) in table {
        let kept = kept_indices(&line, radius_m, min_neighbors);
        assert_eq!(kept, expected, "{min_neighbors} within {radius_m}");
        // The rule has no preferred axis.
        let upright = line.map(|[x, y, z]| [z, y, x]);
        assert_eq!(kept_indices(&upright, radius_m, min_neighbors), expected);
    }
    let twins = [[0.0; 3], [0.0; 3], [5.0; 3]];
    assert_eq!(kept_indices(&twins, 0.1, 1), [0, 1]);
    assert_eq!(kept_indices(&twins, 0.1, 2), [0_usize; 0]);
}

#[test]
fn points_that_are_no_numbers_are_dropped_and_far_ones_cost_nothing() {
    let mut points: Vec<[f64; 3]> = (0..100).map(|i| [f64::from(i) * 0.1, 0.0, 0.0]).collect();
    points.push([f64::NAN, 0.0, 0.0]);
    points.push([0.0, f64::INFINITY, 0.0]);
    points.push([1e4, -1e4, 1e4]);
    points.push([-1e300, 1e300, 1e300]);
    let kept = keep(&points, 0.5, 4);
    assert!(kept[..100].iter().all(|&kept| kept));
    assert!(kept[100..].iter().all(|&kept| !kept));
    assert!(keep(&[], 1.0, 1).is_empty());
}

/// Each against each, these are hundreds of billions of distances, and minutes.
#[test]
fn many_points_at_one_place_are_counted_at_once() {
    let twins = |index: usize| match index % 4 {
        0 => [0.9; 3],
        1 => [0.9 + 1e-9, 0.9, 0.9],
        _ => [0.0; 3],
    };
    let points: Vec<[f64; 3]> = (0..400_000).map(twins).collect();
    // Two hundred thousand at either place, 1.56 m apart: in one cell of the grid, but not
    // neighbours.
    let kept = |min_neighbors| kept_indices(&points, 1.0, min_neighbors).len();
    assert_eq!(kept(10), 400_000);
    assert_eq!(kept(150_000), 400_000);
    assert_eq!(kept(199_999), 400_000);
    assert_eq!(kept(200_000), 0);
}

fn brute_force(points: &[[f64; 3]], radius_m: f64, min_neighbors: usize) -> Vec<bool> {
    let near = |a: &[f64; 3], b: &[f64; 3]| {
        let [x, y, z] = [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
        x * x + y * y + z * z < radius_m * radius_m
    };
    points.iter().map(|a| points.iter().filter(|b| near(a, b)).count() > min_neighbors).collect()
}

/// A second opinion from a kd-tree.
fn by_kd_tree(points: &[[f64; 3]], radius_m: f64, min_neighbors: usize) -> Vec<bool> {
    let tree = kiddo::ImmutableKdTree::<f64, 3>::new_from_slice(points).expect("a tree");
    let count = |point: &[f64; 3]| {
        let query = tree.query(point).within::<kiddo::SquaredEuclidean<f64>>(radius_m * radius_m);
        query.exclusive_boundaries().unsorted().execute().len()
    };
    points.iter().map(|point| count(point) > min_neighbors).collect()
}

/// Clouds of every shape that has its own way through the filter.
fn cloud() -> impl Strategy<Value = Vec<[f64; 3]>> {
    let point = |x: f64, z: f64| [-x..x, -x..x, -z..z];
    let volume = prop::collection::vec(point(6.0, 6.0), 0..400);
    let surface = prop::collection::vec(point(12.0, 0.3), 0..400);
    let lattice =
        prop::collection::vec([0..6_i32, 0..6, 0..6].prop_map(|p| p.map(f64::from)), 0..300);
    let cluster = prop::collection::vec(
        (point(200.0, 20.0), prop::collection::vec(point(1.0, 1.0), 1..60)),
        1..6,
    )
    .prop_map(|clusters| {
        let around = |(centre, offsets): ([f64; 3], Vec<[f64; 3]>)| {
            offsets.into_iter().map(move |offset| [0, 1, 2].map(|axis| centre[axis] + offset[axis]))
        };
        clusters.into_iter().flat_map(around).collect::<Vec<_>>()
    });
    let far = (
        prop::collection::vec(point(3.0, 3.0), 0..200),
        prop::collection::vec(point(2e4, 1e4), 0..20),
    )
        .prop_map(|(near, far)| [near, far].concat());
    let track =
        prop::collection::vec((0.0..3000.0_f64, point(1.5, 0.5)), 0..300).prop_map(|places| {
            places.into_iter().map(|(s, [x, y, z])| [s + x, s + y, 0.2 * s + z]).collect::<Vec<_>>()
        });
    prop_oneof![volume, surface, lattice, cluster, far, track]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn the_filter_keeps_what_a_brute_force_count_keeps(
        mut points in cloud(),
        radius_m in prop_oneof![Just(1.0), Just(2.0), 0.05..4.0_f64],
        min_neighbors in 1_usize..24,
        repeats in 0_usize..40,
        shift in prop_oneof![Just(0.0), Just(3_250_000.0)],
    ) {
        let again: Vec<[f64; 3]> = points.iter().copied().take(repeats).collect();
        points.extend(again);
        for point in &mut points {
            point[1] += shift;
        }
        let kept = keep(&points, radius_m, min_neighbors);
        prop_assert_eq!(&kept, &brute_force(&points, radius_m, min_neighbors));
        if !points.is_empty() {
            prop_assert_eq!(&kept, &by_kd_tree(&points, radius_m, min_neighbors));
        }
    }
}

/// The floors of the recommended preset on simulated ponds with all artefacts; the accuracy bench
/// has twenty of each.
#[test]
fn recommended_depths_hold_their_floors_on_simulated_ponds() {
    for (kind, scene, p95_m) in [
        ("gentle", Scene::gentle(), 0.06),
        ("steep", Scene::steep(), 0.15),
        ("rough", Scene::rough(), 0.15),
    ] {
        let pond = KnownSurvey::new(&scene, 11);
        let products = results(&pond.survey, &Settings::default());
        let mut errors = pond.depth_errors_m(&products);
        let depths = Residuals::of(&mut errors).expect("side-scan points");
        assert!(depths.n * 10 > pond.survey.side_scan.len() * 17, "{kind}: {depths:?}");
        assert!(depths.mean_m.abs() <= 0.01 && depths.p95_m <= p95_m, "{kind}: {depths:?}");
    }
}
