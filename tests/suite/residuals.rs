//! Tests the differences of points from a reference, on the map and in the panel.

use crate::cli::{refusal, run};
use crate::support::{demo_log, manifest_entry};
use crate::truth::KnownSurvey;
use crate::window::{Window, app, drawn_window, drop_file, empty_window, press, settle};
use bathyscope::app::{Action, App, Command, FileToWrite, Jobs, MapLayer, ReferenceBy, View};
use bathyscope_bottom::bathymetry::compare::{Match, Matching};
use bathyscope_log::support::geo::UtmZone;
use bathyscope_products::pipeline::Settings;
use bathyscope_simulation::Scene;
use egui::accesskit::Role;
use egui::{Key, Modifiers};
use egui_kittest::kittest::Queryable as _;
use serde_json::Value;
use std::path::PathBuf;
use std::sync::Arc;

fn act(window: &mut Window, action: Action) {
    window.state_mut().app.apply(Command::Do(action));
    settle(window);
}

#[test]
fn the_map_shows_how_each_point_differs_from_the_soundings() {
    let mut window = drawn_window([900.0, 640.0]);
    window.state_mut().app.apply(Command::OpenDemo);
    window.state_mut().show_alone(View::Map);
    settle(&mut window);
    assert!(
        app(&window).findings.reference_comparison.agreement().is_none(),
        "nobody has looked at it yet"
    );
    for layer in [Action::ResidualLayer, Action::IsobathLayer] {
        act(&mut window, layer);
    }
    let agreement =
        app(&window).findings.reference_comparison.agreement().cloned().expect("an agreement");
    let products = app(&window).logs.shown.products.as_ref().expect("a result");
    // Every difference is that of a kept side-scan point from soundings within reach.
    let [log] = &agreement.logs[..] else { panic!("one log") };
    assert!(log.differences.len() > 1000);
    for matched in &log.differences {
        let point = &products.cloud.points[matched.measured];
        assert!(products.classes[matched.measured].is_kept() && point.sounding().is_none());
        assert!((point.z_m - matched.reference_z_m - matched.difference_m).abs() < 1e-12);
    }
    assert!(window.query_by_label_contains(", residuals").is_some());
    window.snapshot("map_residuals");
    act(&mut window, Action::ResidualLayer);
    assert!(!app(&window).view.options.map.layers.is_visible(MapLayer::Residuals));
}

/// Distance between the points of a known bed, metres.
const STEP_M: f64 = 0.3;

/// A small pond on a bed of its own seed, under `level_m` more water.
pub(super) fn pond(level_m: f64) -> Scene {
    let mut scene = Scene::gentle();
    scene.track.lines = 3;
    scene.track.cross_lines = 1;
    scene.track.length_m = 40.0;
    scene.bed.seed = Some(7);
    scene.bed.mean_depth_m += level_m;
    if let Some(terrace) = &mut scene.bed.terrace {
        terrace.depth_m += level_m;
    }
    scene
}

/// A first mission, open in a window, and a folder with its log.
fn first_mission() -> (Window, KnownSurvey, tempfile::TempDir) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let known = KnownSurvey::new(&pond(0.0), 1);
    let log = folder.path().join("first.sl2");
    std::fs::write(&log, known.truth.sl2_bytes()).expect("a log");
    let mut window = empty_window();
    window.state_mut().app.apply(Command::Open(log));
    window.run();
    (window, known, folder)
}

fn compare_with(window: &mut Window, path: PathBuf) {
    window.state_mut().app.apply(Command::CompareWith(path));
    window.run();
}

fn mean_m(window: &Window) -> f64 {
    let agreement = app(window).findings.reference_comparison.agreement().expect("an agreement");
    agreement.comparison.residuals.expect("statistics").mean_m
}

/// The last notice.
fn notice(window: &Window) -> (String, bool) {
    let notice = app(window).notices.shown().last().expect("a notice");
    (notice.text.clone(), notice.is_error)
}

/// A first mission open in a window, and the log of a second one, under 0.20 m more water, beside
/// its own.
fn two_missions() -> (Window, tempfile::TempDir) {
    let (window, _, folder) = first_mission();
    let second = KnownSurvey::new(&pond(0.20), 2);
    let log = folder.path().join("second.sl2");
    std::fs::write(log, second.truth.sl2_bytes()).expect("a log");
    (window, folder)
}

#[test]
fn a_second_mission_under_higher_water_is_lower_by_as_much() {
    let (mut window, folder) = two_missions();
    press(&mut window, Modifiers::COMMAND, Key::P);
    window.get_by_label("Command").type_text("compare with");
    window.run();
    press(&mut window, Modifiers::NONE, Key::Enter);
    let name = "Points (with columns: FILE.csv:x,y,z, or -z for a depth), GeoTIFF or log";
    let field = window.get_by_role_and_label(Role::TextInput, name);
    field.type_text(&folder.path().join("second.sl2").to_string_lossy());
    window.run();
    press(&mut window, Modifiers::NONE, Key::Enter);
    assert!((mean_m(&window) - 0.20).abs() < 0.01, "{}", mean_m(&window));
    let (text, is_error) = notice(&window);
    assert!(!is_error && text.contains("shallower"), "{text}");
    let layers = &app(&window).view.options.map.layers;
    assert!(layers.is_visible(MapLayer::Residuals));
    for command in [Command::Do(Action::CloseReference), Command::CompareWithReference] {
        window.state_mut().app.apply(command);
        window.run();
    }
    let agreement = app(&window).findings.reference_comparison.agreement().expect("an agreement");
    assert!(agreement.reference.is_none(), "its own soundings again");
}

#[test]
fn window_compare_and_process_write_the_same_figures() {
    let (mut window, folder) = two_missions();
    let (folder, out) = (folder.path(), folder.path().join("out"));
    let text = |path: PathBuf| std::fs::read_to_string(path).expect("a file that was written");
    compare_with(&mut window, folder.join("second.sl2"));
    window.state_mut().app.apply(Command::Write(FileToWrite::Products(out.clone())));
    window.run();
    let written: Value = serde_json::from_str(&text(out.join("quality/comparison.json"))).unwrap();
    // A number read back from JSON may be off in its last bit.
    let written_m = written["mean_m"].as_f64().expect("a mean");
    assert!((written_m - mean_m(&window)).abs() < 1e-12);
    assert_eq!(written["reference"]["kind"], "mission");
    let points = text(out.join("quality/comparison.csv"));
    let lines = points.lines().count() as u64;
    assert_eq!(written["n"].as_u64(), Some(lines - 1));
    let entry = manifest_entry(&out, "quality/comparison.csv");
    assert_eq!(entry["values"]["of"], "difference_m");
    assert!(text(out.join("report.html")).contains(">second.sl2<"));

    let compare = ["compare", "first.sl2", "second.sl2"];
    let surface = ["--by", "surface", "--json", "-o", "points.csv"];
    let printed = run(folder, &[&compare[..], &surface].concat());
    let printed: Value = serde_json::from_str(&printed).expect("JSON on stdout");
    for key in ["n", "mean_m", "p95_m", "orders", "sources", "by_depth_m"] {
        assert_eq!(written[key], printed[key], "{key}");
    }
    assert_eq!(text(folder.join("points.csv")), points);
    let process = ["process", "first.sl2", "--reference", "second.sl2"];
    let residuals = ["--no-objects", "--products", "residuals", "-o", "headless"];
    run(folder, &[&process[..], &residuals].concat());
    assert_eq!(text(folder.join("headless/quality/comparison.csv")), points);

    let refused = refusal(folder, &[&compare[..], &["-o", "second.sl2"]].concat(), 1);
    assert!(refused.contains("another name"), "{refused}");
}

#[test]
fn a_setting_acts_on_both_missions_and_on_no_file() {
    let (mut window, folder) = two_missions();
    let out = folder.path().join("out");
    window.state_mut().app.apply(Command::Write(FileToWrite::Products(out.clone())));
    window.run();
    compare_with(&mut window, folder.path().join("second.sl2"));
    let before =
        app(&window).findings.reference_comparison.agreement().cloned().expect("an agreement");
    let mut settings = Settings::clone(&app(&window).logs.shown.settings);
    settings.draft_m = 0.5;
    let change = Command::Change { settings: Box::new(settings), label: "draft", live: false };
    for command in [change, Command::CompareWithReference] {
        window.state_mut().app.apply(command);
        window.run();
    }
    let after =
        app(&window).findings.reference_comparison.agreement().cloned().expect("an agreement");
    let [before_m, after_m] =
        [before, after].map(|agreement| agreement.logs[0].differences[0].reference_z_m);
    let deeper_m = before_m - after_m;
    assert!((deeper_m - 0.5).abs() < 1e-3, "{before_m} {after_m}");
    assert!((mean_m(&window) - 0.20).abs() < 0.01);

    // The cloud that was written without the draft, in metres from the first fix.
    compare_with(&mut window, out.join("points/cloud.ply"));
    let (text, is_error) = notice(&window);
    assert!(!is_error && text.contains("first fix"), "{text}");
    // The median: that file holds what is flagged as above-bottom too.
    let agreement = app(&window).findings.reference_comparison.agreement().expect("an agreement");
    let median_m = agreement.comparison.residuals.expect("statistics").median_m;
    assert!((median_m + 0.5).abs() < 0.01, "{median_m}");
}

#[test]
fn the_true_bed_in_a_file_gives_the_errors_that_the_simulation_knows() {
    let (mut window, known, folder) = first_mission();
    let frame = known.survey.track.frame.clone();
    let zone = UtmZone::of(frame.origin());
    let products = app(&window).logs.shown.products.as_ref().expect("a result");
    let reach_m = (products.cloud.points.iter())
        .map(|point| point.east_m.abs().max(point.north_m.abs()))
        .fold(1.0, f64::max);
    let half = (reach_m / STEP_M).ceil() as i32 + 1;
    let mut text = String::new();
    for (column, row) in (-half..=half).flat_map(|x| (-half..=half).map(move |y| (x, y))) {
        let [east_m, north_m] = [column, row].map(|step| STEP_M * f64::from(step));
        let [x, y] = zone.to_metres(frame.to_lon_lat(east_m, north_m));
        let z_m = -known.truth.bed_depth_m(east_m, north_m);
        text += &format!("{x:.4} {y:.4} {z_m:.4}\n");
    }
    let path = folder.path().join("bed.xyz");
    std::fs::write(&path, text).unwrap();
    drop_file(&mut window, path);
    let (text, is_error) = notice(&window);
    assert!(!is_error && text.contains("UTM zone 17N"), "{text}");
    let agreement =
        app(&window).findings.reference_comparison.agreement().cloned().expect("an agreement");
    assert_eq!(agreement.comparison.unmatched, 0);
    // Between the points of the file objects have edges.
    let is_right = |matched: &&Match| {
        let point = &agreement.logs[0].cloud.points[matched.measured];
        let bed_m = known.truth.bed_depth_m(point.east_m, point.north_m);
        (matched.reference_z_m + bed_m).abs() < 0.02
    };
    let differences = &agreement.logs[0].differences;
    let right = differences.iter().filter(is_right).count();
    assert!(50 * right >= 49 * differences.len(), "{right}");
    let nearest = Command::MatchBy { by: ReferenceBy::Nearest, radius_m: 0.12 };
    for command in [nearest, Command::CompareWithReference] {
        window.state_mut().app.apply(command);
        window.run();
    }
    let near = app(&window).findings.reference_comparison.agreement().expect("an agreement");
    // The points of the file lie at whole multiples of the step.
    let off_m = |metres: f64| (metres / STEP_M).round() * STEP_M - metres;
    let is_near = |matched: &&Match| {
        let point = &agreement.logs[0].cloud.points[matched.measured];
        off_m(point.east_m).hypot(off_m(point.north_m)) <= 0.12
    };
    let expected = differences.iter().filter(is_near).count();
    let found = near.differences().count();
    assert!(expected > 1000 && found.abs_diff(expected) <= 5, "{found} of {expected}");
}

#[test]
fn what_cannot_be_compared_is_reported_and_changes_nothing() {
    let (mut window, known, folder) = first_mission();
    let at = known.survey.track.frame.origin();
    let far = format!("lon,lat,z\n{},{},-2\n", at.lon_deg + 0.1, at.lat_deg);
    let lone = format!("lon,lat,z\n{},{},-2\n", at.lon_deg, at.lat_deg);
    for (name, text, said) in [
        ("far.csv", far.as_str(), "km from this survey"),
        ("lone.csv", &lone, "no point of this survey has a reference"),
        ("metres.csv", "x,y,z\n900000,100,-2\n", "which system"),
        ("flat.csv", "lon,lat\n1,2\n", "flat.csv"),
        ("none.csv", "lon,lat,z\n", "none.csv"),
        ("text.bin", "no log", "not a sonar log"),
    ] {
        let path = folder.path().join(name);
        std::fs::write(&path, text).unwrap();
        let before = app(&window).notices.shown().len();
        compare_with(&mut window, path);
        let (text, is_error) = notice(&window);
        assert!(is_error && text.contains(said), "{name}: {text}");
        assert_eq!(app(&window).notices.shown().len(), before + 1, "{name}");
        assert!(app(&window).map.comparing.reference.is_none(), "{name}");
    }
}

/// Waits for all workers.
pub(super) fn wait(app: &mut App) {
    while !app.is_idle() {
        std::thread::sleep(std::time::Duration::from_millis(2));
        app.poll();
    }
}

#[test]
fn comparing_is_stopped_and_taken_up_again() {
    let mut app = App::new(Jobs::Threads(Arc::new(|| ())));
    app.apply(Command::OpenDemo);
    wait(&mut app);
    app.apply(Command::CompareWith(demo_log()));
    assert!(app.awaited().is_some_and(|(what, _)| what == "opening the reference"));
    app.apply(Command::Do(Action::Cancel));
    wait(&mut app);
    assert!(app.map.comparing.reference.is_none() && app.notices.shown().is_empty());

    app.apply(Command::CompareWith(demo_log()));
    wait(&mut app);
    assert!(
        app.map.comparing.reference.is_some()
            && app.findings.reference_comparison.agreement().is_some()
    );
    let nearest = Command::MatchBy { by: ReferenceBy::Nearest, radius_m: 0.5 };
    for command in [nearest, Command::CompareWithReference, Command::Do(Action::Cancel)] {
        app.apply(command);
    }
    let problem = app.findings.reference_comparison.problem().expect("it was stopped");
    assert!(problem.contains("Update"), "{problem}");
    app.apply(Command::CompareWithReference);
    assert!(app.is_idle(), "it rests until it is asked for");
    for command in [Command::Do(Action::Update), Command::CompareWithReference] {
        app.apply(command);
    }
    wait(&mut app);
    let agreement = app.findings.reference_comparison.agreement().expect("an agreement");
    assert_eq!(agreement.matching, Matching::Nearest { radius_m: 0.5 });
}
