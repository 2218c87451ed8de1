//! Depth maps of simulated ponds against their beds; `cargo bench -- surface` prints the figures
//! over many.

use crate::missions::{Mission, repeatability};
use crate::truth::MapError;
use bathyscope_bottom::bathymetry::crosslines::{Crossing, TrackDepth, crossings};
use bathyscope_bottom::bathymetry::{CellSource, Surface, SurfaceSettings, SwathDepth};
use bathyscope_bottom::cloud::{PointSource, Residuals};
use bathyscope_log::support::progress::Progress;
use bathyscope_simulation::{Mound, Scene};

/// Root mean square of the errors of a map, metres.
fn rms_m(errors: &[MapError]) -> f64 {
    let mut errors: Vec<f64> = errors.iter().map(|error| error.error_m).collect();
    Residuals::of(&mut errors).expect("cells").rms_m
}

/// Share of the errors of a map that are smaller than so many of the stated standard deviations.
fn share_within(errors: &[MapError], sigmas: f64) -> f64 {
    let within = errors.iter().filter(|error| error.error_m.abs() / error.spread_m < sigmas);
    within.count() as f64 / errors.len() as f64
}

/// Four lines 8 m apart and two across, on a bed of its own seed.
fn pond() -> Scene {
    let mut scene = Scene::steep();
    scene.track.lines = 4;
    scene.track.spacing_m = 8.0;
    scene.bed.seed = Some(31);
    scene
}

#[test]
fn side_scan_lowers_the_error_of_the_map_and_missions_repeat_as_the_truth_says() {
    let first = Mission::new(&pond(), 31);
    let with =
        SurfaceSettings { cell_m: Some(0.4), swath: SwathDepth::Off, ..SurfaceSettings::default() };
    let without = SurfaceSettings { side_scan_weight: 0.0, ..with.clone() };
    let soundings = first.known.map(&first.products, &without);
    let [with, without] = [with, without].map(|settings| {
        let map = first.known.map(&first.products, &settings);
        rms_m(&first.known.map_errors(&map, &soundings))
    });
    assert!(with < 0.98 * without, "{with} {without}");

    let mut scene = pond();
    scene.track.lines = 5;
    scene.track.spacing_m = 7.0;
    let second = Mission::new(&scene, 32);
    let (found, expected) = repeatability(&first, &second);
    for (found, expected) in found.iter().zip(expected) {
        assert!((found - expected).abs() < 0.01, "{found} {expected}");
    }
}

#[test]
fn a_map_knows_how_near_it_is_to_the_bed() {
    // Beds of the other seeds of `cargo bench -- surface`; nothing was chosen on these.
    for (mut scene, seed) in [(Scene::gentle(), 41), (Scene::steep(), 42), (Scene::rough(), 43)] {
        scene.track.lines = 4;
        scene.track.spacing_m = 8.0;
        let pond = Mission::new(&scene, seed);
        let settings = SurfaceSettings { cell_m: Some(0.4), ..SurfaceSettings::default() };
        let map = pond.known.map(&pond.products, &settings);
        let errors = pond.known.map_errors(&map, &map);
        let [one, two] = [1.0, 2.0].map(|sigmas| share_within(&errors, sigmas));
        // What all depths have in common is not in it: rounded positions on slopes.
        assert!((0.5..0.85).contains(&one) && two > 0.8, "{seed}: {one} {two}");
    }
}

#[test]
fn levels_find_mounds_that_lie_between_the_lines() {
    let mut scene = Scene::gentle();
    scene.track.lines = 4;
    scene.track.spacing_m = 8.0;
    let mound = |east_m, north_m, height_m| Mound { east_m, north_m, radius_m: 1.4, height_m };
    scene.bed.mounds = vec![
        mound(-9.0, 0.4, 0.4),
        mound(1.0, -0.3, -0.4),
        mound(8.0, 7.8, 0.4),
        mound(-4.0, -8.2, -0.4),
    ];
    let pond = Mission::new(&scene, 51);
    let map = |swath| {
        let settings = SurfaceSettings { cell_m: Some(0.4), swath, ..SurfaceSettings::default() };
        pond.known.map(&pond.products, &settings)
    };
    let [plain, from_levels] = [SwathDepth::Off, SwathDepth::Always].map(map);
    let errors = |map| {
        let errors = pond.known.map_errors(map, &plain).into_iter();
        errors.filter(|error| error.away_m > 1.0).collect::<Vec<MapError>>()
    };
    let left = rms_m(&errors(&from_levels)) / rms_m(&errors(&plain));
    assert!(left < 0.8, "{left}");
    let within = share_within(&errors(&from_levels), 2.0);
    assert!(within > 0.8, "{within}");
    check_sources(&plain, &from_levels);
    check_hardness(&pond, &from_levels);
}

/// Checks that interpolated cells are from levels where echoes reach, and that measured cells stay
/// measured.
fn check_sources(plain: &Surface, from_levels: &Surface) {
    let share = |map: &Surface, source: CellSource| {
        map.source.iter().filter(|cell_source| **cell_source == source).count() as f64
            / map.source.len() as f64
    };
    for source in [CellSource::Sounding, CellSource::FirstReturn] {
        assert_eq!(share(plain, source), share(from_levels, source));
    }
    let [before, left] = [plain, from_levels].map(|map| share(map, CellSource::Interpolated));
    assert_eq!(share(plain, CellSource::FromLevels), 0.0);
    // Near the lines triangles count more.
    assert!(left < 0.65 * before && left > 0.0, "{before} {left}");
}

/// The brightness that levels leave to the bed is that of its patches, smoothed as far as predicts
/// depths best.
fn check_hardness(pond: &Mission, from_levels: &Surface) {
    let hardness_db = from_levels.hardness_db.as_ref().expect("from levels");
    let steps = [-0.3, 0.0, 0.3];
    let true_db = |[east_m, north_m]: [f64; 2]| {
        let around = steps.iter().flat_map(|e| steps.iter().map(move |n| [e, n]));
        let sum: f64 =
            around.map(|[e, n]| pond.known.truth.bed_strength(east_m + e, north_m + n)).sum();
        10.0 * (sum / 9.0).log10()
    };
    let cells = hardness_db.iter().enumerate().filter(|(_, found)| !found.is_nan());
    let pairs: Vec<[f64; 2]> = cells
        .map(|(cell, found)| [f64::from(*found), true_db(from_levels.grid.centre_of(cell))])
        .collect();
    let mean =
        |of: &dyn Fn(&[f64; 2]) -> f64| pairs.iter().map(of).sum::<f64>() / pairs.len() as f64;
    let means = [mean(&|pair| pair[0]), mean(&|pair| pair[1])];
    let moment = |one: usize, other: usize| {
        mean(&|pair| (pair[one] - means[one]) * (pair[other] - means[other]))
    };
    let correlation = moment(0, 1) / (moment(0, 0) * moment(1, 1)).sqrt();
    let per_db = moment(0, 1) / moment(1, 1);
    assert!(correlation > 0.6, "{correlation}");
    assert!((0.3..1.2).contains(&per_db), "{per_db}");
}

#[test]
fn crossings_of_one_survey_show_the_noise_of_its_soundings() {
    let mission = Mission::new(&Scene::gentle(), 5);
    let survey = &mission.known.survey;
    let points = mission.products.cloud.points.iter();
    let soundings =
        points.filter(|point| point.source == PointSource::DownScan && point.fault().is_none());
    let track: Vec<TrackDepth> = soundings
        .map(|point| {
            let time_s = survey.soundings[point.sounding().expect("a sounding")].time_s;
            TrackDepth::new(time_s, [point.east_m, point.north_m], -point.z_m)
        })
        .collect();
    let found = crossings(&[track], &Progress::new()).expect("not cancelled");
    // Two lines and two across.
    assert!((4..=6).contains(&found.len()), "{}", found.len());
    let mut differences: Vec<f64> = found.iter().map(Crossing::difference_m).collect();
    // 3 cm of noise in each depth, the median of some seven of them on either pass, and the roll.
    let residuals = Residuals::of(&mut differences).expect("crossings");
    assert!(residuals.rms_m < 0.05, "{residuals:?}");
}
