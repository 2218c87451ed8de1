//! Lines to sail next in the window: planned by key, dragged, removed, undone and written.

use crate::exclusion_window::{click, places_on_map};
use crate::window::{Window, app, demo_window, drawn_window, press, settle};
use bathyscope::app::{Action, Command, FileToWrite, PlanRequest, View};
use bathyscope_bottom::planning::{Leg, PlanSettings};
use egui::{Key, Modifiers};
use egui_kittest::kittest::Queryable as _;
use std::fs;

fn lines(window: &Window) -> Vec<Leg> {
    let planned = app(window).map.planning.lines.as_ref();
    planned.map_or_else(Vec::new, |planned| planned.plan.lines.clone())
}

/// A plan of two minutes with turns of 3 m.
fn plan(window: &mut Window) {
    let asked = PlanSettings { minutes: 2.0, turn_radius_m: 3.0, ..PlanSettings::default() };
    let ask = Command::Plan(PlanRequest::Ask(asked));
    window.state_mut().app.apply(ask);
    let plan = Command::Do(Action::PlanLines);
    window.state_mut().app.apply(plan);
    window.run();
    window.run();
}

/// Distance from a place to the nearest of a leg, metres.
fn distance_m([x, y]: [f64; 2], leg: &Leg) -> f64 {
    let way = [leg.to[0] - leg.from[0], leg.to[1] - leg.from[1]];
    let from = [x - leg.from[0], y - leg.from[1]];
    let share = (from[0] * way[0] + from[1] * way[1]) / (way[0] * way[0] + way[1] * way[1]);
    let share = share.clamp(0.0, 1.0);
    (from[0] - share * way[0]).hypot(from[1] - share * way[1])
}

#[test]
fn lines_are_planned_dragged_removed_and_every_step_is_undone() {
    let mut window = demo_window();
    assert!(lines(&window).is_empty());
    let at = places_on_map(&mut window);
    plan(&mut window);
    let planned = lines(&window);
    assert!(!planned.is_empty());
    assert_eq!(app(&window).document.history.undo_label(), Some("planned lines"));
    let said = format!("{} line", planned.len());
    assert!(window.query_by_label_contains(&said).is_some(), "the read-out");

    // A drag of a line's end by 30 points down: of the one that lies farthest from all other lines,
    // and north of the read-out at the lower edge of the map.
    let clearance_m = |line: &usize| {
        let others = planned.iter().enumerate().filter(|(other, _)| other != line);
        let away_m = others.map(|(_, leg)| distance_m(planned[*line].to, leg));
        away_m.fold(f64::INFINITY, f64::min)
    };
    let north = (0..planned.len()).filter(|line| planned[*line].to[1] > 5.0);
    let line = north.max_by(|a, b| clearance_m(a).total_cmp(&clearance_m(b)));
    let line = line.expect("a line");
    let from = at(planned[line].to);
    let to = from + egui::vec2(0.0, 30.0);
    window.hover_at(from);
    window.run();
    window.drag_at(from);
    for share in [0.3_f32, 0.7, 1.0] {
        window.hover_at(from.lerp(to, share));
        window.run();
    }
    window.drop_at(to);
    window.run();
    window.step();
    let dragged = lines(&window);
    assert_eq!(dragged.len(), planned.len());
    let others = |legs: &[Leg]| -> Vec<Leg> {
        let legs = legs.iter().enumerate();
        legs.filter(|(index, _)| *index != line).map(|(_, leg)| *leg).collect()
    };
    assert_eq!(dragged[line].from, planned[line].from);
    assert!(dragged[line].to[1] < planned[line].to[1] - 0.1, "{dragged:?}");
    assert_eq!(others(&dragged), others(&planned));
    let there = at(dragged[line].to);
    assert!(there.distance(to) < 3.0, "{there:?} {to:?}");

    // A click on its middle selects it; the command removes it.
    let middle = [0, 1].map(|axis| 0.5 * (dragged[line].from[axis] + dragged[line].to[axis]));
    click(&mut window, at(middle));
    assert_eq!(app(&window).map.planning.selected, Some(line));
    window.state_mut().app.apply(Command::Do(Action::RemoveLine));
    window.run();
    assert_eq!(lines(&window), others(&dragged));
    press(&mut window, Modifiers::COMMAND, Key::Z);
    assert_eq!(lines(&window), dragged);
    press(&mut window, Modifiers::COMMAND, Key::Z);
    assert_eq!(lines(&window), planned);
    press(&mut window, Modifiers::COMMAND, Key::Z);
    assert!(lines(&window).is_empty());
    press(&mut window, Modifiers::COMMAND | Modifiers::SHIFT, Key::Z);
    assert_eq!(lines(&window), planned);
    window.state_mut().app.apply(Command::Do(Action::RemovePlan));
    assert!(lines(&window).is_empty());
}

#[test]
fn planned_lines_are_written_where_the_name_says_and_nothing_is_planned_of_nothing() {
    let mut window = demo_window();
    let before = app(&window).notices.shown().len();
    window.state_mut().app.apply(Command::Do(Action::RemoveLine));
    assert_eq!(app(&window).notices.shown().len(), before + 1);
    plan(&mut window);
    let folder = tempfile::tempdir().expect("a temporary folder");
    for (name, words) in [
        ("lines.gpx", "<rtept "),
        ("lines.kml", "<LineString>"),
        ("lines.plan", "\"fileType\": \"Plan\""),
        ("lines.waypoints", "QGC WPL 110"),
    ] {
        let path = folder.path().join(name);
        let save = Command::Write(FileToWrite::Plan(path.clone()));
        window.state_mut().app.apply(save);
        let text = fs::read_to_string(path).expect("a file");
        assert!(text.contains(words), "{name}: {text}");
    }
    let path = folder.path().join("lines.txt");
    let save = Command::Write(FileToWrite::Plan(path.clone()));
    window.state_mut().app.apply(save);
    let notice = app(&window).notices.shown().last().expect("a notice");
    assert!(notice.text.contains(".waypoints") && !path.exists(), "{}", notice.text);
}

#[test]
fn the_map_shows_the_lines_with_their_way() {
    let mut window = drawn_window([900.0, 640.0]);
    window.state_mut().app.apply(Command::OpenDemo);
    window.state_mut().show_alone(View::Map);
    settle(&mut window);
    plan(&mut window);
    settle(&mut window);
    window.snapshot("map_planned_lines");
}
