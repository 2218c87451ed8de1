//! The profile in a window of its own.

use super::synthetic::{bed_m, even_bottom, pond};
use super::{app_with, name, pond_app, window};
use bathyscope::app::{Command, LogPlace};
use bathyscope_bottom::first_return::{
    FirstReturnSettings, ImageSettings, Method, Normalisation, SampleMode, detect,
};
use bathyscope_log::support::progress::Progress;
use bathyscope_log::survey::Side;
use bathyscope_products::pipeline::settings::ControlValue;
use egui::pos2;
use std::time::Duration;

#[test]
fn the_profile_says_its_values() {
    let mut app = pond_app();
    app.view.selection = Some(LogPlace::ping(100));
    let mut window = window(app, [300.0, 180.0]);
    window.state_mut().shows_profile = true;
    window.run_steps(2);
    let bed_m = bed_m(100);
    assert_eq!(
        name(&window),
        format!(
            "Profile of ping 100: port first return {bed_m:.2} m, starboard first return {bed_m:.2} m, threshold 0.30, \
             bottom 4.00 m below transducer by sounding"
        )
    );
    window.state_mut().app.apply(Command::Hover(Some(LogPlace::ping(270))));
    window.run_steps(2);
    assert!(name(&window).contains("ping 270: port first return none"), "{}", name(&window));
}

#[test]
fn the_profile_is_the_intensity_that_the_search_sees() {
    let survey = pond();
    let progress = Progress::new();
    for samples in [SampleMode::Bytes, SampleMode::Words] {
        let image = ImageSettings { samples };
        let settings =
            FirstReturnSettings { method: Method::Threshold, ..FirstReturnSettings::default() };
        let dead_zone_m = settings.dead_zone_m;
        let normalisation = Normalisation::measure(&survey, &image, dead_zone_m, &progress);
        let normalisation = normalisation.expect("not cancelled");
        let returns = detect(&survey, &image, &settings, &progress).expect("not cancelled");
        let per_value = if samples == SampleMode::Words { 4 } else { 1 };
        for ping in [0, 100, 205, 500] {
            for side in Side::BOTH {
                let profile = normalisation.profile(&survey, ping, side);
                assert_eq!(profile.len(), 400 / per_value);
                // Beyond the dead zone, where the search begins: masked words may lie above the
                // threshold.
                let span = survey.side_scan[ping].side(side).expect("a recorded side");
                let dead = (span.sample_at(dead_zone_m) - 1e-6).ceil() as usize;
                let passes = |index: &usize| profile[*index] >= settings.threshold;
                let first = (dead.div_ceil(per_value)..profile.len()).find(passes);
                let found = returns.side(side)[ping].sample as usize / per_value;
                assert_eq!(first, Some(found), "{samples:?} ping {ping} {side:?}");
            }
        }
    }
}

#[test]
fn the_threshold_line_can_be_dragged() {
    let mut app = app_with(even_bottom(10));
    app.view.selection = Some(LogPlace::ping(5));
    let mut window = window(app, [300.0, 180.0]);
    window.state_mut().shows_profile = true;
    window.run_steps(2);
    // The plot is 148 points high between 16 above and 16 below.
    let level_y = |level: f32| 180.0 - 16.0 - level * 148.0;
    window.drag_at(pos2(60.0, level_y(0.30)));
    window.run_steps(1);
    window.hover_at(pos2(60.0, level_y(0.45)));
    window.run_steps(1);
    window.hover_at(pos2(60.0, level_y(0.60)));
    window.run_steps(1);
    window.drop_at(pos2(60.0, level_y(0.60)));
    window.run_steps(2);
    let changes: Vec<(ControlValue, bool)> = window
        .state()
        .pushed
        .iter()
        .filter_map(|command| match command {
            Command::Set { key: "first_return.threshold", value, live } => Some((*value, *live)),
            _ => None,
        })
        .collect();
    let value = |threshold: f32| ControlValue::Number(Some(f64::from(threshold)));
    assert!(changes.contains(&(value(0.45), true)), "{changes:?}");
    assert_eq!(changes.last(), Some(&(value(0.60), false)), "{changes:?}");
    assert_eq!(window.state().app.document.history.undo_label(), Some("threshold 0.60"));
}

#[test]
fn the_profile_looks_as_it_did() {
    let mut app = pond_app();
    app.view.selection = Some(LogPlace::ping(100));
    let mut window = window(app, [300.0, 180.0]);
    window.state_mut().shows_profile = true;
    // The scale of the whole picture is measured on a worker.
    for () in bathyscope_test_support::attempts() {
        window.run_steps(1);
        if window.state().profile.is_settled() {
            break;
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    window.run_steps(1);
    window.snapshot("profile");
}
