//! The boxes against the truth, as the analyst sees it: curve, figures, list of mistakes, missed
//! objects.

use super::*;
use bathyscope::app::MistakeSort;
use bathyscope_objects::truth::{Mistake, SurveyTruth};
use egui_kittest::kittest::NodeT as _;

/// The demo, whose truth is known, with what a detector would find that misses two objects and sees
/// two where nothing is.
fn judged() -> (tempfile::TempDir, Window) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut window = demo_window();
    propose_with_mistakes(&mut window, folder.path());
    open_step(&mut window, WorkStep::Objects);
    (folder, window)
}

fn propose_with_mistakes(window: &mut Window, folder: &Path) {
    // Without boxes every object that counts is a miss.
    let judging = &app(window).logs.shown.reviewing.judging;
    let truth = judging.comparison().expect("the truth").truth().clone();
    let seen: Vec<usize> = judging.mistakes().iter().filter_map(missed).collect();
    assert!(seen.len() > 10, "{seen:?}");
    let detection = |(index, object): (usize, &usize)| Detection {
        class: truth.objects[*object].class,
        score: 0.95 - 0.6 * index as f32 / seen.len() as f32,
        mark: truth.objects[*object].whole.clone(),
    };
    let mut found: Vec<Detection> = seen.iter().skip(2).enumerate().map(detection).collect();
    let names = truth.classes.clone();
    let ghosts = [(100, 0.61), (900, 0.33)].map(|(ping, score)| Detection {
        class: 1,
        score,
        mark: Mark { side: Side::Starboard, pings: ping..ping + 9, near_m: 9.0, far_m: 10.0 },
    });
    found.extend(ghosts);
    let review = Review::new(identity(window), names.clone());
    let review = review.adopt("a model", &names, &found, &raster(window), 0..usize::MAX);
    let path = folder.join("demo.review.json");
    fs::write(&path, review.to_json()).expect("a file");
    app_mut(window).apply(Command::OpenFile(FileToOpen::Review(path)));
    window.run();
}

fn missed(mistake: &Mistake) -> Option<usize> {
    match mistake {
        Mistake::Miss { object, .. } => Some(*object),
        Mistake::FalseAlarm { .. } => None,
    }
}

fn slide(window: &mut Window, confidence: f64) {
    let slider = window.get_by_role_and_label(Role::Slider, "Least score");
    slider.set_value_accesskit(confidence);
    window.run();
}

fn counts(window: &Window) -> [usize; 3] {
    let standing = app(window).logs.shown.reviewing.judging.standing().expect("a standing");
    let counts = standing.counts;
    [counts.found, counts.false_alarms, counts.missed()]
}

#[test]
fn the_slider_runs_along_the_curve_and_every_figure_follows() {
    let (_folder, mut window) = judged();
    let [found, false_alarms, missed] = counts(&window);
    assert_eq!([false_alarms, missed], [2, 2]);
    let said = format!("{found} found, 2 false alarms, 2 missed");
    window.get_by_label_contains(&said);
    window.get_by_label_contains("at score 0.25 precision 0.");
    slide(&mut window, 0.5);
    let [fewer, ghosts, more_missed] = counts(&window);
    assert!(fewer < found && ghosts == 1);
    assert_eq!(fewer + more_missed, found + missed, "each object once");
    let precision = fewer as f64 / (fewer + 1) as f64;
    window.get_by_label_contains(&format!("at score 0.50 precision {precision:.2}"));
    // A decision about a box is none about the model; another class is.
    let right = review_of(&window).boxes().find(|review_box| review_box.score > Some(0.9));
    let (id, class) =
        right.map(|review_box| (review_box.id, review_box.class)).expect("a sure box");
    let edit = |edit: Edit| Command::Edit { edit, live: false };
    app_mut(&mut window).apply(edit(Edit::Accept(id)));
    window.run();
    assert_eq!(counts(&window), [fewer, ghosts, more_missed]);
    let other = review_of(&window).classes()[(class + 1) % 3].clone();
    app_mut(&mut window).apply(edit(Edit::Classify(id, other)));
    window.run();
    assert_eq!(counts(&window), [fewer - 1, ghosts + 1, more_missed + 1]);
    press(&mut window, Modifiers::COMMAND, Key::Z);
    assert_eq!(counts(&window), [fewer, ghosts, more_missed]);
}

#[test]
fn a_click_on_the_curve_sets_the_confidence() {
    let (_folder, mut window) = judged();
    let curve = window.get_by_label_contains("Precision-recall curve");
    // The lower right: all objects that can be found, whatever the precision.
    let at = curve.rect().right_bottom() - egui::vec2(7.0, 40.0);
    window.hover_at(at);
    window.drag_at(at);
    window.drop_at(at);
    window.run();
    let least = review_of(&window).boxes().filter_map(|review_box| review_box.score);
    let least = least.fold(1.0, f32::min);
    assert_eq!(app(&window).logs.shown.reviewing.queue.threshold, least);
    assert_eq!(counts(&window)[2], 2, "what has no box stays missed");
}

#[test]
fn mistakes_are_walked_by_keys_and_by_clicks_and_shown_on_the_waterfall() {
    let (_folder, mut window) = judged();
    press(&mut window, Modifiers::NONE, Key::F);
    window.get_by_label_contains(", 2 missed in view");
    press(&mut window, Modifiers::NONE, Key::Period);
    let ghost = review_of(&window).get(selected(&window)).expect("a box");
    assert_eq!(ghost.score, Some(0.61), "the surest false alarm first");
    let serial = |window: &Window| app(window).view.reveal.map(|reveal| reveal.serial);
    let before = serial(&window);
    for _ in 0..2 {
        press(&mut window, Modifiers::NONE, Key::Period);
    }
    let judging = &app(&window).logs.shown.reviewing.judging;
    let object = judging.missed.expect("a missed object");
    assert!(app(&window).logs.shown.reviewing.selected.is_none());
    let comparison = judging.comparison().expect("a comparison");
    let whole = comparison.truth().objects[object].whole.clone();
    let at = app(&window).view.selection.expect("a place");
    assert!(whole.pings.contains(&at.ping) && at.side == Some(whole.side));
    assert_eq!(serial(&window), before.map(|serial| serial + 2));
    press(&mut window, Modifiers::NONE, Key::Comma);
    let ghost = review_of(&window).get(selected(&window)).expect("a box");
    assert_eq!(ghost.score, Some(0.33));
    assert!(app(&window).logs.shown.reviewing.judging.missed.is_none());

    app_mut(&mut window).apply(Command::SortMistakes(MistakeSort::Size));
    window.run();
    let mistakes = app(&window).logs.shown.reviewing.judging.mistakes().to_vec();
    assert!(mistakes.is_sorted_by(|a, b| a.size_m() >= b.size_m()));
    let row = window
        .get_all_by_label_contains("missed ")
        .rfind(|node| node.accesskit_node().role() == Role::Button);
    // It may lie below the panel's edge.
    row.expect("a row").click_accesskit();
    window.run();
    let last = app(&window).logs.shown.reviewing.mistake_at().expect("a mistake");
    assert!(missed(&mistakes[last]).is_some());
}

#[test]
fn the_matrix_says_what_was_taken_for_what() {
    let (_folder, window) = judged();
    let name = review_of(&window).class_name(1).to_owned();
    window.get_by_label_contains(&format!("2 false alarms: {name}"));
    let matrix = window.get_by_label_contains("Confusion matrix, rows truth, columns proposed");
    let said = matrix.accesskit_node().label().expect("a name");
    let found = said.split("; ").filter_map(|cell| cell.split_once(" found: "));
    let count = |(count, _): (&str, &str)| count.rsplit(' ').next()?.parse::<usize>().ok();
    assert_eq!(found.filter_map(count).sum::<usize>(), counts(&window)[0]);
}

#[test]
fn truth_is_found_next_to_the_log_opened_by_path_and_left() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let log = folder.path().join("pond.sl2");
    fs::copy(crate::support::demo_log(), &log).expect("a log");
    let mut window = crate::window::empty_window();
    app_mut(&mut window).apply(Command::Open(log.clone()));
    window.run();
    assert!(app(&window).logs.shown.reviewing.judging.source().is_none());
    let table = folder.path().join("pond.objects.csv");
    fs::write(&table, include_str!("../../../assets/demo.objects.csv")).expect("a table");
    app_mut(&mut window).apply(Command::Open(log.clone()));
    window.run();
    let source = app(&window).logs.shown.reviewing.judging.source();
    assert_eq!(source.as_deref(), Some("pond.objects.csv"));
    app_mut(&mut window).apply(Command::Do(Action::ForgetTruth));
    window.run();
    assert!(window.query_by_label_contains("Precision-recall").is_none());

    // A review is truth too, by the menu's path field.
    press(&mut window, Modifiers::COMMAND, Key::P);
    window.get_by_label("Command").type_text("open known");
    window.run();
    press(&mut window, Modifiers::NONE, Key::Enter);
    let review = Review::new(identity(&window), classes());
    let drawn = Edit::Add {
        mark: Mark { side: Side::Port, pings: 10..20, near_m: 3.0, far_m: 5.0 },
        class: 0,
    };
    let review = review.apply(&drawn).expect("a box");
    let path = folder.path().join("known.review.json");
    fs::write(&path, review.to_json()).expect("a file");
    window
        .get_by_role_and_label(Role::TextInput, "Path of a table of objects or a review")
        .type_text(&path.to_string_lossy());
    window.run();
    window.get_by_label("Open").click();
    window.run();
    assert_eq!(counts(&window), [0, 0, 1]);
    // What belongs to another log is refused, and the truth stays.
    fs::write(
        &table,
        "kind,side,near_m,far_m,box_first_ping,box_last_ping,box_near_m,box_far_m,shown\nrock,port,1,2,0,99999,1,3,1\n",
    )
    .expect("a table");
    app_mut(&mut window).apply(Command::OpenFile(FileToOpen::Truth(table)));
    window.run();
    assert!(window.query_by_label_contains("ping 99999 is beyond").is_some());
    assert_eq!(counts(&window), [0, 0, 1]);
}

#[test]
fn the_table_of_the_demo_is_what_its_scene_gives() {
    let simulated = simulate(&Scene::demo(), 1, &Progress::new()).expect("the demo");
    let mut table = Vec::new();
    simulated.write_objects_csv(&mut table).expect("a table");
    let bundled = include_str!("../../../assets/demo.objects.csv");
    assert!(
        table == bundled.as_bytes(),
        "assets/demo.objects.csv is not what assets/demo.toml gives with seed 1"
    );
    let of = Identity {
        swapped_sides: false,
        file: "demo.sl2".into(),
        byte_count: 0,
        pings: simulated.pings.len(),
    };
    let read = SurveyTruth::parse(bundled, &of).expect("our own table");
    let mut sightings = simulated.objects.iter().flat_map(|object| {
        let name = object.kind.name();
        object.sightings.iter().map(move |sighting| (name, sighting))
    });
    for known in &read.objects {
        let (name, sighting) = sightings.next().expect("a sighting");
        assert_eq!(read.class_name(known.class), name);
        let (mark, [near_m, far_m]) = (&known.whole, sighting.echo_and_shadow_m());
        assert_eq!(mark.side, sighting.side);
        assert_eq!(mark.pings, sighting.pings(simulated.pings.len()));
        assert_eq!(known.shown, sighting.shown.is_some());
        assert!((mark.near_m - near_m).abs() < 1e-4 && (mark.far_m - far_m).abs() < 1e-4);
    }
    assert!(sightings.next().is_none());
}
