//! The guided step of the calibration in the window: a stretch is proposed, what it would change is
//! shown, and only then it is taken.

use crate::support::real_data;
use crate::window::{Window, app, demo_window, drop_file, empty_window, open_step, press};
use bathyscope::app::{Action, Command, LogPlace, Tool, WorkStep};
use bathyscope_bottom::calibration::{PingRange, ScaleMode};
use bathyscope_bottom::cloud::PointClass;
use bathyscope_log::survey::Side;
use egui::{Key, Modifiers};
use egui_kittest::kittest::{NodeT as _, Queryable as _};

fn apply(window: &mut Window, command: Command) {
    window.state_mut().app.apply(command);
    window.run();
}

fn act(window: &mut Window, action: Action) {
    apply(window, Command::Do(action));
}

/// Depths of the side-scan points that count.
fn depths_m(window: &Window) -> Vec<f64> {
    let products = app(window).logs.shown.products.as_ref().expect("results");
    products.kept_points().map(|point| -point.z_m).collect()
}

fn mode(window: &Window) -> ScaleMode {
    app(window).logs.shown.settings.calibration.mode
}

#[test]
fn a_proposal_changes_nothing_until_it_is_used_and_one_step_takes_it_back() {
    let mut window = demo_window();
    let before = depths_m(&window);
    press(&mut window, Modifiers::NONE, Key::C);
    assert_eq!(app(&window).logs.shown.reviewing.tool, Tool::Calibrate);
    let proposed = app(&window).logs.shown.proposed_stretch().expect("the best stretch");
    let trial = app(&window).logs.shown.scale_trial().expect("a trial").clone();
    assert_eq!(mode(&window), ScaleMode::Header);
    assert_eq!(depths_m(&window), before);
    assert_eq!(app(&window).document.history.undo_label(), None);
    // What is said beforehand is what comes of it.
    let effect = trial.effect.expect("an effect");
    assert!(window.query_by_label_contains("Proposed: pings").is_some());
    window.get_by_label("Use this scale").click();
    window.run();
    assert_eq!(mode(&window), ScaleMode::FlatSpot);
    assert_eq!(app(&window).logs.shown.settings.calibration.pings, Some(proposed));
    assert_eq!(app(&window).logs.shown.proposed_stretch(), None);
    assert_eq!(app(&window).logs.shown.reviewing.tool, Tool::Look);
    let notice = app(&window).notices.shown().last().expect("a notice").clone();
    assert_eq!(notice.offer, Some(Action::Undo));
    let said = format!("depths change by {:+.1} cm (median)", 100.0 * effect.change.median_m);
    assert!(notice.text.contains(&said), "{} for {said}", notice.text);
    let after = depths_m(&window);
    assert_ne!(after, before);
    act(&mut window, Action::Undo);
    assert_eq!(mode(&window), ScaleMode::Header);
    assert_eq!(depths_m(&window), before);
    let offered =
        app(&window).notices.shown().iter().any(|notice| notice.offer == Some(Action::Undo));
    assert!(!offered, "what was taken back is not offered any more");
}

#[test]
fn the_recorded_range_is_kept_or_taken_again() {
    let mut window = demo_window();
    let before = depths_m(&window);
    press(&mut window, Modifiers::NONE, Key::C);
    window.get_by_label("Keep the recorded range").click();
    window.run();
    assert_eq!(app(&window).logs.shown.proposed_stretch(), None);
    assert_eq!(app(&window).document.history.undo_label(), None, "nothing changed");
    press(&mut window, Modifiers::NONE, Key::Escape);
    press(&mut window, Modifiers::NONE, Key::C);
    act(&mut window, Action::UseScale);
    assert_eq!(mode(&window), ScaleMode::FlatSpot);
    act(&mut window, Action::KeepRecordedRange);
    assert_eq!(mode(&window), ScaleMode::Header);
    assert_eq!(app(&window).logs.shown.settings.calibration.pings, None);
    assert_eq!(depths_m(&window), before);
}

#[test]
fn a_drag_in_the_waterfall_proposes_its_pings_and_escape_leaves_tool_then_proposal() {
    let mut window = demo_window();
    act(&mut window, Action::Calibrate);
    let first = app(&window).logs.shown.proposed_stretch();
    let picture = window.get_by_label_contains("Waterfall, pings").rect();
    let seen = app(&window).view.visible.clone();
    let at = |share: f32| picture.left_center() + egui::vec2(picture.width() * share, -30.0);
    window.drag_at(at(0.40));
    window.step();
    window.hover_at(at(0.55));
    window.step();
    window.drop_at(at(0.55));
    window.run();
    let dragged = app(&window).logs.shown.proposed_stretch().expect("a proposal");
    assert_ne!(Some(dragged), first);
    let ping = |share: f64| seen.start as f64 + share * seen.len() as f64;
    assert!((dragged.start as f64 - ping(0.40)).abs() < 0.02 * seen.len() as f64, "{dragged:?}");
    assert!((dragged.end as f64 - ping(0.55)).abs() < 0.02 * seen.len() as f64, "{dragged:?}");
    assert_eq!(app(&window).document.history.undo_label(), None);
    press(&mut window, Modifiers::NONE, Key::Escape);
    assert_eq!(app(&window).logs.shown.reviewing.tool, Tool::Look);
    assert_eq!(app(&window).logs.shown.proposed_stretch(), Some(dragged));
    press(&mut window, Modifiers::NONE, Key::Escape);
    assert_eq!(app(&window).logs.shown.proposed_stretch(), None);
}

#[test]
fn a_stretch_that_is_worse_says_so_and_one_without_scale_cannot_be_used() {
    let Some(data) = real_data() else {
        return;
    };
    let mut window = empty_window();
    let river = data.join("humminbird-glen-canyon/Rec00001.DAT");
    drop_file(&mut window, river);
    let survey = app(&window).logs.shown.survey.clone().expect("the river");
    let lost: Vec<usize> = (0..survey.side_scan.len())
        .filter(|&ping| survey.side_scan[ping].depth_fault.is_some())
        .collect();
    let run = lost.chunk_by(|a, b| b - a == 1).max_by_key(|run| run.len());
    let run = run.expect("the recorder lost the bottom");
    let stretch = PingRange { start: run[0], end: run[run.len() - 1] + 1 };
    apply(&mut window, Command::ProposeStretch(stretch));
    let trial = app(&window).logs.shown.scale_trial().expect("a trial").clone();
    let why = trial.objections.join(" ");
    assert!(why.contains("lost the bottom"), "{stretch:?}: {why}");
    assert!(window.query_by_label_contains("The recorder had lost the bottom").is_some());
    act(&mut window, Action::UseScale);
    assert_eq!(mode(&window), ScaleMode::Header, "nothing to use");
    let notice = app(&window).notices.shown().last().expect("a notice");
    assert!(notice.is_error && notice.text.contains("lost the bottom"), "{notice:?}");
    // The start of the log, where the scale of single pings scatters by much.
    let start = PingRange { start: 0, end: 100 };
    apply(&mut window, Command::ProposeStretch(start));
    let trial = app(&window).logs.shown.scale_trial().expect("a trial").clone();
    println!("{}\n{:?}", trial.spot.summary(), trial.objections);
    assert!(!trial.objections.is_empty(), "{:?}", trial.spot);
}

#[test]
fn candidates_are_buttons_that_propose_and_say_what_is_worse() {
    let mut window = demo_window();
    window.set_size(egui::vec2(1400.0, 2800.0));
    window.run();
    let spots = app(&window).logs.shown.products.as_ref().expect("results").flat_spots.clone();
    assert!(spots.len() > 2);
    // The list opens with the tool.
    press(&mut window, Modifiers::NONE, Key::C);
    let second = window.get_by_label_contains("Flat stretch 2, pings");
    second.click();
    window.run();
    let proposed = app(&window).logs.shown.proposed_stretch();
    assert_eq!(proposed, Some(spots[1].range()));
    assert!(app(&window).view.selection.is_some(), "it is shown in all views");
    let second = window.get_by_label_contains("Flat stretch 2, pings");
    let toggled = second.accesskit_node().toggled();
    assert_eq!(toggled, Some(egui::accesskit::Toggled::True));
    let survey = app(&window).logs.shown.survey.clone().expect("the demo");
    let names: Vec<String> = (window.query_all_by_label_contains("Flat stretch "))
        .filter_map(|node| node.accesskit_node().label())
        .collect();
    for (rank, spot) in spots.iter().enumerate() {
        let is_worse = !spot.objections(&survey, spots.first()).is_empty();
        let start = format!("Flat stretch {}, ", rank + 1);
        let name = names.iter().find(|name| name.starts_with(&start)).expect("a row");
        assert_eq!(name.contains("worse: "), is_worse, "{name}");
    }
}

/// First returns above the recorded depth that an analyst accepts as bottom count for the map; undo
/// takes it back, and the settings that a project and `process` use hold it.
#[test]
fn a_stretch_is_accepted_as_bottom_with_one_action() {
    let mut window = demo_window();
    open_step(&mut window, WorkStep::Bottom);
    let figures = app(&window).logs.shown.figures.clone().expect("figures");
    let above = figures.above_bottom;
    let stretch = (above.stretches.iter())
        .find(|stretch| stretch.uncounted > 0)
        .copied()
        .expect("the weed of the demo");
    let class = |window: &Window| {
        let products = app(window).logs.shown.products.as_ref().expect("results");
        products.classes.iter().filter(|class| **class == PointClass::AboveBottom).count()
    };
    let before = (class(&window), depths_m(&window).len());
    let calibration =
        app(&window).logs.shown.products.as_ref().expect("results").calibration.clone();
    let [first, last] = stretch.pings;
    let side = stretch.side.name();
    let title = format!("{} such stretches", above.stretches.len());
    window.set_size(egui::vec2(1400.0, 2800.0));
    window.run();
    window.get_by_label(&title).click();
    window.run();
    let name = format!("Accept as bottom: pings {first} to {last}, {side}");
    window.get_by_label(&name).click();
    window.run();
    assert_eq!(app(&window).document.history.undo_label(), Some("bottom"));
    let after = (class(&window), depths_m(&window).len());
    assert!(after.0 < before.0 && after.1 > before.1, "{before:?}, {after:?}");
    let found = app(&window).logs.shown.returns().expect("first returns").clone();
    assert!((first..=last).all(|ping| !found.side(stretch.side)[ping].above_bottom));
    let now = app(&window).logs.shown.products.as_ref().expect("results").calibration.clone();
    assert_eq!(format!("{now:?}"), format!("{calibration:?}"), "no scale rests on it");
    // What a script reads gives the same.
    let bottom = app(&window).logs.shown.settings.bottom.clone();
    assert_eq!(bottom.accepted_count(), last - first + 1);
    let settings = bathyscope_products::pipeline::Settings { bottom, ..Default::default() };
    let survey = app(&window).logs.shown.survey.clone().expect("the demo");
    let progress = bathyscope_log::support::progress::Progress::new();
    let made = bathyscope_products::pipeline::run(&survey, &settings, None, &progress, |_| ());
    let made = made.expect("not cancelled");
    assert_eq!(made.kept_points().count(), after.1);
    act(&mut window, Action::Undo);
    assert_eq!((class(&window), depths_m(&window).len()), before);
    // With the tool the other side too, as asked for.
    act(&mut window, Action::BottomBothSides);
    apply(&mut window, Command::AcceptBottom { side: Side::Port, pings: [10, 19], accept: true });
    assert_eq!(app(&window).logs.shown.settings.bottom.accepted_count(), 20);
    apply(&mut window, Command::AcceptBottom { side: Side::Port, pings: [0, 99], accept: false });
    assert!(app(&window).logs.shown.settings.bottom.is_empty());
}

#[test]
fn the_key_proposes_at_the_selected_ping() {
    let mut window = demo_window();
    apply(&mut window, Command::Reveal(LogPlace::ping(700)));
    press(&mut window, Modifiers::NONE, Key::C);
    let proposed = app(&window).logs.shown.proposed_stretch().expect("a proposal");
    assert!((proposed.start..proposed.end).contains(&700), "{proposed:?}");
    assert_eq!(mode(&window), ScaleMode::Header);
}

/// Pictures for whoever looks: the folder that is named gets the window with a proposal, before it
/// is used and after.
#[test]
fn pictures_of_the_step() {
    let Some(folder) = std::env::var_os("BATHYSCOPE_PICTURES").map(std::path::PathBuf::from) else {
        return;
    };
    std::fs::create_dir_all(&folder).expect("a folder");
    let save = |window: &mut Window, name: &str| {
        let picture = window.render().expect("a picture");
        picture.save(folder.join(format!("{name}.png"))).expect("room");
    };
    // What is accepted is kept beside the log: a copy of it.
    let copy = tempfile::tempdir().expect("a folder");
    let mut window = match real_data() {
        Some(data) => {
            let log = copy.path().join("river.sl2");
            std::fs::copy(data.join("lowrance/glencanyon-transcoded.sl2"), &log).expect("room");
            let mut window = empty_window();
            drop_file(&mut window, log);
            window
        }
        None => demo_window(),
    };
    window.set_size(egui::vec2(1400.0, 1400.0));
    window.run();
    save(&mut window, "calibration_0_start");
    press(&mut window, Modifiers::NONE, Key::C);
    save(&mut window, "calibration_1_proposed");
    act(&mut window, Action::UseScale);
    save(&mut window, "calibration_2_used");
    act(&mut window, Action::Undo);
    let start = PingRange { start: 0, end: 100 };
    apply(&mut window, Command::ProposeStretch(start));
    save(&mut window, "calibration_3_worse");
    let survey = app(&window).logs.shown.survey.clone().expect("a log");
    if let Some(lost) = survey.side_scan.iter().position(|ping| ping.depth_fault.is_some()) {
        let stretch = PingRange { start: lost, end: lost + 60 };
        apply(&mut window, Command::ProposeStretch(stretch));
        apply(&mut window, Command::Reveal(LogPlace::ping(lost)));
        save(&mut window, "calibration_4_lost");
    }
    act(&mut window, Action::DropProposal);
    let stretches = app(&window)
        .logs
        .shown
        .figures
        .as_ref()
        .map(|figures| figures.above_bottom.stretches.len());
    let title = format!("{} such stretches", stretches.unwrap_or(0));
    window.get_by_label(&title).click();
    window.run();
    save(&mut window, "above_bottom_1_list");
    let stretch =
        app(&window).logs.shown.figures.as_ref().map(|figures| figures.above_bottom.stretches[0]);
    let stretch = stretch.expect("figures");
    apply(
        &mut window,
        Command::Reveal(LogPlace {
            side: Some(stretch.side),
            ..LogPlace::ping(usize::midpoint(stretch.pings[0], stretch.pings[1]))
        }),
    );
    apply(
        &mut window,
        Command::AcceptBottom { side: stretch.side, pings: stretch.pings, accept: true },
    );
    save(&mut window, "above_bottom_2_accepted");
}
