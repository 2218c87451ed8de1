//! The review of a detector's boxes, driven as an analyst would: by keys alone, and by the mouse.

use crate::window::{Window, app, demo_window, drawn_window, press, settle};
use bathyscope::app::{Action, App, Command, Jobs, Tool};
use bathyscope::detection::review::{BoxId, Edit, Identity, Review, State};
use bathyscope::detection::{Detection, Mark, Raster};
use bathyscope::progress::Progress;
use bathyscope::simulation::{Scene, simulate};
use bathyscope::survey::Side;
use egui::accesskit::Role;
use egui::{Key, Modifiers, Pos2, pos2};
use egui_kittest::kittest::Queryable as _;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

const CLASSES: [&str; 3] = ["rock", "tyre", "log"];
/// Class keys in the order of the classes.
const CLASS_KEYS: [Key; 3] = [Key::Num1, Key::Num2, Key::Num3];

fn classes() -> Vec<String> {
    CLASSES.map(str::to_owned).to_vec()
}

/// Boxes along the open survey, both sides in turn, scores falling and rising again.
fn detections(window: &Window, count: usize) -> Vec<Detection> {
    let pings = identity(window).pings;
    let step = (pings - 40) / count;
    let one = |index: usize| Detection {
        class: index % 2,
        score: 0.3 + 0.6 * ((index * 7 % count) as f32 / count as f32),
        mark: Mark {
            side: Side::BOTH[index % 2],
            pings: 10 + index * step..10 + index * step + 12,
            near_m: 4.0,
            far_m: 6.0,
        },
    };
    (0..count).map(one).collect()
}

fn identity(window: &Window) -> Identity {
    let survey = app(window).survey.as_ref().expect("a survey");
    Identity::of(survey)
}

fn raster(window: &Window) -> Raster {
    let survey = app(window).survey.as_ref().expect("a survey");
    let products = app(window).products.as_ref().expect("results");
    Raster::new(survey, &products.navigation, 0.04)
}

/// Gives the window a model's detections by way of a review file, and returns the file.
fn propose(window: &mut Window, detections: &[Detection], folder: &Path) -> PathBuf {
    let empty = Review::new(identity(window), classes());
    let review = empty.adopt("test model", &classes(), detections, &raster(window));
    let path = folder.join("demo.review.json");
    fs::write(&path, review.to_json()).expect("a file");
    window
        .state_mut()
        .app
        .apply(Command::OpenReview(path.clone()));
    window.run();
    assert_eq!(review_of(window).boxes().len(), detections.len());
    path
}

fn review_of(window: &Window) -> &Review {
    &app(window).reviewing.review
}

fn selected(window: &Window) -> BoxId {
    app(window).reviewing.selected.expect("a selected box")
}

fn states(window: &Window) -> Vec<State> {
    review_of(window).boxes().map(|one| one.state).collect()
}

#[test]
fn fifty_boxes_are_reviewed_by_keys_alone_and_come_back() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut window = demo_window();
    let found = detections(&window, 50);
    let path = propose(&mut window, &found, folder.path());
    press(&mut window, Modifiers::NONE, Key::Tab);
    let mut presses = 1;
    let mut wanted = Vec::new();
    for index in 0..50 {
        let id = selected(&window);
        let state = if index % 3 == 0 {
            press(&mut window, Modifiers::NONE, Key::R);
            presses += 1;
            State::Rejected
        } else {
            if index % 5 == 0 {
                press(&mut window, Modifiers::NONE, CLASS_KEYS[2]);
                presses += 1;
            }
            press(&mut window, Modifiers::NONE, Key::A);
            presses += 1;
            State::Accepted
        };
        wanted.push((id, state));
    }
    assert!(presses <= 2 * 50, "{presses} key presses for 50 boxes");
    for (id, state) in &wanted {
        assert_eq!(
            review_of(&window).get(*id).map(|one| one.state),
            Some(*state)
        );
    }
    let logs = review_of(&window).boxes().filter(|one| one.class == 2);
    assert_eq!(logs.count(), 6, "those that were named a log");
    assert_eq!(app(&window).reviewing.counts().decided(), 50);
    let scores: Vec<_> = wanted
        .iter()
        .map(|(id, _)| review_of(&window).get(*id).and_then(|one| one.score))
        .collect();
    assert!(scores.is_sorted_by(|a, b| a >= b), "the surest first");

    assert!(app(&window).reviewing.is_unsaved());
    press(&mut window, Modifiers::COMMAND, Key::S);
    assert!(!app(&window).reviewing.is_unsaved());
    let mut next = demo_window();
    next.state_mut().app.apply(Command::OpenReview(path));
    next.run();
    assert_eq!(review_of(&next), review_of(&window));

    let folder = folder.path().join("out");
    export_by_keys(&mut window, &folder);
    let exported = folder.join("boxes.review.json");
    let mut again = demo_window();
    again.state_mut().app.apply(Command::OpenReview(exported));
    again.run();
    assert_eq!(review_of(&again), review_of(&window));
    check_tables(&folder, review_of(&window));
    check_dataset(&folder.join("dataset"), review_of(&window));
}

/// Runs a command of the palette, then answers the path field.
fn export_by_keys(window: &mut Window, folder: &Path) {
    press(window, Modifiers::COMMAND, Key::P);
    window.get_by_label("Command").type_text("export boxes");
    window.run();
    press(window, Modifiers::NONE, Key::Enter);
    window
        .get_by_role_and_label(Role::TextInput, "Folder to write into")
        .type_text(&folder.to_string_lossy());
    window.run();
    window.get_by_label("Export").click();
    window.run();
    assert!(window.query_by_label_contains("Wrote 50 boxes").is_some());
}

fn check_tables(folder: &Path, review: &Review) {
    let objects = review.boxes().filter(|one| one.state.is_object()).count();
    let read = |name: &str| fs::read_to_string(folder.join(name)).expect("a file");
    let table = read("objects.csv");
    let mut table = csv::Reader::from_reader(table.as_bytes());
    let lines: Vec<csv::StringRecord> = table.records().map(|line| line.expect("a line")).collect();
    assert_eq!(lines.len(), 50);
    for (line, one) in lines.iter().zip(review.boxes()) {
        assert_eq!(line[0], one.id.0.to_string());
        assert_eq!(&line[2], review.class_name(one.class));
        assert_eq!(&line[4], one.state.name());
        // The pond of the demo lies at 29.41 N 82.11 W.
        let [lon, lat]: [f64; 2] =
            [&line[10], &line[11]].map(|degrees| degrees.parse().expect("degrees"));
        assert!(
            f64::abs(lon + 82.11) < 1e-3 && f64::abs(lat - 29.41) < 1e-3,
            "{line:?}"
        );
    }
    assert_eq!(read("objects.kml").matches("<Placemark>").count(), objects);
    assert_eq!(read("objects.gpx").matches("<wpt ").count(), objects);
    let points: serde_json::Value = serde_json::from_str(&read("objects.geojson")).expect("JSON");
    assert_eq!(points["features"].as_array().map(Vec::len), Some(50));
}

fn check_dataset(folder: &Path, review: &Review) {
    let coco = fs::read_to_string(folder.join("annotations.json")).expect("annotations");
    let coco: serde_json::Value = serde_json::from_str(&coco).expect("JSON");
    let images = coco["images"].as_array().expect("images");
    let annotations = coco["annotations"].as_array().expect("annotations");
    let classes = fs::read_to_string(folder.join("classes.txt")).expect("classes");
    assert!(classes.lines().eq(review.classes()));
    let mut labelled = 0;
    for image in images {
        let name = image["file_name"].as_str().expect("a name");
        let stem = name.trim_end_matches(".png");
        let picture = image::open(folder.join("images").join(name)).expect("a picture");
        assert_eq!((picture.width(), picture.height()), (416, 416));
        let yolo = fs::read_to_string(folder.join("labels").join(format!("{stem}.txt")));
        let yolo = yolo.expect("labels");
        let voc = fs::read_to_string(folder.join("voc").join(format!("{stem}.xml")));
        let voc = voc.expect("labels");
        let sure = |one: &&serde_json::Value| one["image_id"] == image["id"] && one["iscrowd"] == 0;
        let sure: Vec<_> = annotations.iter().filter(sure).collect();
        assert_eq!(yolo.lines().count(), sure.len());
        assert_eq!(voc.matches("<difficult>0<").count(), sure.len());
        for (line, one) in yolo.lines().zip(&sure) {
            let numbers: Vec<f64> = line
                .split(' ')
                .map(|number| number.parse().expect("a number"))
                .collect();
            assert_eq!(
                numbers[0] as u64 + 1,
                one["category_id"].as_u64().expect("a class")
            );
            let [left, width] = [0, 2].map(|index| one["bbox"][index].as_f64().expect("pixels"));
            assert!((numbers[1] * 416.0 - (left + 0.5 * width)).abs() < 0.01);
        }
        labelled += sure.len();
    }
    let objects = review.boxes().filter(|one| one.state.is_object()).count();
    assert!(
        labelled >= objects,
        "{labelled} labels of {objects} objects"
    );
}

#[test]
fn decisions_are_undone_one_by_one_and_share_the_history_with_settings() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut window = demo_window();
    let found = detections(&window, 4);
    propose(&mut window, &found, folder.path());
    press(&mut window, Modifiers::NONE, Key::Tab);
    let first = selected(&window);
    press(&mut window, Modifiers::NONE, Key::A);
    press(&mut window, Modifiers::NONE, Key::CloseBracket);
    press(&mut window, Modifiers::NONE, Key::R);
    let after = states(&window);
    assert_eq!(app(&window).undo_label(), Some("reject box"));
    press(&mut window, Modifiers::COMMAND, Key::Z);
    assert_eq!(app(&window).undo_label(), Some("threshold"));
    assert_eq!(crate::window::threshold(&window), 0.31);
    press(&mut window, Modifiers::COMMAND, Key::Z);
    assert_eq!(crate::window::threshold(&window), 0.30);
    press(&mut window, Modifiers::COMMAND, Key::Z);
    assert_eq!(states(&window), [State::Proposed; 4]);
    assert_eq!(selected(&window), first, "undo goes back to the box");
    for _ in 0..3 {
        press(&mut window, Modifiers::COMMAND | Modifiers::SHIFT, Key::Z);
    }
    assert_eq!(states(&window), after);
    press(&mut window, Modifiers::NONE, Key::U);
    assert_eq!(
        after
            .iter()
            .filter(|state| **state == State::Proposed)
            .count()
            + 1,
        states(&window)
            .iter()
            .filter(|state| **state == State::Proposed)
            .count(),
    );
}

#[test]
fn digits_name_the_selected_box_and_otherwise_focus_a_view() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut window = demo_window();
    let found = detections(&window, 4);
    propose(&mut window, &found, folder.path());
    press(&mut window, Modifiers::NONE, Key::Tab);
    let id = selected(&window);
    press(&mut window, Modifiers::NONE, Key::Num3);
    assert_eq!(review_of(&window).get(id).map(|one| one.class), Some(2));
    press(&mut window, Modifiers::NONE, Key::Num9);
    assert_eq!(review_of(&window).get(id).map(|one| one.class), Some(2));
    press(&mut window, Modifiers::NONE, Key::Escape);
    assert_eq!(app(&window).reviewing.selected, None);
    let before = review_of(&window).clone();
    press(&mut window, Modifiers::NONE, Key::Num1);
    assert_eq!(*review_of(&window), before);
}

#[test]
fn arrows_move_the_box_only_while_it_is_edited() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut window = demo_window();
    let found = detections(&window, 4);
    propose(&mut window, &found, folder.path());
    press(&mut window, Modifiers::NONE, Key::Tab);
    let id = selected(&window);
    let mark = |window: &Window| {
        review_of(window)
            .get(id)
            .map(|one| one.mark.clone())
            .expect("the box")
    };
    let before = mark(&window);
    press(&mut window, Modifiers::NONE, Key::ArrowRight);
    assert_eq!(mark(&window), before);
    press(&mut window, Modifiers::NONE, Key::E);
    assert_eq!(app(&window).reviewing.tool, Tool::Edit);
    press(&mut window, Modifiers::SHIFT, Key::ArrowRight);
    assert_eq!(
        mark(&window).pings,
        before.pings.start + 10..before.pings.end + 10
    );
    press(&mut window, Modifiers::COMMAND, Key::ArrowLeft);
    assert_eq!(mark(&window).pings.end, before.pings.end + 9);
    press(&mut window, Modifiers::NONE, Key::S);
    assert_ne!(mark(&window).side, before.side);
    press(&mut window, Modifiers::NONE, Key::Escape);
    assert_eq!(app(&window).reviewing.tool, Tool::Look);
    for _ in 0..3 {
        press(&mut window, Modifiers::COMMAND, Key::Z);
    }
    assert_eq!(mark(&window), before);
}

#[test]
fn boxes_of_a_log_come_back_when_it_is_opened_again() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut window = demo_window();
    let found = detections(&window, 4);
    propose(&mut window, &found, folder.path());
    press(&mut window, Modifiers::NONE, Key::Tab);
    press(&mut window, Modifiers::NONE, Key::A);
    let decided = states(&window);
    // Another log, shorter, with a review beside it.
    let bytes = fs::read(crate::support::demo_log()).expect("the demo log");
    let log = folder.path().join("other.sl2");
    fs::write(&log, &bytes[..bytes.len() / 2]).expect("half a log");
    window.state_mut().app.apply(Command::Open(log.clone()));
    window.run();
    assert!(!app(&window).reviewing.has_boxes());
    let add = Edit::Add {
        mark: found[1].mark.clone(),
        class: 0,
    };
    let app_now = &mut window.state_mut().app;
    app_now.apply(Command::Edit {
        edit: add,
        live: false,
    });
    let beside = app_now.review_path().expect("a place for the review");
    assert_eq!(beside, folder.path().join("other.review.json"));
    app_now.apply(Command::SaveReview(log.clone()));
    assert_eq!(
        fs::read(&log).expect("the log").len(),
        bytes.len() / 2,
        "the log stays"
    );
    window.state_mut().app.apply(Command::SaveReview(beside));
    window.state_mut().app.apply(Command::OpenDemo);
    window.run();
    assert_eq!(states(&window), decided);
    let mut fresh = demo_window();
    fresh.state_mut().app.apply(Command::Open(log));
    fresh.run();
    assert_eq!(states(&fresh), [State::Added], "found beside the log");
}

/// Where a place is on the screen of a waterfall that shows all of the demo, time to the right.
fn at(window: &Window, ping: f64, across_m: f64) -> Pos2 {
    let view = window.get_by_label_contains("Waterfall, pings").rect();
    let seen = &app(window).visible;
    let share = (ping - seen.start as f64) / seen.len() as f64;
    // The range that is shown is the demo's longest.
    let far_m = farthest_m(window);
    pos2(
        view.left() + view.width() * share as f32,
        view.center().y + 0.5 * view.height() * (across_m / far_m) as f32,
    )
}

fn farthest_m(window: &Window) -> f64 {
    let survey = app(window).survey.as_ref().expect("a survey");
    let sides = survey
        .side_scan
        .iter()
        .flat_map(|ping| [ping.port, ping.starboard]);
    sides
        .flatten()
        .fold(0.0, |far_m, side| f64::max(far_m, f64::from(side.far_m)))
}

fn drag(window: &mut Window, from: Pos2, to: Pos2) {
    window.hover_at(from);
    window.step();
    window.drag_at(from);
    window.step();
    for share in [0.3, 0.7, 1.0] {
        window.hover_at(from.lerp(to, share));
        window.step();
        window.step();
    }
    window.drop_at(to);
    window.run();
}

#[test]
fn a_missed_object_is_drawn_with_the_mouse_and_moved() {
    let mut window = demo_window();
    press(&mut window, Modifiers::NONE, Key::F);
    press(&mut window, Modifiers::NONE, Key::N);
    let (from, to) = (at(&window, 300.0, -8.0), at(&window, 400.0, -5.0));
    drag(&mut window, from, to);
    let one = review_of(&window).boxes().next().cloned().expect("a box");
    assert_eq!((one.state, one.mark.side), (State::Added, Side::Port));
    let near = |value: f64, wanted: f64, by: f64| (value - wanted).abs() < by;
    let mark = &one.mark;
    assert!(near(mark.pings.start as f64, 300.0, 4.0), "{mark:?}");
    assert!(near(mark.pings.end as f64, 400.0, 4.0), "{mark:?}");
    assert!(
        near(mark.near_m, 5.0, 0.1) && near(mark.far_m, 8.0, 0.1),
        "{mark:?}"
    );
    assert_eq!(selected(&window), one.id);
    assert_eq!(app(&window).reviewing.tool, Tool::Look);
    assert!(
        window
            .query_by_label_contains("box 1 selected: object, added")
            .is_some()
    );

    // Without the tool a drag moves the picture, with it the box, and its far edge alone.
    press(&mut window, Modifiers::NONE, Key::E);
    let (from, to) = (at(&window, 350.0, -6.5), at(&window, 450.0, -7.5));
    drag(&mut window, from, to);
    let moved = review_of(&window)
        .get(one.id)
        .expect("the box")
        .mark
        .clone();
    assert!(near(moved.pings.start as f64, 400.0, 8.0), "{moved:?}");
    assert!(
        near(moved.near_m, 6.0, 0.2) && near(moved.far_m, 9.0, 0.2),
        "{moved:?}"
    );
    let (from, to) = (at(&window, 450.0, -moved.far_m), at(&window, 470.0, -10.0));
    drag(&mut window, from, to);
    let sized = review_of(&window)
        .get(one.id)
        .expect("the box")
        .mark
        .clone();
    assert_eq!(
        (sized.pings.clone(), sized.near_m),
        (moved.pings.clone(), moved.near_m)
    );
    assert!(near(sized.far_m, 10.0, 0.2), "{sized:?}");
    press(&mut window, Modifiers::COMMAND, Key::Z);
    let back = review_of(&window)
        .get(one.id)
        .expect("the box")
        .mark
        .clone();
    assert_eq!(back, moved, "a drag is one step");
    press(&mut window, Modifiers::COMMAND, Key::Z);
    press(&mut window, Modifiers::COMMAND, Key::Z);
    assert_eq!(review_of(&window).boxes().len(), 0);
}

#[test]
fn a_click_selects_the_box_under_it_and_beside_it_a_ping() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut window = demo_window();
    let found = detections(&window, 8);
    propose(&mut window, &found, folder.path());
    press(&mut window, Modifiers::NONE, Key::F);
    let mark = &found[3].mark;
    let middle = mark.pings.start as f64 + 6.0;
    let place = at(&window, middle, 5.0);
    window.drag_at(place);
    window.drop_at(place);
    window.run();
    let one = app(&window)
        .reviewing
        .selected_box()
        .cloned()
        .expect("a box");
    assert_eq!(one.mark, *mark);
    assert!(window.query_by_label_contains("Picture of box").is_some());
    window.get_by_label("Accept box").click();
    window.run();
    assert_eq!(
        review_of(&window).get(one.id).map(|one| one.state),
        Some(State::Accepted)
    );
    let beside = at(&window, middle, -5.0);
    window.drag_at(beside);
    window.drop_at(beside);
    window.run();
    assert_eq!(app(&window).reviewing.selected, None);
    assert!(app(&window).selection.is_some());
}

#[test]
fn the_confidence_slider_hides_proposals_but_no_decisions() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut window = demo_window();
    let found = detections(&window, 10);
    propose(&mut window, &found, folder.path());
    press(&mut window, Modifiers::NONE, Key::F);
    app_mut(&mut window).apply(Command::Edit {
        edit: Edit::Reject(BoxId(1)),
        live: false,
    });
    window.run();
    window.get_by_label_contains("1 of 10 decided");
    window.get_by_label_contains(", 10 boxes in view");
    let slider = window.get_by_role_and_label(Role::Slider, "Confidence");
    slider.set_value_accesskit(0.62);
    window.run();
    let sure = found
        .iter()
        .skip(1)
        .filter(|found| found.score >= 0.62)
        .count();
    assert!((1..9).contains(&sure));
    let counts = app(&window).reviewing.counts();
    assert_eq!((counts.rejected, counts.proposed), (1, sure));
    window.get_by_label_contains(&format!(", {} boxes in view", sure + 1));
    window.get_by_label_contains(&format!("{} below the confidence", 9 - sure));
}

fn app_mut(window: &mut Window) -> &mut bathyscope::app::App {
    &mut window.state_mut().app
}

#[test]
fn what_is_written_about_a_box_is_kept_when_the_next_one_is_selected() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut window = demo_window();
    let found = detections(&window, 4);
    propose(&mut window, &found, folder.path());
    press(&mut window, Modifiers::NONE, Key::Tab);
    let id = selected(&window);
    let note = window.get_by_role_and_label(Role::TextInput, "Note on the box");
    note.focus();
    window.run();
    let note = window.get_by_role_and_label(Role::TextInput, "Note on the box");
    note.type_text("two tyres, see dive 3");
    window.run();
    assert_eq!(
        states(&window),
        [State::Proposed; 4],
        "letters are text here"
    );
    press(&mut window, Modifiers::NONE, Key::Enter);
    assert_eq!(
        review_of(&window).get(id).map(|one| one.note.as_str()),
        Some("two tyres, see dive 3")
    );
}

/// A small model of random weights: it finds things everywhere, fast.
fn model(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("tests/suite/detector_models/{name}.onnx"))
}

#[test]
fn objects_are_found_by_a_button_and_found_again_without_losing_a_decision() {
    let mut window = demo_window();
    app_mut(&mut window).apply(Command::UseModel(model("end_to_end")));
    window.run();
    window.get_by_label("Find objects").click();
    window.run();
    let found = review_of(&window).boxes().len();
    assert!(found > 100, "{found}");
    assert!(review_of(&window).classes().contains(&"log".to_owned()));
    assert!(window.query_by_label_contains("end_to_end.onnx").is_some());
    assert!(
        !app(&window).reviewing.is_unsaved(),
        "proposals are no loss"
    );
    press(&mut window, Modifiers::NONE, Key::Tab);
    let id = selected(&window);
    press(&mut window, Modifiers::NONE, Key::R);
    window.get_by_label("Find objects").click();
    window.run();
    assert_eq!(
        review_of(&window).get(id).map(|one| one.state),
        Some(State::Rejected)
    );
    assert_eq!(review_of(&window).boxes().len(), found, "each once");
    press(&mut window, Modifiers::COMMAND, Key::Z);
    press(&mut window, Modifiers::COMMAND, Key::Z);
    press(&mut window, Modifiers::COMMAND, Key::Z);
    assert!(!app(&window).reviewing.has_boxes());

    app_mut(&mut window).apply(Command::UseModel(model("nms_inside")));
    app_mut(&mut window).apply(Command::Do(Action::FindObjects));
    window.run();
    let notice = app(&window).notices.last().expect("a refusal");
    assert!(
        notice.is_error && notice.text.contains("nms_inside"),
        "{notice:?}"
    );
}

#[test]
fn boxes_come_while_the_search_runs_and_stay_when_it_is_stopped() {
    let mut app = App::new(Jobs::Threads(Arc::new(|| ())));
    let until = |app: &mut App, done: &dyn Fn(&App) -> bool| {
        for _ in 0..6000 {
            app.poll();
            if done(app) {
                return;
            }
            std::thread::sleep(std::time::Duration::from_millis(10));
        }
        panic!("it takes more than a minute");
    };
    app.apply(Command::OpenDemo);
    until(&mut app, &|app| app.products.is_some() && app.is_idle());
    app.apply(Command::UseModel(model("tianxiaomo")));
    app.apply(Command::Do(Action::FindObjects));
    until(&mut app, &|app| app.reviewing.has_boxes());
    assert!(app.detect_fraction().is_some(), "it still runs");
    app.apply(Command::Do(Action::Cancel));
    until(&mut app, &App::is_idle);
    assert!(app.detect_fraction().is_none() && app.reviewing.has_boxes());
    assert_eq!(app.undo_label(), Some("find objects"));
    app.apply(Command::Do(Action::Undo));
    assert!(!app.reviewing.has_boxes());
}

/// What a perfect detector would find in the demo: each sighting of each object, with its shadow.
fn truth(window: &Window) -> (Vec<String>, Vec<Detection>) {
    let simulated = simulate(&Scene::demo(), 1, &Progress::new()).expect("the demo");
    let mut names: Vec<String> = Vec::new();
    let mut found = Vec::new();
    let pings = identity(window).pings;
    for (index, object) in simulated.objects.iter().enumerate() {
        let name = object.kind.name();
        let known = names.iter().position(|known| known == name);
        let class = known.unwrap_or_else(|| {
            names.push(name.to_owned());
            names.len() - 1
        });
        for (pass, sighting) in object.sightings.iter().enumerate() {
            let end_m = sighting.shadow_m[1];
            found.push(Detection {
                class,
                score: 0.95 - 0.07 * ((index * 3 + pass * 5) % 9) as f32,
                mark: Mark {
                    side: sighting.side,
                    pings: sighting.first_ping..(sighting.last_ping + 1).min(pings),
                    near_m: sighting.near_m,
                    far_m: if end_m.is_finite() {
                        end_m
                    } else {
                        sighting.far_m
                    },
                },
            });
        }
    }
    (names, found)
}

#[test]
fn the_window_in_review_looks_as_it_did() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut window = drawn_window([1400.0, 900.0]);
    window.state_mut().app.apply(Command::OpenDemo);
    window.run();
    let (names, found) = truth(&window);
    let review = Review::new(identity(&window), names.clone());
    let review = review.adopt("truth of the demo", &names, &found, &raster(&window));
    let path = folder.path().join("demo.review.json");
    fs::write(&path, review.to_json()).expect("a file");
    app_mut(&mut window).apply(Command::OpenReview(path));
    window.run();
    app_mut(&mut window).apply(Command::Dismiss(0));
    let by_place = review.boxes().map(|one| (one.mark.pings.start, one.id));
    let mut by_place: Vec<_> = by_place.collect();
    by_place.sort();
    for (index, (_, id)) in by_place.iter().enumerate().take(6) {
        let edit = match index % 3 {
            0 => Edit::Accept(*id),
            1 => Edit::Reject(*id),
            _ => continue,
        };
        app_mut(&mut window).apply(Command::Edit { edit, live: false });
    }
    app_mut(&mut window).apply(Command::SelectBox(Some(by_place[2].1)));
    app_mut(&mut window).apply(Command::Do(Action::EditBox));
    window.state_mut().show_pings(0..700);
    settle(&mut window);
    window.snapshot("window_review");
}
