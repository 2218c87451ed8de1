//! Decisions about logs that are in no named project: they are saved as they are made, and are
//! there when the log is opened again, alone or with others.

use crate::logs_window::settle;
use crate::many_logs::write_logs;
use crate::window::{Window, app, empty_window, press};
use bathyscope::app::{Action, App, BottomStroke, Command, FileToWrite, Ink, Jobs};
use bathyscope_log::survey::Side;
use bathyscope_objects::Mark;
use bathyscope_objects::review::{Edit, Review, State};
use bathyscope_products::pipeline::Settings;
use egui::{Key, Modifiers};
use egui_kittest::kittest::Queryable as _;
use std::fs;
use std::path::{Path, PathBuf};

/// A window that saves decisions in a folder of its own, with logs open in it.
fn opened(folder: &Path, logs: &[&str]) -> Window {
    let mut window = empty_window();
    window.state_mut().app.files.untitled_folder = Some(folder.join("kept"));
    open(&mut window, folder, logs);
    window
}

fn open(window: &mut Window, folder: &Path, logs: &[&str]) {
    let paths = logs.iter().map(|name| folder.join(name)).collect();
    act(window, Command::OpenAll(paths));
}

fn act(window: &mut Window, command: Command) {
    window.state_mut().app.apply(command);
    settle(window);
}

fn logs() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a temporary folder");
    write_logs(folder.path(), 2);
    folder
}

const A: &str = "lake-0.sl2";
const B: &str = "lake-1.sl2";

fn change(window: &mut Window, assignment: &str) {
    crate::logs_window::change(window, assignment);
    settle(window);
}

fn stroke(window: &mut Window) {
    let path = vec![[30.0, 3.1], [60.0, 3.3]];
    act(window, Command::DrawBottom(BottomStroke { side: Side::Port, path, ink: Ink::Bottom }));
}

fn mark(window: &mut Window) {
    let mark = Mark { side: Side::Port, pings: 20..30, near_m: 4.0, far_m: 6.0 };
    act(window, Command::Edit { edit: Edit::Add { mark, class: 0 }, live: false });
}

/// Returns the decisions about the shown log.
fn decisions(window: &Window) -> (Settings, Vec<State>) {
    let log = &app(window).logs.shown;
    let states = log.reviewing.review.boxes().map(|review_box| review_box.state).collect();
    (Settings::clone(&log.settings), states)
}

fn kept(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder.join("kept")).into_iter().flatten().flatten();
    let paths = entries.map(|entry| entry.path());
    let mut paths: Vec<PathBuf> = paths
        .filter(|path| path.extension().is_some_and(|ending| ending == "bathyscope"))
        .collect();
    paths.sort();
    paths
}

#[test]
fn each_decision_is_saved_at_once_and_comes_back_with_its_log_and_with_undo() {
    let folder = logs();
    let mut window = opened(folder.path(), &[A]);
    assert!(kept(folder.path()).is_empty(), "nothing is written for those who only look");
    change(&mut window, "first_return.threshold=0.41");
    stroke(&mut window);
    mark(&mut window);
    let last = decisions(&window);
    assert_eq!(kept(folder.path()).len(), 1);
    assert!(app(&window).files.project_saving.is_unsaved(), "it has no name yet");
    assert_eq!(app(&window).files.project_saving.path(), None);
    assert!(!app(&window).is_at_risk());
    // As if the program was killed: it could save nothing at its end.
    std::mem::forget(window);
    let copy = folder.path().join("copy");
    fs::create_dir(&copy).expect("a folder");
    for entry in fs::read_dir(folder.path().join("kept")).expect("a folder").flatten() {
        fs::copy(entry.path(), copy.join(entry.file_name())).expect("a copy");
    }

    let mut window = empty_window();
    window.state_mut().app.files.untitled_folder = Some(copy);
    open(&mut window, folder.path(), &[A]);
    assert_eq!(decisions(&window), last);
    window.get_by_label_contains("with the last decisions");
    assert_eq!(app(&window).recent.first(), Some(&folder.path().join(A)));
    for _ in 0..3 {
        press(&mut window, Modifiers::COMMAND, Key::Z);
        settle(&mut window);
    }
    assert_eq!(decisions(&window), (Settings::default(), Vec::new()));
    // Undone, it is undone the next time.
    window.state_mut().app.keep_all();
    drop(window);
    let mut window = empty_window();
    window.state_mut().app.files.untitled_folder = Some(folder.path().join("copy"));
    open(&mut window, folder.path(), &[A]);
    assert_eq!(decisions(&window), (Settings::default(), Vec::new()));
}

#[test]
fn another_survey_opened_meanwhile_costs_no_decision() {
    let folder = logs();
    let mut window = opened(folder.path(), &[A]);
    mark(&mut window);
    change(&mut window, "draft_m=0.4");
    let of_a = decisions(&window);
    open(&mut window, folder.path(), &[B]);
    window.get_by_label_contains("are there when it is opened again");
    assert_eq!(decisions(&window), (Settings::default(), Vec::new()));
    open(&mut window, folder.path(), &[A]);
    assert_eq!(decisions(&window), of_a);

    // With another log: the decisions come along as one step.
    open(&mut window, folder.path(), &[B, A]);
    let a = app(&window).logs.all().find(|log| log.name() == "lake-0").expect("the log").id;
    act(&mut window, Command::ShowLog(a));
    assert_eq!(decisions(&window).1, [State::Added]);
    assert!((decisions(&window).0.draft_m - 0.4).abs() < 1e-9);
    press(&mut window, Modifiers::COMMAND, Key::Z);
    settle(&mut window);
    assert!(decisions(&window).1.is_empty());
    press(&mut window, Modifiers::COMMAND | Modifiers::SHIFT, Key::Z);
    settle(&mut window);

    // A change of the two makes a project of the two, which the two open again.
    change(&mut window, "first_return.threshold=0.41");
    let both = decisions(&window);
    open(&mut window, folder.path(), &[B]);
    assert_eq!(decisions(&window).0.first_return.threshold, 0.41);
    open(&mut window, folder.path(), &[A, B]);
    assert_eq!(app(&window).logs.count(), 2);
    let last = app(&window).logs.all().last().expect("two logs").id;
    act(&mut window, Command::ShowLog(last));
    assert_eq!(decisions(&window), both);
}

#[test]
fn a_log_that_is_closed_keeps_its_decisions() {
    let folder = logs();
    let mut window = opened(folder.path(), &[A, B]);
    mark(&mut window);
    let of_a = decisions(&window);
    let id = app(&window).logs.shown.id;
    act(&mut window, Command::CloseLog(id));
    assert_eq!(app(&window).logs.count(), 1);
    act(&mut window, Command::Add(vec![folder.path().join(A)]));
    assert_eq!(app(&window).logs.count(), 2);
    assert_eq!(decisions(&window), of_a);
    // Closed as the last one as well.
    for _ in 0..2 {
        let id = app(&window).logs.shown.id;
        act(&mut window, Command::CloseLog(id));
    }
    open(&mut window, folder.path(), &[A]);
    assert_eq!(decisions(&window), of_a);
}

#[test]
fn a_log_that_was_replaced_has_no_decisions_and_one_that_was_moved_has_its_own() {
    let folder = logs();
    let mut window = opened(folder.path(), &[A]);
    mark(&mut window);
    let of_a = decisions(&window);
    window.state_mut().app.keep_all();
    drop(window);
    let moved = folder.path().join("moved");
    fs::create_dir(&moved).expect("a folder");
    fs::rename(folder.path().join(A), moved.join(A)).expect("the log moves");
    // As long, but another recording.
    let mut bytes = fs::read(moved.join(A)).expect("the log");
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    fs::write(folder.path().join(A), bytes).expect("another log");
    let window = opened(folder.path(), &[A]);
    assert!(decisions(&window).1.is_empty());
    drop(window);
    let mut window = opened(folder.path(), &[]);
    open(&mut window, &moved, &[A]);
    assert_eq!(decisions(&window), of_a);
    let names: Vec<String> = app(&window).logs.all().map(|log| log.name()).collect();
    assert_eq!(names, ["lake-0"]);
}

#[test]
fn a_survey_with_a_name_needs_no_untitled_project_any_more() {
    let folder = logs();
    let mut window = opened(folder.path(), &[A, B]);
    mark(&mut window);
    assert_eq!(kept(folder.path()).len(), 1);
    let path = folder.path().join("lake.bathyscope");
    act(&mut window, Command::Write(FileToWrite::Project(path.clone())));
    assert_eq!(app(&window).files.project_saving.path(), Some(path.as_path()));
    assert!(!app(&window).files.project_saving.is_unsaved());
    press(&mut window, Modifiers::COMMAND, Key::Z);
    settle(&mut window);
    assert!(decisions(&window).1.is_empty());
    assert!(app(&window).files.project_saving.is_unsaved());
    // Another survey in between, and the project again: no decision is said to be lost.
    press(&mut window, Modifiers::COMMAND | Modifiers::SHIFT, Key::Z);
    settle(&mut window);
    act(&mut window, Command::Open(path.clone()));
    open(&mut window, folder.path(), &[A]);
    act(&mut window, Command::Open(path.clone()));
    assert_eq!(decisions(&window).1, [State::Added]);
    let lost = app(&window).notices.all().find(|notice| notice.text.contains("are gone"));
    assert_eq!(lost, None);
    // A log alone has no decisions of before it was saved; where they are is said.
    open(&mut window, folder.path(), &[A]);
    assert!(decisions(&window).1.is_empty());
    window.get_by_label_contains("are in the project");
    // Without that project they are there as they were saved.
    fs::remove_file(&path).expect("the project goes");
    open(&mut window, folder.path(), &[B]);
    open(&mut window, folder.path(), &[A]);
    assert_eq!(decisions(&window).1, [State::Added]);
}

#[test]
fn a_log_that_grows_keeps_its_decisions() {
    let folder = logs();
    let path = folder.path().join(A);
    let bytes = fs::read(&path).expect("the log");
    fs::remove_file(&path).expect("the log goes");
    fs::write(&path, &bytes[..bytes.len() / 2]).expect("half a log");
    let mut window = opened(folder.path(), &[A]);
    mark(&mut window);
    let pings = app(&window).logs.shown.survey.as_ref().expect("a log").side_scan.len();
    drop_kept(window);
    fs::remove_file(&path).expect("the log goes");
    fs::write(&path, &bytes).expect("the whole log");
    for _ in 0..2 {
        let window = opened(folder.path(), &[A]);
        let now = app(&window).logs.shown.survey.as_ref().expect("a log").side_scan.len();
        assert!(now > pings);
        assert_eq!(decisions(&window).1, [State::Added]);
        drop_kept(window);
    }
}

/// Closes a window as its user does.
fn drop_kept(mut window: Window) {
    window.state_mut().app.keep_all();
}

#[test]
fn another_recording_among_the_logs_has_no_decisions_and_is_opened() {
    let folder = logs();
    let mut window = opened(folder.path(), &[A, B]);
    mark(&mut window);
    let b = app(&window).logs.all().last().expect("two logs").id;
    act(&mut window, Command::ShowLog(b));
    mark(&mut window);
    drop_kept(window);
    let path = folder.path().join(B);
    let mut bytes = fs::read(&path).expect("the log");
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    fs::remove_file(&path).expect("the log goes");
    fs::write(&path, bytes).expect("another log");
    let window = opened(folder.path(), &[A, B]);
    let boxes = app(&window).logs.all().map(|log| log.reviewing.review.boxes().len());
    assert_eq!(boxes.collect::<Vec<_>>(), [1, 0]);
}

#[test]
fn logs_of_one_name_in_two_folders_are_told_apart() {
    let folder = logs();
    let other = folder.path().join("other");
    fs::create_dir(&other).expect("a folder");
    fs::rename(folder.path().join(B), other.join(A)).expect("the log moves");
    let mut window = opened(folder.path(), &[A]);
    mark(&mut window);
    let names = [A.to_owned(), format!("other/{A}")];
    let names = names.each_ref().map(String::as_str);
    for _ in 0..2 {
        open(&mut window, folder.path(), &names);
        let boxes = app(&window).logs.all().map(|log| log.reviewing.review.boxes().len());
        assert_eq!(boxes.collect::<Vec<_>>(), [1, 0]);
        change(&mut window, "draft_m=0.4");
    }
}

#[test]
fn the_open_survey_is_opened_again_as_it_is() {
    let folder = logs();
    let mut window = opened(folder.path(), &[A]);
    mark(&mut window);
    open(&mut window, folder.path(), &[A]);
    assert_eq!(decisions(&window).1, [State::Added]);
    assert_eq!(kept(folder.path()).len(), 1);
    press(&mut window, Modifiers::COMMAND, Key::Z);
    settle(&mut window);
    assert!(decisions(&window).1.is_empty(), "undo goes on");
}

#[test]
fn settings_of_all_logs_come_back_after_their_only_log_was_closed() {
    let folder = logs();
    let mut window = opened(folder.path(), &[A]);
    change(&mut window, "first_return.threshold=0.41");
    let id = app(&window).logs.shown.id;
    act(&mut window, Command::CloseLog(id));
    assert_eq!(kept(folder.path()).len(), 2);
    press(&mut window, Modifiers::COMMAND, Key::Z);
    settle(&mut window);
    assert_eq!(kept(folder.path()).len(), 1, "it is open again");
    let id = app(&window).logs.shown.id;
    act(&mut window, Command::CloseLog(id));
    drop_kept(window);
    let window = opened(folder.path(), &[A]);
    assert_eq!(app(&window).logs.shown.settings.first_return.threshold, 0.41);
}

#[test]
fn a_second_window_takes_the_decisions_and_makes_its_own() {
    let folder = logs();
    let mut first = opened(folder.path(), &[A]);
    mark(&mut first);
    let mut second = opened(folder.path(), &[A]);
    assert_eq!(decisions(&second), decisions(&first));
    change(&mut second, "draft_m=0.4");
    assert_eq!(kept(folder.path()).len(), 2);
    change(&mut first, "draft_m=0.3");
    assert!((decisions(&second).0.draft_m - 0.4).abs() < 1e-9);
}

#[test]
fn a_folder_that_cannot_be_written_is_named_and_closing_asks() {
    let folder = logs();
    fs::write(folder.path().join("kept"), "a file").expect("a file");
    let mut window = opened(folder.path(), &[A]);
    mark(&mut window);
    window.get_by_label_contains("decisions cannot be saved as they are made");
    assert!(app(&window).is_at_risk());
    open(&mut window, folder.path(), &[B]);
    window.get_by_label_contains("were in no file, and are gone");
}

#[test]
fn a_decision_is_saved_although_the_log_was_removed_after_it_was_opened() {
    let folder = logs();
    let mut window = opened(folder.path(), &[A]);
    fs::remove_file(folder.path().join(A)).expect("a log");
    mark(&mut window);
    assert!(!app(&window).is_at_risk());
    assert_eq!(kept(folder.path()).len(), 1);
}

#[test]
fn a_review_that_was_written_later_is_named() {
    let folder = logs();
    let mut window = opened(folder.path(), &[A]);
    mark(&mut window);
    let path = app(&window).logs.shown.review_path().expect("a place");
    act(&mut window, Command::Write(FileToWrite::Review(path.clone())));
    open(&mut window, folder.path(), &[B]);
    open(&mut window, folder.path(), &[A]);
    assert!(window.query_by_label_contains("is newer than").is_none(), "it is the same");
    let review = Review::clone(&app(&window).logs.shown.reviewing.review);
    let id = review.boxes().next().expect("a box").id;
    let other = review.apply(&Edit::Reject(id)).expect("a change");
    open(&mut window, folder.path(), &[B]);
    std::thread::sleep(std::time::Duration::from_millis(20));
    fs::write(&path, other.to_json()).expect("a review");
    open(&mut window, folder.path(), &[A]);
    window.get_by_label_contains("is newer than the last decisions");
    assert_eq!(decisions(&window).1, [State::Added]);
}

/// Nothing is saved unasked where no folder is given, as in a picture or a test.
#[test]
fn without_a_folder_nothing_is_written() {
    let folder = logs();
    let mut app = App::new(Jobs::Inline);
    app.apply(Command::Open(folder.path().join(A)));
    app.poll();
    app.apply(Command::Do(Action::SwapSides));
    app.keep_all();
    let names: Vec<_> = fs::read_dir(folder.path()).expect("a folder").flatten().collect();
    assert_eq!(names.len(), 2, "{names:?}");
}

/// The program's own folder for options is that of Linux.
#[cfg(target_os = "linux")]
#[test]
fn a_command_that_is_given_a_log_names_the_project_with_the_decisions_about_it() {
    let folder = logs();
    let run = |log: &str| {
        let arguments = ["process", log, "-o", "out", "--products", "track", "--no-objects"];
        let output = std::process::Command::new(crate::support::program())
            .args(arguments)
            .current_dir(folder.path())
            .env("XDG_DATA_HOME", folder.path())
            .output()
            .expect("the program starts");
        assert!(output.status.success());
        String::from_utf8_lossy(&output.stderr).into_owned()
    };
    let untitled = folder.path().join("bathyscope/untitled");
    let mut window = empty_window();
    window.state_mut().app.files.untitled_folder = Some(untitled.clone());
    open(&mut window, folder.path(), &[A]);
    change(&mut window, "draft_m=0.4");
    let name = fs::read_dir(&untitled).expect("a folder").flatten().map(|entry| entry.path());
    let mut projects = name.filter(|path| path.extension().is_some_and(|e| e == "bathyscope"));
    let project = projects.next().expect("an untitled project").display().to_string();
    let warned = run(A);
    assert!(
        warned.contains("decisions made about lake-0") && warned.contains(&project),
        "{warned}"
    );
    assert!(!run(B).contains("decisions made"));
    // The project is still open, and its file does not contain the change yet.
    assert!(!run(&project).contains("decisions made"));
    let report = fs::read_to_string(folder.path().join("out/report.json")).expect("a report");
    assert!(report.contains("\"draft_m\": 0.4"), "{report}");

    // Under a name, they are in the named project.
    let named = folder.path().join("lake.bathyscope");
    act(&mut window, Command::Write(FileToWrite::Project(named.clone())));
    let warned = run(A);
    assert!(warned.contains(&named.display().to_string()), "{warned}");
    window.state_mut().app.keep_all();
    drop(window);
    assert!(!run("lake.bathyscope").contains("decisions made"));
}
