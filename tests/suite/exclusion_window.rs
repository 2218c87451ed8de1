//! Stretches excluded in the window: drawn over waterfall and map, found by turn rate and speed,
//! listed and included again.

use crate::bottom::draw;
use crate::logs_window::{change, opened, settle};
use crate::review::mouse::{at, drag, pull};
use crate::window::{Window, app, demo_window, drawn_window, open_section, press, settle as drawn};
use bathyscope::app::{Command, LogId, OpenLog, Tool, WorkStep};
use bathyscope_log::survey::{ExcludedStretch, ExclusionReason};
use egui::{Key, Modifiers, Pos2, pos2};
use egui_kittest::kittest::{NodeT as _, Queryable as _};

fn out_of(log: &OpenLog) -> Vec<ExcludedStretch> {
    log.exclusions().expect("a result").exclusions.stretches.clone()
}

fn exclusions(window: &Window) -> Vec<ExcludedStretch> {
    out_of(&app(window).logs.shown)
}

/// First and last pings of what is excluded from the log that is shown.
fn pings(window: &Window) -> Vec<[usize; 2]> {
    let stretches = exclusions(window).into_iter();
    stretches.filter_map(|stretch| stretch.pings).collect()
}

fn near(found: [usize; 2], expected: [usize; 2]) -> bool {
    let near = |(one, other): (usize, usize)| one.abs_diff(other) <= 4;
    found.into_iter().zip(expected).all(near)
}

/// Kept points that a stretch of pings has in the results.
fn points_in(window: &Window, [first, last]: [usize; 2]) -> usize {
    let products = app(window).logs.shown.products.as_ref().expect("results");
    (products.kept_points()).filter(|point| (first..=last).contains(&(point.ping as usize))).count()
}

fn name_of(window: &Window, part: &str) -> String {
    let node = window.get_by_label_contains(part);
    node.accesskit_node().label().expect("a name")
}

pub(super) fn click(window: &mut Window, at: Pos2) {
    window.hover_at(at);
    window.run();
    window.drag_at(at);
    window.drop_at(at);
    window.run();
    window.step();
}

/// Returns the place of a ping of a log on the screen of the map.
pub(super) fn on_map(window: &mut Window, log: LogId, ping: usize) -> Pos2 {
    let at = places_on_map(window);
    let log = app(window).logs.get(log).expect("it is open");
    let boat = log.products.as_ref().expect("results").navigation.pings[ping];
    at([boat.east_m, boat.north_m])
}

/// Returns the conversion from places of the plane to the screen of the map, by two places that are
/// measured there.
pub(super) fn places_on_map(window: &mut Window) -> impl Fn([f64; 2]) -> Pos2 + use<> {
    let rect = window.get_by_label_contains("Map, track of").rect();
    let probes = [rect.center(), rect.center() + egui::vec2(40.0, 0.0)];
    press(window, Modifiers::NONE, Key::D);
    for probe in probes {
        click(window, probe);
    }
    let figure = app(window).map.measuring.figure.clone().expect("a line");
    press(window, Modifiers::NONE, Key::Escape);
    press(window, Modifiers::NONE, Key::Escape);
    let log = &app(window).logs.shown;
    let survey = log.survey.as_ref().expect("a log");
    let navigation = &log.products.as_ref().expect("results").navigation;
    let [start, end] = [0, 1].map(|index| {
        let corner = figure.measurement.corners[index];
        navigation.to_plane(&survey.track, corner)
    });
    let per_point = (end[0] - start[0]) / 40.0;
    move |[east_m, north_m]| {
        let right = (east_m - start[0]) / per_point;
        let down = (start[1] - north_m) / per_point;
        pos2(probes[0].x + right as f32, probes[0].y + down as f32)
    }
}

#[test]
fn a_drag_along_the_waterfall_leaves_pings_out_of_everything_as_one_step() {
    let mut window = demo_window();
    press(&mut window, Modifiers::NONE, Key::F);
    let before = points_in(&window, [300, 400]);
    assert!(before > 100 && pings(&window).is_empty());
    press(&mut window, Modifiers::NONE, Key::K);
    assert_eq!(app(&window).logs.shown.reviewing.tool, Tool::Exclude);
    window.get_by_label_contains(", excluding stretches");
    // Backwards as well as forwards.
    draw(&mut window, Modifiers::NONE, (400.0, -4.0), (300.0, 5.0));
    let [stretch] = pings(&window)[..] else { panic!("{:?}", pings(&window)) };
    assert!(near(stretch, [300, 400]), "{stretch:?}");
    assert_eq!(exclusions(&window)[0].reason, ExclusionReason::Drawn);
    assert_eq!(points_in(&window, stretch), 0, "the results follow");
    let products = app(&window).logs.shown.products.as_ref().expect("results");
    assert_eq!(products.exclusions.stretches, exclusions(&window));
    for view in ["Waterfall, pings", "Time line, ping"] {
        let name = name_of(&window, view);
        assert!(name.contains(", 1 stretch excluded"), "{name}");
    }
    let name = name_of(&window, "Map, track of");
    let count = format!(" of which {} excluded", stretch[1] + 1 - stretch[0]);
    assert!(name.contains(&count), "{name}");

    // With Ctrl a part of it counts again; what touches it joins it.
    draw(&mut window, Modifiers::COMMAND, (340.0, 0.0), (360.0, 0.0));
    assert_eq!(pings(&window).len(), 2);
    draw(&mut window, Modifiers::NONE, (330.0, 0.0), (370.0, 0.0));
    assert_eq!(pings(&window), [stretch]);
    for expected in [2, 1, 0] {
        press(&mut window, Modifiers::COMMAND, Key::Z);
        assert_eq!(pings(&window).len(), expected);
    }
    assert_eq!(points_in(&window, [300, 400]), before);
    assert_eq!(app(&window).document.history.undo_label(), None);
    press(&mut window, Modifiers::COMMAND | Modifiers::SHIFT, Key::Z);
    assert_eq!(pings(&window), [stretch]);

    // A click includes it again; beside it a click only selects.
    let beside = at(&window, 600.0, 4.0);
    click(&mut window, beside);
    assert_eq!(pings(&window), [stretch]);
    assert!(near([app(&window).view.selection.expect("a ping").ping; 2], [600; 2]));
    let inside = at(&window, 350.0, 4.0);
    click(&mut window, inside);
    assert!(pings(&window).is_empty());
    assert!(app(&window).logs.shown.settings.excluded.is_empty());
    // Without the tool a drag moves the picture.
    press(&mut window, Modifiers::NONE, Key::Escape);
    draw(&mut window, Modifiers::NONE, (300.0, -6.0), (400.0, -4.0));
    assert!(pings(&window).is_empty());
}

#[test]
fn a_drag_that_is_given_up_changes_nothing() {
    let mut window = demo_window();
    press(&mut window, Modifiers::NONE, Key::F);
    let (from, to) = (at(&window, 300.0, 4.0), at(&window, 400.0, 6.0));
    // Excluded stretches, the bottom, a new box.
    for tool in [Key::K, Key::M, Key::N] {
        press(&mut window, Modifiers::NONE, tool);
        pull(&mut window, from, to);
        press(&mut window, Modifiers::NONE, Key::Escape);
        window.drop_at(to);
        window.run();
        assert!(pings(&window).is_empty());
        assert!(app(&window).logs.shown.settings.bottom.is_empty());
        assert!(!app(&window).logs.shown.reviewing.has_boxes());
        assert_eq!(app(&window).document.history.undo_label(), None, "{tool:?}");
    }
}

#[test]
fn turns_are_found_listed_and_taken_back_in() {
    let mut window = demo_window();
    open_section(&mut window, WorkStep::Correct, "Excluded");
    change(&mut window, "excluded.max_turn_deg_s=4");
    let found = exclusions(&window);
    assert!(!found.is_empty(), "the demo turns");
    assert!(found.iter().all(|stretch| stretch.reason == ExclusionReason::Turn));
    let pings_out: usize = pings(&window).iter().map(|[a, b]| b + 1 - a).sum();
    let extent = app(&window).logs.shown.exclusions().expect("found").extent(None);
    assert_eq!(extent.pings, pings_out);
    let name = if found.len() == 1 { "1 turn: " } else { " turns: " };
    window.get_by_label_contains(name);
    let [first, last] = found[0].pings.expect("pings");
    window.get_by_label(&format!("Stretch turn {first}..{last}")).click_accesskit();
    settle(&mut window);
    let shown = app(&window).view.selection.expect("a ping").ping;
    assert!((first..=last).contains(&shown));
    window.get_by_label_contains(", excluded: turn");

    window.get_by_label(&format!("Include again: turn {first}..{last}")).click_accesskit();
    settle(&mut window);
    assert_eq!(exclusions(&window), found[1..]);
    assert!(points_in(&window, [first, last]) > 0);
    // It is listed as kept, and left to the search again.
    window.get_by_label(&format!("Reset: kept {first}..{last}")).click_accesskit();
    settle(&mut window);
    assert_eq!(exclusions(&window), found);
    // By key, at the selected ping.
    press(&mut window, Modifiers::SHIFT, Key::K);
    settle(&mut window);
    assert_eq!(exclusions(&window), found[1..]);
    press(&mut window, Modifiers::SHIFT, Key::K);
    assert!(window.query_by_label_contains("the selected ping is not excluded").is_some());
}

#[test]
fn a_drag_along_a_track_of_the_map_leaves_out_pings_of_its_log() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut window = opened(folder.path(), 2);
    let ids = crate::logs_window::ids(&window);
    let [from, to] = [40, 140].map(|ping| on_map(&mut window, ids[1], ping));
    press(&mut window, Modifiers::NONE, Key::K);
    drag(&mut window, from, to);
    settle(&mut window);
    assert_eq!(app(&window).logs.shown.id, ids[0], "the shown log stays");
    assert!(pings(&window).is_empty());
    let other = app(&window).logs.get(ids[1]).expect("it is open");
    let [stretch] = out_of(other)[..] else { panic!("{:?}", out_of(other)) };
    assert!(near(stretch.pings.expect("pings"), [40, 140]), "{stretch:?}");
    let products = other.products.as_ref().expect("results");
    assert_eq!(products.exclusions.stretches, [stretch]);
    let name = name_of(&window, "Map, track of");
    assert!(name.contains(" excluded"), "{name}");
    // A click with the tool includes it again; without it a drag moves the map.
    let inside = on_map_again(&mut window, ids[1], 90);
    click(&mut window, inside);
    settle(&mut window);
    assert!(out_of(app(&window).logs.get(ids[1]).expect("it is open")).is_empty());
}

/// [`on_map`] with the tool in hand before and after.
fn on_map_again(window: &mut Window, log: LogId, ping: usize) -> Pos2 {
    press(window, Modifiers::NONE, Key::Escape);
    let at = on_map(window, log, ping);
    press(window, Modifiers::NONE, Key::K);
    at
}

#[test]
fn excluded_stretches_look_as_they_did() {
    let mut window = drawn_window([1400.0, 1000.0]);
    window.state_mut().app.apply(Command::OpenDemo);
    window.run();
    open_section(&mut window, WorkStep::Correct, "Excluded");
    change(&mut window, "excluded.max_turn_deg_s=4");
    press(&mut window, Modifiers::NONE, Key::F);
    press(&mut window, Modifiers::NONE, Key::K);
    draw(&mut window, Modifiers::NONE, (300.0, -4.0), (380.0, -4.0));
    window.get_by_label("Exclude stretches").scroll_to_me();
    window.run();
    drawn(&mut window);
    window.snapshot("window_excluded");
}
