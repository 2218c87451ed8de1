//! The review of a detector's boxes, driven as an analyst would: by keys alone, and by the mouse.

mod exported;
mod judged;
pub(crate) mod mouse;
mod on_map;
pub(crate) mod search;

use self::exported::{check_dataset, check_tables, export_by_keys};
use crate::window::{Window, app, demo_window, drawn_window, open_step, press, settle, threshold};
use bathyscope::app::{
    Action, App, BoxEdge, Command, FileToOpen, FileToWrite, Jobs, ObjectState, Tool, WorkStep,
    border_m,
};
use bathyscope_log::support::progress::Progress;
use bathyscope_log::survey::{Identity, Side};
use bathyscope_objects::review::{BoxId, Edit, Review, Reviewed, State};
use bathyscope_objects::{Detection, Mark, ObjectExtent, Raster};
use bathyscope_simulation::{Scene, simulate};
use egui::accesskit::Role;
use egui::{Key, Modifiers, Pos2, pos2};
use egui_kittest::kittest::Queryable as _;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

const CLASSES: [&str; 3] = ["rock", "tyre", "log"];
/// The key of the third class of the usual list, and the class.
const TREE: (Key, &str) = (Key::Num3, "tree");

fn classes() -> Vec<String> {
    CLASSES.map(str::to_owned).to_vec()
}

/// Boxes along the open survey, both sides in turn, scores falling and rising again.
pub(crate) fn detections(window: &Window, count: usize) -> Vec<Detection> {
    let pings = identity(window).pings;
    let step = (pings - 40) / count;
    let detection = |index: usize| Detection {
        class: index % 2,
        score: 0.3 + 0.6 * ((index * 7 % count) as f32 / count as f32),
        mark: Mark {
            side: Side::BOTH[index % 2],
            pings: 10 + index * step..10 + index * step + 12,
            near_m: 4.0,
            far_m: 6.0,
        },
    };
    (0..count).map(detection).collect()
}

fn identity(window: &Window) -> Identity {
    let survey = app(window).logs.shown.survey.as_ref().expect("a survey");
    Identity::of(survey)
}

fn raster(window: &Window) -> Raster {
    let survey = app(window).logs.shown.survey.as_ref().expect("a survey");
    let products = app(window).logs.shown.products.as_ref().expect("results");
    Raster::new(survey, &products.navigation, 0.04)
}

/// Gives the window a model's detections by way of a review file, and returns the file.
pub(crate) fn propose(window: &mut Window, detections: &[Detection], folder: &Path) -> PathBuf {
    let empty = Review::new(identity(window), classes());
    let review = empty.adopt("test model", &classes(), detections, &raster(window), 0..usize::MAX);
    let path = folder.join("demo.review.json");
    fs::write(&path, review.to_json()).expect("a file");
    window.state_mut().app.apply(Command::OpenFile(FileToOpen::Review(path.clone())));
    window.run();
    assert_eq!(review_of(window).boxes().len(), detections.len());
    path
}

/// The demo with `count` proposals to review, whose review is kept in a temporary folder.
fn proposed(count: usize) -> (tempfile::TempDir, Window) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut window = demo_window();
    let found = detections(&window, count);
    propose(&mut window, &found, folder.path());
    (folder, window)
}

fn review_of(window: &Window) -> &Review {
    &app(window).logs.shown.reviewing.review
}

fn selected(window: &Window) -> BoxId {
    app(window).logs.shown.reviewing.selected.expect("a selected box")
}

fn states(window: &Window) -> Vec<State> {
    review_of(window).boxes().map(|review_box| review_box.state).collect()
}

#[test]
fn fifty_boxes_are_reviewed_by_keys_alone_and_come_back() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut window = demo_window();
    let found = detections(&window, 50);
    let path = propose(&mut window, &found, folder.path());
    press(&mut window, Modifiers::NONE, Key::Tab);
    let mut presses = 1;
    let mut expected = Vec::new();
    for index in 0..50 {
        let id = selected(&window);
        let state = if index % 3 == 0 {
            press(&mut window, Modifiers::NONE, Key::R);
            presses += 1;
            State::Rejected
        } else {
            if index % 5 == 0 {
                press(&mut window, Modifiers::NONE, TREE.0);
                presses += 1;
            }
            press(&mut window, Modifiers::NONE, Key::A);
            presses += 1;
            State::Accepted
        };
        expected.push((id, state));
    }
    assert!(presses <= 2 * 50, "{presses} key presses for 50 boxes");
    for (id, state) in &expected {
        assert_eq!(review_of(&window).get(*id).map(|review_box| review_box.state), Some(*state));
    }
    let named = review_of(&window);
    let trees = (named.boxes()).filter(|review_box| named.class_name(review_box.class) == TREE.1);
    assert_eq!(trees.count(), 6, "those that were named a tree");
    assert_eq!(app(&window).logs.shown.reviewing.counts().decided(), 50);
    let scores: Vec<_> = expected
        .iter()
        .map(|(id, _)| review_of(&window).get(*id).and_then(|review_box| review_box.score))
        .collect();
    assert!(scores.is_sorted_by(|a, b| a >= b), "the surest first");

    assert!(app(&window).logs.shown.reviewing.is_unsaved());
    press(&mut window, Modifiers::COMMAND, Key::S);
    assert!(!app(&window).logs.shown.reviewing.is_unsaved());
    let mut next = demo_window();
    next.state_mut().app.apply(Command::OpenFile(FileToOpen::Review(path)));
    next.run();
    assert_eq!(review_of(&next), review_of(&window));

    let folder = folder.path().join("out");
    export_by_keys(&mut window, &folder);
    let exported = folder.join("boxes.review.json");
    let mut again = demo_window();
    again.state_mut().app.apply(Command::OpenFile(FileToOpen::Review(exported)));
    again.run();
    assert_eq!(review_of(&again), review_of(&window));
    check_tables(&folder, review_of(&window));
    check_dataset(&folder.join("dataset"), review_of(&window));

    // The report shows what was decided, not what was proposed.
    let products = folder.join("products");
    (window.state_mut().app).apply(Command::Write(FileToWrite::Products(products.clone())));
    window.run();
    let page = std::fs::read_to_string(products.join("report.html")).expect("a report");
    assert!(page.contains("Boxes of the review: 33 accepted, 0 added, 17 rejected, 0 undecided"));
    assert_eq!(page.matches(">accepted</td>").count(), objects(&window, ObjectState::Accepted));
    assert!(!page.contains(">rejected</td>"));
}

/// Objects of the window in a state.
fn objects(window: &Window, state: ObjectState) -> usize {
    app(window).objects.all().iter().filter(|object| object.state == state).count()
}

#[test]
fn the_report_lists_no_undecided_proposal_among_the_objects() {
    let (folder, mut window) = proposed(6);
    let report = |window: &mut Window, name: &str| {
        let products = folder.path().join(name);
        (window.state_mut().app).apply(Command::Write(FileToWrite::Products(products.clone())));
        window.run();
        fs::read_to_string(products.join("report.html")).expect("a report")
    };
    // While nobody has decided, the proposals are what is known, and said to be that.
    let page = report(&mut window, "proposed");
    assert!(page.contains("<p>Proposed by the detector, not reviewed. "));
    assert!(page.contains("objects proposed, not reviewed"));
    let undecided = objects(&window, ObjectState::Undecided);
    assert!((3..=6).contains(&undecided));
    assert_eq!(page.matches(">undecided</td>").count(), undecided);
    press(&mut window, Modifiers::NONE, Key::Tab);
    for key in [Key::A, Key::A, Key::R] {
        press(&mut window, Modifiers::NONE, key);
    }
    let page = report(&mut window, "reviewed");
    assert_eq!(page.matches(">accepted</td>").count(), objects(&window, ObjectState::Accepted));
    assert_eq!(page.matches(">undecided</td>").count(), 0);
    assert!(page.contains("3 proposals are undecided and not listed."));
}

#[test]
fn decisions_are_undone_one_by_one_and_share_the_history_with_settings() {
    let (_folder, mut window) = proposed(4);
    press(&mut window, Modifiers::NONE, Key::Tab);
    let first = selected(&window);
    press(&mut window, Modifiers::NONE, Key::A);
    press(&mut window, Modifiers::NONE, Key::CloseBracket);
    let BoxId(second) = selected(&window);
    press(&mut window, Modifiers::NONE, Key::R);
    let after = states(&window);
    let rejected = format!("reject box {second}");
    assert_eq!(app(&window).document.history.undo_label(), Some(&*rejected));
    press(&mut window, Modifiers::COMMAND, Key::Z);
    assert_eq!(app(&window).document.history.undo_label(), Some("threshold 0.31"));
    assert_eq!(threshold(&window), 0.31);
    press(&mut window, Modifiers::COMMAND, Key::Z);
    assert_eq!(threshold(&window), 0.30);
    press(&mut window, Modifiers::COMMAND, Key::Z);
    assert_eq!(states(&window), [State::Proposed; 4]);
    assert_eq!(selected(&window), first, "undo goes back to the box");
    for _ in 0..3 {
        press(&mut window, Modifiers::COMMAND | Modifiers::SHIFT, Key::Z);
    }
    assert_eq!(states(&window), after);
    press(&mut window, Modifiers::NONE, Key::U);
    assert_eq!(
        after.iter().filter(|state| **state == State::Proposed).count() + 1,
        states(&window).iter().filter(|state| **state == State::Proposed).count(),
    );
}

/// Holds a key as a keyboard does: it is pressed again and again until it is let go.
fn hold(window: &mut Window, key: Key) {
    for _ in 0..5 {
        window.key_down(key);
        window.run();
    }
    window.key_up(key);
    window.run();
}

#[test]
fn a_held_key_decides_about_one_box_and_goes_on_stepping() {
    let (_folder, mut window) = proposed(8);
    press(&mut window, Modifiers::NONE, Key::Tab);
    for (decided, key) in (1..).zip([Key::A, Key::R, Key::Delete]) {
        hold(&mut window, key);
        let counts = app(&window).logs.shown.reviewing.counts();
        assert_eq!(counts.decided(), decided, "{key:?}");
    }
    // A button that has the keyboard is pressed by Space and Enter, and their repeats.
    for (decided, key) in (4..).zip([Key::Space, Key::Enter]) {
        window.get_by_label("Accept box").focus();
        window.run();
        hold(&mut window, key);
        let counts = app(&window).logs.shown.reviewing.counts();
        assert_eq!(counts.decided(), decided, "{key:?}");
    }
    let before = threshold(&window);
    hold(&mut window, Key::CloseBracket);
    assert_eq!(threshold(&window), before, "the button has the keyboard");
    press(&mut window, Modifiers::NONE, Key::Escape);
    hold(&mut window, Key::CloseBracket);
    assert!((threshold(&window) - before - 0.05).abs() < 1e-6);
}

#[test]
fn digits_name_the_selected_box_and_otherwise_focus_a_view() {
    let (_folder, mut window) = proposed(4);
    press(&mut window, Modifiers::NONE, Key::Tab);
    let id = selected(&window);
    let list = ["wreck", "anchor", "buoy"].map(str::to_owned).to_vec();
    (window.state_mut().app).apply(Command::SetClasses(list));
    press(&mut window, Modifiers::NONE, Key::Num3);
    assert_eq!(class_of(&window, id), "buoy");
    // Behind the list come the classes that boxes have besides.
    press(&mut window, Modifiers::NONE, Key::Num5);
    let fifth = app(&window).logs.class_names()[4].to_owned();
    assert_eq!(class_of(&window, id), fifth);
    press(&mut window, Modifiers::NONE, Key::Num9);
    assert_eq!(class_of(&window, id), fifth, "there is no ninth");
    press(&mut window, Modifiers::NONE, Key::Escape);
    assert_eq!(app(&window).logs.shown.reviewing.selected, None);
    let before = review_of(&window).clone();
    press(&mut window, Modifiers::NONE, Key::Num1);
    assert_eq!(*review_of(&window), before);
}

fn class_of(window: &Window, id: BoxId) -> String {
    let review = review_of(window);
    let review_box = review.get(id).expect("the box");
    review.class_name(review_box.class).to_owned()
}

#[test]
fn the_list_of_classes_is_edited_and_a_new_name_holds_for_all_boxes_as_one_step() {
    let (_folder, mut window) = proposed(4);
    press(&mut window, Modifiers::NONE, Key::Tab);
    let id = selected(&window);
    let list = |window: &Window| app(window).logs.shown.settings.review.classes.clone();
    let first = list(&window);
    assert_eq!(first[..2], ["wreck", "anchor"]);
    window.get_by_label("Edit classes").click_accesskit();
    window.run();
    window.get_by_label("Move down wreck").click_accesskit();
    window.run();
    assert_eq!(list(&window)[..2], ["anchor", "wreck"]);
    press(&mut window, Modifiers::NONE, Key::Num1);
    assert_eq!(class_of(&window, id), "anchor");
    let rename = Command::RenameClass { from: "anchor".to_owned(), to: "mooring".to_owned() };
    (window.state_mut().app).apply(rename);
    window.run();
    assert_eq!(list(&window)[..2], ["mooring", "wreck"]);
    assert_eq!(class_of(&window, id), "mooring");
    press(&mut window, Modifiers::COMMAND, Key::Z);
    assert_eq!(list(&window)[..2], ["anchor", "wreck"]);
    assert_eq!(class_of(&window, id), "anchor");
    // No result depends on the list.
    assert!(app(&window).logs.shown.stale().is_none());
    window.get_by_label("Remove class anchor").click_accesskit();
    window.run();
    assert!(!list(&window).contains(&"anchor".to_owned()));
    assert_eq!(class_of(&window, id), "anchor", "its boxes keep it");
    let kept = app(&window).logs.class_names();
    assert!(kept.contains(&"anchor"), "{kept:?}");
}

#[test]
fn arrows_move_the_box_only_while_it_is_edited() {
    let (_folder, mut window) = proposed(4);
    press(&mut window, Modifiers::NONE, Key::Tab);
    let id = selected(&window);
    let mark = |window: &Window| {
        review_of(window).get(id).map(|review_box| review_box.mark.clone()).expect("the box")
    };
    let before = mark(&window);
    press(&mut window, Modifiers::NONE, Key::ArrowRight);
    assert_eq!(mark(&window), before);
    press(&mut window, Modifiers::NONE, Key::E);
    assert_eq!(app(&window).logs.shown.reviewing.tool, Tool::Edit);
    press(&mut window, Modifiers::SHIFT, Key::ArrowRight);
    assert_eq!(mark(&window).pings, before.pings.start + 10..before.pings.end + 10);
    press(&mut window, Modifiers::COMMAND, Key::ArrowLeft);
    assert_eq!(mark(&window).pings.end, before.pings.end + 9);
    press(&mut window, Modifiers::NONE, Key::S);
    assert_ne!(mark(&window).side, before.side);
    press(&mut window, Modifiers::NONE, Key::Escape);
    assert_eq!(app(&window).logs.shown.reviewing.tool, Tool::Look);
    for _ in 0..3 {
        press(&mut window, Modifiers::COMMAND, Key::Z);
    }
    assert_eq!(mark(&window), before);
}

#[test]
fn boxes_of_a_log_come_back_when_it_is_opened_again() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let pond = folder.path().join("pond.sl2");
    fs::copy(crate::support::demo_log(), &pond).expect("a log");
    let mut window = crate::window::empty_window();
    window.state_mut().app.files.untitled_folder = Some(folder.path().join("kept"));
    window.state_mut().app.apply(Command::Open(pond.clone()));
    window.run();
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
    assert!(!app(&window).logs.shown.reviewing.has_boxes());
    let add = Edit::Add { mark: found[1].mark.clone(), class: 0 };
    let app_now = &mut window.state_mut().app;
    app_now.apply(Command::Edit { edit: add, live: false });
    let beside = app_now.logs.shown.review_path().expect("a place for the review");
    assert_eq!(beside, folder.path().join("other.review.json"));
    // The same file, spelt in another way.
    app_now.apply(Command::Write(FileToWrite::Review(folder.path().join(".").join("other.sl2"))));
    assert_eq!(fs::read(&log).expect("the log").len(), bytes.len() / 2, "the log stays");
    window.state_mut().app.apply(Command::Write(FileToWrite::Review(beside)));
    window.state_mut().app.apply(Command::Open(pond));
    window.run();
    assert_eq!(states(&window), decided);
    let mut fresh = demo_window();
    fresh.state_mut().app.apply(Command::Open(log));
    fresh.run();
    assert_eq!(states(&fresh), [State::Added], "found next to the log");
}

#[test]
fn the_confidence_slider_hides_proposals_but_no_decisions() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut window = demo_window();
    let found = detections(&window, 10);
    propose(&mut window, &found, folder.path());
    open_step(&mut window, WorkStep::Objects);
    press(&mut window, Modifiers::NONE, Key::F);
    app_mut(&mut window).apply(Command::Edit { edit: Edit::Reject(BoxId(1)), live: false });
    window.run();
    window.get_by_label_contains("1 of 10 decided");
    window.get_by_label_contains(", 10 boxes in view");
    let slider = window.get_by_role_and_label(Role::Slider, "Least score");
    slider.set_value_accesskit(0.62);
    window.run();
    let sure = found.iter().skip(1).filter(|found| found.score >= 0.62).count();
    assert!((1..9).contains(&sure));
    let counts = app(&window).logs.shown.reviewing.counts();
    assert_eq!((counts.rejected, counts.proposed), (1, sure));
    window.get_by_label_contains(&format!(", {} boxes in view", sure + 1));
    let below = bathyscope_bottom::presentation::text::plural(9 - sure, "proposal", "proposals");
    window.get_by_label_contains(&format!("{below} below the least score"));
}

fn app_mut(window: &mut Window) -> &mut bathyscope::app::App {
    &mut window.state_mut().app
}

#[test]
fn what_is_written_about_a_box_is_kept_when_the_next_one_is_selected() {
    let (_folder, mut window) = proposed(4);
    press(&mut window, Modifiers::NONE, Key::Tab);
    let id = selected(&window);
    let note = window.get_by_role_and_label(Role::TextInput, "Note on the box");
    note.focus();
    window.run();
    let note = window.get_by_role_and_label(Role::TextInput, "Note on the box");
    note.type_text("two tyres, see dive 3");
    window.run();
    assert_eq!(states(&window), [State::Proposed; 4], "letters are text here");
    press(&mut window, Modifiers::NONE, Key::Enter);
    assert_eq!(
        review_of(&window).get(id).map(|review_box| review_box.note.as_str()),
        Some("two tyres, see dive 3")
    );
}
