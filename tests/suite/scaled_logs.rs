//! Logs whose depths differ by a share of the depth, as by another sound speed, are named by
//! `process` and in the window.

use crate::cli::stderr_of;
use crate::logs_window::settle;
use crate::window::{app, drop_files, empty_window};
use egui_kittest::kittest::Queryable as _;
use serde_json::Value;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

/// East and north each half metre along six lines of 60 m, 10 m apart, that the boat goes up and
/// down, metres.
fn serpentine() -> Vec<[f64; 2]> {
    let lines = (0..6).flat_map(|line| {
        let across_m = 10.0 * f64::from(line);
        let along = move |step: i32| {
            let along_m = 0.5 * f64::from(step);
            [across_m, if line % 2 == 0 { along_m } else { 60.0 - along_m }]
        };
        let end = along(120);
        let turn = (1..20).map(move |step| [across_m + 0.5 * f64::from(step), end[1]]);
        (0..=120).map(along).chain(turn)
    });
    lines.collect()
}

/// Two logs of depths alone over a slope of 2 to 8 m, one along it and one across; depths of the
/// second are `factor` times those of the first.
fn write_two(folder: &Path, factor: f64) -> [PathBuf; 2] {
    let write = |name: &str, is_across: bool, factor: f64| {
        let mut rows = "lat,lon,depth_m\n".to_owned();
        for (index, [a, b]) in serpentine().into_iter().enumerate() {
            let [east_m, north_m] = if is_across { [b, a + 5.0] } else { [a + 5.0, b] };
            let lat = 47.0 + north_m / 111_180.0;
            let lon = 8.0 + east_m / (111_320.0 * lat.to_radians().cos());
            let noise_m = 0.01 * (index as f64 * 2.3).sin();
            let depth_m = 2.0 + 0.1 * east_m + 0.5 * (north_m / 9.0).sin();
            writeln!(rows, "{lat:.8},{lon:.8},{:.3}", factor * (depth_m + noise_m)).expect("a row");
        }
        let path = folder.join(name);
        fs::write(&path, rows).expect("a log");
        path
    };
    [write("along.csv", false, 1.0), write("across.csv", true, factor)]
}

#[test]
fn depths_that_are_greater_by_a_share_are_said_with_it_and_equal_ones_are_not() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    for (factor, is_said) in [(1.02, true), (1.0, false)] {
        let logs = write_two(folder.path(), factor);
        let logs: Vec<&str> = logs.iter().filter_map(|path| path.to_str()).collect();
        let process = [&["process"], &logs[..], &["-o", "out", "--products", "report"]].concat();
        let said = stderr_of(folder.path(), &process);
        let text = "Depths of across are 2.";
        assert_eq!(said.contains(text), is_said, "{said}");
        let report = fs::read_to_string(folder.path().join("out/report.json")).expect("a report");
        let report: Value = serde_json::from_str(&report).expect("JSON");
        let scales = &report["logs"]["scales"];
        let share = scales[0]["share"].as_f64();
        assert_eq!(share.is_some_and(|share| (share - 0.02).abs() < 0.002), is_said, "{scales}");
    }
}

#[test]
fn the_window_lists_it_among_the_heights() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut window = empty_window();
    drop_files(&mut window, write_two(folder.path(), 1.02));
    settle(&mut window);
    assert_eq!(app(&window).logs.all().count(), 2);
    assert!(window.query_by_label_contains("sound speeds that differ by").is_some());
}
