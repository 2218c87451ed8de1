//! Boxes of several logs in one window: one queue, one list of objects, decisions about an object
//! in all logs that saw it.

use crate::logs_window::{ids, names, opened, opened_in, settle};
use crate::many_logs::{sailed, true_box, write_logs};
use crate::review::search::{model, until};
use crate::support::real_data;
use crate::window::{Window, app, drawn_window, open_step, press, settle as drawn};
use bathyscope::app::{
    Action, App, Command, FileToOpen, FileToWrite, Jobs, LogBox, LogId, Object, ObjectState,
    WorkStep,
};
use bathyscope_log::survey::{Identity, Side};
use bathyscope_objects::Detection;
use bathyscope_objects::review::{Edit, Review, State};
use egui::accesskit::Role;
use egui::{Key, Modifiers};
use egui_kittest::kittest::Queryable as _;
use std::path::Path;
use std::sync::Arc;

/// Proposes the boxes of a detector that sees all objects in every log, each log with a list of
/// classes of its own.
fn propose(window: &mut Window, folder: &Path) {
    for (index, id) in ids(window).into_iter().enumerate() {
        window.state_mut().app.apply(Command::ShowLog(id));
        settle(window);
        let survey = app(window).logs.shown.survey.clone().expect("a log");
        let truth = sailed(index);
        let seen = truth.objects.iter().flat_map(|object| &object.sightings);
        let marks = seen.filter_map(|seen| true_box(&survey, seen));
        let classes: Vec<String> = match index % 2 {
            0 => vec!["block".to_owned(), "rock".to_owned()],
            _ => vec!["tyre".to_owned(), "block".to_owned()],
        };
        let found: Vec<Detection> = marks
            .enumerate()
            .map(|(number, mark)| Detection {
                class: index % 2,
                score: 0.9 - 0.01 * number as f32,
                mark,
            })
            .collect();
        let raster = app(window).logs.shown.reviewing.raster().expect("a raster");
        let empty = Review::new(Identity::of(&survey), classes.clone());
        let review = empty.adopt("all of them", &classes, &found, raster, 0..usize::MAX);
        let path = folder.join(format!("{index}.json"));
        std::fs::write(&path, review.to_json()).expect("a file");
        window.state_mut().app.apply(Command::OpenFile(FileToOpen::Review(path)));
        settle(window);
    }
    let first = ids(window)[0];
    window.state_mut().app.apply(Command::ShowLog(first));
    while !app(window).notices.shown().is_empty() {
        window.state_mut().app.apply(Command::Dismiss(0));
    }
    settle(window);
}

/// Two logs with their boxes.
pub(super) fn proposed() -> (tempfile::TempDir, Window) {
    proposed_of(2)
}

/// Opens a number of logs with their boxes.
pub(super) fn proposed_of(logs: usize) -> (tempfile::TempDir, Window) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut window = opened(folder.path(), logs);
    propose(&mut window, folder.path());
    (folder, window)
}

/// The object that lies where an object of the lake does, with the most boxes. All logs lie in the
/// plane of the first.
pub(super) fn object_of(window: &Window, index: usize) -> Object {
    let truth = &sailed(0).objects[index];
    let off_m = |object: &&Object| {
        let [east_m, north_m] = object.place_m;
        f64::hypot(east_m - truth.east_m, north_m - truth.north_m)
    };
    let near = app(window).objects.all().iter().filter(|object| off_m(object) < 1.0);
    let most = near.max_by_key(|object| object.boxes.len());
    most.expect("an object").clone()
}

fn states(window: &Window, boxes: &[LogBox]) -> Vec<State> {
    let state = |id: &LogBox| app(window).logs.log_box(*id).expect("a box").state;
    boxes.iter().map(state).collect()
}

fn all_boxes(window: &Window) -> Vec<LogBox> {
    let logs = app(window).logs.all();
    logs.flat_map(|log| {
        let boxes = log.reviewing.review.boxes();
        boxes.map(|review_box| LogBox { log: log.id, id: review_box.id })
    })
    .collect()
}

fn selected(window: &Window) -> LogBox {
    app(window).logs.shown.selected_box().expect("a selected box")
}

#[test]
fn an_object_of_two_logs_is_one_in_the_list_and_leads_to_both() {
    let (_folder, mut window) = proposed();
    for index in 0..4 {
        let object = object_of(&window, index);
        assert_eq!(object.logs(), ids(&window), "{index}: {object:?}");
        assert_eq!(object.class, "block", "classes are compared by name");
    }
    let object = object_of(&window, 1);
    let (first, second) = (ids(&window)[0], ids(&window)[1]);
    let (times, boxes) = (object.sightings, object.boxes.len());
    assert!(times <= boxes, "a pass that both sides saw counts once");
    let name = format!("Object {}, block, seen {times} times, undecided", object.number);
    press(&mut window, Modifiers::NONE, Key::Num4);
    window.get_by_label(&name).click_accesskit();
    settle(&mut window);
    assert_eq!(selected(&window).log, first, "first in the log that is shown");
    assert!(object.boxes.contains(&selected(&window)));
    let passes = app(&window).selected_object_passes().expect("they are counted");
    assert!(passes.seen == times && passes.covered >= times);
    let seen = format!("{times} of {} passes, in 2 logs", passes.covered);
    window.get_by_label_contains(&seen);

    // Its pictures are of both logs; one of the other log leads there.
    let other = object.boxes.iter().find(|id| id.log == second);
    let other = *other.expect("a box of the other log");
    for id in &object.boxes {
        let log = app(&window).logs.get(id.log).expect("it is open").name();
        window.get_by_label(&format!("Sighting in {log}, box {}", id.id.0));
    }
    let picture = format!("Sighting in lake-1, box {}", other.id.0);
    window.get_by_label(&picture).click_accesskit();
    settle(&mut window);
    assert_eq!(selected(&window), other);
    assert_eq!(app(&window).logs.shown.name(), "lake-1");
    let mark = &app(&window).logs.log_box(other).expect("a box").mark;
    let ping = app(&window).view.selection.expect("it is revealed").ping;
    assert!(mark.pings.contains(&ping));

    // The key walks through them all, and around.
    let mut walked = vec![selected(&window)];
    for _ in 1..boxes {
        press(&mut window, Modifiers::NONE, Key::J);
        walked.push(selected(&window));
    }
    press(&mut window, Modifiers::NONE, Key::J);
    assert_eq!(selected(&window), other);
    walked.sort();
    assert_eq!(walked, object.boxes);
}

#[test]
fn an_object_is_decided_in_all_its_logs_as_one_step() {
    let (folder, mut window) = proposed();
    let object = object_of(&window, 2);
    let rest = |window: &Window| {
        let mut rest = all_boxes(window);
        rest.retain(|id| !object.boxes.contains(id));
        states(window, &rest)
    };
    let before = app(&window).document.history.undo_label().map(str::to_owned);
    window.state_mut().app.apply(Command::SelectLogBox(object.boxes[0]));
    settle(&mut window);
    for (key, state, label) in
        [(Key::A, State::Accepted, "accept object"), (Key::R, State::Rejected, "reject object")]
    {
        press(&mut window, Modifiers::SHIFT, key);
        settle(&mut window);
        let decided = states(&window, &object.boxes);
        assert!(decided.iter().all(|decision| *decision == state), "{decided:?}");
        let mut others = rest(&window).into_iter();
        assert!(others.all(|decision| decision == State::Proposed));
        let undo = app(&window).document.history.undo_label().expect("a step");
        assert!(undo.starts_with(label), "{undo}");
        // On to a box that is undecided; the object keeps its number.
        assert!(!object.boxes.contains(&selected(&window)));
        let same = app(&window).objects.of_box(object.boxes[0]).expect("an object");
        assert_eq!((same.number, &same.boxes), (object.number, &object.boxes));
        assert!(!matches!(same.state, ObjectState::Undecided));

        press(&mut window, Modifiers::COMMAND, Key::Z);
        settle(&mut window);
        let undone = states(&window, &all_boxes(&window));
        assert!(undone.iter().all(|decision| *decision == State::Proposed));
        assert_eq!(app(&window).document.history.undo_label(), before.as_deref());
        assert!(object.boxes.contains(&selected(&window)), "undo leads back");
    }
    // Taken back without undo, and without moving on.
    press(&mut window, Modifiers::SHIFT, Key::A);
    (window.state_mut().app).apply(Command::SelectLogBox(object.boxes[0]));
    settle(&mut window);
    press(&mut window, Modifiers::SHIFT, Key::U);
    settle(&mut window);
    let open = states(&window, &object.boxes);
    assert!(open.iter().all(|decision| *decision == State::Proposed), "{open:?}");
    assert_eq!(selected(&window), object.boxes[0]);

    // Every log's decisions go into the file of that log.
    press(&mut window, Modifiers::SHIFT, Key::A);
    window.state_mut().app.apply(Command::Write(FileToWrite::Reviews));
    settle(&mut window);
    let accepted = |name: &str| {
        let text = std::fs::read_to_string(folder.path().join(name)).expect("a review");
        text.matches("accepted").count()
    };
    assert!(accepted("0.json") > 0 && accepted("1.json") > 0);
    assert_eq!(accepted("0.json") + accepted("1.json"), object.boxes.len());
    assert!(app(&window).logs.all().all(|log| !log.reviewing.is_unsaved()));
    press(&mut window, Modifiers::COMMAND, Key::Z);
    settle(&mut window);

    // One sighting is none: it leaves the object, which keeps its number and the others.
    press(&mut window, Modifiers::NONE, Key::R);
    settle(&mut window);
    let left = object_of(&window, 2);
    assert_eq!(left.number, object.number);
    assert_eq!(left.boxes.len(), object.boxes.len() - 1);
}

#[test]
fn the_list_is_sorted_by_how_often_an_object_was_seen() {
    let (_folder, mut window) = proposed();
    press(&mut window, Modifiers::NONE, Key::Num4);
    settle(&mut window);
    let times = |window: &Window| -> Vec<usize> {
        let mut rows: Vec<(f32, usize)> = app(window)
            .objects
            .all()
            .iter()
            .map(|object| {
                let name = format!("Object {}, ", object.number);
                let row = window.get_by_label_contains(&name);
                (row.rect().top(), object.sightings)
            })
            .collect();
        rows.sort_by(|a, b| a.0.total_cmp(&b.0));
        rows.into_iter().map(|(_, times)| times).collect()
    };
    let by_number: Vec<usize> =
        (app(&window).objects.all().iter()).map(|object| object.sightings).collect();
    assert_eq!(times(&window), by_number);
    assert!(!by_number.is_sorted_by(|a, b| a >= b), "{by_number:?}");
    window.get_by_label("Sort objects by seen").click_accesskit();
    settle(&mut window);
    let sorted = times(&window);
    assert!(sorted.is_sorted_by(|a, b| a >= b), "{sorted:?}");
    // Another click turns it around.
    window.get_by_label("Sort objects by seen, falling").click_accesskit();
    settle(&mut window);
    let rising = times(&window);
    assert!(rising.is_sorted(), "{rising:?}");

    // The filter leaves what has the name.
    let object = object_of(&window, 1);
    let edit = Edit::Rename(object.boxes[0].id, "Anna".to_owned());
    (window.state_mut().app).apply(Command::EditIn(object.boxes[0].log, edit));
    settle(&mut window);
    let field = "Filter of the objects";
    (window.get_by_role_and_label(Role::TextInput, field)).focus();
    window.run();
    (window.get_by_role_and_label(Role::TextInput, field)).type_text("ann");
    settle(&mut window);
    assert_eq!(app(&window).objects.listed(), [object.number]);
    let name = format!("Object {}, Anna, block", object.number);
    window.get_by_label_contains(&name);
    window.get_by_label_contains("by the filter");
}

#[test]
fn the_table_is_walked_through_by_keys() {
    let (_folder, mut window) = proposed();
    press(&mut window, Modifiers::NONE, Key::Num4);
    settle(&mut window);
    let rows = app(&window).objects.listed().to_vec();
    let last = rows[rows.len() - 1];
    window.get_by_label(&format!("Objects, {} rows, none selected", rows.len()));
    let walk = [
        (Key::ArrowDown, rows[0]),
        (Key::ArrowDown, rows[1]),
        (Key::ArrowUp, rows[0]),
        (Key::End, last),
        (Key::ArrowDown, last),
        (Key::Home, rows[0]),
    ];
    for (key, expected) in walk {
        press(&mut window, Modifiers::NONE, key);
        settle(&mut window);
        let object = app(&window).selected_object().expect("an object");
        assert_eq!(object.number, expected, "{key:?}");
        // Its box is revealed in the views.
        let ping = app(&window).view.selection.expect("a selected ping").ping;
        let mark = &app(&window).logs.log_box(selected(&window)).expect("a box").mark;
        assert!(mark.pings.contains(&ping), "{key:?}");
    }
    let waterfall = "Waterfall, pings";
    assert!(window.query_by_label_contains(waterfall).is_none());
    press(&mut window, Modifiers::NONE, Key::Enter);
    settle(&mut window);
    assert!(window.query_by_label_contains(waterfall).is_some());
    let reveal = app(&window).view.reveal.expect("a place");
    assert!(reveal.close_up.is_some(), "it is enlarged");
    // A digit would name the class of the box now.
    press(&mut window, Modifiers::COMMAND, Key::T);
    settle(&mut window);
    window.get_by_label(&format!("Objects, row 1 of {} selected", rows.len()));
}

#[test]
fn a_note_stays_with_the_box_of_its_log() {
    let (_folder, mut window) = proposed();
    let object = object_of(&window, 1);
    let mine = object.boxes[0];
    let other = *object.boxes.last().expect("a box");
    assert_ne!(mine.log, other.log);
    (window.state_mut().app).apply(Command::SelectLogBox(mine));
    settle(&mut window);
    let line = "Note on the box";
    (window.get_by_role_and_label(Role::TextInput, line)).focus();
    window.run();
    (window.get_by_role_and_label(Role::TextInput, line)).type_text("a tyre");
    window.run();
    // The place of the log that is shown, and with it the box, are others before the line has lost
    // the keyboard.
    (window.state_mut().app).apply(Command::SelectLogBox(other));
    settle(&mut window);
    let note = |id: LogBox| app(&window).logs.log_box(id).expect("a box").note.clone();
    assert_eq!([note(mine), note(other)], ["a tyre", ""]);
    assert_eq!(selected(&window), other);
}

/// Log and number of every box that Tab comes to from the first one on.
fn walk(window: &mut Window, count: usize) -> Vec<LogBox> {
    let mut walked = Vec::new();
    for _ in 0..count {
        press(window, Modifiers::NONE, Key::Tab);
        walked.push(selected(window));
    }
    walked
}

#[test]
fn the_queue_goes_on_into_the_next_log() {
    let (_folder, mut window) = proposed();
    let all = all_boxes(&window);
    let (first, second) = (ids(&window)[0], ids(&window)[1]);
    let of = |log: LogId| all.iter().filter(|id| id.log == log).count();
    assert!(of(first) > 1 && of(second) > 1);
    open_step(&mut window, WorkStep::Objects);
    let said = format!("0 of {} decided in 2 logs", all.len());
    window.get_by_label(&said);
    let walked = walk(&mut window, all.len());
    let logs: Vec<LogId> = walked.iter().map(|id| id.log).collect();
    let expected = [vec![first; of(first)], vec![second; of(second)]].concat();
    assert_eq!(logs, expected, "log after log, in the order of the list");
    let score = |id: &LogBox| app(&window).logs.log_box(*id).expect("a box").score;
    let of_first: Vec<_> = walked[..of(first)].iter().map(score).collect();
    assert!(of_first.is_sorted_by(|a, b| a >= b), "the surest first");
    let last = selected(&window);
    press(&mut window, Modifiers::NONE, Key::Tab);
    assert_eq!(selected(&window), last, "at the end it stays");

    // Back into the first log, and a decision about its last box leads on into the second again.
    for _ in 0..of(second) {
        press(&mut window, Modifiers::SHIFT, Key::Tab);
    }
    assert_eq!(selected(&window), walked[of(first) - 1]);
    press(&mut window, Modifiers::NONE, Key::A);
    assert_eq!(selected(&window), walked[of(first)]);
    window.get_by_label(&said.replacen('0', "1", 1));

    // The filter is one over all logs, by the name of the class.
    let mut queue = app(&window).logs.shown.reviewing.queue.clone();
    queue.filter.class = Some("tyre".to_owned());
    (window.state_mut().app).apply(Command::LineUp(Box::new(queue.clone())));
    settle(&mut window);
    assert_eq!(app(&window).logs.review_counts().in_line, 0);
    queue.filter.class = Some("block".to_owned());
    (window.state_mut().app).apply(Command::LineUp(Box::new(queue)));
    settle(&mut window);
    assert_eq!(app(&window).logs.review_counts().in_line, all.len());

    // A log that is unticked takes no part once another one is shown.
    window.state_mut().app.apply(Command::ShowLog(first));
    (window.state_mut().app).apply(Command::SetLogVisible(second, false));
    settle(&mut window);
    window.get_by_label(&format!("1 of {} decided", of(first)));
    let objects = app(&window).objects.all();
    assert!(objects.iter().all(|object| object.logs() == [first]));
}

#[test]
fn a_search_goes_through_all_logs_as_one_step() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut window = opened(folder.path(), 2);
    let second = ids(&window)[1];
    (window.state_mut().app).apply(Command::SetLogVisible(second, false));
    (window.state_mut().app).apply(Command::UseModel(model("end_to_end")));
    settle(&mut window);
    let find = |window: &mut Window| {
        let app = &mut window.state_mut().app;
        app.apply(Command::Do(Action::FindObjects));
        settle(window);
    };
    let found = |window: &Window| -> Vec<usize> {
        let logs = app(window).logs.all();
        logs.map(|log| log.reviewing.review.boxes().len()).collect()
    };
    find(&mut window);
    let [count, 0] = found(&window)[..] else { panic!("{:?}", found(&window)) };
    assert!(count > 10, "{count}");
    (window.state_mut().app).apply(Command::SetLogVisible(second, true));
    settle(&mut window);
    find(&mut window);
    let [again, other] = found(&window)[..] else { panic!("two logs") };
    assert_eq!(again, count, "each once");
    assert!(other > 10, "{other}");
    assert_eq!(names(&window).len(), 2);
    assert_eq!(app(&window).logs.shown.name(), "lake-0", "the log that is shown stays");
    let logs = || app(&window).logs.all().map(|log| &log.reviewing);
    assert!(logs().all(|reviewing| reviewing.review.coverage().is_none()));
    // From the confidence of the model on, in both logs.
    let threshold = app(&window).logs.shown.reviewing.queue.threshold;
    assert!(logs().all(|reviewing| reviewing.queue.threshold == threshold));
    press(&mut window, Modifiers::COMMAND, Key::Z);
    settle(&mut window);
    assert_eq!(found(&window), [count, 0], "one step for all logs");
}

#[test]
fn a_search_that_is_stopped_in_the_second_log_keeps_what_it_found() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    write_logs(folder.path(), 2);
    let mut app = App::new(Jobs::Threads(Arc::new(|| ())));
    let logs = ["lake-0.sl2", "lake-1.sl2"].map(|name| folder.path().join(name));
    app.apply(Command::OpenAll(logs.to_vec()));
    // The second one is searched once it has results.
    until(&mut app, &|app| app.logs.count() == 2 && app.logs.shown.products.is_some());
    let ids: Vec<LogId> = app.logs.all().map(|log| log.id).collect();
    app.apply(Command::UseModel(model("tianxiaomo")));
    app.apply(Command::Do(Action::FindObjects));
    let status = app.search_status().expect("a search");
    assert_eq!((status.log, status.place, status.logs), (Some(ids[0]), 1, 2));
    app.apply(Command::ShowLog(ids[1]));
    let note = app.search_note().expect("it waits");
    assert!(note.contains("has not been searched yet"), "{note}");
    until(&mut app, &|app| {
        let status = app.search_status();
        status.is_some_and(|status| status.log == Some(ids[1]))
    });
    let status = app.search_status().expect("a search");
    assert!(status.place == 2 && status.share >= 0.5, "{status:?}");
    app.apply(Command::Do(Action::Cancel));
    until(&mut app, &App::is_idle);
    assert_eq!(app.search_status(), None);
    let review = |app: &App, index: usize| {
        let log = app.logs.get(ids[index]).expect("it is open");
        log.reviewing.review.clone()
    };
    let first = review(&app, 0);
    assert!(first.boxes().len() > 0 && first.unsearched().is_empty());
    // One step for both.
    assert_eq!(app.document.history.undo_label(), Some("find objects of lake-0"));
    app.apply(Command::Do(Action::Undo));
    for index in 0..2 {
        assert_eq!(review(&app, index).boxes().len(), 0);
    }
    assert_ne!(app.document.history.undo_label(), Some("find objects"));
}

/// Copies of the river in two formats, with a mark on either side of its boat: marks are kept
/// beside the log.
fn marked_river(mut window: Window, folder: &Path) -> Option<Window> {
    let real = real_data()?.join("lowrance");
    let logs = ["glencanyon-transcoded.sl2", "glencanyon-transcoded.sl3"];
    let logs = logs.map(|name| {
        let log = folder.join(name);
        std::fs::copy(real.join(name), &log).expect("room");
        log
    });
    let logs = logs.to_vec();
    (window.state_mut().app).apply(Command::OpenAll(logs));
    settle(&mut window);
    for (ping, side) in [(1344, Side::Port), (1345, Side::Starboard)] {
        let survey = app(&window).logs.shown.survey.clone().expect("a log");
        let depth_m = f64::from(survey.good_depth_m(ping));
        let edit = Edit::AddPoint { side, ping, range_m: 1.01 * depth_m, class: 0 };
        let live = false;
        (window.state_mut().app).apply(Command::Edit { edit, live });
        settle(&mut window);
    }
    Some(window)
}

#[test]
fn marks_on_both_sides_of_one_pass_are_one_sighting_also_where_two_logs_have_the_pass() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let Some(window) = marked_river(opened(folder.path(), 1), folder.path()) else {
        return;
    };
    let object = app(&window).selected_object().expect("an object");
    assert_eq!((object.boxes.len(), object.sightings), (2, 1));
    let passes = app(&window).selected_object_passes().expect("counted");
    assert_eq!([passes.seen, passes.covered], [1, 1]);
    window.get_by_label_contains("1 of 1 pass, in 1 log, 2 boxes");
}

#[test]
fn the_window_with_an_object_of_four_logs_looks_as_it_did() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let window = drawn_window([1400.0, 1220.0]);
    let mut window = opened_in(window, folder.path(), 4);
    propose(&mut window, folder.path());
    let object = object_of(&window, 0);
    assert_eq!(object.logs().len(), 4);
    let app = &mut window.state_mut().app;
    app.apply(Command::SelectLogBox(object.boxes[0]));
    app.view.options.map.track_by_log = true;
    drawn(&mut window);
    window.snapshot("window_objects");
}
