//! The automatic level of the picture.

use super::synthetic::{span, survey_of};
use super::{Window, app_with, settle, window};
use bathyscope::app::Command;
use bathyscope_bottom::presentation::colours::ColourMap;
use egui_kittest::Harness;

/// Grey of the picture at 10 m to starboard in the middle of a window of 400 x 300 points.
fn grey(window: &mut Harness<'_, Window>) -> u8 {
    settle(window);
    let picture = window.render().expect("a picture");
    picture.get_pixel(200, 225).0[0]
}

#[test]
fn the_automatic_level_lifts_a_dim_survey_alike_near_and_far() {
    // 20 m in 400 samples that climb from 0 to 99: 50 at 10 m.
    let bytes = (0..400_usize).map(|sample| (sample / 4) as u8).collect();
    let sides = [None, Some(span(0, 400, 20.0))];
    let mut app = app_with(survey_of(bytes, std::iter::repeat_n(sides, 3_000)));
    app.view.options.waterfall.colour_map = ColourMap::Grey;
    app.view.options.waterfall.range_lines = false;
    let mut window = window(app, [400.0, 300.0]);
    // Black is at 10 and white at 99 / 0.9.
    let expected = (255.0 * (50.0 - 10.0) / (99.0 / 0.9 - 10.0)) as u8;
    let near = grey(&mut window);
    assert!(near.abs_diff(expected) <= 5, "{near}, not {expected}");
    window.state_mut().waterfall.show_pings(0..3_000);
    let far = grey(&mut window);
    assert!(far.abs_diff(near) <= 3, "{far} far out, {near} near");
    let app = &mut window.state_mut().app;
    let settings = app.logs.shown.settings.with_assignment("picture.black=0");
    let settings = settings.and_then(|settings| settings.with_assignment("picture.white=255"));
    app.apply(Command::Change {
        settings: Box::new(settings.expect("settings")),
        label: "levels",
        live: false,
    });
    let recorded = grey(&mut window);
    assert!(recorded.abs_diff(50) <= 3, "{recorded} of a recorded 50");
}
