//! Tests corrections of depths and positions, entered in Bathyscope as an analyst would, and
//! undone.

use crate::window::{
    Window, app, demo_window, drop_file, open_section, open_step, press, type_export_folder,
};
use bathyscope::app::{Action, Command, WorkStep};
use egui::accesskit::Role;
use egui::{Key, Modifiers};
use egui_kittest::kittest::Queryable as _;

#[test]
fn draft_and_sound_speed_move_the_cloud_and_can_be_undone() {
    let mut window = demo_window();
    let before_m = depth_m(&window);
    open_step(&mut window, WorkStep::Correct);
    window.get_by_role_and_label(Role::Slider, "Draft").set_value_accesskit(0.4);
    window.run();
    assert!((depth_m(&window) - before_m - 0.4).abs() < 1e-6);
    window.get_by_label("Correct the speed of sound").click_accesskit();
    window.run();
    let speed = app(&window).logs.shown.settings.sound_speed.clone();
    assert_eq!(speed.temperature_c, Some(12.0));
    let factor = speed.water_m_s().expect("a speed") / 1500.0;
    assert!((depth_m(&window) - 0.4 - factor * before_m).abs() < 1e-6);
    let products = app(&window).logs.shown.products.as_ref().expect("results");
    for sentence in products.correction.sentences() {
        assert!(window.query_by_label(&sentence).is_some(), "{sentence}");
    }
    for _ in 0..2 {
        window.state_mut().app.apply(Command::Do(Action::Undo));
        window.run();
    }
    assert_eq!(depth_m(&window), before_m);
}

/// Depth of a point of the cloud.
fn depth_m(window: &Window) -> f64 {
    let products = app(window).logs.shown.products.as_ref().expect("a result");
    -products.cloud.points[100].z_m
}

fn errors(window: &Window) -> Vec<&str> {
    let notices = app(window).notices.shown().iter();
    let errors = notices.filter(|notice| notice.is_error);
    errors.map(|notice| notice.text.as_str()).collect()
}

/// A row of readings a minute over the demo, `level_m` high.
fn readings(window: &Window, level_m: f64) -> String {
    let survey = app(window).logs.shown.survey.as_ref().expect("the demo");
    let start_s = survey.start_unix_s.expect("a clock");
    let rows = (-5..30).map(|minute| format!("{},{level_m}\n", start_s + 60.0 * f64::from(minute)));
    rows.fold("time,level_m\n".to_owned(), |text, row| text + &row)
}

#[test]
fn readings_of_a_gauge_are_chosen_dropped_and_left() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let write = |name: &str, text: &str| {
        let path = folder.path().join(name);
        std::fs::write(&path, text).expect("a temporary file");
        path
    };
    let mut window = demo_window();
    let before_m = depth_m(&window);
    let high = write("high.csv", &readings(&window, 0.75));
    open_step(&mut window, WorkStep::Correct);
    window.get_by_label("Open water levels…").click_accesskit();
    window.run();
    let field = window.get_by_label("Path of a CSV with time and level_m");
    field.type_text(&high.display().to_string());
    window.run();
    press(&mut window, Modifiers::NONE, Key::Enter);
    assert!((before_m - depth_m(&window) - 0.75).abs() < 1e-6);
    assert!(window.query_by_label("high.csv").is_some());

    let missing = write("bad.csv", "time,height\n1,2\n");
    drop_file(&mut window, missing);
    let early = write("early.csv", "time,level_m\n1000000000,1\n1000000600,1\n");
    drop_file(&mut window, early);
    let said = errors(&window);
    assert_eq!(said.len(), 2, "{said:?}");
    assert!(said[1].contains("add the readings that are missing"), "{said:?}");
    assert!((before_m - depth_m(&window) - 0.75).abs() < 1e-6, "as it was");

    let low = write("low.csv", &readings(&window, 0.25));
    drop_file(&mut window, low);
    assert!((before_m - depth_m(&window) - 0.25).abs() < 1e-6);
    window.get_by_label("Remove the water levels").click_accesskit();
    window.run();
    assert_eq!(depth_m(&window), before_m);
    press(&mut window, Modifiers::COMMAND, Key::Z);
    press(&mut window, Modifiers::COMMAND, Key::Z);
    assert!((before_m - depth_m(&window) - 0.75).abs() < 1e-6);
}

/// The recorder's own track as another receiver would have it: each fix once, its clock `behind_s`
/// behind.
fn other_track(window: &Window, behind_s: f64) -> String {
    let survey = app(window).logs.shown.survey.as_ref().expect("the demo");
    let start_s = survey.start_unix_s.expect("a clock");
    let mut text = "time,lon,lat\n".to_owned();
    let mut last = None;
    for fix in survey.track.fixes.iter() {
        if last.replace(fix.position) != Some(fix.position) {
            let (at, time_s) = (fix.position, start_s + fix.time_s - behind_s);
            text += &format!("{time_s:.3},{:.9},{:.9}\n", at.lon_deg, at.lat_deg);
        }
    }
    text
}

#[test]
fn another_receivers_track_is_applied_slid_and_taken_back() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("rtk.csv");
    let mut window = demo_window();
    let places =
        |window: &Window| app(window).logs.shown.products.as_ref().unwrap().navigation.clone();
    let recorded = places(&window);
    let returns = app(&window).logs.shown.products.as_ref().unwrap().returns.clone();
    std::fs::write(&path, other_track(&window, 3.0)).expect("a temporary file");
    drop_file(&mut window, path.clone());
    assert_eq!(errors(&window), Vec::<&str>::new());
    let apart_m = |window: &Window| app(window).logs.shown.external.apart.median_m;
    let moved_m = |window: &Window| {
        let now = places(window);
        let pairs = now.pings.iter().zip(recorded.pings.iter()).skip(200).take(1000);
        let off = pairs.map(|(a, b)| (a.east_m - b.east_m).hypot(a.north_m - b.north_m));
        off.sum::<f64>() / 1000.0
    };
    let late_m = moved_m(&window);
    let speed_mps = recorded.pings[1000].speed_mps;
    assert!((apart_m(&window) / (3.0 * speed_mps) - 1.0).abs() < 0.3, "{}", apart_m(&window));
    open_section(&mut window, WorkStep::Correct, "Position");
    window.get_by_role_and_label(Role::SpinButton, "Time offset").set_value_accesskit(3.0);
    window.run();
    assert!(apart_m(&window) < 0.01, "{}", apart_m(&window));
    // Not to the millimetre: the fit weighs each fix once now, and not as often as the recorder
    // repeated it.
    let off_m = moved_m(&window);
    assert!(off_m < 0.2 * late_m, "{off_m} of {late_m} m");
    let now = app(&window).logs.shown.products.as_ref().unwrap();
    assert!(std::sync::Arc::ptr_eq(&now.returns, &returns), "nothing is tracked anew");

    let into = folder.path().join("out");
    type_export_folder(&mut window, &into);
    press(&mut window, Modifiers::NONE, Key::Enter);
    let report = std::fs::read_to_string(into.join("report.json")).expect("a report");
    assert!(report.contains("Positions are those of rtk.csv, 3 s later than it says."));

    press(&mut window, Modifiers::COMMAND, Key::Z);
    assert!(apart_m(&window) > 1.0);
    press(&mut window, Modifiers::COMMAND, Key::Z);
    assert!(app(&window).logs.shown.external.recorded.is_none());
    assert_eq!(places(&window).pings[1000], recorded.pings[1000]);
    press(&mut window, Modifiers::COMMAND | Modifiers::SHIFT, Key::Z);
    assert!(app(&window).logs.shown.external.recorded.is_some());
    window.get_by_label("Remove the external track").click_accesskit();
    window.run();
    assert_eq!(places(&window).pings[1000], recorded.pings[1000]);

    std::fs::write(&path, "time,lon,lat\n900000,2,3\n900001,3,4\n").expect("a temporary file");
    drop_file(&mut window, path);
    assert!(errors(&window)[0].contains("covers no ping"), "{:?}", errors(&window));
    assert!(app(&window).logs.shown.settings.track.file.is_none());
}
