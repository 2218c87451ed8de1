//! Several logs in one window: one map, one cloud, one history.

use crate::many_logs::{HIGHER_M, bed_depth_m, rms, write_logs};
use crate::window::{Window, app, drawn_window, drop_file, empty_window, press, settle as drawn};
use bathyscope::app::{App, CloudColour, Command, FileToWrite, LogId, LogPlace};
use bathyscope_products::pipeline::Settings;
use egui::accesskit::Role;
use egui::{Key, Modifiers};
use egui_kittest::kittest::{NodeT as _, Queryable as _};
use std::path::Path;

/// Lets everything that is asked for come to its end.
pub(super) fn settle(window: &mut Window) {
    for _ in 0..40 {
        window.run();
        let all_done = app(window).logs.visible().all(|log| !log.is_behind());
        if app(window).is_idle() && all_done {
            return;
        }
    }
    panic!("it comes to no end");
}

/// A window on a folder of logs.
pub(super) fn opened(folder: &Path, count: usize) -> Window {
    opened_in(empty_window(), folder, count)
}

/// The same in a window of another kind.
pub(super) fn opened_in(mut window: Window, folder: &Path, count: usize) -> Window {
    write_logs(folder, count);
    drop_file(&mut window, folder.to_owned());
    settle(&mut window);
    window
}

pub(super) fn ids(window: &Window) -> Vec<LogId> {
    app(window).logs.all().map(|log| log.id).collect()
}

pub(super) fn names(window: &Window) -> Vec<String> {
    app(window).logs.all().map(|log| log.name()).collect()
}

fn pings(window: &Window) -> usize {
    let surveys = app(window).logs.visible().filter_map(|log| log.survey.as_ref());
    surveys.map(|survey| survey.side_scan.len()).sum()
}

fn map_name(window: &Window) -> String {
    let map = window.get_by_label_contains("Map, track of");
    map.accesskit_node().label().expect("a name")
}

pub(super) fn change(window: &mut Window, assignment: &str) {
    let settings = Settings::clone(&app(window).logs.shown.settings);
    let settings = settings.with_assignment(assignment).expect("a setting");
    window.state_mut().app.apply(Command::Change {
        settings: Box::new(settings),
        label: "a test",
        live: false,
    });
    settle(window);
}

#[test]
fn a_folder_of_logs_is_one_survey_on_map_and_in_cloud() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let window = drawn_window([1400.0, 1000.0]);
    let mut window = opened_in(window, folder.path(), 3);
    assert_eq!(names(&window), ["lake-0", "lake-1", "lake-2"]);
    assert_eq!(app(&window).logs.shown.name(), "lake-0", "the first one is shown");
    let all = pings(&window);
    let said = map_name(&window).replace([' ', ',', '\u{202f}', '\u{a0}'], "");
    assert!(said.contains(&format!("trackof{all}pings")), "{said}: {all}");
    let points: usize = (app(&window).logs.with_results().iter())
        .map(|shown| shown.log.products.kept_points().count())
        .sum();
    let cloud = window.get_by_label_contains("3D point cloud,");
    let cloud = cloud.accesskit_node().label().expect("a name");
    let cloud = cloud.replace([' ', ',', '\u{202f}', '\u{a0}'], "");
    assert!(cloud.contains(&format!("cloud{points}points")), "{cloud}: {points}");

    // All of them lie in the plane of the first.
    let origins = app(&window).logs.with_results();
    let origins = origins.iter().map(|shown| shown.log.survey.track.frame.origin());
    let first = origins.clone().next().expect("three logs");
    assert!(origins.clone().all(|origin| origin == first));

    window.state_mut().app.view.options.cloud.colour = CloudColour::Log;
    window.state_mut().app.view.options.map.track_by_log = true;
    drawn(&mut window);
    window.snapshot("window_logs");
}

#[test]
fn another_log_is_shown_by_its_row_by_key_and_by_a_place_of_it() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut window = opened(folder.path(), 2);
    window.get_by_label("Log lake-1").click();
    settle(&mut window);
    assert_eq!(app(&window).logs.shown.name(), "lake-1");
    press(&mut window, Modifiers::COMMAND, Key::PageDown);
    assert_eq!(app(&window).logs.shown.name(), "lake-0", "around the end");
    let second = ids(&window)[1];
    let place = Command::RevealIn(second, LogPlace::ping(40));
    window.state_mut().app.apply(place);
    settle(&mut window);
    assert_eq!(app(&window).logs.shown.id, second);
    assert_eq!(app(&window).view.selection.map(|mark| mark.ping), Some(40));
}

#[test]
fn what_is_unticked_takes_no_part_and_undo_goes_over_all_logs() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut window = opened(folder.path(), 2);
    let [whole, before] = [pings(&window), app(&window).logs.with_results().len()];
    assert_eq!(before, 2);
    let tick = window.get_by_role_and_label(Role::CheckBox, "Show lake-1 on the map");
    tick.click();
    settle(&mut window);
    assert_eq!(app(&window).logs.with_results().len(), 1);
    assert!(pings(&window) < whole);

    window.get_by_label("Move down lake-0").click();
    settle(&mut window);
    assert_eq!(names(&window), ["lake-1", "lake-0"]);
    change(&mut window, "first_return.threshold=0.41");
    change(&mut window, "draft_m=0.7");
    let of = |window: &Window, name: &str| {
        let found = app(window).logs.all().find(|log| log.name() == name);
        found.expect("it is open").settings.clone()
    };
    assert_eq!(of(&window, "lake-0").draft_m, 0.7);
    assert_eq!(of(&window, "lake-1").draft_m, 0.0, "a draft is that of one log");
    for name in ["lake-0", "lake-1"] {
        assert_eq!(of(&window, name).first_return.threshold, 0.41, "{name}");
    }
    for _ in 0..4 {
        press(&mut window, Modifiers::COMMAND, Key::Z);
        settle(&mut window);
    }
    assert_eq!(names(&window), ["lake-0", "lake-1"]);
    assert_eq!(pings(&window), whole);
    for name in ["lake-0", "lake-1"] {
        assert_eq!(*of(&window, name), Settings::default(), "{name}");
    }
    assert_eq!(app(&window).document.history.undo_label(), None);
    for _ in 0..4 {
        press(&mut window, Modifiers::COMMAND | Modifiers::SHIFT, Key::Z);
        settle(&mut window);
    }
    assert_eq!(of(&window, "lake-0").draft_m, 0.7);
    assert_eq!(names(&window), ["lake-1", "lake-0"]);
}

#[test]
fn a_recording_is_opened_once_and_closed_again() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut window = opened(folder.path(), 2);
    let copy = folder.path().join("the same again.sl2");
    std::fs::copy(folder.path().join("lake-1.sl2"), &copy).expect("a copy");
    drop_file(&mut window, copy);
    settle(&mut window);
    assert_eq!(names(&window), ["lake-0", "lake-1"]);
    let found = window.query_by_label_contains("open already, as lake-1");
    assert!(found.is_some());

    window.get_by_label("Close lake-0").click_accesskit();
    settle(&mut window);
    assert_eq!(names(&window), ["lake-1"]);
    assert_eq!(app(&window).logs.shown.name(), "lake-1");
    press(&mut window, Modifiers::COMMAND, Key::W);
    assert_eq!(app(&window).logs.count(), 0);
    window.get_by_label("Open the demo survey");
}

/// Computes the error of the depth map of all logs against the bottom that was sailed over, RMS in
/// metres, where a depth is within 2 m.
fn error_of_depth_map_m(app: &App, mean_m: f64) -> f64 {
    let depth_map = app.depth_map().flatten().expect("a depth map");
    let grid = &depth_map.surface.grid;
    let errors_m = (0..grid.len()).filter_map(|cell| {
        let place = grid.centre(cell / grid.columns, cell % grid.columns);
        let at = depth_map.to_survey(place);
        let (depth_m, _) = depth_map.at(at).filter(|(_, away_m)| *away_m < 2.0)?;
        Some(f64::from(depth_m) - (bed_depth_m(at) + mean_m))
    });
    rms(&errors_m.collect::<Vec<f64>>())
}

#[test]
fn a_log_that_was_closed_comes_back_with_undo() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut window = opened(folder.path(), 2);
    let path = folder.path().join("lake.bathyscope");
    let save = Command::Write(FileToWrite::Project(path.clone()));
    window.state_mut().app.apply(save);
    settle(&mut window);
    change(&mut window, "draft_m=0.7");
    let kept = |path: &Path| {
        let project = bathyscope_products::project::Store::open(path).expect("a project").project;
        let drafts = project.logs().iter();
        let draft = |log: &std::sync::Arc<bathyscope_products::project::ProjectLog>| {
            let draft = log.settings.own().get("draft_m").map(ToString::to_string);
            (log.name.clone(), draft)
        };
        drafts.map(draft).collect::<Vec<_>>()
    };
    let whole = pings(&window);
    window.get_by_label("Close lake-0").click_accesskit();
    settle(&mut window);
    assert_eq!(app(&window).document.history.undo_label(), Some("close lake-0"));
    // The other one, and nothing is open.
    press(&mut window, Modifiers::COMMAND, Key::W);
    assert_eq!(app(&window).logs.count(), 0);
    for count in [1, 2] {
        press(&mut window, Modifiers::COMMAND, Key::Z);
        settle(&mut window);
        assert_eq!(app(&window).logs.count(), count);
    }
    assert_eq!(names(&window), ["lake-0", "lake-1"]);
    assert_eq!(pings(&window), whole);
    assert_eq!(app(&window).logs.with_results().len(), 2, "with its results");
    let first = app(&window).logs.all().next().expect("two logs");
    assert_eq!(first.settings.draft_m, 0.7);
    press(&mut window, Modifiers::COMMAND | Modifiers::SHIFT, Key::Z);
    settle(&mut window);
    assert_eq!(names(&window), ["lake-1"]);
    // Opened again by its file it is there once, also after undo.
    drop_file(&mut window, folder.path().join("lake-0.sl2"));
    settle(&mut window);
    press(&mut window, Modifiers::COMMAND, Key::Z);
    settle(&mut window);
    assert_eq!(app(&window).logs.count(), 2);
    drop(window);
    let [(first, _), (second, _)] = &kept(&path)[..] else { panic!("two logs") };
    assert_eq!([first.as_str(), second.as_str()], ["lake-1", "lake-0"]);
}

#[test]
fn heights_are_compared_and_applied_as_one_step() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    // Ten of them are levelled without a window, by `many_logs_files`.
    let higher_m = &HIGHER_M[..4];
    let mut window = opened(folder.path(), higher_m.len());
    settle(&mut window);
    assert!(app(&window).height_offsets().is_some());
    let warned =
        app(&window).notices.all().any(|notice| notice.text.contains("deeper than those of"));
    assert!(warned, "the logs differ, and nobody was told");
    // In the list of logs and in the notice.
    window.get_all_by_label("Apply heights").next().expect("a button").click_accesskit();
    settle(&mut window);
    let applied: Vec<f64> =
        app(&window).logs.all().map(|log| log.settings.height_offset_m).collect();
    let mean_m = higher_m.iter().sum::<f64>() / higher_m.len() as f64;
    assert_eq!(applied.len(), higher_m.len());
    for (offset_m, higher_m) in applied.iter().zip(higher_m) {
        let off_m = offset_m - (higher_m - mean_m);
        assert!(off_m.abs() < 0.01, "{applied:?}");
    }
    let error_m = error_of_depth_map_m(app(&window), mean_m);
    eprintln!("the depth map of four logs in the window is off by {error_m:.4} m RMS");
    assert!(error_m < 0.03, "{error_m}");
    press(&mut window, Modifiers::COMMAND, Key::Z);
    settle(&mut window);
    assert!(app(&window).logs.all().all(|log| log.settings.height_offset_m == 0.0));
}
