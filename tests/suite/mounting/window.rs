//! The mounting in the window: by panel and by key, taken back, kept in a project, and as the
//! default of a recorder.

use super::{off_m, scene};
use crate::cli::run;
use crate::logs_window::{change, settle};
use crate::truth::KnownSurvey;
use crate::window::{Window, app, drawn_window, drop_file, empty_window, open_section, press};
use bathyscope::app::{
    Action, BottomStroke, Command, FileToOpen, FileToWrite, Ink, LogPlace, Mountings, WorkStep,
};
use bathyscope_log::survey::{Identity, MountingSettings, Side};
use bathyscope_objects::review::{Edit, Review};
use bathyscope_test_support::handmade;
use egui::accesskit::Role;
use egui::{Key, Modifiers};
use egui_kittest::kittest::Queryable as _;
use std::path::Path;

/// Format that the readers report for the simulator's logs.
const RECORDER: &str = "Lowrance SL2 (version 1)";

fn written(folder: &Path, name: &str, seed: u64) -> KnownSurvey {
    let mut askew = scene();
    (askew.mounting.forward_m, askew.mounting.right_m) = (2.5, -1.5);
    let known = KnownSurvey::new(&askew, seed);
    std::fs::write(folder.join(name), known.truth.sl2_bytes()).expect("a log");
    known
}

fn open(window: &mut Window, path: &Path) {
    drop_file(window, path.to_owned());
    settle(window);
    assert!(app(window).logs.shown.products.is_some(), "{:?}", app(window).notices.shown());
}

fn act(window: &mut Window, action: Action) {
    window.state_mut().app.apply(Command::Do(action));
    settle(window);
}

fn mounting(window: &Window) -> MountingSettings {
    app(window).logs.shown.settings.mounting
}

fn type_into(window: &mut Window, name: &str, value: f64) {
    let field = window.get_by_role_and_label(Role::SpinButton, name);
    field.set_value_accesskit(value);
    settle(window);
}

#[test]
fn an_arm_is_typed_shown_and_taken_back() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let known = written(folder.path(), "pond.sl2", 3);
    let mut window = empty_window();
    open(&mut window, &folder.path().join("pond.sl2"));
    open_section(&mut window, WorkStep::Correct, "Mounting");
    let off =
        |window: &Window| off_m(&known, app(window).logs.shown.products.as_ref().expect("results"));
    let before_m = off(&window);
    type_into(&mut window, "Forward", 2.5);
    type_into(&mut window, "Starboard", -1.5);
    println!("{before_m:.2} m, mounted {:.2} m", off(&window));
    assert!(before_m > 2.5 && off(&window) < 0.6, "{before_m} {}", off(&window));
    assert_eq!(
        app(&window).document.history.undo_label(),
        Some("transducer to starboard of the antenna -1.50 m")
    );
    let said = "The transducer is 2.50 m forward and 1.50 m to port of the antenna.";
    assert!(window.query_by_label(said).is_some());

    let reveal = Command::Reveal(LogPlace::ping(300));
    window.state_mut().app.apply(reveal);
    settle(&mut window);
    let fact = "2.50 m forward and 1.50 m to port of the antenna";
    assert!(window.query_by_label(fact).is_some());
    let map = "antenna and transducer of the selected ping";
    assert!(window.query_by_label_contains(map).is_some());

    act(&mut window, Action::Undo);
    act(&mut window, Action::Undo);
    assert!(mounting(&window).is_none());
    assert!((off(&window) - before_m).abs() < 1e-9);
    assert!(window.query_by_label_contains(map).is_none());
}

/// A box and a stroke on port at the same pings.
fn mark_port(window: &mut Window) {
    let survey = app(window).logs.shown.survey.clone().expect("a log");
    let review = Review::new(Identity::of(&survey), vec!["rock".to_owned()]);
    let mark =
        bathyscope_objects::Mark { side: Side::Port, pings: 100..120, near_m: 4.0, far_m: 6.0 };
    let review = review.apply(&Edit::Add { mark, class: 0 }).expect("a box");
    let path = survey.source.files[0].with_file_name("boxes.json");
    std::fs::write(&path, review.to_json()).expect("a file");
    let stroke =
        BottomStroke { side: Side::Port, path: vec![[40.0, 4.0], [60.0, 3.5]], ink: Ink::Bottom };
    for command in [Command::OpenFile(FileToOpen::Review(path)), Command::DrawBottom(stroke)] {
        window.state_mut().app.apply(command);
        settle(window);
    }
}

/// Sides of the box, of the stroke, and of the pings that count as drawn.
fn sides(window: &Window) -> [Side; 3] {
    let log = &app(window).logs.shown;
    let first = log.reviewing.review.boxes().next().expect("a box");
    let drawn = &log.products.as_ref().expect("results").returns.drawn;
    [first.mark.side, log.settings.bottom.lines[0].side, drawn[0].0]
}

#[test]
fn boxes_and_strokes_stay_on_their_echoes_when_sides_are_exchanged() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let log = folder.path().join("pond.sl2");
    written(folder.path(), "pond.sl2", 3);
    let mut window = empty_window();
    open(&mut window, &log);
    let project = folder.path().join("pond.bathyscope");
    window.state_mut().app.apply(Command::Write(FileToWrite::Project(project.clone())));
    settle(&mut window);
    mark_port(&mut window);
    let picks = |window: &Window| {
        let returns = app(window).logs.shown.products.as_ref().expect("results").returns.clone();
        [returns.port.clone(), returns.starboard.clone()]
    };
    let [port, starboard] = picks(&window);
    assert_eq!(sides(&window), [Side::Port; 3]);
    let selected = LogPlace { side: Some(Side::Port), sample: Some(500.0), ..LogPlace::ping(110) };
    window.state_mut().app.apply(Command::Select(Some(selected)));
    press(&mut window, Modifiers::SHIFT, Key::S);
    settle(&mut window);
    assert!(!mounting(&window).swap_sides, "it asks");
    window.get_by_label("Exchange port and starboard").click_accesskit();
    settle(&mut window);
    assert!(mounting(&window).swap_sides);
    assert_eq!(sides(&window), [Side::Starboard; 3]);
    assert_eq!(picks(&window), [starboard.clone(), port.clone()]);
    assert_eq!(app(&window).view.selection.and_then(|mark| mark.side), Some(Side::Starboard));
    assert_eq!(app(&window).document.history.undo_label(), Some("sides of the recorder"));
    act(&mut window, Action::Undo);
    assert_eq!((sides(&window), mounting(&window).swap_sides), ([Side::Port; 3], false));
    assert_eq!(picks(&window), [port, starboard]);
    act(&mut window, Action::Redo);
    change(&mut window, "mounting.forward_m=2.5");
    change(&mut window, "mounting.clock_offset_s=-3.25");
    press(&mut window, Modifiers::COMMAND, Key::S);
    settle(&mut window);
    let by_window = folder.path().join("window");
    window.state_mut().app.apply(Command::Write(FileToWrite::Products(by_window.clone())));
    settle(&mut window);
    let left = mounting(&window);
    drop(window);

    // Without a window it is the same survey, byte for byte.
    let args = ["process", "pond.bathyscope", "--no-objects", "-o", "process"];
    run(folder.path(), &args);
    let read = |name: &str| {
        ["window", "process"]
            .map(|of| std::fs::read(folder.path().join(of).join(name)).expect(name))
    };
    for name in ["points/cloud.csv", "points/first_returns.csv", "mosaic/mosaic.tif"] {
        let [window, process] = read(name);
        assert!(window == process, "{name} differs");
    }

    let mut again = empty_window();
    open(&mut again, &project);
    assert_eq!(mounting(&again), left);
    assert_eq!(sides(&again), [Side::Starboard; 3]);
    let log = &app(&again).logs.shown;
    assert!(log.survey.as_ref().expect("a log").swapped_sides);
    // Back again, the boxes of the project come back to port.
    act(&mut again, Action::SwapSides);
    assert_eq!(sides(&again), [Side::Port; 3]);
}

#[test]
fn a_review_beside_the_log_says_which_sides_it_means() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let log = folder.path().join("pond.sl2");
    written(folder.path(), "pond.sl2", 3);
    let mut window = empty_window();
    open(&mut window, &log);
    mark_port(&mut window);
    act(&mut window, Action::SwapSides);
    let review = folder.path().join("pond.review.json");
    window.state_mut().app.apply(Command::Write(FileToWrite::Review(review.clone())));
    settle(&mut window);
    drop(window);
    let text = std::fs::read_to_string(&review).expect("a review");
    assert!(text.contains("\"swapped_sides\": true") && text.contains("\"starboard\""), "{text}");

    // A new window knows of no exchange: the box lies on the echoes that it was drawn on.
    let mut again = empty_window();
    open(&mut again, &log);
    let first = app(&again).logs.shown.reviewing.review.boxes().next().expect("a box");
    assert_eq!(first.mark.side, Side::Port);
}

#[test]
fn a_recorder_has_a_default_that_its_logs_are_opened_with() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let folder = folder.path();
    for (name, seed) in [("first.sl2", 3), ("second.sl2", 4), ("third.sl2", 5)] {
        written(folder, name, seed);
    }
    std::fs::write(folder.join("other.xtf"), handmade::xtf(60, 1, 3, (-73.6, 42.7), 7.5)).unwrap();
    let mut window = empty_window();
    open(&mut window, &folder.join("first.sl2"));
    open_section(&mut window, WorkStep::Correct, "Mounting");
    let add = |window: &mut Window, name: &str| {
        let path = folder.join(name);
        window.state_mut().app.apply(Command::Add(vec![path]));
        settle(window);
    };
    add(&mut window, "second.sl2");
    assert!(window.query_by_label_contains("It has no default").is_some());
    change(&mut window, "mounting.forward_m=2.5");
    assert!(window.query_by_label_contains("Of this log alone").is_some());
    let label = Action::UseMounting.label();
    window.get_by_label(label).click_accesskit();
    settle(&mut window);
    let mountings = |window: &Window| -> Vec<f64> {
        let logs = app(window).logs.all();
        logs.map(|log| log.settings.mounting.forward_m).collect()
    };
    assert_eq!(mountings(&window), [2.5, 2.5], "open logs of the recorder");
    let said = format!("From the default of {RECORDER}.");
    assert!(window.query_by_label(&said).is_some(), "{}", app(&window).logs.shown.recorder());
    assert!(app(&window).logs.all().all(|log| !log.is_behind()));

    // Those that are opened from then on, but no other recorder's.
    add(&mut window, "third.sl2");
    add(&mut window, "other.xtf");
    assert_eq!(mountings(&window), [2.5, 2.5, 2.5, 0.0]);
    let notice = app(&window)
        .notices
        .shown()
        .iter()
        .find(|notice| notice.text.contains("default mounting of"));
    assert!(notice.is_some_and(|notice| notice.text.contains("third")));
    act(&mut window, Action::Undo);
    assert_eq!(mountings(&window)[..2], [0.0, 2.5], "as it was before it was for all");
    assert!(app(&window).document.mountings.is_empty());
    act(&mut window, Action::Redo);
    assert_eq!(app(&window).document.mountings.len(), 1);
    let kept = Mountings::clone(&app(&window).document.mountings);
    drop(window);

    // A run knows nothing of it, whatever the window keeps.
    let process = |set: &[&str]| {
        let args = ["process", "first.sl2", "--no-objects"];
        let args = [&args[..], &["--products", "track", "-o", "out"]].concat();
        run(folder, &[&args[..], set].concat());
        std::fs::read_to_string(folder.join("out/report.json")).expect("a report")
    };
    assert!(!process(&[]).contains("of the antenna"));
    let printed = process(&["--set", "mounting.forward_m=2.5"]);
    assert!(printed.contains("2.5 m forward of the antenna"), "{printed}");

    let mut again = empty_window();
    again.state_mut().app.document.mountings = kept.into();
    open(&mut again, &folder.join("first.sl2"));
    open_section(&mut again, WorkStep::Correct, "Mounting");
    assert_eq!(mounting(&again).forward_m, 2.5);
    assert!(again.query_by_label(&said).is_some());
    change(&mut again, "mounting.forward_m=1");
    let other = format!("Not the default of {RECORDER}.");
    assert!(again.query_by_label(&other).is_some());
    act(&mut again, Action::ForgetMounting);
    assert!(app(&again).document.mountings.is_empty());
    assert_eq!(mounting(&again).forward_m, 1.0, "open logs stay as they are");
}

#[test]
fn the_system_of_metres_is_typed_in_the_panel() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let folder = folder.path();
    for (name, east_m) in [("line.xtf", 606_900.0), ("next.xtf", 606_950.0)] {
        let bytes = handmade::xtf(60, 1, 0, (east_m, 4_732_000.0), 7.5);
        std::fs::write(folder.join(name), bytes).expect("a log");
    }
    let mut window = empty_window();
    open(&mut window, &folder.join("line.xtf"));
    let next = Command::Add(vec![folder.join("next.xtf")]);
    window.state_mut().app.apply(next);
    settle(&mut window);
    let places = |window: &Window| -> Vec<[f64; 4]> {
        let logs = app(window).logs.with_results().into_iter();
        let place = |shown: bathyscope::app::VisibleLog| {
            let (survey, navigation) = (&shown.log.survey, &shown.log.products.navigation);
            let ping = navigation.pings[30];
            let at = navigation.to_lon_lat(&survey.track, ping.east_m, ping.north_m);
            [at.lon_deg, at.lat_deg, ping.east_m, ping.north_m]
        };
        logs.map(place).collect()
    };
    open_section(&mut window, WorkStep::Correct, "Mounting");
    assert!(places(&window)[0][0].abs() < 0.01);
    let enter = |window: &mut Window, text: &str| {
        let field = window.get_by_role_and_label(Role::TextInput, "Metres of");
        field.focus();
        window.run();
        let field = window.get_by_role_and_label(Role::TextInput, "Metres of");
        field.type_text(text);
        window.run();
        press(window, Modifiers::NONE, Key::Enter);
        settle(window);
    };
    enter(&mut window, "4326");
    let refused =
        app(&window).notices.shown().last().map(|notice| notice.text.clone()).expect("a notice");
    assert!(refused.contains("source.crs: EPSG:4326 (WGS 84) has degrees"), "{refused}");
    assert_eq!(app(&window).logs.shown.settings.source.crs, None);
    enter(&mut window, "32618");
    let now = places(&window);
    println!("{now:?}");
    assert!(
        now.iter().all(|[lon, lat, ..]| (lon + 73.69).abs() < 0.01 && (lat - 42.73).abs() < 0.01)
    );
    // Both in one plane on the Earth, as far apart as their metres say.
    let [one, other] = now[..] else { panic!("two logs") };
    assert!(one[2].abs() < 100.0 && one[3].abs() < 100.0, "{one:?}");
    let apart_m = (one[2] - other[2]).hypot(one[3] - other[3]);
    println!("{apart_m:.3} m apart");
    assert!((apart_m - 50.0).abs() < 0.1, "{apart_m}");
    assert!(window.query_by_label_contains("Positions are metres of EPSG:32618").is_some());
    act(&mut window, Action::Undo);
    assert!(places(&window).iter().all(|[lon, ..]| lon.abs() < 0.01));
}

#[test]
fn the_waterfall_is_drawn_anew_when_sides_are_exchanged() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut drawn = Vec::new();
    for mirrored in [false, true] {
        let mut scene = scene();
        scene.mounting.swap_sides = mirrored;
        let path = folder.path().join("pond.sl2");
        let log = KnownSurvey::new(&scene, 3).truth.sl2_bytes();
        std::fs::write(&path, log).expect("a log");
        let mut window = drawn_window([1400.0, 1000.0]);
        open(&mut window, &path);
        // The picture of the log as it was is there before its sides are exchanged.
        crate::window::settle(&mut window);
        if mirrored {
            act(&mut window, Action::SwapSides);
            crate::window::settle(&mut window);
        }
        let view = window.get_by_label_contains("Waterfall, pings").rect();
        let image = window.render().expect("a picture");
        let [left, top] = [view.left(), view.top()].map(|points| points.ceil() as u32);
        let [width, height] = [view.width(), view.height()].map(|points| points as u32 - 1);
        drawn.push(image::imageops::crop_imm(&image, left, top, width, height).to_image());
    }
    let [plain, exchanged] = &drawn[..] else { panic!("two pictures") };
    assert_eq!(plain.dimensions(), exchanged.dimensions());
    let pairs = plain.pixels().zip(exchanged.pixels());
    let differ = pairs.filter(|(one, other)| one != other).count();
    println!("{differ} of {} pixels differ", plain.pixels().len());
    assert!(50 * differ < plain.pixels().len(), "{differ}");
}
