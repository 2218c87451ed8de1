//! The maps of `bathyscope process`: which are made, and that they agree with each other.

use super::{refusal, run, simulated};
use serde_json::Value;
use std::fs;
use std::path::Path;

const DEPTH: [&str; 3] = ["depth.tif", "uncertainty.tif", "distance.tif"];
const ISOBATHS: [&str; 3] = ["isobaths.geojson", "depth_areas.geojson", "storage.csv"];

fn json(path: &Path) -> Value {
    serde_json::from_slice(&fs::read(path).expect("a product")).expect("JSON")
}

fn assert_made(folder: &Path, products: &[&str], made: bool) {
    for product in products {
        assert_eq!(folder.join(product).is_file(), made, "{product}");
    }
}

#[test]
fn only_the_products_that_are_named_are_made() {
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let folder = temporary.path();
    simulated(folder);
    let process = ["process", "pond.sl2", "--no-objects", "-o"];
    run(
        folder,
        &[&process[..], &["some", "--products", "depth,residuals"]].concat(),
    );
    let some = folder.join("some");
    assert_made(&some, &DEPTH, true);
    assert_made(&some, &["residuals.json", "cloud.csv", "report.json"], true);
    assert_made(&some, &ISOBATHS, false);
    assert_made(&some, &["mosaic.tif"], false);
    let wrong = [&process[..], &["other", "--products", "dept"]].concat();
    assert!(refusal(folder, &wrong, 2).contains("dept"));
    let wrong = [&process[..], &["other", "--set", "surface.max_gap_m=0"]].concat();
    assert!(refusal(folder, &wrong, 1).contains("surface.max_gap_m"));
}

#[test]
fn isobaths_areas_storage_and_residuals_agree() {
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let folder = temporary.path();
    simulated(folder);
    let mut process = vec!["process", "pond.sl2", "--no-objects", "-o", "out"];
    process.extend([
        "--products",
        "isobaths,residuals",
        "--set",
        "surface.cell_m=0.2",
    ]);
    process.extend([
        "--set",
        "isobaths.interval_m=0.1",
        "--set",
        "water_level_m=0.5",
    ]);
    run(folder, &process);
    let out = folder.join("out");

    let lines = json(&out.join("isobaths.geojson"));
    let lines = lines["features"].as_array().expect("features");
    assert!(!lines.is_empty());
    for line in lines {
        let depth_m = line["properties"]["depth_m"].as_f64().expect("a depth");
        assert!(
            (depth_m * 10.0 - (depth_m * 10.0).round()).abs() < 1e-9,
            "{depth_m}"
        );
    }

    // The areas cover what the storage table says is deeper than the shallowest place, but for the cells at the edge.
    let areas = json(&out.join("depth_areas.geojson"));
    let areas = areas["features"].as_array().expect("features");
    let covered: f64 = areas
        .iter()
        .map(|area| area["properties"]["area_m2"].as_f64().unwrap())
        .sum();
    let table = fs::read_to_string(out.join("storage.csv")).expect("a table");
    let rows: Vec<Vec<f64>> = table
        .lines()
        .skip(1)
        .map(|row| {
            row.split(',')
                .map(|value| value.parse().expect("a number"))
                .collect()
        })
        .collect();
    assert!(
        covered > 0.5 * rows[0][1] && covered < rows[0][1],
        "{covered} of {}",
        rows[0][1]
    );
    assert!(
        rows.windows(2)
            .all(|step| step[0][1] >= step[1][1] && step[0][2] >= step[1][2])
    );

    // Side-scan against down-scan is about what the report says of the same pings, the sign turned.
    let record = json(&out.join("residuals.json"));
    let report = json(&out.join("report.json"));
    let by_surface = &record["comparisons"][0];
    assert_eq!(by_surface["source"], "side-scan");
    let median = |one: &Value| one["median_m"].as_f64().expect("a number");
    assert!(
        (median(by_surface) + median(&report["residuals"])).abs() < 0.1,
        "{by_surface}"
    );
    assert_eq!(record["settings"]["water_level_m"], 0.5);
}

/// `source, ping, z_m` of every point.
fn points(folder: &Path) -> Vec<(String, usize, f64)> {
    let text = fs::read_to_string(folder.join("cloud.csv")).expect("a cloud");
    let rows = text.lines().skip(1).map(|row| {
        let fields: Vec<&str> = row.split(',').collect();
        let [ping, z_m] = [fields[1], fields[6]];
        (
            fields[0].to_owned(),
            ping.parse().unwrap(),
            z_m.parse().unwrap(),
        )
    });
    rows.collect()
}

#[test]
fn water_and_transducer_correct_soundings_and_side_scan_alike() {
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let folder = temporary.path();
    simulated(folder);
    let process = [
        "process",
        "pond.sl2",
        "--no-objects",
        "--products",
        "depth,residuals",
        "-o",
    ];
    run(folder, &[&process[..], &["plain"]].concat());
    let start_s = json(&folder.join("plain/report.json"))["start_unix_s"]
        .as_f64()
        .expect("a time");
    // 10 m at the log's first second, a centimetre more a second.
    let gauge = format!(
        "time,level_m\n{},9\n{},19\n",
        start_s - 100.0,
        start_s + 900.0
    );
    fs::write(folder.join("gauge.csv"), gauge).unwrap();
    let sets = [
        "--set",
        "draft_m=0.35",
        "--set",
        "water_level.file=gauge.csv",
        "--set",
        "sound_speed.temperature_c=20",
        "--set",
        "sound_speed.recorder_m_s=1463",
    ];
    run(folder, &[&process[..], &["corrected"], &sets].concat());

    let times = fs::read_to_string(folder.join("plain/first_returns.csv")).unwrap();
    let times: Vec<f64> = times
        .lines()
        .skip(1)
        .map(|row| row.split(',').nth(1).unwrap().parse().unwrap())
        .collect();
    let [plain, corrected] = ["plain", "corrected"].map(|name| points(&folder.join(name)));
    assert!(plain.len() > 100 && plain.len() == corrected.len());
    for ((source, ping, z_m), (_, _, found_m)) in plain.iter().zip(&corrected) {
        // The speed of sound in fresh water of 20 C is 1482.343 m/s.
        let expected_m = z_m * 1482.343 / 1463.0 - 0.35 + 10.0 + 0.01 * times[*ping];
        // A sounding bears the number of the side-scan ping nearest to it.
        let tolerance_m = if source == "downscan" { 2e-3 } else { 2e-4 };
        assert!(
            (found_m - expected_m).abs() < tolerance_m,
            "{source} {ping}: {found_m} {expected_m}"
        );
    }

    let report = json(&folder.join("corrected/report.json"));
    assert_eq!(report["inputs"].as_array().unwrap().len(), 2);
    for product in ["report.json", "residuals.json"] {
        let statement = json(&folder.join("corrected").join(product))["statement"].to_string();
        for words in [
            "1482.3 m/s",
            "draft 0.35 m",
            "gauge.csv",
            "Not corrected: roll and pitch.",
        ] {
            assert!(statement.contains(words), "{product}: {statement}");
        }
    }
    let raster = fs::read(folder.join("corrected/depth.tif")).unwrap();
    assert!(String::from_utf8_lossy(&raster).contains("draft 0.35 m added"));

    fs::write(
        folder.join("gauge.csv"),
        format!("time,level_m\n{start_s},9\n{},9\n", start_s + 1.0),
    )
    .unwrap();
    let refused = refusal(folder, &[&process[..], &["refused"], &sets].concat(), 1);
    assert!(
        refused.contains("readings that are missing") && refused.contains("gauge.csv"),
        "{refused}"
    );
}
