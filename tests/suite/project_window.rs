//! A survey of several logs kept as a project: opened, changed, saved, closed and opened again, in
//! the window.

use crate::logs_window::{change, ids, names, opened, settle};
use crate::window::{Window, app, drop_file, empty_window, press};
use bathyscope::app::{Action, BottomStroke, Command, FileToWrite, Ink};
use bathyscope_log::survey::Side;
use egui::{Key, Modifiers};
use egui_kittest::kittest::Queryable as _;
use sha2::{Digest as _, Sha256};
use std::path::{Path, PathBuf};

pub(super) fn save_as(window: &mut Window, path: &Path) {
    window.state_mut().app.apply(Command::Write(FileToWrite::Project(path.to_owned())));
    settle(window);
    assert_eq!(app(window).files.project_saving.path(), Some(path));
}

pub(super) fn open(path: &Path) -> Window {
    let mut window = empty_window();
    drop_file(&mut window, path.to_owned());
    settle(&mut window);
    window
}

/// A stroke over the waterfall of the log that is shown.
fn draw_bottom(window: &mut Window) {
    window.state_mut().app.apply(Command::DrawBottom(BottomStroke {
        side: Side::Port,
        path: vec![[30.0, 3.1], [60.0, 3.3]],
        ink: Ink::Bottom,
    }));
    settle(window);
}

/// Returns the decisions about all logs, as far as they can be compared.
fn decisions(window: &Window) -> Vec<String> {
    let logs = app(window).logs.all().map(|log| {
        let settings = toml::to_string(&*log.settings).expect("settings are text");
        format!("{} {} {settings}", log.name(), log.is_visible)
    });
    logs.collect()
}

pub(super) fn hashes(folder: &Path) -> Vec<(PathBuf, Vec<u8>)> {
    let entries = std::fs::read_dir(folder).expect("the folder").flatten();
    let logs = entries.map(|entry| entry.path());
    let logs = logs.filter(|path| path.extension().is_some_and(|ending| ending == "sl2"));
    let mut all: Vec<_> = logs
        .map(|path| {
            let bytes = std::fs::read(&path).expect("a log");
            (path, Sha256::digest(bytes).to_vec())
        })
        .collect();
    all.sort();
    all
}

#[test]
fn a_project_comes_back_as_it_was_left_and_the_logs_are_untouched() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut window = opened(folder.path(), 3);
    let before = hashes(folder.path());
    let path = folder.path().join("lake.bathyscope");
    save_as(&mut window, &path);
    change(&mut window, "first_return.threshold=0.37");
    change(&mut window, "draft_m=0.4");
    draw_bottom(&mut window);
    let [first, second, _] = ids(&window)[..] else { panic!("three logs") };
    let app_of = |window: &mut Window, command: Command| {
        window.state_mut().app.apply(command);
        settle(window);
    };
    app_of(&mut window, Command::MoveLog(first, 2));
    app_of(&mut window, Command::SetLogVisible(second, false));
    assert!(app(&window).files.project_saving.is_unsaved());
    press(&mut window, Modifiers::COMMAND, Key::S);
    assert!(!app(&window).files.project_saving.is_unsaved());
    let left = decisions(&window);
    assert_eq!(names(&window), ["lake-1", "lake-2", "lake-0"]);
    drop(window);

    let again = open(&path);
    assert_eq!(names(&again), ["lake-1", "lake-2", "lake-0"]);
    assert_eq!(decisions(&again), left);
    let drawn = app(&again).logs.all().last().expect("three logs");
    assert_eq!(drawn.settings.bottom.ping_count(), 31);
    assert_eq!(hashes(folder.path()), before, "no log is written");
    drop(again);
    // Without a window it is the same survey: the logs that are ticked, each with its settings.
    let out = folder.path().join("out");
    let program = std::process::Command::new(crate::support::program())
        .args(["process", "--no-objects", "--products", "track", "-o"])
        .args([&out, &path])
        .output()
        .expect("the program");
    assert!(program.status.success(), "{program:?}");
    let table = std::fs::read_to_string(out.join("points/first_returns.csv")).expect("a table");
    let logs: std::collections::BTreeSet<_> =
        (table.lines().skip(1)).filter_map(|line| line.split(',').next()).collect();
    assert_eq!(logs.into_iter().collect::<Vec<_>>(), ["lake-0", "lake-2"]);
    let beside = folder.path().join("lake-0.bottom.toml");
    assert!(!beside.exists(), "the project keeps it");
}

#[test]
fn a_project_that_is_opened_again_can_be_undone_whether_it_was_saved_or_not() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut window = opened(folder.path(), 2);
    let path = folder.path().join("lake.bathyscope");
    // What was done before it was a project counts as well.
    change(&mut window, "first_return.threshold=0.36");
    let first = decisions(&window);
    save_as(&mut window, &path);
    change(&mut window, "draft_m=0.4");
    draw_bottom(&mut window);
    press(&mut window, Modifiers::COMMAND, Key::Z);
    draw_bottom(&mut window);
    let saved = decisions(&window);
    press(&mut window, Modifiers::COMMAND, Key::S);
    change(&mut window, "first_return.threshold=0.38");
    let last = decisions(&window);
    drop(window);

    let mut again = open(&path);
    let steps = app(&again).document.history.steps().count();
    assert_eq!(steps, 4, "what was taken back is no step");
    assert_eq!(decisions(&again), last);
    let undo = |window: &mut Window| {
        press(window, Modifiers::COMMAND, Key::Z);
        settle(window);
    };
    undo(&mut again);
    assert_eq!(decisions(&again), saved, "from the journal");
    undo(&mut again);
    undo(&mut again);
    assert_eq!(decisions(&again), first, "from the history beside the file");
    undo(&mut again);
    let threshold = app(&again).logs.shown.settings.first_return.threshold;
    assert!((threshold - 0.3).abs() < 1e-6, "{threshold}");
    press(&mut again, Modifiers::COMMAND | Modifiers::SHIFT, Key::Z);
    settle(&mut again);
    assert_eq!(decisions(&again), first);
}

#[test]
fn a_log_keeps_its_water_levels_when_a_setting_of_all_logs_changes() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut window = opened(folder.path(), 2);
    let survey = app(&window).logs.shown.survey.clone().expect("a survey");
    let start_s = survey.start_unix_s.expect("a time");
    let gauge = folder.path().join("gauge.csv");
    let (first_s, last_s) = (start_s - 100.0, start_s + 900.0);
    std::fs::write(&gauge, format!("time,level_m\n{first_s},1\n{last_s},2\n")).expect("a file");
    drop_file(&mut window, gauge);
    settle(&mut window);
    let path = folder.path().join("lake.bathyscope");
    save_as(&mut window, &path);
    let gauged = |window: &Window| -> Vec<bool> {
        let products = app(window).logs.all().filter_map(|log| log.products.as_ref());
        products.map(|results| results.correction.gauge().is_some()).collect()
    };
    let which = gauged(&window);
    assert_eq!(which.iter().filter(|has| **has).count(), 1, "{which:?}");

    drop(window);
    let mut window = open(&path);
    assert_eq!(gauged(&window), which);
    // With either log shown: the other one follows the shared settings.
    for threshold in ["0.37", "0.38"] {
        change(&mut window, &format!("first_return.threshold={threshold}"));
        assert_eq!(gauged(&window), which, "{threshold}");
        press(&mut window, Modifiers::COMMAND, Key::Z);
        settle(&mut window);
        assert_eq!(gauged(&window), which, "undone");
        window.state_mut().app.apply(Command::Do(Action::NextLog));
        settle(&mut window);
    }
}

#[test]
fn what_was_not_saved_is_in_the_journal() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut window = opened(folder.path(), 2);
    let path = folder.path().join("lake.bathyscope");
    save_as(&mut window, &path);
    change(&mut window, "first_return.threshold=0.44");
    draw_bottom(&mut window);
    let left = decisions(&window);
    // Nobody saves; the window goes.
    drop(window);
    let mut again = open(&path);
    assert_eq!(decisions(&again), left);
    assert!(app(&again).files.project_saving.is_unsaved());
    // Another window on the same project does not get it.
    let other = open(&path);
    assert_eq!(app(&other).logs.count(), 0);
    assert!(other.query_by_label_contains("open in another window").is_some());
    // A log that joins the survey is in the project at once.
    let more = tempfile::tempdir().expect("a temporary folder");
    crate::many_logs::write_logs(more.path(), 3);
    drop_file(&mut again, more.path().join("lake-2.sl2"));
    settle(&mut again);
    assert_eq!(names(&again), ["lake-0", "lake-1", "lake-2"]);
    drop(again);
    assert_eq!(names(&open(&path)), ["lake-0", "lake-1", "lake-2"]);
}

#[test]
fn a_log_that_was_moved_is_found_and_one_that_is_gone_is_named_and_kept() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut window = opened(folder.path(), 3);
    let path = folder.path().join("lake.bathyscope");
    save_as(&mut window, &path);
    drop(window);
    let deeper = folder.path().join("cards").join("one");
    std::fs::create_dir_all(&deeper).expect("a folder");
    let moved = deeper.join("renamed.sl2");
    std::fs::rename(folder.path().join("lake-1.sl2"), moved).expect("moved");
    let elsewhere = tempfile::tempdir().expect("a temporary folder");
    let gone = elsewhere.path().join("lake-2.sl2");
    std::fs::copy(folder.path().join("lake-2.sl2"), &gone).expect("a copy");
    std::fs::remove_file(folder.path().join("lake-2.sl2")).expect("gone");

    let mut window = open(&path);
    assert_eq!(names(&window), ["lake-0", "renamed"]);
    let found = window.query_by_label_contains("the log lake-2 is missing");
    assert!(found.is_some());
    press(&mut window, Modifiers::COMMAND, Key::S);
    drop(window);
    std::fs::copy(&gone, folder.path().join("lake-2.sl2")).expect("back again");
    assert_eq!(names(&open(&path)), ["lake-0", "renamed", "lake-2"]);
}
