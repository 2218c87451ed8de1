//! The whole job by keys alone, without one event of a pointer: open, look, mark and name a target,
//! measure, review, save, export.

use crate::review::{detections, propose};
use crate::support::demo_log;
use crate::window::{Window, app, demo_window, empty_window, open_step, press};
use bathyscope::app::WorkStep;
use bathyscope_objects::ObjectExtent;
use bathyscope_objects::review::State;
use egui::{Event, Key, Modifiers};
use egui_kittest::kittest::Queryable as _;
use std::path::Path;

/// Types a text into whatever has the keyboard.
fn write(window: &mut Window, text: &str) {
    window.event(Event::Text(text.to_owned()));
    window.run();
}

/// Names a file in the dialog that has just opened; what was proposed is selected, and replaced.
fn name(window: &mut Window, path: &Path) {
    window.run();
    write(window, &path.display().to_string());
    press(window, Modifiers::NONE, Key::Enter);
    window.run();
}

fn repeat(window: &mut Window, times: usize, modifiers: Modifiers, key: Key) {
    for _ in 0..times {
        press(window, modifiers, key);
    }
}

/// A log with the proposals of a detector beside it.
pub(crate) fn log_with_boxes(folder: &Path, count: usize) -> std::path::PathBuf {
    let mut window = demo_window();
    let found = detections(&window, count);
    propose(&mut window, &found, folder);
    let log = folder.join("demo.sl2");
    std::fs::copy(demo_log(), &log).expect("a copy of the demo");
    log
}

#[test]
fn the_main_job_is_done_without_a_pointer() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let log = log_with_boxes(folder.path(), 5);
    let mut window = empty_window();
    press(&mut window, Modifiers::COMMAND, Key::O);
    name(&mut window, &log);
    let found = app(&window).logs.shown.products.as_ref().expect("results");
    let port = found.returns.port.iter().filter(|pick| pick.is_some());
    assert!(port.count() > 1000, "the first return is found");
    let is_shown = |window: &Window| app(window).view.options.waterfall.first_return;
    press(&mut window, Modifiers::NONE, Key::B);
    assert!(!is_shown(&window));
    press(&mut window, Modifiers::NONE, Key::B);
    assert!(is_shown(&window));

    // A target at the cross, and its name.
    press(&mut window, Modifiers::NONE, Key::Num1);
    press(&mut window, Modifiers::NONE, Key::T);
    assert!(window.query_by_label_contains("Mark target: ").is_some());
    repeat(&mut window, 7, Modifiers::NONE, Key::ArrowUp);
    repeat(&mut window, 3, Modifiers::SHIFT, Key::ArrowRight);
    press(&mut window, Modifiers::NONE, Key::T);
    let target = app(&window).logs.shown.reviewing.selected_box();
    let target = target.expect("the target is selected").clone();
    assert_eq!(target.extent, ObjectExtent::Point);
    assert_eq!(target.state, State::Added);
    press(&mut window, Modifiers::NONE, Key::F2);
    window.run();
    write(&mut window, "anchor");
    press(&mut window, Modifiers::NONE, Key::Enter);
    let named = app(&window).logs.shown.reviewing.selected_box();
    assert_eq!(named.map(|review_box| review_box.name.as_str()), Some("anchor"));

    // A distance between two corners of the cross.
    press(&mut window, Modifiers::NONE, Key::D);
    repeat(&mut window, 2, Modifiers::NONE, Key::ArrowUp);
    press(&mut window, Modifiers::NONE, Key::X);
    repeat(&mut window, 12, Modifiers::NONE, Key::ArrowRight);
    press(&mut window, Modifiers::NONE, Key::X);
    press(&mut window, Modifiers::NONE, Key::Enter);
    press(&mut window, Modifiers::NONE, Key::Escape);
    assert!(app(&window).map.measuring.tool.is_none());
    let figure = app(&window).map.measuring.figure.clone().expect("a figure");
    let length_m = figure.measurement.length_m();
    println!("measured {length_m:.2} m by keys");
    assert!(length_m > 1.0, "{length_m}");

    // The boxes, one after the other.
    press(&mut window, Modifiers::NONE, Key::Tab);
    while app(&window).logs.review_counts().boxes.proposed > 0 {
        press(&mut window, Modifiers::NONE, Key::A);
    }
    let accepted = app(&window).logs.review_counts().boxes.accepted;
    assert_eq!(accepted, 5);

    // The project, whose name is asked for, and the products.
    let project = folder.path().join("pond.bathyscope");
    press(&mut window, Modifiers::COMMAND, Key::S);
    name(&mut window, &project);
    let text = std::fs::read_to_string(&project).expect("a project");
    assert!(text.contains("anchor"), "{text}");
    let out = folder.path().join("out");
    press(&mut window, Modifiers::COMMAND, Key::E);
    name(&mut window, &out);
    assert!(out.join("manifest.json").is_file());
    let failed = app(&window).notices.all().find(|notice| notice.is_error).cloned();
    assert_eq!(failed, None);
}

#[test]
fn the_keyboard_goes_into_the_panels_and_back() {
    use egui_kittest::kittest::NodeT as _;
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut window = demo_window();
    let found = detections(&window, 3);
    propose(&mut window, &found, folder.path());
    open_step(&mut window, WorkStep::Objects);
    let is_focused = |window: &Window, name: &str| {
        let node = window.get_by_label(name);
        node.accesskit_node().is_focused()
    };
    press(&mut window, Modifiers::NONE, Key::F6);
    window.run();
    assert!(is_focused(&window, "Objects section"));
    // With boxes Tab goes to the next one; in a panel it goes on to the next control.
    press(&mut window, Modifiers::NONE, Key::Tab);
    assert_eq!(app(&window).logs.shown.reviewing.selected, None);
    assert!(!is_focused(&window, "Objects section"));
    press(&mut window, Modifiers::NONE, Key::F6);
    window.run();
    assert!(is_focused(&window, "Review section"));
    press(&mut window, Modifiers::NONE, Key::Enter);
    assert!(window.query_by_label("Least score").is_none(), "it is folded");
    press(&mut window, Modifiers::NONE, Key::F6);
    window.run();
    press(&mut window, Modifiers::NONE, Key::Tab);
    assert!(app(&window).logs.shown.reviewing.selected.is_some());
}
