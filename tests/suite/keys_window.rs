//! Bare keys, those that could be part of a text: they act only where the keyboard is and on what
//! is shown as selected, and what they change of depths and decisions is said, with undo.

use crate::keyboard_window::log_with_boxes;
use crate::review::search::model;
use crate::window::{Window, app, empty_window, open_step, press, threshold};
use bathyscope::app::{Action, App, Command, Jobs, KeyFocus, LogPlace, View, WorkStep, is_bare};
use bathyscope::ui::Shell;
use bathyscope_objects::review::{Reviewed, State};
use bathyscope_products::pipeline::{SettingValues, setting_values};
use egui::{Event, Key, Modifiers};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable as _;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Keys without a letter or digit that a table or a toolkit may give a meaning.
const OTHERS: [Key; 22] = [
    Key::Comma,
    Key::Period,
    Key::OpenBracket,
    Key::CloseBracket,
    Key::Plus,
    Key::Equals,
    Key::Minus,
    Key::Slash,
    Key::Backslash,
    Key::Colon,
    Key::Semicolon,
    Key::Quote,
    Key::Space,
    Key::Tab,
    Key::Enter,
    Key::Backspace,
    Key::Delete,
    Key::Home,
    Key::End,
    Key::ArrowLeft,
    Key::ArrowRight,
    Key::ArrowDown,
];

/// The bare keys that a command has, and those that act on a control which has the keyboard.
fn bare_keys_of_commands() -> Vec<(Modifiers, Key)> {
    let of_actions = Action::ALL.iter().flat_map(|action| action.all_keys());
    let of_actions = of_actions.filter(|keys| is_bare(keys)).map(held_and_key);
    let on_controls = [Key::Space, Key::Enter, Key::Delete, Key::ArrowDown];
    let on_controls = on_controls.map(|key| (Modifiers::NONE, key));
    of_actions.chain(on_controls).collect()
}

/// A bare key of the command table.
fn held_and_key(keys: &str) -> (Modifiers, Key) {
    let (held, name) = match keys.strip_prefix("Shift+") {
        Some(name) => (Modifiers::SHIFT, name),
        None => (Modifiers::NONE, keys),
    };
    (held, Key::from_name(name).expect(keys))
}

/// Every bare key, alone and with Shift: letters, digits, signs, and those that move.
fn bare_keys() -> Vec<(Modifiers, Key)> {
    let signs = ('A'..='Z').chain('0'..='9').filter_map(|sign| Key::from_name(&sign.to_string()));
    let keys: Vec<Key> = signs.chain(OTHERS).collect();
    assert_eq!(keys.len(), 36 + OTHERS.len());
    let held = [Modifiers::NONE, Modifiers::SHIFT];
    held.into_iter().flat_map(|held| keys.iter().map(move |key| (held, *key))).collect()
}

#[test]
fn every_bare_key_of_the_command_table_is_tried() {
    let tried = bare_keys();
    for keys in Action::ALL.iter().flat_map(|action| action.all_keys()).filter(|keys| is_bare(keys))
    {
        let (held, key) = held_and_key(keys);
        assert!(tried.contains(&(held, key)) || key == Key::Escape, "{keys}");
    }
}

/// Depths, decisions and files: what a key must not change.
#[derive(Debug, PartialEq)]
struct Kept {
    settings: SettingValues,
    bottom: String,
    boxes: Vec<Reviewed>,
    files: BTreeMap<PathBuf, Vec<u8>>,
}

fn kept(window: &Window, folder: &Path) -> Kept {
    let log = &app(window).logs.shown;
    let mut settings = setting_values(&log.settings);
    settings.retain(|key, _| !key.starts_with("picture."));
    let files = std::fs::read_dir(folder).expect("a folder").map(|entry| {
        let path = entry.expect("an entry").path();
        let bytes = std::fs::read(&path).expect("a file");
        (path, bytes)
    });
    Kept {
        settings,
        bottom: format!("{:?}", log.settings.bottom),
        boxes: log.reviewing.review.boxes().cloned().collect(),
        files: files.collect(),
    }
}

/// A log with boxes in a folder of its own.
fn window_with_boxes(folder: &Path, count: usize) -> Window {
    let log = log_with_boxes(folder, count);
    let mut window = empty_window();
    window.state_mut().app.apply(Command::Open(log));
    window.run();
    assert!(app(&window).logs.has_boxes());
    window
}

/// Types a key as a keyboard does: the key, and its sign as text.
fn type_key(window: &mut Window, held: Modifiers, key: Key) {
    let name = key.symbol_or_name();
    if name.len() == 1 {
        let text = if held.shift { name.to_owned() } else { name.to_lowercase() };
        window.event(Event::Text(text));
    }
    press(window, held, key);
}

/// Clears the selection, leaves the tool and closes what is open.
fn rest(window: &mut Window) {
    for _ in 0..2 {
        press(window, Modifiers::NONE, Key::Escape);
    }
    let app = &mut window.state_mut().app;
    app.apply(Command::Select(None));
    app.apply(Command::SelectBox(None));
    app.apply(Command::Do(Action::RemoveFigure));
    if app.map.measuring.tool.is_some() {
        app.apply(Command::Do(Action::LeaveTool));
    }
    window.run();
}

type Opens = fn(&mut Window);

/// Places that can have the keyboard, and the gesture that gives it to each.
const PLACES: [(&str, Opens); 14] = [
    ("waterfall", |window| press(window, Modifiers::NONE, Key::Num1)),
    ("map", |window| press(window, Modifiers::NONE, Key::Num2)),
    ("3D cloud", |window| press(window, Modifiers::NONE, Key::Num3)),
    ("table of objects", |window| press(window, Modifiers::NONE, Key::Num4)),
    ("palette", |window| press(window, Modifiers::COMMAND, Key::P)),
    ("export", |window| press(window, Modifiers::COMMAND, Key::E)),
    ("path field", |window| press(window, Modifiers::COMMAND, Key::O)),
    ("print", |window| press(window, Modifiers::COMMAND | Modifiers::SHIFT, Key::E)),
    ("manual", |window| do_action(window, Action::Manual, "Manual")),
    ("history", |window| do_action(window, Action::History, "History")),
    ("notices", |window| do_action(window, Action::Notices, "Notices")),
    ("drop-down list", |window| {
        press(window, Modifiers::NONE, Key::Num1);
        click(window, "Colour map");
    }),
    ("menu", |window| click(window, "File")),
    ("panel", |window| press(window, Modifiers::NONE, Key::F6)),
];

/// Opens a window of the program, unless it is open.
fn do_action(window: &mut Window, action: Action, title: &str) {
    if window.query_by_role_and_label(egui::accesskit::Role::Window, title).is_none() {
        let key = Key::from_name(match action {
            Action::Manual => "F1",
            Action::Notices => "F9",
            _ => "H",
        });
        let held = match action {
            Action::History => Modifiers::COMMAND,
            _ => Modifiers::NONE,
        };
        press(window, held, key.expect("a key"));
    }
}

fn click(window: &mut Window, name: &str) {
    window.get_by_label(name).click();
    window.run();
}

#[test]
fn no_command_key_changes_depths_decisions_or_files_while_nothing_is_selected() {
    // Each key in every third place; tests/nightly types all of them in all places.
    no_key_changes_anything(&bare_keys_of_commands(), 3);
}

#[test]
#[ignore = "1 600 keys: tests/nightly"]
fn no_bare_key_changes_depths_decisions_or_files_while_nothing_is_selected() {
    no_key_changes_anything(&bare_keys(), 1);
}

/// Types each key in one of `every` places, so that a place gets one of as many keys.
fn no_key_changes_anything(keys: &[(Modifiers, Key)], every: usize) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut window = window_with_boxes(folder.path(), 5);
    let before = kept(&window, folder.path());
    for (first, (place, open)) in PLACES.into_iter().enumerate() {
        for (held, key) in keys.iter().skip(first % every).step_by(every) {
            rest(&mut window);
            open(&mut window);
            type_key(&mut window, *held, *key);
            let after = kept(&window, folder.path());
            assert_eq!(after, before, "{held:?} {key:?} in {place}");
        }
    }
}

/// The notice that undo can be pressed in.
fn undo_notices(window: &Window) -> Vec<String> {
    let offered =
        app(window).notices.shown().iter().filter(|notice| notice.offer == Some(Action::Undo));
    offered.map(|notice| notice.text.clone()).collect()
}

#[test]
fn the_threshold_moves_by_key_in_the_waterfall_alone_and_says_so() {
    let mut window = crate::window::demo_window();
    let start = threshold(&window);
    press(&mut window, Modifiers::NONE, Key::CloseBracket);
    assert_eq!(threshold(&window), start, "no ping is selected");
    window.state_mut().app.apply(Command::Reveal(LogPlace::ping(200)));
    press(&mut window, Modifiers::NONE, Key::Num2);
    press(&mut window, Modifiers::NONE, Key::CloseBracket);
    assert_eq!(threshold(&window), start, "the map has the keyboard");
    press(&mut window, Modifiers::NONE, Key::Num1);
    for _ in 0..3 {
        press(&mut window, Modifiers::NONE, Key::CloseBracket);
    }
    assert!((threshold(&window) - start - 0.03).abs() < 1e-6);
    let said = undo_notices(&window);
    assert_eq!(said.len(), 1, "{said:?}");
    assert!(said[0].starts_with("key ]: threshold 0.33"), "{said:?}");
    window.get_by_label("Undo").click();
    window.run();
    assert!((threshold(&window) - start - 0.02).abs() < 1e-6);
    assert_eq!(undo_notices(&window), [""; 0], "it takes one step back, once");
}

#[test]
fn a_decision_by_key_is_said_and_taken_back_by_its_button() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut window = window_with_boxes(folder.path(), 5);
    press(&mut window, Modifiers::NONE, Key::A);
    assert_eq!(app(&window).logs.review_counts().boxes.accepted, 0);
    assert_eq!(app(&window).logs.shown.reviewing.selected, None, "it asks for a box");
    press(&mut window, Modifiers::NONE, Key::Tab);
    let first = app(&window).logs.shown.reviewing.selected.expect("a box");
    press(&mut window, Modifiers::NONE, Key::A);
    press(&mut window, Modifiers::NONE, Key::R);
    let counts = app(&window).logs.review_counts().boxes;
    assert_eq!([counts.accepted, counts.rejected], [1, 1]);
    let said = undo_notices(&window);
    assert!(matches!(&said[..], [text] if text.starts_with("key R: reject box")), "{said:?}");
    window.get_by_label("Undo").click();
    window.run();
    let counts = app(&window).logs.review_counts().boxes;
    assert_eq!([counts.accepted, counts.rejected], [1, 0]);
    let state =
        app(&window).logs.shown.reviewing.review.get(first).map(|review_box| review_box.state);
    assert_eq!(state, Some(State::Accepted));
    // Another step than the key's takes the offer back.
    press(&mut window, Modifiers::NONE, Key::R);
    assert_eq!(undo_notices(&window).len(), 1);
    press(&mut window, Modifiers::COMMAND, Key::Z);
    assert_eq!(undo_notices(&window).len(), 0);
}

#[test]
fn a_box_that_was_scrolled_away_is_not_decided_unseen() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut window = window_with_boxes(folder.path(), 5);
    press(&mut window, Modifiers::NONE, Key::Tab);
    let id = app(&window).logs.shown.reviewing.selected.expect("a box");
    let pings = app(&window).logs.shown.reviewing.selected_box().expect("it").mark.pings.clone();
    let is_seen = |window: &Window| {
        let seen = app(window).view.visible.clone();
        pings.start < seen.end && seen.start < pings.end
    };
    assert!(is_seen(&window));
    press(&mut window, Modifiers::NONE, Key::End);
    assert!(!is_seen(&window), "{:?}", app(&window).view.visible);
    press(&mut window, Modifiers::NONE, Key::A);
    assert_eq!(app(&window).logs.review_counts().boxes.accepted, 0);
    assert_eq!(app(&window).logs.shown.reviewing.selected, Some(id));
    assert!(is_seen(&window), "it comes into view");
    press(&mut window, Modifiers::NONE, Key::A);
    assert_eq!(app(&window).logs.review_counts().boxes.accepted, 1);
    // Hidden boxes are not decided either.
    press(&mut window, Modifiers::SHIFT, Key::B);
    press(&mut window, Modifiers::NONE, Key::A);
    assert_eq!(app(&window).logs.review_counts().boxes.accepted, 1);
    let said = app(&window).notices.shown().last().map(|notice| notice.text.clone());
    assert_eq!(said.as_deref(), Some("boxes are hidden here; Shift+B shows them"));
}

#[test]
fn keys_that_change_every_depth_ask_first() {
    let mut window = crate::window::demo_window();
    window.state_mut().app.apply(Command::Reveal(LogPlace::ping(200)));
    window.run();
    let before = setting_values(&app(&window).logs.shown.settings);
    let offered = |window: &Window, action: Action| {
        app(window).notices.shown().iter().any(|notice| notice.offer == Some(action))
    };
    for (held, key) in [(Modifiers::NONE, Key::C), (Modifiers::SHIFT, Key::S)] {
        press(&mut window, held, key);
        press(&mut window, held, key);
        assert_eq!(setting_values(&app(&window).logs.shown.settings), before, "{key:?}");
    }
    assert!(offered(&window, Action::SwapSides));
    assert!(app(&window).logs.shown.proposed_stretch().is_some());
    window.state_mut().app.apply(Command::Do(Action::SwapSides));
    assert_ne!(setting_values(&app(&window).logs.shown.settings), before);
}

#[test]
fn a_key_acts_in_the_view_that_was_clicked_wherever_the_pointer_is() {
    let mut window = crate::window::demo_window();
    let is_ground = |window: &Window| app(window).view.options.waterfall.ground_range;
    press(&mut window, Modifiers::NONE, Key::Num2);
    press(&mut window, Modifiers::NONE, Key::G);
    assert!(!is_ground(&window), "G is a key of the waterfall");
    let centre = |window: &Window, name: &str| window.get_by_label_contains(name).rect().center();
    let waterfall = centre(&window, "Waterfall, ");
    window.hover_at(waterfall);
    window.run();
    press(&mut window, Modifiers::NONE, Key::G);
    assert!(!is_ground(&window), "pointing at a view gives it no keyboard");
    window.drag_at(waterfall);
    window.drop_at(waterfall);
    window.run();
    press(&mut window, Modifiers::NONE, Key::G);
    assert!(is_ground(&window));
    // With Shift a letter is another key: it does not turn the waterfall where the bottom in 3D is
    // not.
    let turned = app(&window).view.options.waterfall.orientation;
    press(&mut window, Modifiers::SHIFT, Key::V);
    assert_eq!(app(&window).view.options.waterfall.orientation, turned);
    let scope = Action::GroundRange.key_scope().expect("a bare key");
    assert!(
        scope.holds(KeyFocus::View(View::Waterfall)) && !scope.holds(KeyFocus::View(View::Map))
    );
}

/// Lets workers go on until nothing runs any more.
fn until_idle(window: &mut Window) {
    for () in bathyscope_test_support::attempts() {
        window.step();
        if app(window).is_idle() {
            return;
        }
        std::thread::sleep(std::time::Duration::from_millis(10));
    }
    panic!("it does not end");
}

#[test]
fn the_first_tab_after_a_search_selects_a_box() {
    let by_palette: Opens = |window| {
        window.key_press_modifiers(Modifiers::COMMAND, Key::P);
        window.step();
        window.event(Event::Text("find objects".to_owned()));
        window.step();
        window.key_press(Key::Enter);
    };
    let by_button: Opens = |window| {
        open_step(window, WorkStep::Objects);
        // The table of objects offers it, too; the first button is that of the panel.
        let button = window.get_all_by_label("Find objects").next();
        button.expect("the search is offered").focus();
        window.step();
        window.key_press(Key::Enter);
    };
    for search in [by_palette, by_button] {
        let mut window: Window = Harness::builder()
            .with_size([1400.0, 1000.0])
            .with_max_steps(24)
            .build_eframe(|_| Shell::new(App::new(Jobs::Threads(Arc::new(|| ())))));
        window.state_mut().app.apply(Command::OpenDemo);
        until_idle(&mut window);
        window.state_mut().app.apply(Command::UseModel(model("end_to_end")));
        window.step();
        search(&mut window);
        window.run_steps(3);
        until_idle(&mut window);
        assert!(app(&window).logs.has_boxes());
        window.key_press(Key::Tab);
        window.step();
        let first = app(&window).logs.shown.reviewing.selected;
        assert!(first.is_some());
        until_idle(&mut window);
        assert_eq!(app(&window).logs.shown.reviewing.selected, first);
    }
}
