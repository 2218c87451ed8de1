//! The history as a list: steps by name, where we are in it, and a click or a key that goes
//! anywhere.

use crate::logs_window::{change, ids, names, opened, settle};
use crate::window::{Window, app, press};
use bathyscope::app::{Action, BottomStroke, Command, Ink};
use bathyscope_log::survey::Side;
use egui::{Key, Modifiers};
use egui_kittest::kittest::{NodeT as _, Queryable as _};

/// The rows of the list: what each step is called, and how it stands.
fn rows(window: &Window) -> Vec<String> {
    let rows = window.query_all_by_label_contains("Change ");
    let label = |node: egui_kittest::Node<'_>| node.accesskit_node().label();
    rows.filter_map(label)
        .filter_map(|label| Some(label.strip_prefix("Change ")?.to_owned()))
        .collect()
}

fn threshold(window: &Window) -> f32 {
    app(window).document.shared.first_return.threshold
}

#[test]
fn steps_are_named_by_what_became_of_which_log_and_a_click_goes_there() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut window = opened(folder.path(), 2);
    press(&mut window, Modifiers::COMMAND, Key::H);
    assert_eq!(rows(&window), ["as opened, here"]);
    window.get_by_label("Log lake-1").click();
    settle(&mut window);
    change(&mut window, "first_return.threshold=0.41");
    change(&mut window, "draft_m=0.7");
    change(&mut window, "cloud.geometry=nadir");
    let stroke =
        BottomStroke { side: Side::Port, path: vec![[30.0, 3.1], [60.0, 3.3]], ink: Ink::Bottom };
    let [first, second] = ids(&window)[..] else { panic!("two logs") };
    for command in [
        Command::DrawBottom(stroke),
        Command::SetLogVisible(first, false),
        Command::MoveLog(second, -1),
        Command::UsePreset(bathyscope_products::pipeline::Preset::Published),
        Command::Do(Action::KeepRecordedRange),
    ] {
        window.state_mut().app.apply(command);
        settle(&mut window);
    }
    let done = [
        "as opened, done",
        "a test 0.41, done",
        "a test 0.70 m of lake-1, done",
        "a test nadir, done",
        "bottom of lake-1, done",
        "hide lake-0, done",
        "move lake-1 up, done",
        "preset, done",
        "Scale: recorded range, lake-1, here",
    ];
    let shown = rows(&window);
    assert_eq!(shown[..7], done[..7]);
    assert!(shown[7].starts_with("preset"), "{shown:?}");
    assert_eq!(shown[8], done[8]);
    assert_eq!(names(&window), ["lake-1", "lake-0"]);

    // Back over several steps at once, and what is taken back is still in the list.
    window.get_by_label("Change a test 0.41, done").click();
    settle(&mut window);
    assert_eq!(names(&window), ["lake-0", "lake-1"]);
    assert!(app(&window).logs.all().all(|log| log.is_visible));
    assert_eq!(threshold(&window), 0.41);
    assert!(app(&window).logs.shown.settings.bottom.is_empty());
    assert_eq!(app(&window).logs.shown.settings.draft_m, 0.0);
    let shown = rows(&window);
    assert_eq!(shown[..2], ["as opened, done", "a test 0.41, here"]);
    assert_eq!(shown[2], "a test 0.70 m of lake-1, taken back");
    assert_eq!(shown.len(), 9);
    assert_eq!(app(&window).document.history.redo_label(), Some("a test 0.70 m of lake-1"));

    // By the keyboard: to the row, and Enter.
    window.get_by_label("Change bottom of lake-1, taken back").focus();
    window.run();
    press(&mut window, Modifiers::NONE, Key::Enter);
    settle(&mut window);
    assert_eq!(app(&window).logs.shown.settings.bottom.ping_count(), 31);
    assert_eq!(app(&window).document.history.undo_label(), Some("bottom of lake-1"));
    window.get_by_label("Change as opened, done").click();
    settle(&mut window);
    assert_eq!(threshold(&window), 0.30);
    assert_eq!(app(&window).document.history.undo_label(), None);

    // A new step forgets those that were taken back.
    change(&mut window, "first_return.threshold=0.35");
    assert_eq!(rows(&window), ["as opened, done", "a test 0.35, here"]);
    press(&mut window, Modifiers::COMMAND, Key::H);
    assert!(rows(&window).is_empty());
}
