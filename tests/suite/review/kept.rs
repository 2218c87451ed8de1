//! Decisions are kept on the way, and offered again: never lost by a closed window, never mixed
//! into another log.

use super::*;

/// The demo as a file of its own in a folder, opened, with four proposals.
fn opened(folder: &Path) -> (PathBuf, Window) {
    let log = folder.join("pond.sl2");
    if !log.exists() {
        fs::copy(crate::support::demo_log(), &log).expect("a log");
    }
    let mut window = crate::window::empty_window();
    app_mut(&mut window).apply(Command::Open(log.clone()));
    window.run();
    (log, window)
}

fn proposed_in(folder: &Path) -> (PathBuf, Window) {
    let (log, mut window) = opened(folder);
    let found = detections(&window, 4);
    propose(&mut window, &found, folder);
    (log, window)
}

fn kept(folder: &Path) -> Option<Review> {
    let text = fs::read_to_string(folder.join("pond.review.unsaved.json")).ok()?;
    let bytes = fs::metadata(folder.join("pond.sl2")).expect("the log").len();
    let identity =
        serde_json::from_str::<serde_json::Value>(&text).expect("JSON")["survey"].clone();
    assert_eq!(identity["byte_count"], bytes);
    let identity = serde_json::from_value(identity).expect("an identity");
    Some(Review::from_json(&text, &identity).expect("a review"))
}

fn decided(review: &Review) -> usize {
    review.boxes().filter(|review_box| review_box.is_kept()).count()
}

#[test]
fn decisions_are_kept_every_few_seconds_and_at_the_end_and_taken_up_by_a_click() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let (log, mut window) = proposed_in(folder.path());
    let before = fs::read(&log).expect("the log");
    assert!(kept(folder.path()).is_none(), "proposals alone are no loss");
    press(&mut window, Modifiers::NONE, Key::Tab);
    press(&mut window, Modifiers::NONE, Key::A);
    window.run();
    assert_eq!(decided(&kept(folder.path()).expect("kept at once")), 1);
    press(&mut window, Modifiers::NONE, Key::R);
    window.run();
    assert_eq!(decided(&kept(folder.path()).expect("kept")), 1, "not at every decision");
    let due = app(&window).autosave_due().expect("something to keep");
    assert!(due <= std::time::Duration::from_secs(3) && !due.is_zero());
    assert!(app(&window).is_at_risk());
    app_mut(&mut window).keep_decisions();
    assert!(!app(&window).is_at_risk());
    let last = review_of(&window).clone();
    assert_eq!(kept(folder.path()).as_ref().map(Review::shared), Some(last.shared()));
    drop(window);

    let (_, mut window) = opened(folder.path());
    assert!(!app(&window).log.reviewing.has_boxes(), "offered, not taken");
    window.get_by_label_contains("Decisions about 2 boxes were not saved");
    window.get_by_label("Restore unsaved decisions").click();
    window.run();
    assert_eq!(review_of(&window).shared(), last.shared());
    assert!(window.query_by_label("Restore unsaved decisions").is_none());
    press(&mut window, Modifiers::COMMAND, Key::Z);
    assert!(!app(&window).log.reviewing.has_boxes(), "one undo step");
    press(&mut window, Modifiers::COMMAND | Modifiers::SHIFT, Key::Z);
    assert_eq!(review_of(&window).shared(), last.shared());
    // Saved, they need not be kept.
    let path = app(&window).review_path().expect("a place");
    app_mut(&mut window).apply(Command::Write(FileToWrite::Review(path)));
    window.run();
    assert!(kept(folder.path()).is_none());
    let (_, window) = opened(folder.path());
    assert_eq!(review_of(&window).shared(), last.shared());
    assert!(window.query_by_label("Restore unsaved decisions").is_none());
    assert!(fs::read(&log).expect("the log") == before, "the log is never written");
}

#[test]
fn decisions_that_nobody_took_up_are_set_aside_and_those_of_another_log_left_alone() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let (log, mut window) = proposed_in(folder.path());
    press(&mut window, Modifiers::NONE, Key::Tab);
    press(&mut window, Modifiers::NONE, Key::A);
    app_mut(&mut window).keep_decisions();
    let file = folder.path().join("pond.review.unsaved.json");
    let first = fs::read_to_string(&file).expect("kept");
    let (_, mut window) = proposed_in(folder.path());
    press(&mut window, Modifiers::NONE, Key::Tab);
    press(&mut window, Modifiers::NONE, Key::R);
    app_mut(&mut window).keep_decisions();
    let older = folder.path().join("pond.review.unsaved-older.json");
    assert_eq!(fs::read_to_string(older).expect("set aside"), first);
    let second = fs::read_to_string(&file).expect("kept");
    assert_ne!(second, first);
    drop(window);

    // Half of the log is another log.
    let bytes = fs::read(&log).expect("the log");
    // A new file: a worker of the window may still look into the map of the old one.
    fs::remove_file(&log).expect("the log goes");
    fs::write(&log, &bytes[..bytes.len() / 2]).expect("half a log");
    let (_, mut window) = opened(folder.path());
    window.get_by_label_contains("belongs to another log");
    let found = detections(&window, 4);
    propose(&mut window, &found, folder.path());
    press(&mut window, Modifiers::NONE, Key::Tab);
    press(&mut window, Modifiers::NONE, Key::A);
    app_mut(&mut window).keep_decisions();
    assert_eq!(fs::read_to_string(&file).expect("left alone"), second);
    assert!(app(&window).is_at_risk(), "and the analyst is asked when closing");
}

#[test]
fn another_log_opened_meanwhile_costs_no_decision() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let (log, mut window) = proposed_in(folder.path());
    press(&mut window, Modifiers::NONE, Key::Tab);
    for key in [Key::A, Key::R, Key::A] {
        press(&mut window, Modifiers::NONE, key);
    }
    app_mut(&mut window).apply(Command::OpenDemo);
    window.run();
    assert_eq!(decided(&kept(folder.path()).expect("kept")), 3);
    assert!(!app(&window).is_at_risk());
    assert!(window.query_by_label("Restore unsaved decisions").is_none());
    app_mut(&mut window).apply(Command::Open(log));
    window.run();
    assert_eq!(decided(review_of(&window)), 3);
    assert!(
        window.query_by_label("Restore unsaved decisions").is_none(),
        "this run's own decisions are no news"
    );
}
