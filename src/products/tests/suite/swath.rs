//! Depths across the track of StructureScan 3D, from the file to points, surface, files and report.

use crate::truth::results;
use crate::written;
use bathyscope_bottom::cloud::{CloudPoint, PointRecord, PointSource};
use bathyscope_log::formats::{open_bytes, open_growing, open_tail};
use bathyscope_log::support::geo::{LocalFrame, METRES_PER_FOOT, lowrance_mercator_inverse};
use bathyscope_log::support::progress::Progress;
use bathyscope_log::survey::{Bytes, Side, Survey, SurveyVersions};
use bathyscope_objects::objects::SurveyReview;
use bathyscope_products::outputs::Product;
use bathyscope_products::pipeline::{
    Derived, GrowingResults, ProcessedLog, Products, Settings, extend,
};
use bathyscope_test_support::handmade::{Frame, sl3};
use serde_json::Value;
use std::fs;
use std::path::PathBuf;
use std::sync::Arc;

/// Start of the boat, Mercator metres.
const START_M: [i32; 2] = [-9_000_000, 3_400_000];
/// Milliseconds between two places of the boat, whole Mercator metres apart.
const STEP_MS: i32 = 500;
/// A boat that goes north.
const NORTH: [i32; 2] = [0, 1];
/// Depths of a side in a ping.
const PAIRS: usize = 60;

/// Unit vector to starboard of a boat that goes so many Mercator metres east and north.
fn starboard([east, north]: [i32; 2]) -> [f64; 2] {
    let (east, north) = (f64::from(east), f64::from(north));
    [north, -east].map(|metres| metres / east.hypot(north))
}

/// Depth of a plane that falls to starboard, metres below the transducer.
fn plane_m(way: [i32; 2], east_m: f64, north_m: f64) -> f64 {
    let [east, north] = starboard(way);
    8.0 + 0.1 * (east * east_m + north * north_m)
}

fn feet(metres: f64) -> f32 {
    (metres / METRES_PER_FOOT) as f32
}

/// A log over the plane: soundings, and depths up to 15 m on both sides; a spike in each ping.
fn log(steps: i32, way: [i32; 2]) -> Vec<u8> {
    let mercator_m = |step: i32| [0, 1].map(|axis| START_M[axis] + way[axis] * step);
    let position = |step: i32| {
        let [x, y] = mercator_m(step).map(f64::from);
        lowrance_mercator_inverse(x, y)
    };
    let frame = LocalFrame::new(position(0));
    let each = (0..steps).flat_map(|step| {
        let [east_m, north_m] = frame.to_enu(position(step));
        let right = starboard(way);
        let pairs = |side: Side| -> Vec<[f32; 2]> {
            let pair = |number: usize| {
                let out_m = 0.25 * (number + 1) as f64;
                let right_m = side.to_starboard(out_m);
                let place = [east_m + right_m * right[0], north_m + right_m * right[1]];
                let spike_m = if number == 30 { 4.0 } else { 0.0 };
                let depth_m = plane_m(way, place[0], place[1]) - spike_m;
                [out_m, depth_m].map(feet)
            };
            (0..PAIRS).map(pair).collect()
        };
        let [port, starboard] = Side::BOTH.map(pairs);
        let swath = Frame::of_swath(STEP_MS * step, [&port, &starboard, &[[10.0, 3.0]]]);
        let sounding = Frame {
            depth_ft: feet(plane_m(way, east_m, north_m)),
            ..Frame::new(0, STEP_MS * step)
        };
        let [x, y] = mercator_m(step);
        [sounding, swath].map(|frame| Frame { xy_m: (x, y), ..frame })
    });
    sl3(&each.collect::<Vec<_>>(), 168)
}

fn open(bytes: Vec<u8>) -> Survey {
    open_bytes("pond.sl3", bytes, &Progress::new()).unwrap_or_else(|error| panic!("{error}"))
}

fn swath(products: &Products) -> Vec<CloudPoint> {
    let kept = products.kept_points();
    let swath = kept.filter(|point| point.source == PointSource::Swath);
    swath.copied().collect()
}

fn set(assignments: &[&str]) -> Settings {
    let with = |settings: Settings, assignment: &&str| {
        settings.with_assignment(assignment).expect("a setting")
    };
    assignments.iter().fold(Settings::default(), with)
}

#[test]
fn points_lie_on_the_plane_and_on_their_sides() {
    for way in [NORTH, [0, -1], [1, 1], [-2, 1]] {
        let survey = open(log(80, way));
        let products = results(&survey, &Settings::default());
        let points = swath(&products);
        // Of each stretch of a tenth of the depth one: 15 m a side, 8 m deep.
        assert!(points.len() > 80 * 2 * 15, "{}", points.len());
        let mut worst_m: f64 = 0.0;
        for point in &points {
            worst_m = worst_m.max((point.z_m + plane_m(way, point.east_m, point.north_m)).abs());
            let boat = point.record().place(&products.navigation);
            let boat = boat.expect("a place");
            let off_m = [point.east_m - boat.east_m, point.north_m - boat.north_m];
            let [east, north] = starboard(way);
            let right_m = east * off_m[0] + north * off_m[1];
            let expected = if right_m > 0.0 { Side::Starboard } else { Side::Port };
            assert_eq!(point.side(&survey), Some(expected));
            let range_m = products.reduction().point_range_m(&survey, point);
            assert!((range_m - right_m.hypot(point.z_m)).abs() < 0.01);
        }
        eprintln!("{} points, at most {worst_m:.4} m off the plane", points.len());
        assert!(worst_m < 0.01, "{worst_m} m");
    }
}

#[test]
fn corrections_of_depths_positions_and_cables_reach_the_swath() {
    let survey = open(log(40, NORTH));
    let plain = swath(&results(&survey, &Settings::default()));
    let settings = set(&["draft_m=0.4", "mounting.right_m=2.0"]);
    let moved = swath(&results(&survey, &settings));
    assert_eq!(plain.len(), moved.len());
    for (before, after) in plain.iter().zip(&moved) {
        assert!((before.z_m - after.z_m - 0.4).abs() < 1e-9);
        assert!((after.east_m - before.east_m - 2.0).abs() < 1e-3);
    }
    let settings = set(&["mounting.swap_sides=true"]);
    let exchanged = survey.clone().mounted(&settings.mounting);
    let swapped = swath(&results(&exchanged, &settings));
    assert_eq!(plain.len(), swapped.len());
    for before in &plain {
        let is_same = |after: &&CloudPoint| {
            (after.record(), after.sample) == (before.record(), before.sample)
        };
        let after = swapped.iter().find(is_same).expect("the same depth");
        assert_eq!(before.z_m, after.z_m);
        let (out, back) = (before.side(&survey), after.side(&exchanged));
        assert_eq!(out.map(Side::other), back);
    }
}

#[test]
fn excluded_stretches_and_parts_take_their_depths_with_them() {
    let survey = open(log(40, NORTH));
    let mut settings = set(&[]);
    settings.excluded.stretches = vec![bathyscope_log::survey::Stretch {
        pings: None,
        time_s: Some([5.0, 9.9]),
        reason: Some(bathyscope_log::survey::ExclusionReason::Bad),
        trusted: false,
    }];
    let products = results(&survey, &settings);
    let pings: Vec<usize> = swath(&products)
        .iter()
        .filter_map(|point| match point.record() {
            PointRecord::Swath(index) => Some(index),
            _ => None,
        })
        .collect();
    assert!(pings.iter().all(|ping| !(10..20).contains(ping)));
    assert!(pings.contains(&9) && pings.contains(&20));
    let (part, places) = survey.part(&products.navigation, std::slice::from_ref(&(5..15)));
    assert_eq!((part.swath.len(), places.swath.len()), (10, 10));
    assert_eq!(part.swath[0], survey.swath[5]);
    assert_eq!(places.swath[9], products.navigation.swath[14]);
}

#[test]
fn a_log_that_grows_has_the_points_of_the_whole_one() {
    let whole = log(600, NORTH);
    let (progress, settings) = (Progress::new(), Arc::new(Settings::default()));
    let held = |end: usize| {
        let bytes = Bytes::Held(Arc::new(whole[..end].to_vec()));
        vec![(PathBuf::from("log.sl3"), bytes)]
    };
    let mut survey = open_growing(held(whole.len() / 2), &progress).expect("a log");
    let mut products = results(&survey, &settings);
    let mut growing = GrowingResults::measure(&survey, &settings, &progress).expect("a scale");
    let mut versions = SurveyVersions::default();
    for step in 1..=4 {
        let end = whole.len() * (4 + step) / 8;
        let seam = survey.seam().expect("a seam");
        let tail = open_tail(&survey, &seam, held(end), &progress).expect("a tail");
        survey = (survey.extended(tail, &seam, &mut versions)).expect("it goes on");
        let made = extend(&survey, 0, &products, &settings, &mut growing, &progress);
        products = made.expect("nobody cancels");
        assert_eq!(products.navigation.swath.len(), survey.swath.len());
        assert_eq!(products.classes.len(), products.cloud.points.len());
    }
    let expected = results(&open(whole), &settings);
    let [made, expected] = [&products, &expected].map(swath);
    assert!(made.len().abs_diff(expected.len()) < expected.len() / 100);
    for (a, b) in made.iter().zip(&expected) {
        assert_eq!((a.record(), a.sample, a.z_m), (b.record(), b.sample, b.z_m));
    }
}

#[test]
fn the_depth_map_the_files_and_the_report_take_the_swath() {
    let survey = Arc::new(open(log(80, NORTH)));
    let products = results(&survey, &Settings::default());
    let points = swath(&products).len();
    let all = products.cloud.points.of(PointSource::Swath).len();
    let logs = [ProcessedLog { survey, products }];
    let map = Derived::default().depth_map(&logs, &Progress::new()).expect("not cancelled");
    let surface = &map.expect("a depth map").surface;
    // 15 m to both sides of a line: soundings alone have no surface.
    let [west_m, south_m, east_m, north_m] = surface.known_bounds_m().expect("depths");
    assert!(east_m - west_m > 28.0 && north_m - south_m > 60.0);
    let folder = tempfile::tempdir().expect("a folder");
    let requested = [Product::Cloud, Product::Residuals];
    let written = written(&logs, &requested, &SurveyReview::default(), folder.path());
    let table = fs::read_to_string(folder.path().join("points/cloud.csv")).expect("a table");
    let rows = table.lines().filter(|line| line.starts_with("swath,"));
    assert_eq!(rows.count(), all);
    let mut las = las::Reader::from_path(folder.path().join("points/cloud.copc.laz")).expect("LAZ");
    let las = las.read_all().expect("points");
    let users = las.points().map(|point| point.expect("a point").user_data);
    assert_eq!(users.filter(|user| *user == 3).count(), all);
    let counts = written.report.counts.swath.expect("a swath");
    assert_eq!((counts.pings, counts.points), (80, all));
    assert_eq!((counts.depths, counts.unreliable), (80 * 2 * PAIRS, 80));
    assert!(points > all / 2, "{points} of {all}");
    assert!(written.report.summary().contains("80 depths that the recorder marks as unreliable"));
    let residuals = fs::read_to_string(folder.path().join("quality/residuals.json"));
    let residuals: Value = serde_json::from_str(&residuals.expect("a file")).expect("JSON");
    let compared = residuals["comparisons"].as_array().expect("comparisons");
    assert!(compared.iter().any(|comparison| comparison["source"] == "swath"));
}
