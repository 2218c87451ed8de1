//! Depth maps of simulated ponds against their beds; `cargo bench -- surface` prints the figures over many.

use crate::missions::{Mission, repeatability};
use bathyscope::bathymetry::SurfaceSettings;
use bathyscope::bathymetry::crosslines::{Crossing, TrackDepth, crossings};
use bathyscope::cloud::{PointSource, Residuals};
use bathyscope::progress::Progress;
use bathyscope::simulation::Scene;

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
    let with = SurfaceSettings {
        cell_m: Some(0.4),
        ..SurfaceSettings::default()
    };
    let without = SurfaceSettings {
        side_scan_weight: 0.0,
        ..with.clone()
    };
    let soundings = first.known.map(&first.products, &without);
    let rms_m = |settings: &SurfaceSettings| {
        let map = first.known.map(&first.products, settings);
        let errors = first.known.map_errors_m(&map, &soundings);
        let mut errors: Vec<f64> = errors.into_iter().map(|(error_m, _)| error_m).collect();
        Residuals::of(&mut errors).expect("cells").rms_m
    };
    let [with, without] = [rms_m(&with), rms_m(&without)];
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
fn crossings_of_one_survey_show_the_noise_of_its_soundings() {
    let mission = Mission::new(&Scene::gentle(), 5);
    let survey = &mission.known.survey;
    let points = mission.products.cloud.points.iter();
    let soundings = points.filter(|point| point.source == PointSource::DownScan && point.reliable);
    let track: Vec<TrackDepth> = soundings
        .map(|point| TrackDepth {
            time_s: survey.soundings[point.sounding.expect("a sounding").get()].time_s,
            east_m: point.east_m,
            north_m: point.north_m,
            depth_m: -point.z_m,
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
