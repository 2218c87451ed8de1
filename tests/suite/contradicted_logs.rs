//! Soundings that other logs of a survey show to be false: said by `process` and in the window, and
//! left out where that is asked for.

use crate::cli::{run, stderr_of};
use crate::logs_window::settle;
use crate::window::{Window, app, drop_files, empty_window, press};
use egui::{Key, Modifiers};
use egui_kittest::kittest::Queryable as _;
use serde_json::Value;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

/// Logs of depths alone, a sounding each metre: two lines to the north and one to the east over a
/// bed of 22 m, whose sounder took something at 9.2 m for the bottom between 20 m and 60 m.
fn write_three(folder: &Path) -> [PathBuf; 3] {
    let place = |east_m: f64, north_m: f64| {
        let lat = 47.0 + north_m / 111_180.0;
        (lat, 8.0 + east_m / (111_320.0 * lat.to_radians().cos()))
    };
    let bed_m = |index: u32| 22.0 + 0.1 * f64::from(index % 3);
    let held_m = move |index: u32| if (20..60).contains(&index) { 9.2 } else { bed_m(index) };
    let write = |name: &str, along: &dyn Fn(f64) -> (f64, f64), depth_m: &dyn Fn(u32) -> f64| {
        let mut rows = "lat,lon,depth_m\n".to_owned();
        for index in 0..100 {
            let (lat, lon) = along(f64::from(index));
            writeln!(rows, "{lat:.8},{lon:.8},{:.2}", depth_m(index)).expect("a row");
        }
        let path = folder.join(name);
        fs::write(&path, rows).expect("a log");
        path
    };
    [
        write("east.csv", &|along_m| place(along_m, 50.0), &held_m),
        write("north-1.csv", &|along_m| place(30.0, along_m), &bed_m),
        write("north-2.csv", &|along_m| place(45.0, along_m), &bed_m),
    ]
}

#[test]
fn process_names_false_soundings_and_leaves_them_out_when_it_is_asked_to() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let logs = write_three(folder.path());
    let logs: Vec<&str> = logs.iter().filter_map(|path| path.to_str()).collect();
    let process = |more: &[&'static str]| [&["process"], &logs[..], &["-o", "out"], more].concat();
    let report = || -> Value {
        let text = fs::read_to_string(folder.path().join("out/report.json")).expect("a report");
        serde_json::from_str(&text).expect("JSON")
    };
    let said = stderr_of(folder.path(), &process(&[]));
    let expected =
        "east: 40 soundings between 20 s and 59 s (9.20 m), false by other logs: north-1 has";
    assert!(said.contains(expected) && said.contains("--adjust leaves them out"), "{said}");
    let report_before = report();
    let listed = &report_before["logs"]["contradicted"];
    assert_eq!(listed.as_array().map(Vec::len), Some(1), "{listed}");
    assert_eq!((&listed[0]["log"], &listed[0]["count"]), (&0.into(), &40.into()));
    assert_eq!(listed[0]["against"].as_array().map(Vec::len), Some(2), "{listed}");

    let said = run(folder.path(), &process(&["--adjust"]));
    assert!(said.contains("east: excluded.stretches of 40 soundings"), "{said}");
    let report = report();
    assert_eq!(report["logs"]["contradicted"], Value::Array(Vec::new()));
    assert_eq!(report["logs"]["logs"][0]["excluded"][0]["time_s"], serde_json::json!([20.0, 59.0]));
    let spread = |report: &Value| report["logs"]["crosslines"]["all"]["p95_m"].as_f64();
    assert!(spread(&report_before).is_some_and(|p95_m| p95_m > 10.0), "{report_before}");
    assert!(spread(&report).is_none_or(|p95_m| p95_m < 0.3), "{report}");
}

/// Number of excluded stretches of the first log.
fn excluded(window: &Window) -> usize {
    let log = app(window).logs.all().find(|log| log.name() == "east").expect("the log");
    log.settings.excluded.stretches.len()
}

#[test]
fn the_window_offers_to_leave_false_soundings_out_as_one_step() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut window = empty_window();
    drop_files(&mut window, write_three(folder.path()));
    settle(&mut window);
    let is_said =
        app(&window).notices.all().any(|notice| notice.text.contains("false by other logs"));
    let said: Vec<String> = app(&window).notices.all().map(|notice| notice.text.clone()).collect();
    assert!(is_said, "nobody was told of the false soundings: {said:?}");
    let label = "Leave out contradicted soundings";
    window.get_all_by_label(label).next().expect("a button").click_accesskit();
    settle(&mut window);
    assert_eq!(excluded(&window), 1);
    assert!(window.query_all_by_label(label).next().is_none(), "nothing is left to do");
    press(&mut window, Modifiers::COMMAND, Key::Z);
    settle(&mut window);
    assert_eq!(excluded(&window), 0);
}
