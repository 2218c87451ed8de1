//! Gain, stripes and geometry of the picture, pixel by pixel against the numbers that it is drawn
//! by.

use super::synthetic::{span, survey_of};
use super::{Window, settle, window};
use bathyscope::app::{Action, App, Command, Jobs, Tool};
use bathyscope_bottom::mosaic::Gain;
use bathyscope_bottom::picture::PictureGeometry;
use bathyscope_bottom::presentation::colours::ColourMap;
use bathyscope_log::support::progress::Progress;
use bathyscope_log::survey::{Side, Survey};
use bathyscope_products::pipeline::{self, Settings};
use egui::pos2;
use egui_kittest::Harness;
use std::sync::Arc;

/// Depth of the bottom, metres.
const BED_M: f64 = 4.0;
/// Level that is shown as white.
const WHITE: f64 = 1000.0;
const FAR_M: f64 = 20.0;

/// A level bed 4 m down whose echo falls with the range, half as strong to starboard; every 50th
/// ping three times as bright.
fn falling() -> Survey {
    let mut bytes = Vec::new();
    let mut spans = Vec::new();
    for ping in 0..400 {
        let bright = if ping % 50 == 25 { 3.0 } else { 1.0 };
        let mut sides = [None, None];
        for (side, strength) in [(Side::Port, 80.0), (Side::Starboard, 40.0)] {
            sides[side as usize] = Some(span(bytes.len(), 400, FAR_M as f32));
            bytes.extend((0..400).map(|sample| {
                let range_m = (f64::from(sample) + 0.5) * FAR_M / 400.0;
                if range_m < BED_M { 4 } else { (bright * strength * BED_M / range_m) as u8 }
            }));
        }
        spans.push(sides);
    }
    survey_of(bytes, spans.into_iter())
}

fn shown(change: impl FnOnce(&mut Settings)) -> App {
    let survey = Arc::new(falling());
    let settings = Settings::default();
    let made = pipeline::run(&survey, &settings, None, &Progress::new(), |_| ());
    let mut app = App::new(Jobs::Inline);
    app.show_survey(survey, Some(made.expect("nobody cancels")));
    let waterfall = &mut app.view.options.waterfall;
    waterfall.colour_map = ColourMap::Grey;
    waterfall.range_lines = false;
    waterfall.first_return = false;
    waterfall.flat_stretches = false;
    let mut settings = Settings::clone(&app.logs.shown.settings);
    settings.picture.black = Some(0.0);
    settings.picture.white = Some(WHITE);
    change(&mut settings);
    app.apply(Command::Change { settings: Box::new(settings), label: "picture", live: false });
    app.poll();
    assert!(app.picture().is_some() && app.histogram().is_some());
    app
}

fn greys(window: &mut Harness<'_, Window>, x: u32) -> Vec<u8> {
    settle(window);
    let picture = window.render().expect("a picture");
    (0..300).map(|y| picture.get_pixel(x, y).0[0]).collect()
}

/// Rows of the picture that hold neither words nor the ends of the ground, by side, with their
/// distance from the middle, metres.
fn rows(least_m: f64) -> impl Iterator<Item = (usize, Side, f64)> {
    (30..265_usize).filter_map(move |row| {
        let across_m = (row as f64 + 0.5 - 150.0) * FAR_M / 150.0;
        let side = if across_m < 0.0 { Side::Port } else { Side::Starboard };
        (across_m.abs() > least_m).then_some((row, side, across_m.abs()))
    })
}

/// Echo level at a recorded range.
fn level(side: Side, recorded_m: f64) -> f64 {
    let strength = if side == Side::Port { 80.0 } else { 40.0 };
    (strength * BED_M / recorded_m).floor()
}

#[test]
fn the_shader_shows_what_the_numbers_say_in_every_geometry() {
    for (ground, water) in [(false, true), (false, false), (true, false)] {
        let mut app = shown(|settings| {
            settings.picture.spreading_db = 20.0;
            settings.picture.absorption_db_m = 0.1;
            settings.picture.balance_db = 3.0;
        });
        app.view.options.waterfall.ground_range = ground;
        app.view.options.waterfall.water_column = water;
        let geometry = app.view.options.waterfall.geometry();
        let mut window = window(app, [400.0, 300.0]);
        let greys = greys(&mut window, 210);
        let app = &window.state().app;
        let picture = app.picture().expect("a picture");
        let gain = picture.gain.as_ref().expect("a gain table");
        let tone = app.logs.shown.settings.picture.tone();
        let least_m = if geometry == PictureGeometry::Slant { 4.6 } else { 1.0 };
        let (mut looked_at, mut worst) = (0, 0.0_f64);
        for (row, side, across_m) in rows(least_m) {
            let scale = picture.scales.at(side, 210);
            let recorded_m = scale.recorded_at_m(geometry, across_m);
            if recorded_m > FAR_M - 0.2 {
                continue;
            }
            let slant_m = scale.slant_m(recorded_m) as f32;
            let factor = gain.factor(side, slant_m, scale.altitude_m)
                * tone.factor(side, slant_m, picture.middle_m);
            let expected = 255.0 * level(side, recorded_m) * f64::from(factor) / WHITE;
            let off = (f64::from(greys[row]) - expected).abs() / expected.max(10.0);
            worst = worst.max(off);
            looked_at += 1;
        }
        eprintln!("{geometry:?}: {looked_at} pixels, worst {:.1} % off", 100.0 * worst);
        // A level is a whole number: at 8 it is 12 % from the next.
        assert!(looked_at > 150 && worst < 0.16, "{geometry:?} {worst}");
    }
}

#[test]
fn normalised_ground_is_even_over_range_and_alike_on_both_sides() {
    let spread = |gain: Gain| {
        let mut window = window(shown(|settings| settings.picture.gain = gain), [400.0, 300.0]);
        let greys = greys(&mut window, 210);
        let ground: Vec<f64> = rows(4.8).map(|(row, ..)| f64::from(greys[row])).collect();
        let mean = ground.iter().sum::<f64>() / ground.len() as f64;
        let square = ground.iter().map(|grey| (grey - mean).powi(2)).sum::<f64>();
        (square / ground.len() as f64).sqrt() / mean
    };
    let [recorded, even] = [Gain::Recorded, Gain::Empirical].map(spread);
    eprintln!(
        "spread over the swath: {:.0} % as recorded, {:.0} % normalised",
        100.0 * recorded,
        100.0 * even
    );
    assert!(recorded > 0.4 && even < 0.12, "{recorded} {even}");
}

#[test]
fn the_stripe_filter_takes_a_bright_ping_to_its_neighbours() {
    let contrast = |filter: bool| {
        let mut window =
            window(shown(|settings| settings.picture.stripe_filter = filter), [400.0, 300.0]);
        let [bright, beside] = [225, 215].map(|x| {
            let greys = greys(&mut window, x);
            rows(4.8).map(|(row, ..)| f64::from(greys[row])).sum::<f64>()
        });
        bright / beside
    };
    let [before, after] = [contrast(false), contrast(true)];
    eprintln!("a bright ping: {before:.2} times its neighbours, {after:.2} with the filter");
    assert!(before > 2.0 && (after - 1.0).abs() < 0.1, "{before} {after}");
}

#[test]
fn ground_range_puts_an_echo_and_the_pointer_where_they_lie() {
    let mut app = shown(|settings| settings.picture.gain = Gain::Recorded);
    app.view.options.waterfall.ground_range = true;
    let mut window = window(app, [400.0, 300.0]);
    settle(&mut window);
    // 9 m on the ground to starboard is a slant range of 9.85 m.
    window.hover_at(pos2(210.5, 150.0 + (9.0 / FAR_M * 150.0) as f32));
    window.run_steps(2);
    let state = window.state();
    let mark = state.app.view.hover.expect("the pointer is over a ping");
    let scale = state.app.picture().expect("a picture").scales.at(Side::Starboard, 210);
    let expected_m = scale.recorded_m(9.0_f64.hypot(f64::from(scale.altitude_m)));
    assert!((f64::from(scale.altitude_m) - BED_M).abs() < 0.3, "{scale:?}");
    assert_eq!((mark.ping, mark.side), (210, Some(Side::Starboard)));
    let sample = f64::from(mark.sample.expect("a sample"));
    assert!((sample - expected_m / 0.05).abs() < 1.5, "{sample}");
    assert!(pushed_text(&window).contains("9.00 m on the ground"), "{}", pushed_text(&window));
    // Who draws the bottom sees the water above it.
    let app = &mut window.state_mut().app;
    app.apply(Command::Do(Action::DrawBottom));
    assert_eq!(app.logs.shown.reviewing.tool, Tool::Bottom);
    window.hover_at(pos2(211.5, 150.0 + (2.0 / FAR_M * 150.0) as f32));
    window.run_steps(2);
    let mark = window.state().app.view.hover.expect("the pointer is over a ping");
    assert!((mark.sample.expect("a sample") - 40.0).abs() < 1.5, "{mark:?}");
}

/// The words beside the pointer.
fn pushed_text(window: &Harness<'_, Window>) -> String {
    use egui::accesskit::Role;
    use egui_kittest::kittest::{NodeT as _, Queryable as _};
    let picture: egui_kittest::Node<'_> = window.get_by_role(Role::Image);
    picture.accesskit_node().value().unwrap_or_default()
}

#[test]
fn flipped_and_swapped_a_ping_is_read_where_it_is_shown() {
    let app = shown(|settings| {
        settings.picture.flip = true;
        settings.picture.starboard_first = true;
    });
    let mut window = window(app, [400.0, 300.0]);
    settle(&mut window);
    window.hover_at(pos2(100.5, 75.0));
    window.run_steps(2);
    let mark = window.state().app.view.hover.expect("the pointer is over a ping");
    assert_eq!((mark.ping, mark.side), (299, Some(Side::Starboard)));
    // Ping 225 is bright: it stands 225 from the right.
    let [bright, beside] = [399 - 225, 399 - 215].map(|x| greys(&mut window, x)[60]);
    assert!(bright > 2 * beside, "{bright} {beside}");
}

#[test]
fn a_change_of_the_picture_is_one_step_and_makes_no_result_old() {
    let mut app = shown(|_| ());
    let products = app.logs.shown.products.clone().expect("results");
    app.apply(Command::Do(Action::GainNormalised));
    assert_eq!(app.logs.shown.settings.picture.gain, Gain::Recorded);
    assert!(!app.logs.shown.is_behind() && app.logs.shown.stale().is_none());
    assert!(app.logs.shown.own.is_own("picture.gain"), "each log has its own");
    let now = app.logs.shown.products.as_ref().expect("results");
    assert!(Arc::ptr_eq(&now.cloud, &products.cloud));
    app.apply(Command::Do(Action::Undo));
    assert_eq!(app.logs.shown.settings.picture.gain, Gain::Empirical);
    assert!(!app.logs.shown.is_behind());
    app.apply(Command::Do(Action::Redo));
    assert_eq!(app.logs.shown.settings.picture.gain, Gain::Recorded);
}
