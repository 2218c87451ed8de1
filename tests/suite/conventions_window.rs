//! Keys that users of other programs expect: full screen, the palette's second key, steps of
//! playing, boxes and lines out of the way.

use crate::review::{detections, propose};
use crate::window::{Window, app, demo_window, press};
use bathyscope::app::{Command, LogPlace, MapLayer};
use egui::{Event, Key, Modifiers, ViewportCommand, ViewportId};
use egui_kittest::kittest::Queryable as _;

/// Returns the requests for the whole screen that Bathyscope sent to the desktop in the last frame.
fn full_screen_requests(window: &Window) -> Vec<bool> {
    let output = window.output().viewport_output.get(&ViewportId::ROOT);
    let commands = output.into_iter().flat_map(|output| &output.commands);
    let asked = commands.filter_map(|command| match command {
        ViewportCommand::Fullscreen(on) => Some(*on),
        _ => None,
    });
    asked.collect()
}

/// Presses a key and returns what was asked of the desktop about the whole screen in the frame that
/// saw it.
fn asked_by(window: &mut Window, key: Key) -> Vec<bool> {
    let event = |pressed| Event::Key {
        key,
        physical_key: None,
        pressed,
        repeat: false,
        modifiers: Modifiers::NONE,
    };
    window.event(event(true));
    window.step();
    let asked = full_screen_requests(window);
    window.event(event(false));
    window.run();
    asked
}

/// Sets the state of the whole screen, as the desktop does.
fn set_full_screen(window: &mut Window, on: bool) {
    let viewports = &mut window.input_mut().viewports;
    viewports.entry(ViewportId::ROOT).or_default().fullscreen = Some(on);
}

#[test]
fn the_window_takes_the_whole_screen_and_gives_it_back() {
    let mut window = demo_window();
    assert_eq!(asked_by(&mut window, Key::F11), [true]);
    for key in [Key::F11, Key::Escape] {
        set_full_screen(&mut window, true);
        window.run();
        assert_eq!(asked_by(&mut window, key), [false], "{key:?}");
    }
    set_full_screen(&mut window, true);
    // Escape is the tool's first, and the palette's.
    press(&mut window, Modifiers::NONE, Key::D);
    assert!(app(&window).map.measuring.tool.is_some());
    assert!(asked_by(&mut window, Key::Escape).is_empty());
    assert!(app(&window).map.measuring.tool.is_none());
    press(&mut window, Modifiers::COMMAND, Key::K);
    assert!(asked_by(&mut window, Key::Escape).is_empty());
    set_full_screen(&mut window, false);
    window.run();
    assert!(asked_by(&mut window, Key::Escape).is_empty());
}

#[test]
fn the_palette_opens_by_both_of_its_keys() {
    let mut window = demo_window();
    for key in [Key::P, Key::K] {
        press(&mut window, Modifiers::COMMAND, key);
        assert!(window.query_by_label("Command").is_some(), "Ctrl+{key:?}");
        press(&mut window, Modifiers::NONE, Key::Escape);
        assert!(window.query_by_label("Command").is_none());
    }
}

/// Survey seconds that playing runs over in some frames, as fast as it is set to.
fn played_s(window: &mut Window) -> f64 {
    let time_s = |window: &Window| {
        let mark = app(window).view.selection.expect("a selection");
        let survey = app(window).logs.shown.survey.as_ref().expect("a survey");
        survey.side_scan[mark.ping].time_s
    };
    window.state_mut().app.apply(Command::Reveal(LogPlace::ping(0)));
    window.run();
    let before_s = time_s(window);
    window.key_press(Key::Space);
    window.run_steps(12);
    window.key_press(Key::Space);
    window.run_steps(2);
    time_s(window) - before_s
}

#[test]
fn playing_gets_faster_and_slower_by_keys_and_stays_within_its_steps() {
    let mut window = demo_window();
    let mut all_s = Vec::new();
    for _ in 0..8 {
        press(&mut window, Modifiers::COMMAND, Key::ArrowDown);
    }
    for _ in 0..7 {
        all_s.push(played_s(&mut window));
        press(&mut window, Modifiers::COMMAND, Key::ArrowUp);
    }
    println!("seconds of the survey played in the same frames: {all_s:.1?}");
    let [slowest_s, fastest_s] = [all_s[0], all_s[5]];
    assert!(all_s.windows(2).take(5).all(|two| two[0] < two[1]));
    let factor = fastest_s / slowest_s;
    assert!((factor - 30.0).abs() < 3.0, "{factor}");
    assert!((all_s[6] - fastest_s).abs() < 1.0, "there is no faster");
}

#[test]
fn all_boxes_are_hidden_and_shown_by_a_key() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut window = demo_window();
    let found = detections(&window, 3);
    propose(&mut window, &found, folder.path());
    let shown = |window: &Window| {
        let options = &app(window).view.options;
        let on_map = options.map.layers.is_visible(MapLayer::Boxes);
        [options.waterfall.boxes, on_map, options.cloud.boxes]
    };
    assert_eq!(shown(&window), [true; 3]);
    press(&mut window, Modifiers::SHIFT, Key::B);
    assert_eq!(shown(&window), [false; 3]);
    let notice = app(&window).notices.shown().last().expect("it is said");
    assert!(notice.text.contains("Shift+B"), "{}", notice.text);
    press(&mut window, Modifiers::SHIFT, Key::B);
    assert_eq!(shown(&window), [true; 3]);
    // Where one view shows them, all are to be hidden first.
    let mut options = app(&window).view.options.clone();
    options.waterfall.boxes = false;
    let show = Command::Show(Box::new(options));
    window.state_mut().app.apply(show);
    press(&mut window, Modifiers::SHIFT, Key::B);
    assert_eq!(shown(&window), [false; 3]);
}

#[test]
fn the_recorded_depth_is_shown_and_hidden_by_a_key() {
    let mut window = demo_window();
    let is_shown = |window: &Window| app(window).view.options.waterfall.depth_line;
    let before = is_shown(&window);
    press(&mut window, Modifiers::COMMAND, Key::B);
    assert_eq!(is_shown(&window), !before);
    press(&mut window, Modifiers::COMMAND, Key::B);
    assert_eq!(is_shown(&window), before);
}
