//! One truth for depths and ranges: what map, cloud, status bar, selection, time line and report
//! say of the same water.

use crate::cli::run;
use crate::support::demo_log;
use crate::window::{Window, app, demo_window, open_section, open_step};
use bathyscope::app::{Command, LogPlace, WorkStep};
use bathyscope_bottom::cloud::{ClassCounts, PointSource};
use bathyscope_log::support::statistics::colour_ends;
use bathyscope_products::pipeline::Products;
use bathyscope_products::pipeline::Settings;
use egui_kittest::kittest::{NodeT as _, Queryable as _};
use serde_json::Value;
use std::path::Path;

fn change(window: &mut Window, assignments: &[&str]) {
    let mut settings = Settings::clone(&app(window).logs.shown.settings);
    for assignment in assignments {
        settings = settings.with_assignment(assignment).expect("a setting");
    }
    let change = Command::Change { settings: Box::new(settings), label: "a test", live: false };
    window.state_mut().app.apply(change);
    window.run();
}

/// Depths of the soundings of the cloud, with the ping that each belongs to.
fn soundings(products: &Products) -> Vec<(usize, f64)> {
    (products.kept_points())
        .filter(|point| point.source == PointSource::DownScan)
        .map(|point| (point.ping as usize, -point.z_m))
        .collect()
}

fn names(window: &Window, part: &str) -> Vec<String> {
    let found = window.query_all_by_label_contains(part);
    let names = found.map(|node| {
        let node = node.accesskit_node();
        node.label().or(node.value()).unwrap_or_default()
    });
    names.collect()
}

#[test]
fn draft_and_sound_speed_reach_map_status_bar_selection_and_time_line_alike() {
    let mut window = demo_window();
    for (assignments, reference) in [
        (vec![], "below transducer"),
        (vec!["draft_m=0.4", "sound_speed.m_s=1440"], "below surface"),
        (vec!["draft_m=0.4", "water_level_m=1.25"], "below water level zero"),
    ] {
        change(&mut window, &assignments);
        let products = app(&window).logs.shown.products.clone().expect("a result");
        let depths = soundings(&products);
        let (ping, depth_m) = depths[depths.len() / 3];
        let mark = LogPlace::ping(ping);
        window.state_mut().app.apply(Command::Select(Some(mark)));
        window.run();
        // Status bar and selection: the sounding of the cloud, to the centimetre that is written.
        let depth = format!("{depth_m:.2} m {reference}, sounding");
        assert!(
            window.query_by_label(&format!("depth {depth}")).is_some(),
            "status bar: {depth}, {:?}",
            names(&window, "depth ")
        );
        assert!(window.query_by_label(&depth).is_some(), "selection: {depth}");
        // Time line: the deepest of them.
        let deepest_m = depths.iter().map(|(_, depth_m)| *depth_m).fold(0.0, f64::max);
        let deepest = format!("depth to {deepest_m:.1} m {reference}");
        assert!(
            window.query_by_label_contains(&deepest).is_some(),
            "time line: {deepest}, {:?}",
            names(&window, "Time line")
        );
        // Map: the scale of the track's colours.
        let [shallow, deep] =
            colour_ends(depths.iter().map(|(_, depth_m)| *depth_m as f32)).expect("depths");
        let scale = format!("depth {shallow:.1} to {deep:.1} m {reference}");
        assert!(
            window.query_by_label_contains(&scale).is_some(),
            "map: {scale}, {:?}",
            names(&window, "Map, ")
        );
    }
}

#[test]
fn the_speed_of_sound_scales_the_range_of_a_sample_as_it_does_the_cloud() {
    let mut window = demo_window();
    change(&mut window, &["sound_speed.m_s=1440", "cloud.geometry=nadir"]);
    let products = app(&window).logs.shown.products.clone().expect("a result");
    let points = products.cloud.points.iter();
    let point = points.filter(|point| point.source == PointSource::Port).nth(200).expect("a point");
    let mark = LogPlace {
        side: Some(bathyscope_log::survey::Side::Port),
        sample: Some(point.sample),
        ..LogPlace::ping(point.ping as usize)
    };
    window.state_mut().app.apply(Command::Select(Some(mark)));
    window.run();
    // Straight below, the range is the depth.
    let range = format!("range {:.2} m port", -point.z_m);
    assert!(window.query_by_label(&range).is_some(), "{range}, {:?}", names(&window, "range "));
}

fn json(path: &Path) -> Value {
    serde_json::from_slice(&std::fs::read(path).expect("a product")).expect("JSON")
}

#[test]
fn agreement_with_the_soundings_has_one_sign_in_panels_and_files() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let log = demo_log();
    let log = log.to_str().expect("a path");
    // Left in, the lead of the pulse puts the first returns above the soundings.
    let args = [
        "process",
        log,
        "-o",
        "out",
        "--set",
        "calibration.offset=none",
        "--no-objects",
        "--products",
        "residuals",
    ];
    run(folder.path(), &args);
    let report = json(&folder.path().join("out/report.json"));
    let median_m = report["residuals"]["median_m"].as_f64().expect("a median");
    assert!((0.01..0.1).contains(&median_m), "{median_m}");
    let record = json(&folder.path().join("out/quality/residuals.json"));
    assert!(record["sign"].as_str().is_some_and(|sign| sign.contains("positive is shallower")));
    let at_place_m = record["comparisons"][0]["median_m"].as_f64().expect("a median");
    assert!((at_place_m - median_m).abs() < 0.05, "{at_place_m} {median_m}");

    let mut window = demo_window();
    change(&mut window, &["calibration.offset=none"]);
    let figures = app(&window).logs.shown.figures.clone().expect("figures");
    let found = figures.residuals.expect("residuals");
    assert_eq!(found.median_m, median_m);
    let same_ping = format!("+{:.1} cm · p95 {:.1} cm", 100.0 * median_m, 100.0 * found.p95_m);
    open_section(&mut window, WorkStep::Map, "Cloud");
    assert_eq!(names(&window, &same_ping).len(), 1, "cloud: {:?}", names(&window, "p95"));
    open_step(&mut window, WorkStep::Export);
    assert_eq!(names(&window, &same_ping).len(), 1, "residuals: {:?}", names(&window, "p95"));
}

#[test]
fn the_share_of_outliers_is_one_number() {
    let mut window = demo_window();
    change(&mut window, &["outliers.radius_m=0.25", "outliers.min_neighbors=4"]);
    let products = app(&window).logs.shown.products.clone().expect("a result");
    let classes = ClassCounts::of(&products.cloud, &products.classes);
    assert!(classes.noise() > 20, "{classes:?}");
    let percent = format!("({:.1} %", 100.0 * classes.noise_share());
    let panel = format!("{percent})");
    open_section(&mut window, WorkStep::Map, "Outliers");
    let places = window.query_all_by_label_contains(&panel).count();
    assert_eq!(places, 2, "{panel}: {:?}", names(&window, "%"));
    let cloud = format!("removed {percent})");
    assert!(
        window.query_by_label_contains(&cloud).is_some(),
        "{cloud}: {:?}",
        names(&window, "3D point cloud")
    );
    let folder = tempfile::tempdir().expect("a temporary folder");
    let log = demo_log();
    let args = [
        "process",
        log.to_str().expect("a path"),
        "-o",
        "out",
        "--set",
        "outliers.radius_m=0.25",
        "--set",
        "outliers.min_neighbors=4",
        "--no-objects",
        "--products",
        "report",
    ];
    run(folder.path(), &args);
    let counts = &json(&folder.path().join("out/report.json"))["counts"];
    assert_eq!(counts["outliers_removed"], classes.noise());
    let share = counts["outliers_removed_share"].as_f64().expect("a share");
    assert!((share - classes.noise_share()).abs() < 1e-12);
    let page = std::fs::read_to_string(folder.path().join("out/report.html")).expect("a page");
    assert!(page.contains(&format!("{percent}) were set aside")), "{percent}");
}

#[test]
fn info_and_process_state_one_scale() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let log = demo_log();
    let log = log.to_str().expect("a path");
    let info: Value =
        serde_json::from_str(&run(folder.path(), &["info", log, "--json"])).expect("JSON");
    let stated = info["header_px_per_m"].as_f64().expect("a scale");
    let process = ["process", log, "-o", "out", "--no-objects"];
    let said = run(folder.path(), &[&process[..], &["--products", "track"]].concat());
    let report = json(&folder.path().join("out/report.json"));
    assert_eq!(report["calibration"]["header_px_per_m"].as_f64(), Some(stated));
    let line = format!("{stated:.2} samples a metre, as recorded");
    assert!(run(folder.path(), &["info", log]).contains(&line), "{line}");
    // What process says first is the scale that is in force.
    let scale = format!("scale: as recorded {stated:.2} px/m");
    assert!(said.contains(&scale), "{said}");
}

#[test]
fn the_offset_in_use_stands_in_panel_picture_report_and_page() {
    let mut window = demo_window();
    open_step(&mut window, WorkStep::Correct);
    let products = app(&window).logs.shown.products.clone().expect("a result");
    let added_m = -products.calibration.offset_m;
    assert!(added_m > 0.02, "the demo has an offset: {added_m}");
    let added = format!("{added_m:+.2} m");
    let shown = format!("recorded {added}");
    assert!(window.query_by_label(&shown).is_some(), "panel: {shown}");
    let picture = format!("range offset {added}");
    assert!(
        names(&window, "Waterfall, pings").iter().any(|name| name.contains(&picture)),
        "{:?}",
        names(&window, "Waterfall")
    );
    let folder = tempfile::tempdir().expect("a temporary folder");
    let log = demo_log();
    let log = log.to_str().expect("a path");
    let said =
        run(folder.path(), &["process", log, "-o", "out", "--no-objects", "--products", "report"]);
    assert!(said.contains(&picture), "{said}");
    let calibration = &json(&folder.path().join("out/report.json"))["calibration"];
    assert_eq!(calibration["offset_m"].as_f64(), Some(-added_m));
    assert_eq!(calibration["offset_measured_m"], calibration["offset_m"]);
    assert!(calibration["offset_note"].is_null());
    let page = std::fs::read_to_string(folder.path().join("out/report.html")).expect("a page");
    assert!(page.contains(&format!("{added} are added to every range")), "{added}");
}
