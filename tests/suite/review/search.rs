//! The search for objects in the window, and the look of a review.

use super::*;
use crate::window::open_step;
use bathyscope::app::WorkStep;
use bathyscope_objects::truth::Mistake;

/// A small model of random weights: it finds things everywhere, fast.
pub(crate) fn model(name: &str) -> PathBuf {
    bathyscope_test_support::detector_models().join(format!("{name}.onnx"))
}

#[test]
fn objects_are_found_by_a_button_and_found_again_without_losing_a_decision() {
    let mut window = demo_window();
    app_mut(&mut window).apply(Command::UseModel(model("end_to_end")));
    window.run();
    open_step(&mut window, WorkStep::Objects);
    // The table of objects offers it, too; the first button is that of the panel.
    let button = window.get_all_by_label("Find objects").next();
    button.expect("the search is offered").click_accesskit();
    window.run();
    let found = review_of(&window).boxes().len();
    assert!(found > 100, "{found}");
    assert!(review_of(&window).classes().contains(&"log".to_owned()));
    assert!(window.query_by_label_contains("end_to_end.onnx").is_some());
    assert!(!app(&window).logs.shown.reviewing.is_unsaved(), "proposals are no loss");
    press(&mut window, Modifiers::NONE, Key::Tab);
    let id = selected(&window);
    press(&mut window, Modifiers::NONE, Key::R);
    window.get_by_label("Find objects").click_accesskit();
    window.run();
    assert_eq!(
        review_of(&window).get(id).map(|review_box| review_box.state),
        Some(State::Rejected)
    );
    assert_eq!(review_of(&window).boxes().len(), found, "each once");
    press(&mut window, Modifiers::COMMAND, Key::Z);
    press(&mut window, Modifiers::COMMAND, Key::Z);
    press(&mut window, Modifiers::COMMAND, Key::Z);
    assert!(!app(&window).logs.shown.reviewing.has_boxes());

    app_mut(&mut window).apply(Command::UseModel(model("nms_inside")));
    app_mut(&mut window).apply(Command::Do(Action::FindObjects));
    window.run();
    let notice = app(&window).notices.shown().last().expect("a refusal");
    assert!(notice.is_error && notice.text.contains("nms_inside"), "{notice:?}");
}

/// Lets workers go on until something is there.
pub(crate) fn until(app: &mut App, done: &dyn Fn(&App) -> bool) {
    for () in bathyscope_test_support::attempts() {
        app.poll();
        if done(app) {
            return;
        }
        std::thread::sleep(std::time::Duration::from_millis(10));
    }
    panic!("it does not end");
}

#[test]
fn boxes_come_while_the_search_runs_and_stay_when_it_is_stopped() {
    let mut app = App::new(Jobs::Threads(Arc::new(|| ())));
    app.apply(Command::OpenDemo);
    until(&mut app, &|app| app.logs.shown.products.is_some() && app.is_idle());
    app.apply(Command::UseModel(model("tianxiaomo")));
    app.apply(Command::Do(Action::FindObjects));
    until(&mut app, &|app| app.logs.shown.reviewing.has_boxes());
    assert!(app.search_status().is_some(), "it still runs");
    let note = app.search_note().expect("a search that runs");
    assert!(note.contains("is running: pings 0 to "), "{note}");
    app.apply(Command::Do(Action::Cancel));
    until(&mut app, &App::is_idle);
    assert!(app.search_status().is_none() && app.logs.shown.reviewing.has_boxes());
    // What was searched is known, and judged alone; tiles that overlap found nothing twice.
    let review = app.logs.shown.reviewing.review.clone();
    let [gap] = &review.unsearched()[..] else {
        panic!("{:?}", review.searched());
    };
    assert!(gap.start > 0 && gap.end == review.identity().pings);
    assert!(review.boxes().all(|review_box| review_box.mark.pings.end <= gap.start));
    let note = app.search_note().expect("a search that was stopped");
    let covered = format!("covers pings 0 to {} of {}", gap.start - 1, gap.end);
    assert!(note.contains("was stopped") && note.contains(&covered), "{note}");
    let comparison = app.logs.shown.reviewing.judging.comparison().expect("the truth");
    assert!(comparison.unsearched > 0);
    let standing = app.logs.shown.reviewing.judging.standing().expect("a standing");
    let truth = &comparison.truth().objects;
    for mistake in &standing.mistakes {
        if let Mistake::Miss { object, .. } = mistake {
            let at = &truth[*object].whole.pings;
            assert!(at.end <= gap.start, "{at:?} was not searched");
        }
    }
    // The file keeps it.
    let kept = Review::from_json(&review.to_json(), review.identity()).expect("our own file");
    assert_eq!(kept.searched(), review.searched());
    assert_eq!(app.document.history.undo_label(), Some("find objects"));
    app.apply(Command::Do(Action::Undo));
    assert!(!app.logs.shown.reviewing.has_boxes() && app.search_note().is_none());
}

#[test]
fn a_search_that_was_stopped_does_not_look_finished() {
    let (folder, mut window) = proposed(6);
    assert!(window.query_by_label_contains("The search was").is_none());
    let review = review_of(&window);
    let (names, found) = (review.classes().to_vec(), detections(&window, 6));
    let half = review.identity().pings / 2;
    let first: Vec<Detection> =
        (found.into_iter()).filter(|detection| detection.mark.pings.end <= half).collect();
    let empty = Review::new(identity(&window), names.clone());
    let part = empty.adopt("a model", &names, &first, &raster(&window), 0..half);
    let path = folder.path().join("part.review.json");
    fs::write(&path, part.to_json()).expect("a file");
    app_mut(&mut window).apply(Command::OpenFile(FileToOpen::Review(path)));
    window.run();
    press(&mut window, Modifiers::NONE, Key::Tab);
    for _ in &first {
        press(&mut window, Modifiers::NONE, Key::A);
    }
    press(&mut window, Modifiers::NONE, Key::Escape);
    assert_eq!(app(&window).logs.shown.reviewing.counts().proposed, 0);
    let covered = format!("The search was stopped: it covers pings 0 to {}", half - 1);
    assert!(window.get_all_by_label_contains(&covered).count() > 0);
    for finished in ["All boxes in sight are decided", "all decided"] {
        assert!(window.query_by_label_contains(finished).is_none(), "{finished}");
    }
    // The report says so as well.
    let products = folder.path().join("products");
    (window.state_mut().app).apply(Command::Write(FileToWrite::Products(products.clone())));
    window.run();
    let page = fs::read_to_string(products.join("report.html")).expect("a report");
    assert!(page.contains(&covered), "the report");
}

/// Returns the detections of a perfect detector in the demo: each sighting of each object, with its
/// shadow.
pub(super) fn truth(window: &Window) -> (Vec<String>, Vec<Detection>) {
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
                    far_m: if end_m.is_finite() { end_m } else { sighting.far_m },
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
    let review = review.adopt("truth of the demo", &names, &found, &raster(&window), 0..usize::MAX);
    let path = folder.path().join("demo.review.json");
    fs::write(&path, review.to_json()).expect("a file");
    app_mut(&mut window).apply(Command::OpenFile(FileToOpen::Review(path)));
    window.run();
    app_mut(&mut window).apply(Command::Dismiss(0));
    let by_place = review.boxes().map(|review_box| (review_box.mark.pings.start, review_box.id));
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
