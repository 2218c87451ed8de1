//! The tools of the map, driven by keys and mouse.

use crate::window::{Window, app, demo_window, drawn_window, press, settle};
use bathyscope::app::{Action, Command, Mark, View};
use bathyscope::geo::CoordinateFormat;
use bathyscope::ui::Alone;
use egui::{Key, Modifiers};
use egui_kittest::kittest::Queryable as _;

/// Runs a command by its name.
fn by_palette(window: &mut Window, name: &str) {
    press(window, Modifiers::COMMAND, Key::P);
    window.get_by_label("Command").type_text(name);
    window.run();
    press(window, Modifiers::NONE, Key::Enter);
}

/// The map of the demo survey alone.
fn map_window() -> Window {
    let mut window = drawn_window([900.0, 640.0]);
    window.state_mut().app.apply(Command::OpenDemo);
    window.state_mut().show_alone(Alone::View(View::Map));
    settle(&mut window);
    window
}

#[test]
fn every_panel_writes_a_position_in_the_form_that_was_chosen() {
    let mut window = demo_window();
    let select = Command::Reveal(Mark::ping(400));
    window.state_mut().app.apply(select);
    window.run();
    assert!(window.query_all_by_label_contains("° W").next().is_some());
    for (name, format, sign) in [
        (
            "Coordinates: UTM metres",
            CoordinateFormat::Utm,
            "UTM 17N 3923",
        ),
        (
            "Coordinates: degrees and minutes",
            CoordinateFormat::Minutes,
            "29° 24.6",
        ),
        (
            "Coordinates: degrees, minutes and seconds",
            CoordinateFormat::Seconds,
            "29° 24' 3",
        ),
    ] {
        by_palette(&mut window, name);
        assert_eq!(app(&window).options.coordinates, format);
        let written = window.query_all_by_label_contains(sign).count();
        assert_eq!(written, 2, "in the selection and the status line: {sign}");
    }
}

#[test]
fn the_graticule_follows_the_coordinates() {
    let mut window = map_window();
    window.state_mut().app.options.coordinates = CoordinateFormat::Seconds;
    settle(&mut window);
    window.snapshot("map_graticule_seconds");
    window.state_mut().app.options.coordinates = CoordinateFormat::Utm;
    press(&mut window, Modifiers::NONE, Key::L);
    settle(&mut window);
    window.snapshot("map_graticule_utm_light");
    let off = Command::Do(Action::Graticule);
    window.state_mut().app.apply(off);
    assert!(!app(&window).options.map.graticule);
}
