//! Logs of one survey whose positions are off and late: found and put right by `process` and in the
//! window.

use crate::archive::positions::{LOGS, TRUTH, write_four};
use crate::cli::run;
use crate::logs_window::{change, settle};
use crate::window::{Window, app, drop_file, empty_window, press};
use bathyscope::app::FoundPositions;
use bathyscope_products::pipeline::joint::LogPositions;
use egui::{Key, Modifiers};
use egui_kittest::kittest::Queryable as _;
use serde_json::Value;
use std::fs;

/// East and north of the position shift and the latency of every log in the window.
fn in_force(window: &Window) -> Vec<[f64; 3]> {
    let logs = app(window).logs.all().map(|log| {
        let shift = log.settings.position_shift;
        [shift.east_m, shift.north_m, log.settings.mounting.latency_s]
    });
    logs.collect()
}

fn assert_near_truth(found: &[[f64; 3]]) {
    assert_eq!(found.len(), TRUTH.len());
    for (found, truth) in found.iter().zip(TRUTH) {
        let off_m = (found[0] - truth[0]).hypot(found[1] - truth[1]);
        let off_s = (found[2] - truth[2]).abs();
        assert!(off_m < 0.6 && off_s < 0.4, "{found:?} for {truth:?}");
    }
}

#[test]
fn positions_are_compared_in_the_window_and_put_right_as_one_step() {
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let [_, off] = write_four(temporary.path());
    let mut window = empty_window();
    drop_file(&mut window, off);
    settle(&mut window);
    window.get_by_label("Compare positions").click_accesskit();
    settle(&mut window);
    let found = app(&window).findings.positions.as_ref().expect("what was found");
    assert!(FoundPositions::tells(found));
    let shift = |(_, log): &(_, LogPositions)| log.found.shift.values();
    let found: Vec<[f64; 3]> = found.logs.iter().map(shift).collect();
    assert_near_truth(&found);
    window.get_by_label("Apply positions").click_accesskit();
    settle(&mut window);
    assert_near_truth(&in_force(&window));

    // With them in force the crossings show about the same, all told.
    window.get_by_label("Compare positions").click_accesskit();
    settle(&mut window);
    let again = app(&window).findings.positions.as_ref().expect("what was found");
    let again: Vec<[f64; 3]> = again.logs.iter().map(shift).collect();
    for (again, found) in again.iter().zip(&found) {
        let moved = [0, 1, 2].map(|value| (again[value] - found[value]).abs());
        assert!(moved.iter().all(|by| *by < 0.3), "{again:?} {found:?}");
    }
    press(&mut window, Modifiers::COMMAND, Key::Z);
    settle(&mut window);
    assert_eq!(in_force(&window), vec![[0.0; 3]; 4]);

    // What is in force and wrong is told, though what is right is nothing: the first log is not
    // late.
    change(&mut window, "mounting.latency_s=1.5");
    assert_eq!(in_force(&window)[0][2], 1.5);
    window.get_by_label("Compare positions").click_accesskit();
    settle(&mut window);
    window.get_by_label("Apply positions").click_accesskit();
    settle(&mut window);
    assert_near_truth(&in_force(&window));
}

#[test]
fn process_moves_logs_whose_positions_are_off_when_it_is_asked_to() {
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let [_, off] = write_four(temporary.path());
    let statements = |more: &[&str]| -> Vec<String> {
        let process = [&["process"], &LOGS[..], &["-o", "out", "--no-objects", "--adjust"]];
        run(&off, &[&process.concat()[..], &["--products", "residuals"], more].concat());
        let text = fs::read_to_string(off.join("out/report.json")).expect("a report");
        let record: Value = serde_json::from_str(&text).expect("JSON");
        let logs = record["logs"]["logs"].as_array().expect("logs").clone();
        let said = logs.iter().map(|log| log["statement"].to_string());
        said.collect()
    };
    assert!(statements(&[]).iter().all(|said| !said.contains("moved by")));
    let said = statements(&["--positions", "--latency"]);
    assert!(said[0].contains("Positions are moved by 1."), "{}", said[0]);
    assert!(said[1].contains("s later"), "{}", said[1]);
    assert!(said[2].contains("m west and"), "{}", said[2]);
}
