//! Tests the settings that a newly opened survey starts from: none of the survey before, and those
//! that its own log was last given.

use crate::many_logs::write_logs;
use bathyscope::app::{Action, App, Command, Jobs, ViewOptions};
use bathyscope_bottom::presentation::units::LengthUnit;
use bathyscope_log::support::progress::Progress;
use bathyscope_products::pipeline::settings::rows::ROWS;
use bathyscope_products::pipeline::settings::{SettingKind, SettingRow};
use bathyscope_products::pipeline::{Settings, setting_values};
use bathyscope_simulation::{Scene, TrackSettings, simulate};
use std::path::{Path, PathBuf};

/// Lets everything that is asked for come to its end.
fn settle(app: &mut App) {
    for _ in 0..400 {
        app.poll();
        if app.is_idle() {
            return;
        }
    }
    panic!("it comes to no end");
}

fn open(app: &mut App, log: &Path) {
    app.apply(Command::Open(log.to_owned()));
    settle(app);
}

fn change(app: &mut App, settings: Settings) {
    app.apply(Command::Change { settings: Box::new(settings), label: "a test", live: false });
    settle(app);
}

/// Two logs in a folder.
fn logs(folder: &Path) -> [PathBuf; 2] {
    write_logs(folder, 2);
    [0, 1].map(|number| folder.join(format!("lake-{number}.sl2")))
}

/// Another value of one setting; `None` where there is none that a table knows.
fn other(row: &SettingRow, settings: &Settings) -> Option<Settings> {
    let mut changed = settings.clone();
    match &row.kind {
        SettingKind::Number(number) => {
            let [least, most] = number.range;
            let now = (number.get)(settings).unwrap_or(0.5 * (least + most));
            let steps = [number.step, -number.step].map(|step| now + step);
            let value = steps.into_iter().find(|value| (least..=most).contains(value));
            (number.set)(&mut changed, value);
        }
        SettingKind::Choice(choice) => {
            let now = (choice.get)(settings);
            let name = choice.names.iter().find(|name| name.value != now)?;
            (choice.set)(&mut changed, name.value);
        }
        SettingKind::Numbers { .. } | SettingKind::Text(_) => return None,
    }
    (changed.check().is_ok() && changed != *settings).then_some(changed)
}

#[test]
fn no_setting_of_a_survey_is_in_the_next_one() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let [one, two] = logs(folder.path());
    let mut app = App::new(Jobs::Inline);
    open(&mut app, &one);
    let mut settings = Settings::clone(&app.logs.shown.settings);
    let mut changed = Vec::new();
    for row in ROWS {
        if let Some(other) = other(row, &settings) {
            settings = other;
            changed.push(row.key);
        }
    }
    assert!(changed.len() * 10 > ROWS.len() * 8, "{changed:?}");
    change(&mut app, settings.clone());
    assert_eq!(*app.logs.shown.settings, settings);
    open(&mut app, &two);
    let (usual, now) =
        (setting_values(&Settings::default()), setting_values(&app.logs.shown.settings));
    for key in changed {
        assert_eq!(now.get(key), usual.get(key), "{key}");
    }
    assert_eq!(*app.logs.shown.settings, Settings::default());
    assert_eq!(app.document.history.undo_label(), None);
}

#[test]
fn a_log_has_its_last_settings_again_until_they_are_undone() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let [one, two] = logs(folder.path());
    let start = || {
        let mut app = App::new(Jobs::Inline);
        app.files.untitled_folder = Some(folder.path().join("kept"));
        app
    };
    let mut app = start();
    open(&mut app, &one);
    let settings = Settings::clone(&app.logs.shown.settings);
    let settings = settings.with_assignment("draft_m=0.4").expect("a setting");
    let given = settings.with_assignment("first_return.threshold=0.41").expect("a setting");
    change(&mut app, given.clone());
    open(&mut app, &two);
    assert_eq!(*app.logs.shown.settings, Settings::default());
    // Another run of the program.
    app.keep_all();
    let mut app = start();
    open(&mut app, &one);
    assert_eq!(*app.logs.shown.settings, given);
    app.apply(Command::Do(Action::Undo));
    settle(&mut app);
    assert_eq!(*app.logs.shown.settings, Settings::default());
    // A change that was undone is not there the next time.
    open(&mut app, &two);
    open(&mut app, &one);
    assert_eq!(*app.logs.shown.settings, Settings::default());
}

#[test]
fn a_view_that_hides_a_part_is_not_that_of_the_next_survey() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let [one, two] = logs(folder.path());
    let mut app = App::new(Jobs::Inline);
    open(&mut app, &one);
    let mut options = app.view.options.clone();
    options.waterfall.ground_range = true;
    options.waterfall.water_column = false;
    options.waterfall.echogram_alone = true;
    options.map.swipe.on = true;
    options.show_boxes(false);
    options.units.length = LengthUnit::Feet;
    app.apply(Command::Show(Box::new(options)));
    open(&mut app, &two);
    let mut expected = ViewOptions::default();
    expected.units.length = LengthUnit::Feet;
    assert_eq!(app.view.options, expected);
}

#[test]
fn a_log_far_away_and_one_too_short_are_opened_but_not_on_the_map() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let [one, two] = logs(folder.path());
    let far = folder.path().join("a-far.sl2");
    let scene = Scene {
        longitude_deg: 20.0,
        track: TrackSettings { lines: 1, length_m: 30.0, ..TrackSettings::default() },
        ..Scene::default()
    };
    let elsewhere = simulate(&scene, 1, &Progress::new()).expect("nobody cancels");
    std::fs::write(&far, elsewhere.sl2_bytes()).expect("a log");
    let mut app = App::new(Jobs::Inline);
    app.apply(Command::OpenAll(vec![far, one, two]));
    settle(&mut app);
    let shown: Vec<String> = app.logs.visible().map(|log| log.name()).collect();
    assert_eq!(shown, ["lake-0", "lake-1"]);
    assert_eq!(app.logs.shown.name(), "lake-0", "it is the one that is shown");
    let far =
        app.notices.shown().iter().find(|notice| notice.text.contains("km from the other logs"));
    let notice = far.expect("a notice");
    assert!(notice.text.contains("a-far"), "{}", notice.text);
    assert_eq!(notice.offer, Some(Action::ShowTogether));
    app.apply(Command::Do(Action::ShowTogether));
    settle(&mut app);
    assert_eq!(app.logs.visible().count(), 3);
    app.apply(Command::Do(Action::Undo));
    settle(&mut app);
    assert_eq!(app.logs.visible().count(), 2);
}
